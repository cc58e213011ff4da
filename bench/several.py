"""Several recordings of one joint as one: what the intervals cover, which condition is named, the effort's scale.

    python bench/several.py                                   # at the level of estimates: 2000 sets, a minute
    python bench/several.py --sets 4 --recordings 6 --out several.jsonl     # recordings of the bench's own plants

With `--sets` every recording is made by `bench/plants` (drive, excitation, rate, effort and friction law drawn for
each), of a joint whose parameters scatter by 3 % between recordings. With `--payload` nothing scatters, the last third
of each set carries a mass of half the link's inertia, and all efforts are recorded too small by one factor. Each set is
a line of FILE; lines that are there are not made again.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(Path(__file__).resolve().parent), str(ROOT), str(ROOT / "test" / "pooling")]

import numpy as np  # noqa: E402
from plants import CaseError, case_of, made  # noqa: E402
from plants.joints import BASE, SIZES, drawn_joint  # noqa: E402

SCATTER = 0.03
LOAD_AT = 0.4
CONDITIONS = ("amplitude", "payload", "temperature", "gain", "mean position", "duration")
Line = dict[str, Any]


def of_estimates(draws: int) -> None:
    """Print what ten drawn estimates with a true scatter of 3 % give, `draws` times."""
    from drawn import KEYS, TRUTH, members

    from flex_ident.pooling.combining import pooled_all
    from flex_ident.pooling.conditions import causes
    from flex_ident.pooling.disagreement import disagreements
    from flex_ident.pooling.members import side_by_side

    rng = np.random.default_rng(1)
    for count in (2, 3, 5, 10):
        inside = np.zeros(len(KEYS))
        for _ in range(draws):
            found = pooled_all(side_by_side(members(rng, count, scatter=rng.normal(0.0, SCATTER, (count, len(KEYS))))))
            inside += [abs(own.value - true) <= own.half for own, true in zip(found, TRUTH, strict=True)]
        covered = "  ".join(f"{key} {100 * x / draws:.1f}" for key, x in zip(KEYS, inside, strict=True))
        print(f"{count} recordings, intervals that hold the mean, %: {covered}")
    for driver in (*CONDITIONS[:4], None):
        right = named = apart = 0
        sets = draws // 10
        for _ in range(sets):
            table = rng.normal(size=(10, len(CONDITIONS)))
            table[:, 1] = rng.permutation(np.arange(10) % 2)
            scatter = rng.normal(0.0, SCATTER, (10, len(KEYS)))
            if driver is not None:
                column = table[:, CONDITIONS.index(driver)]
                scatter = np.zeros_like(scatter)
                scatter[:, 1] = SCATTER * (column - column.mean()) / column.std()
            given = side_by_side(members(rng, 10, scatter=scatter))
            found = causes(
                given, pooled_all(given), [dict(zip(CONDITIONS, map(float, row), strict=True)) for row in table]
            )
            named += bool(found)
            right += {c.condition for c in found} == {driver}
            apart += bool(disagreements(given, {c.key for c in found}))
        print(f"driven by {driver}: named {100 * named / sets:.1f} %, right {100 * right / sets:.1f} %, a recording "
              f"said to disagree {100 * apart / sets:.1f} %")  # fmt: skip


def name_of(seed: int, index: int, count: int, sensors: str, loaded: bool) -> str:
    """What names a set's line in the file."""
    return f"{seed}|{index}|{count}|{sensors}|{'payload' if loaded else 'scatter'}"


def set_line(seed: int, index: int, count: int, sensors: str, loaded: bool) -> Line:
    """One set of recordings of one joint, each identified, all together; truth beside what came out."""
    from coverage import recording_of

    from flex_ident.estimation.identification import identify
    from flex_ident.estimation.options import IdentifyOptions
    from flex_ident.pooling.members import Member
    from flex_ident.pooling.recorded_conditions import recorded_conditions
    from flex_ident.pooling.several import several
    from flex_ident.pooling.torque_scale import Load

    rng = np.random.default_rng((seed, index))
    kind = list(SIZES)[1 + index % 6]
    joint = drawn_joint(SIZES[kind], rng)
    true_scale = float(rng.uniform(0.8, 1.2)) if loaded else 1.0
    mass = 0.5 * joint.JL / LOAD_AT**2
    results, recordings, loads = [], [], []
    case_number = 97 * index
    while len(results) < count:
        case = replace(case_of(seed, case_number), joint=kind)
        case_number += 1
        if case.stratum != "standard" or case.rate_hz < 9.0 * joint.locked_hz() or case_number > 97 * index + 90:
            if case_number > 97 * index + 90:
                break
            continue
        load = Load(mass, LOAD_AT, 0.0) if loaded and len(results) >= count - max(1, count // 3) else Load()
        factors = 1.0 + rng.normal(0.0, 0.0 if loaded else SCATTER, len(BASE))
        own = joint._replace(**{k: getattr(joint, k) * float(f) for k, f in zip(BASE, factors, strict=True)})
        own = own._replace(JL=own.JL + load.inertia, MX=own.MX + load.mass * load.x)
        try:
            recorded = made(case, own).recorded
        except CaseError:
            continue
        recording = recording_of(recorded, sensors)
        recording = replace(recording, motor_torque=recording.motor_torque / true_scale)
        try:
            results.append(identify(recording, IdentifyOptions(sensors=sensors)))
        except Exception as error:
            print(f"  {case.controller} {case.excitation} {case.rate_hz:g} Hz: {error}", file=sys.stderr)
            continue
        recordings.append(recording)
        loads.append(load)
    line: Line = {
        "name": name_of(seed, index, count, sensors, loaded),
        "joint": kind,
        "verdicts": [r.verdict for r in results],
    }
    good = [i for i, r in enumerate(results) if r.verdict != "rejected" and r.covariance is not None]
    conditions = recorded_conditions([recordings[i] for i in good])
    members = [
        Member(str(i), results[i].parameters, results[i].covariance, own, results[i].verdict)
        for i, own in zip(good, conditions, strict=True)
    ]
    found = several(members, [loads[i] for i in good] if loaded else None, current=loaded)
    truth = {k: getattr(joint, k) for k in BASE}
    scale = found.scale.both if found.scale is not None else None
    line |= {
        "used": len(good), "verdict": found.verdict, "codes": [str(n.code) for n in found.notices],
        "scale": None if scale is None else [true_scale, scale.value, scale.low, scale.high],
        "pairs": chances([m for m, i in zip(members, good, strict=True) if not loads[i].mass]) if loaded else [],
        "agree": None if found.scale is None else found.scale.agree,
        "parameters": {
            p.key: [truth[p.key], p.value, *p.interval]
            for p in found.parameters
            if p.key in truth and (scale is not None or not loaded)
        },
    }  # fmt: skip
    return line


def chances(members: list[Any]) -> list[float]:
    """For each pair of recordings of one joint under one load, the chance that `flex_ident compare` gives."""
    from flex_ident.pooling.agreement import agreement

    found = []
    for one, other in combinations(members, 2):
        keys = [key for key in one.known if key in other.known]
        difference = np.array([one.value(key) - other.value(key) for key in keys])
        total = one.covariance.of(keys) + other.covariance.of(keys)
        found.append(agreement(keys, difference, total).chance)
    return found


def print_lines(lines: list[Line]) -> None:
    """How many intervals hold the truth, parameter by parameter, and how well the scale is found."""
    scales = [line["scale"] for line in lines if line["scale"] is not None]
    print(f"{len(lines)} sets; the scale is told in {len(scales)}")
    if scales:
        true, value, low, high = np.array(scales).T
        errors, inside = 100.0 * np.abs(value / true - 1.0), np.sum((low <= true) & (true <= high))
        print(f"scale: in the interval {inside} of {len(scales)}, error median {np.median(errors):.2f} %, worst "
              f"{np.max(errors):.2f} %; said to differ by inertia and gravity: "
              f"{sum(line['agree'] is False for line in lines)}")  # fmt: skip
    pairs = np.array([chance for line in lines for chance in line.get("pairs", [])])
    if pairs.size:
        print(f"{pairs.size} pairs of recordings of one joint; said to differ: {100 * np.mean(pairs < 0.01):.0f} %")
    for key in BASE:
        rows = np.array([line["parameters"][key] for line in lines if key in line["parameters"]])
        if rows.size:
            true, value, low, high = rows.T
            size = np.where(true == 0.0, np.nan, np.abs(true))
            print(f"{key}: in the interval {np.sum((low <= true) & (true <= high))} of {len(rows)}, median error "
                  f"{100 * np.nanmedian(np.abs(value - true) / size):.2f} %, median half width "
                  f"{100 * np.nanmedian(0.5 * (high - low) / size):.2f} %")  # fmt: skip


def main() -> None:
    """Parse, run what is missing, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=2000)
    parser.add_argument("--sets", type=int, default=0)
    parser.add_argument("--recordings", type=int, default=6)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sensors", default="motor+link", choices=("motor", "motor+link"))
    parser.add_argument("--payload", action="store_true")
    parser.add_argument("--out", type=Path, default=Path("several.jsonl"))
    given = parser.parse_args()
    if not given.sets:
        of_estimates(given.draws)
        return
    lines = [json.loads(text) for text in given.out.read_text().splitlines()] if given.out.exists() else []
    there = {line["name"] for line in lines}
    with given.out.open("a") as file:
        for index in range(given.sets):
            if name_of(given.seed, index, given.recordings, given.sensors, given.payload) in there:
                continue
            started = time.monotonic()
            line = set_line(given.seed, index, given.recordings, given.sensors, given.payload)
            lines.append(line)
            file.write(json.dumps(line) + "\n")
            file.flush()
            print(f"{index + 1}/{given.sets} {line['joint']} {line['verdict']} {time.monotonic() - started:.0f} s",
                  file=sys.stderr)  # fmt: skip
    print_lines(lines)


if __name__ == "__main__":
    main()
