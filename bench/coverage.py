"""Do the stated intervals hold? Recordings of seven joints under five drives, by plants of their own (`bench/plants`).

    python bench/coverage.py --recordings 60 --seed 1 --jobs 2 --out clean.jsonl --sensors both
    python bench/coverage.py --recordings 63 --seed 1 --hidden --out hidden.jsonl      # one effect each, 21 x 3 sizes
    python bench/coverage.py --recordings 60 --seed 1 --explain --out clean.jsonl      # false findings as well
    python bench/coverage.py --recordings 60 --seed 1 --effort-kind motor --out told.jsonl

Every recording and set of sensors is one line of FILE; lines that are there already are not made again, so a run can
be stopped and continued, and `--recordings 0 --out FILE` only prints the tables. `--only 3,17` makes these alone.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
import time
from pathlib import Path
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
sys.path.insert(0, str(Path(__file__).resolve().parent))
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from coverage_tables import print_tables  # noqa: E402
from lines import lines_in, parameter_columns  # noqa: E402
from plants import Case, CaseError, case_of, made  # noqa: E402
from recordings import recording_of  # noqa: E402

Line = dict[str, Any]
Task = tuple[int, int, bool, str, bool, str]
"""Seed, index, hidden, sensors, whether to explain, kind of effort as it is told."""


def name_of(task: Task) -> str:
    """What names a task's line in the file."""
    seed, index, hidden, sensors, explained, effort = task
    kind = "hidden" if hidden else "clean"
    told = "" if effort == "auto" else f"|{effort}"
    return f"{kind}|{seed}|{index}|{sensors}|{'explain' if explained else 'identify'}{told}"


def case_columns(case: Case) -> Line:
    """What the tables break results down by."""
    return {
        "joint": case.joint, "controller": case.controller, "excitation": case.excitation, "rate": case.rate_hz,
        "ratio": case.ratio, "loud": case.loud, "friction": case.friction, "effort": case.effort,
        "stratum": case.stratum, "lag_hz": case.lag_hz, "effect": case.effect, "size": case.size,
    }  # fmt: skip


def result_line(task: Task) -> Line:
    """One recording, identified or explained; an exception is a result too."""
    seed, index, hidden, sensors, explained, effort = task
    case = case_of(seed, index, hidden)
    line: Line = {"name": name_of(task), "seed": seed, "index": index, "hidden": hidden, "sensors": sensors}
    line.update(case_columns(case))
    started = time.monotonic()
    try:
        made_case = made(case)
        line["truth"] = made_case.truth
        line["made_s"] = time.monotonic() - started
        started = time.monotonic()
        done = explanation if explained else answer
        line.update(done(made_case.recorded, sensors, effort))
    except CaseError as error:  # no motion that this controller can play suits the joint: no recording, no result
        line["error"], line["verdict"] = str(error)[:500], "not played"
    except Exception as error:
        line["error"] = f"{type(error).__name__}: {error}"[:500]
        line["verdict"] = "error"
    line["seconds"] = time.monotonic() - started
    return line


def answer(recorded: Any, sensors: str, effort: str) -> Line:
    """Verdict, parameters and notices of `identify`."""
    from flex_ident.estimation.identification import identify
    from flex_ident.estimation.options import IdentifyOptions

    result = identify(recording_of(recorded, sensors), IdentifyOptions(sensors=sensors, effort_kind=effort))
    error = getattr(result.fit, "relative_error_percent", None)
    return {
        "verdict": str(result.verdict), "parameters": parameter_columns(result),
        "nuisances": {p.key: p.value for p in result.measurement},
        "notices": [str(n.code) for n in result.notices],
        "relative_error_percent": None if error is None else float(error),
    }  # fmt: skip


def explanation(recorded: Any, sensors: str, effort: str) -> Line:
    """Verdict and findings of `explain`."""
    from flex_ident.gap import GapOptions, explain

    found = explain(recording_of(recorded, sensors), GapOptions(sensors=sensors, effort_kind=effort))
    return {"verdict": str(found.verdict), "findings": [[f.effect, str(f.verdict)] for f in found.findings]}


def tasks_of(given: argparse.Namespace) -> list[Task]:
    """What was asked for, identification before explanation."""
    sensors = ("motor", "motor+link") if given.sensors == "both" else (given.sensors,)
    indices = [int(v) for v in given.only.split(",")] if given.only else range(given.recordings)
    kinds = (False, True) if given.explain else (False,)
    kinds = (True,) if given.explain_only else kinds
    return [
        (given.seed, i, given.hidden, s, kind, given.effort_kind) for kind in kinds for i in indices for s in sensors
    ]


def main() -> None:
    """Make what is missing, then print the tables of all lines of the file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recordings", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("coverage.jsonl"))
    parser.add_argument("--sensors", choices=("motor", "motor+link", "both"), default="both")
    parser.add_argument("--hidden", action="store_true", help="hide one effect in each recording")
    parser.add_argument("--explain", action="store_true", help="explain the gap as well")
    parser.add_argument("--explain-only", action="store_true", help="explain the gap and do not identify")
    parser.add_argument("--effort-kind", default="auto", help="what the effort is told to be")
    parser.add_argument("--only", default="", help="these recordings alone, as 3,17")
    parser.add_argument("--quiet", action="store_true", help="no line for each recording")
    given = parser.parse_args()
    there = {line["name"] for line in lines_in(given.out)}
    tasks = [task for task in tasks_of(given) if name_of(task) not in there]
    if tasks:
        context = multiprocessing.get_context("spawn")
        with context.Pool(max(1, given.jobs), maxtasksperchild=20) as pool, given.out.open("a") as file:
            for done, line in enumerate(pool.imap_unordered(result_line, tasks), 1):
                file.write(json.dumps(line) + "\n")
                file.flush()
                if not given.quiet:
                    what = line.get("error") or line["verdict"]
                    print(f"{done}/{len(tasks)} {line['name']} {what} {line['seconds']:.1f} s", file=sys.stderr)
    lines = [line for line in lines_in(given.out) if line["hidden"] == given.hidden]
    played = [line for line in lines if line["verdict"] != "not played"]
    print(f"{len(lines) - len(played)} of {len(lines)} could not be played: no amplitude and gain suit the joint")
    print_tables(played)


if __name__ == "__main__":
    main()
