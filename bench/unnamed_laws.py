"""Laws that are in no catalogue, hidden in joints of `bench/plants`: are they drawn as curves, and only then?

    python bench/unnamed_laws.py --seed 1 --out laws.jsonl                  # twelve laws, a cobot's joint
    python bench/unnamed_laws.py --clean 20 --seed 1 --out laws.jsonl       # nothing hidden: no curve may be found
    python bench/unnamed_laws.py --out laws.jsonl --tables                  # the tables of all lines of the file

`--curves-only` leaves the named laws out of the search: a curve is then all that could be found. Lines that are there
already are not made again. Coverage is the share of the curve's length at which its 95 % band holds the plant's law,
less what nobody could tell from a constant (friction), or from gravity and a constant (angle).
"""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
import time
from pathlib import Path
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402
from numpy.typing import NDArray  # noqa: E402
from plants import Case, case_of, made  # noqa: E402
from plants.excitation import excitation  # noqa: E402
from plants.experiment import Setup, moved  # noqa: E402
from plants.laws import Joint  # noqa: E402
from plants.measurement import Chain, recorded  # noqa: E402
from plants.unnamed import ANGLE, FRICTION, SPRING, angle_torque, friction_torque, spring_torque  # noqa: E402
from recordings import recording_of  # noqa: E402

Floats = NDArray[np.float64]
Line = dict[str, Any]
COBOT = Joint(1.5, 12000.0, 2.2, 12.0, 6.0, 3.0, 1.0, 0.0, -8.0)
CURVES = {"friction": "motor_friction_curve", "angle": "motor_angle_curve", "spring": "spring_curve"}
RATE_HZ, RATIO, DURATION_S, START = 500.0, 8, 30.0, 0.6
LAWS = {
    **{f"friction:{name}": {"friction_law": float(i)} for i, name in enumerate(FRICTION) if name},
    **{f"angle:{name}": {"angle_law": float(i)} for i, name in enumerate(ANGLE) if name},
    **{f"spring:{name}": {"spring_law": float(i)} for i, name in enumerate(SPRING) if name},
}  # fmt: skip
LARGER = {
    "friction:root": 3.0, "friction:levelling_off": 4.0, "friction:two_valleys": 2.0, "spring:one_sided": 0.15,
}  # fmt: skip
"""Of those that a straight line takes most of: what is left of them would be no more than noise; one_sided grows."""


def hidden_in(law: str, rng: np.random.Generator) -> Joint:
    """The cobot's joint with one law in it, its size and scale drawn."""
    size = float(rng.uniform(0.7, 1.4)) * LARGER.get(law, 1.0)
    changed = {
        "friction": {"friction_size": 4.0 * size, "friction_speed": 0.5 * float(rng.uniform(0.7, 1.4))},
        "angle": {
            "angle_size": 5.0 * size,
            "angle_width": 0.08,
            "angle_place": START + float(rng.uniform(-0.05, 0.05)),
        },
        "spring": {"spring_size": 12.0 * size, "spring_width": 3e-3 * float(rng.uniform(0.8, 1.3))},
    }[law.split(":")[0]]
    return COBOT._replace(**LAWS[law], **changed)


def played(joint: Joint, seed: int) -> Any:
    """A log chirp of 0.2 rad under a P-PI drive, 17 bits behind a gear of 100, 20 on the link, 1 % noise."""
    case = Case(seed, 0, "cobot", "p_pi", "log_chirp", RATE_HZ, RATIO, True, "coulomb_events", "command")
    tick = 1.0 / (RATE_HZ * RATIO)
    t = np.arange(round(DURATION_S / tick)) * tick
    wave = excitation("log_chirp", t, DURATION_S, 0.1, 40.0, 2.0, np.random.default_rng(seed))
    steps = 2.0 * math.pi / 2.0**17 / 100.0, 2.0 * math.pi / 2.0**20
    ticks = moved(joint, Setup(case, wave, START, tick, steps[0], 0.3, 0.0, np.ones(5)), 0.2, 1.0)
    return recorded(ticks, RATIO, tick, Chain(*steps, 0.3, 0.6, "command", 0.01), np.random.default_rng(seed))


def true_law(joint: Joint, kind: str, at: Floats, points: Floats, stiffness: float) -> Floats:
    """The plant's law at the places of a measured curve, less what the curve leaves out."""

    def law(x: float) -> float:
        if kind == "friction":
            return float(friction_torque(joint, x) + joint.FVm * x + joint.FSm * math.copysign(1.0, x))
        if kind == "angle":
            return float(angle_torque(joint, x))
        return float(spring_torque(joint, x) + joint.K * x)

    there, here = (np.array([law(float(x)) for x in places]) for places in (at, points))
    if kind == "friction":
        return there - here.mean()
    if kind == "spring":
        return there - mean_slope(points, here) * at
    return there - _weight(at) @ np.linalg.pinv(_weight(points), rcond=1e-3) @ here


def mean_slope(x: Floats, y: Floats) -> float:
    """Slope of the straight line that is closest to points."""
    return float(np.polyfit(x, y, 1)[0])


def _weight(x: Floats) -> Floats:
    return np.column_stack([np.ones_like(x), np.cos(x), np.sin(x)])


def explained(recording: Any, sensors: str, curves_only: bool) -> Any:
    from flex_ident.gap import GapOptions, explain

    effects = tuple(CURVES.values()) if curves_only else ()
    return explain(recording_of(recording, sensors), GapOptions(sensors=sensors, effects=effects))


def common(found: Any) -> Line:
    from flex_ident.report.reasons import reason_text

    return {
        "verdict": str(found.verdict), "findings": [f.effect for f in found.findings], "before": found.before,
        "after": found.after, "floor": found.noise_floor,
        "rejected": {r.effect: reason_text(r.reason) for r in found.rejected if r.effect in CURVES.values()},
    }  # fmt: skip


def law_line(law: str, seed: int, sensors: str, curves_only: bool) -> Line:
    """One law, explained; how much of the curve's length its band covers."""
    joint = hidden_in(law, np.random.default_rng((seed, list(LAWS).index(law))))
    found = explained(played(joint, seed), sensors, curves_only)
    from flex_ident.report.gap_words import reading_text
    from flex_ident.report.units import as_they_are

    line = common(found)
    kind = law.split(":")[0]
    for f in found.findings:
        if f.effect == CURVES[kind] and f.curve is not None:
            c = f.curve
            truth = true_law(joint, kind, c.at, c.points, joint.K)
            inside = (truth >= c.lower) & (truth <= c.upper)
            line.update(
                covered=float(inside.mean()), worst_sigmas=float(np.max(np.abs(truth - c.torque) / c.std)),
                rms=float(np.sqrt(np.mean((truth - c.torque) ** 2))), band=float(np.mean(c.std)),
                size=float(np.ptp(truth - c.line)), reading=reading_text(f, as_they_are),
            )  # fmt: skip
    truth = {key: float(getattr(joint, key)) for key in ("Jm", "K", "JL")}
    for c in (f.curve for f in found.findings if f.effect == CURVES["spring"]):  # K is the mean slope over its points
        truth["K"] += mean_slope(c.points, np.array([spring_torque(joint, x) for x in c.points]))
    line["errors"] = {
        p.key: (p.value - truth[p.key]) / p.std for p in found.final.parameters if p.key in ("Jm", "K", "JL")
    }  # fmt: skip
    return line


def clean_line(index: int, seed: int, sensors: str, curves_only: bool) -> Line:
    """One recording with nothing hidden in it."""
    return common(explained(made(case_of(seed, index)).recorded, sensors, curves_only))


def tables(lines: list[Line]) -> None:
    """What was found, law by law, and on clean recordings."""
    print("| law | sensors | found | gap before, after, noise, N m | after / noise | covered, % | Jm, K, JL off, std |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for r in (r for r in lines if r["kind"] == "law" and "error" not in r):
        covered = f"{100 * r['covered']:.0f}" if "covered" in r else "-"
        off = ", ".join(f"{v:+.1f}" for v in r["errors"].values())
        print(
            f"| {r['what']} | {r['sensors']} | {', '.join(r['findings']) or '-'} ({r['verdict']}) | {r['before']:.3g}, "
            f"{r['after']:.3g}, {r['floor']:.3g} | {r['after'] / r['floor']:.2f} | {covered} | {off} |"
        )
    clean = [r for r in lines if r["kind"] == "clean" and "error" not in r]
    named = [r for r in clean if set(r["findings"]) & set(CURVES.values())]
    print(f"\nclean: {len(clean)} results, {len(named)} with a curve: {[(r['what'], r['findings']) for r in named]}")
    for r in (r for r in lines if "error" in r):
        print("failed:", r["name"], r["error"])


def main() -> None:
    """Make what is missing, one line after the other, then print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("laws.jsonl"))
    parser.add_argument("--laws", default="", help="only laws that begin so")
    parser.add_argument("--clean", type=int, default=0, help="recordings of bench/plants with nothing hidden")
    parser.add_argument("--first", type=int, default=0, help="index of the first of them")
    parser.add_argument("--sensors", choices=("motor", "motor+link"), default="motor+link")
    parser.add_argument("--curves-only", action="store_true")
    parser.add_argument("--tables", action="store_true")
    given = parser.parse_args()
    lines = [json.loads(t) for t in given.out.read_text().splitlines()] if given.out.exists() else []
    done = {r["name"] for r in lines}
    whats: list[tuple[str, Any]] = [("clean", i) for i in range(given.first, given.first + given.clean)]
    if not given.clean and not given.tables:
        whats = [("law", law) for law in LAWS if law.startswith(given.laws)]
    for kind, what in whats:
        way = "curves" if given.curves_only else "all"
        line: Line = {"name": f"{kind}|{what}|{given.seed}|{given.sensors}|{way}", "kind": kind, "what": what}
        if line["name"] in done:
            continue
        line["sensors"] = given.sensors
        started = time.monotonic()
        try:
            make = law_line if kind == "law" else clean_line
            line.update(make(what, given.seed, given.sensors, given.curves_only))
        except Exception as error:
            line["error"] = f"{type(error).__name__}: {error}"[:500]
        line["seconds"], line["cpu_s"] = time.monotonic() - started, time.process_time()
        with given.out.open("a") as file:
            file.write(json.dumps(line) + "\n")
        lines.append(line)
    tables(lines)


if __name__ == "__main__":
    main()
