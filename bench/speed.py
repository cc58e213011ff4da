"""How long identification and the search take, beside an earlier version in the same run.

    python bench/speed.py --against 167b623 --repeats 3

Recordings are those of `bench/plants` (joints, controllers and excitations that are not ours), 40 s each. Each version
runs in a process of its own, on one core, in turn; the first call of each, which compiles, is not counted.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ONE_CORE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
CHILD = """
import json, sys, time
import numpy as np
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.gap import GapOptions, explain
from flex_ident.recording import Recording
for line in sys.stdin:
    path, sensors, what, repeats = json.loads(line)
    data = np.load(path)
    link = data["link"] if sensors == "motor+link" else None
    recording = Recording(
        joint="joint", sample_rate_hz=float(data["rate"]), motor_position=data["position"],
        motor_torque=data["torque"], link_position=link,
    )
    def once():
        if what == "identify":
            return identify(recording, IdentifyOptions(sensors=sensors))
        return explain(recording, GapOptions(sensors=sensors))
    times = []
    for i in range(repeats + 1):
        began = time.process_time(), time.perf_counter()
        once()
        times.append((time.process_time() - began[0], time.perf_counter() - began[1]))
    print(json.dumps(sorted(times[1:])[repeats // 2]), flush=True)
"""


def version(folder: Path) -> subprocess.Popen[str]:
    """A process that runs one version."""
    environment = {**os.environ, **ONE_CORE, "PYTHONPATH": str(folder)}
    return subprocess.Popen(
        [sys.executable, "-c", CHILD], cwd=folder, env=environment, text=True, stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )  # fmt: skip


def asked(process: subprocess.Popen[str], task: list[object]) -> tuple[float, float]:
    """Processor time and wall time of a task, s."""
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(json.dumps(task) + "\n")
    process.stdin.flush()
    cpu, wall = json.loads(process.stdout.readline())
    return cpu, wall


def main() -> None:
    """Print a table, one row for each recording, set of sensors and command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--against", default="167b623", help="the earlier version, as git names it")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", default="7,14,16", help="indices of the recordings")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--what", default="identify,explain")
    given = parser.parse_args()
    sys.path[:0] = [str(ROOT / "bench"), str(ROOT)]
    import numpy as np
    from plants import case_of, made

    with tempfile.TemporaryDirectory() as folder:
        before = Path(folder) / "before"
        subprocess.run(["git", "worktree", "add", "-q", "--detach", str(before), given.against], cwd=ROOT, check=True)
        processes = [version(before), version(ROOT)]
        print("| recording | sensors | | before, s of processor (wall) | now | ratio |")
        print("| --- | --- | --- | --- | --- | --- |")
        try:
            for index in map(int, given.cases.split(",")):
                case = case_of(given.seed, index, False)
                recorded = made(case).recorded
                path = Path(folder) / f"{index}.npz"
                np.savez(
                    path, position=recorded.motor_position, torque=recorded.motor_torque, link=recorded.link_position,
                    rate=recorded.rate_hz,
                )  # fmt: skip
                name = f"{case.joint}, {case.controller}, {case.excitation}, {recorded.motor_torque.size} samples"
                for sensors in ("motor", "motor+link"):
                    for what in given.what.split(","):
                        times = [asked(p, [str(path), sensors, what, given.repeats]) for p in processes]
                        row = [f"{cpu:.1f} ({wall:.1f})" for cpu, wall in times]
                        ratio = times[1][0] / times[0][0]
                        print(f"| {name} | {sensors} | {what} | {row[0]} | {row[1]} | {ratio:.2f} |", flush=True)
        finally:
            for process in processes:
                process.kill()
            subprocess.run(["git", "worktree", "remove", "--force", str(before)], cwd=ROOT, check=True)


if __name__ == "__main__":
    main()
