"""Same data, same answer: recordings changed in their last digits, identified and explained again.

    python bench/same_answer.py --recordings 8 --seed 41 --jobs 2
    python bench/same_answer.py --recordings 4 --seed 41 --explain

Torque and positions are changed by one part in 1e12 at random, three times. What counts is the largest change of a
parameter in its own standard deviations, where a tenth is promised, and whether verdict, notices or findings change.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

import numpy as np  # noqa: E402
from coverage_tables import table  # noqa: E402
from plants import CaseError, case_of, made  # noqa: E402
from recordings import recording_of  # noqa: E402

CHANGE = 1e-12
Task = tuple[int, int, str, bool, int]
"""Seed, index, sensors, whether to explain, how often to change."""
Answer = tuple[str, frozenset[str], dict[str, tuple[float, float]]]


def changed(recording: Any, rng: np.random.Generator) -> Any:
    """The recording with every sample changed in its last digits."""

    def near(signal: Any) -> Any:
        return None if signal is None else signal * (1.0 + CHANGE * rng.standard_normal(signal.size))

    return replace(
        recording, motor_position=near(recording.motor_position), motor_torque=near(recording.motor_torque),
        link_position=near(recording.link_position),
    )  # fmt: skip


def answered(recording: Any, sensors: str, explain_too: bool) -> Answer:
    """Verdict, what is said or found, and each identifiable parameter with its standard deviation."""
    if explain_too:
        from flex_ident.gap import GapOptions, explain

        found = explain(recording, GapOptions(sensors=sensors))
        names = frozenset(f"{f.effect} {f.verdict}" for f in found.findings)
        return str(found.verdict), names, _known(found.parameters)
    from flex_ident.estimation.identification import identify
    from flex_ident.estimation.options import IdentifyOptions

    result = identify(recording, IdentifyOptions(sensors=sensors))
    return str(result.verdict), frozenset(str(n.code) for n in result.notices), _known(result.parameters)


def _known(parameters: Any) -> dict[str, tuple[float, float]]:
    return {p.key: (p.value, p.std) for p in parameters if p.identifiable and p.std > 0.0}


def row_of(task: Task) -> list[object]:
    """One recording under one set of sensors."""
    seed, index, sensors, explain_too, times = task
    case = case_of(seed, index, False)
    name = f"{index} {case.joint}, {case.controller}, {case.excitation}, {case.rate_hz:g} Hz"
    try:
        recording = recording_of(made(case).recorded, sensors)
    except CaseError:
        return [name, sensors, "not played", "", "", ""]
    rng = np.random.default_rng(seed)
    first = answered(recording, sensors, explain_too)
    worst, where, said = 0.0, "", "the same"
    for _ in range(times):
        other = answered(changed(recording, rng), sensors, explain_too)
        if other[0] != first[0]:
            said = f"{first[0]}, {other[0]}"
        elif other[1] != first[1]:
            said = " ".join(sorted(first[1] ^ other[1]))
        for key in first[2].keys() & other[2].keys():
            moved = abs(other[2][key][0] - first[2][key][0]) / first[2][key][1]
            if moved > worst:
                worst, where = moved, key
    return [name, sensors, first[0], said, f"{worst:.2g}", where]


def main() -> None:
    """Print a table, one row for each recording and set of sensors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recordings", type=int, default=8)
    parser.add_argument("--seed", type=int, default=41)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--times", type=int, default=3, help="how often each is changed")
    parser.add_argument("--explain", action="store_true", help="explain the gap, in place of identifying")
    given = parser.parse_args()
    tasks = [
        (given.seed, i, sensors, given.explain, given.times)
        for i in range(given.recordings)
        for sensors in ("motor", "motor+link")
    ]
    with multiprocessing.get_context("spawn").Pool(given.jobs, maxtasksperchild=20) as pool:
        rows = pool.map(row_of, tasks, chunksize=1)
    print(table(("recording", "sensors", "verdict", "said otherwise", "moved, std", "key"), rows))


if __name__ == "__main__":
    main()
