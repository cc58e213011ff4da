"""What `effort` is: is each kind recognised, or asked for, and do the intervals hold, found out or told?

    python bench/effort_kinds.py --seed 1 --draws 20 --jobs 2 --out kinds.jsonl

Recordings of `bench/plants`, three sizes of joint, whose effort is made another kind of: the spring's torque
(`joint_sensor`), the motor's less gravity, the same with a controller's model that is a tenth off (`gravity_nearly`),
less the motor's friction, a current of 0.1 A a N m, or without its sign. Each draw is identified by both sets of
sensors, with the kind found out (`auto`) and told. Lines that are in FILE already are not made again.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from coverage_tables import KEYS, covered, percent, pull, stated, table  # noqa: E402
from lines import Line, lines_in, parameter_columns  # noqa: E402
from plants import Case, CaseError, case_of, made  # noqa: E402
from plants.experiment import Made  # noqa: E402
from recordings import recording_of  # noqa: E402

Task = tuple[int, int, str, str, str]
"""Seed, index, kind, sensors, what the effort is told to be."""
TOLD = {
    "motor": "motor", "joint_sensor": "joint_sensor", "gravity_compensated": "gravity_compensated",
    "gravity_nearly": "gravity_compensated", "friction_compensated": "friction_compensated", "current": "current",
    "unsigned": "",
}  # fmt: skip
"""Each kind, and what it is told to be; '' is refused whatever is told."""
SIZES = ("cobot", "series_elastic", "legged")
AMPERES, NEARLY, GRAVITY = 0.1, 0.9, 9.81
ASKED = {"effort_kind_unclear", "effort_kind_open"}
NAMED = {
    "joint_sensor": "effort_joint_sensor", "gravity_compensated": "effort_gravity_compensated",
    "gravity_nearly": "effort_gravity_compensated", "friction_compensated": "effort_friction_compensated",
}  # fmt: skip
FAR = 3.0


def cases(seed: int, draws: int) -> list[int]:
    """Indices of recordings of the three sizes, without a lag in their effort, `draws` of each."""
    found: dict[str, list[int]] = {size: [] for size in SIZES}
    index = 0
    while any(len(own) < draws for own in found.values()):
        case = case_of(seed, index)
        if case.joint in found and case.stratum == "standard" and len(found[case.joint]) < draws:
            found[case.joint].append(index)
        index += 1
    return sorted(i for own in found.values() for i in own)


def effort_of(kind: str, case: Case, plant: Made) -> NDArray[np.float64]:
    """The effort (n,) of a kind, N m or A, with the recording's own noise."""
    joint, held = plant.joint, plant.recorded
    position, torque = held.motor_position, held.motor_torque
    if kind == "joint_sensor":
        spring = joint.K * (plant.ticks[:: case.ratio, 0] - plant.ticks[:: case.ratio, 1])
        noise = case.generator(6).uniform(0.003, 0.02) * np.std(spring)
        return np.asarray(spring + noise * case.generator(7).standard_normal(spring.size))
    if kind in ("gravity_compensated", "gravity_nearly"):
        share = NEARLY if kind == "gravity_nearly" else 1.0
        return torque - share * GRAVITY * (joint.MX * np.cos(position) + joint.MY * np.sin(position))
    if kind == "friction_compensated":
        speed = plant.ticks[:: case.ratio, 5]
        known = case.generator(8).uniform(0.9, 1.3)
        return torque - known * (joint.FVm * speed + joint.FSm * np.tanh(speed / (0.01 * plant.scales.speed)))
    if kind == "current":
        return AMPERES * torque
    return np.abs(torque) if kind == "unsigned" else torque


def result_line(task: Task) -> Line:
    """One recording with its effort of one kind, identified."""
    from flex_ident.errors import FlexIdentError
    from flex_ident.estimation.identification import identify
    from flex_ident.estimation.options import IdentifyOptions

    seed, index, kind, sensors, told = task
    case = case_of(seed, index)
    line: Line = {"name": name_of(task), "kind": kind, "sensors": sensors, "told": told, "joint": case.joint}
    try:
        plant = made(case)
        recorded = replace(plant.recorded, motor_torque=effort_of(kind, case, plant))
        line["truth"] = plant.truth
        result = identify(recording_of(recorded, sensors), IdentifyOptions(sensors=sensors, effort_kind=told))
    except CaseError:
        return {**line, "verdict": "not played"}
    except FlexIdentError as error:
        return {**line, "verdict": "refused", "error": str(error)[:500]}
    except Exception as error:
        return {**line, "verdict": "error", "error": f"{type(error).__name__}: {error}"[:500]}
    notices = [str(n.code) for n in result.notices]
    return {**line, "verdict": str(result.verdict), "parameters": parameter_columns(result), "notices": notices}


def name_of(task: Task) -> str:
    """What names a task's line."""
    return "|".join(map(str, task))


def told_right(line: Line) -> bool:
    """Whether the kind was named, asked for, or refused by name, and no other kind named."""
    codes = set(line.get("notices", ()))
    if line["kind"] == "unsigned":
        return line["verdict"] == "refused" and "sign" in line["error"]
    others = set(NAMED.values()) - {NAMED.get(line["kind"], "")}
    if codes & others:
        return False
    if line["kind"] == "motor":
        return True
    return bool(codes & (ASKED | {NAMED.get(line["kind"], "")}))


def print_tables(lines: list[Line]) -> None:
    """By kind, sensors and what was told: how many are trusted, named or asked for; and the intervals of these."""
    rows, intervals = [], []
    for kind in TOLD:
        for told in ("auto", TOLD[kind]):
            for sensors in ("motor", "motor+link"):
                own = [x for x in lines if (x["kind"], x["told"], x["sensors"]) == (kind, told, sensors)]
                own = [x for x in own if x["verdict"] != "not played"]
                if not own:
                    continue
                trusted = [x for x in own if x["verdict"] == "trusted"]
                scale = kind == "current"
                far = sum(any(abs(pull(x, k)) > FAR for k in KEYS if stated([x], k)) for x in trusted)
                named = percent(sum(map(told_right, own)), len(own)) if told == "auto" and not scale else "-"
                shown = "-" if scale else far
                rows.append([f"{kind}, {told}, {sensors}", len(own), len(trusted), named, shown])
                cells = []
                for key in KEYS:
                    there = stated(trusted, key)
                    cells.append(
                        "-" if scale or not there else percent(sum(covered(x, key) for x in there), len(there))
                    )
                intervals.append([f"{kind}, {told}, {sensors}", *cells])
    print(table(("kind, told, sensors", "results", "trusted", "named or asked, %", "trusted beyond 3"), rows))
    print("\n95 % intervals of the trusted ones cover, %\n")
    print(table(("kind, told, sensors", *KEYS), intervals))


def main() -> None:
    """Make what is missing, then print the tables of all lines of the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--draws", type=int, default=20, help="recordings of each size of joint")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("kinds.jsonl"))
    parser.add_argument("--kinds", default="", help="these alone, with commas between")
    given = parser.parse_args()
    kinds = given.kinds.split(",") if given.kinds else list(TOLD)
    there = {line["name"] for line in lines_in(given.out)}
    tasks = [
        (given.seed, index, kind, sensors, told)
        for index in cases(given.seed, given.draws)
        for kind in kinds
        for sensors in ("motor", "motor+link")
        for told in dict.fromkeys(("auto", TOLD[kind] or "auto"))
    ]
    tasks = [task for task in tasks if name_of(task) not in there]
    if tasks:
        with multiprocessing.get_context("spawn").Pool(given.jobs) as pool, given.out.open("a") as file:
            for done, line in enumerate(pool.imap_unordered(result_line, tasks), 1):
                file.write(json.dumps(line) + "\n")
                file.flush()
                print(f"{done}/{len(tasks)} {line['name']} {line['verdict']}", file=sys.stderr)
    print_tables(lines_in(given.out))


if __name__ == "__main__":
    main()
