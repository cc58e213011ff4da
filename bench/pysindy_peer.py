"""`explain` beside sparse regression of the residual (pysindy): python bench/pysindy_peer.py --draws 2

The peer gets the base model that `explain` starts from, its residual torque and, as a library of functions, what each
effect of the catalogue would add to the torque along the simulated motion, low-passed like the residual; ripples at
their true frequency, which nobody would know. The model's own terms are in the library too. pysindy's STLSQ chooses,
its threshold taken by the Bayesian information criterion; the term that contributes most is the name. Needs pysindy.
"""

from __future__ import annotations

import argparse
import math
import statistics
import time
import warnings
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from confusion import Draw, drawn
from numpy.typing import NDArray

from flex_ident.errors import FlexIdentError
from flex_ident.estimation.estimate import fit_problem
from flex_ident.gap import GapOptions, explain
from flex_ident.gap.base import base_fit
from flex_ident.recording import Recording

try:
    from pysindy import STLSQ
except ImportError:
    raise SystemExit("pysindy is missing: pip install pysindy (a bench extra only).") from None

CLASSES = (
    "none", "stribeck_friction", "viscous_asymmetry", "viscous_nonlinearity", "load_dependent_friction",
    "friction_drift", "nonlinear_stiffness", "backlash", "hysteresis", "joint_damping", "torque_ripple", "time_delay",
)  # fmt: skip
THRESHOLDS = np.geomspace(1e-3, 0.5, 16)
"""Of columns and residual scaled to unit size."""
LEAST_SHARE = 0.02
"""Energy of the residual under which a term is no name."""
OWN = "own"


@dataclass(frozen=True)
class Library:
    """Columns (m, k) of functions of the motion and the effect that each stands for."""

    names: tuple[str, ...]
    columns: NDArray[np.float64]
    residual: NDArray[np.float64]


def library(recording: Recording, sensors: str, hidden: Mapping[str, float]) -> Library:
    """What each effect would add to the torque, beside the base model's residual."""
    problem = fit_problem(recording, sensors=sensors)
    _, fit = base_fit(problem, GapOptions(sensors=sensors))
    values, motion = fit.values, problem.motion
    link = problem.link_response_of(values)
    assert link is not None
    v, t = motion.velocity, np.arange(motion.velocity.size) * recording.sample_time
    bend = motion.position - link.position
    rate = v - link.velocity
    sign = np.sign(v)
    speed, width = float(np.std(v)), float(np.std(bend))
    raw: list[tuple[str, NDArray[np.float64]]] = [
        (OWN, motion.acceleration), (OWN, v), (OWN, sign), (OWN, link.velocity), (OWN, np.sign(link.velocity)),
        (OWN, bend), (OWN, np.cos(motion.position)), (OWN, np.sin(motion.position)),
        ("viscous_asymmetry", np.abs(v)), ("viscous_nonlinearity", v * np.abs(v)),
        ("load_dependent_friction", np.abs(link.spring_torque) * sign),
        ("friction_drift", t * (values["FVm"] * v + values["FSm"] * sign)), ("nonlinear_stiffness", bend**3),
        ("joint_damping", rate), ("hysteresis", np.sign(rate)),
        ("time_delay", np.gradient(recording.motor_torque) / recording.sample_time),
    ]  # fmt: skip
    raw += [("stribeck_friction", sign * np.exp(-((v / (share * speed)) ** 2))) for share in (0.03, 0.1, 0.3)]
    raw += [("backlash", np.clip(bend, -share * width, share * width)) for share in (0.03, 0.1, 0.3)]
    cycles = hidden.get("torque_ripple.cycles_per_turn", 100.0)
    raw += [("torque_ripple", np.sin(cycles * motion.position)), ("torque_ripple", np.cos(cycles * motion.position))]
    rows = problem.usable
    columns = np.column_stack([problem.reduced(column)[rows] for _, column in raw])
    return Library(tuple(name for name, _ in raw), columns, problem.residuals(values)[0][rows])


def named_by_regression(made: Library) -> str:
    """The effect whose terms contribute most to the sparse model; empty when none is worth a name."""
    scale = np.linalg.norm(made.columns, axis=0)
    scale[scale == 0.0] = 1.0
    target = made.residual - made.residual.mean()
    size = float(np.linalg.norm(target))
    columns, target = made.columns / scale, target / size
    best: tuple[float, NDArray[np.float64]] | None = None
    for threshold in THRESHOLDS:
        chosen = STLSQ(threshold=float(threshold), alpha=1e-6)
        chosen.fit(columns, target[:, None])
        coefficients = np.ravel(chosen.coef_)
        rest = target - columns @ coefficients
        bic = target.size * math.log(float(rest @ rest)) + np.count_nonzero(coefficients) * math.log(target.size)
        if best is None or bic < best[0]:
            best = (bic, coefficients)
    assert best is not None
    shares: dict[str, float] = {}
    for name in set(made.names) - {OWN}:
        mine = np.array([n == name for n in made.names])
        part = columns[:, mine] @ best[1][mine]
        shares[name] = float(part @ part)
    first = max(shares, key=lambda name: shares[name])
    return first if shares[first] > LEAST_SHARE else ""


def main() -> None:
    """A row for each class: how often each names it."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--draws", type=int, default=2)
    parser.add_argument("--classes", default=",".join(CLASSES))
    parser.add_argument("--joints", default="paper,cobot")
    parser.add_argument("--sensors", default="motor+link")
    parser.add_argument("--duration", type=float, default=40.0)
    parser.add_argument("--rate", type=float, default=500.0)
    given = parser.parse_args()
    warnings.filterwarnings("ignore", message="Sparsity parameter is too big")
    print("| hidden | draws | explain | pysindy | explain, s | pysindy, s |\n| --- | --- | --- | --- | --- | --- |")
    totals = [0, 0, 0]
    for name in given.classes.split(","):
        ours, theirs, spent = 0, 0, ([], [])
        cases = [(joint, i) for joint in given.joints.split(",") for i in range(given.draws)]
        for joint, i in cases:
            draw = Draw((name,), joint, given.sensors, "chirp", "hidden", 500 + i, given.duration, given.rate, 1.0)
            recording, hidden = drawn(draw)
            expected = "" if name == "none" else name
            start = time.perf_counter()
            try:
                found = explain(recording, GapOptions(sensors=given.sensors)).findings
                ours += (found[0].effect if found else "") == expected
            except FlexIdentError as error:
                print(f"{draw.name}: {error}")
            middle = time.perf_counter()
            theirs += named_by_regression(library(recording, given.sensors, hidden)) == expected
            spent[0].append(middle - start)
            spent[1].append(time.perf_counter() - middle)
        print(
            f"| {name} | {len(cases)} | {ours} | {theirs} | {statistics.median(spent[0]):.1f} | "
            f"{statistics.median(spent[1]):.1f} |", flush=True,
        )  # fmt: skip
        totals = [a + b for a, b in zip(totals, (len(cases), ours, theirs), strict=True)]
    print(f"| all | {totals[0]} | {totals[1]} | {totals[2]} | | |")


if __name__ == "__main__":
    main()
