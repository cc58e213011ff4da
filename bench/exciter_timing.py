"""The exciter's timing beside a simulated joint: python bench/exciter_timing.py --rate 1000 --duration 60

Two processes over DDS on this machine, nothing else listening: samples lost, command jitter, CPU share of each.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from rosbags.highlevel import AnyReader

from flex_ident.bags.selection import REFERENCE

JOINT = "joint_1"
TICK_S = 1.0 / os.sysconf("SC_CLK_TCK")
START_S = 30.0
NODES = ("simulated_joint", "chirp_exciter")


def started(name: str, parameters: dict[str, object], log: Path) -> subprocess.Popen[bytes]:
    """A node as a process that writes to a log."""
    arguments = [sys.executable, "-m", "flex_ident.nodes", name, "--ros-args"]
    for key, value in parameters.items():
        arguments += ["-p", f"{key}:={json.dumps(value)}"]
    return subprocess.Popen(arguments, stdout=log.open("wb"), stderr=subprocess.STDOUT)


def processor_time(process: subprocess.Popen[bytes]) -> float:
    """Time, s, that a running process has spent on processors."""
    fields = Path(f"/proc/{process.pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) * TICK_S


def stamps(bag: Path, topic: str) -> np.ndarray:
    """Header stamps (n,), s, of a topic's messages."""
    with AnyReader([bag]) as reader:
        chosen = [c for c in reader.connections if c.topic == topic]
        raw = [data[4:12] for _, _, data in reader.messages(connections=chosen)]
    pairs = np.frombuffer(b"".join(raw), np.dtype([("s", "<i4"), ("ns", "<u4")]))
    return (pairs["s"] - pairs["s"][0]) + 1e-9 * pairs["ns"]


def missing(times: np.ndarray, period: float) -> int:
    """How many samples of that period are not there between the first and the last."""
    return round(float(times[-1] - times[0]) / period) + 1 - times.size


def main() -> None:
    """Play one chirp, then print what was lost, how late commands were, and what it cost."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rate", type=float, default=1000.0)
    parser.add_argument("--duration", type=float, default=60.0)
    given = parser.parse_args()
    os.environ.setdefault("ROS_DOMAIN_ID", str(1 + os.getpid() % 100))
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        logs = {node: folder / f"{node}.log" for node in NODES}
        joint = started("simulated_joint", {"joint": JOINT, "rate_hz": given.rate}, logs["simulated_joint"])
        exciter = started(
            "chirp_exciter",
            {
                "joint": JOINT, "auto_start": True, "rate_hz": given.rate, "chirp.duration_s": given.duration,
                "chirp.profile": "constant_velocity", "chirp.start_frequency_hz": 0.5, "chirp.amplitude": 0.2,
                "recording.directory": str(folder / "bags"),
            },
            logs["chirp_exciter"],
        )  # fmt: skip
        try:
            report(given, joint, exciter, logs, folder)
        finally:
            joint.terminate()
            exciter.terminate()


def report(
    given: argparse.Namespace, joint: subprocess.Popen[bytes], exciter: subprocess.Popen[bytes], logs: dict[str, Path],
    folder: Path,
) -> None:  # fmt: skip
    """Wait for the run and print its figures."""
    end = time.monotonic() + START_S
    while " exciting" not in logs["chirp_exciter"].read_text():
        if time.monotonic() > end or exciter.poll() is not None:
            sys.exit(f"the chirp did not begin: {logs['chirp_exciter'].read_text()[-300:]}")
        time.sleep(0.05)
    began, before = time.monotonic(), [processor_time(p) for p in (joint, exciter)]
    time.sleep(0.95 * given.duration)
    took, after = time.monotonic() - began, [processor_time(p) for p in (joint, exciter)]
    if exciter.wait(0.5 * given.duration + 20.0) != 0:
        sys.exit(f"the chirp was not played: {logs['chirp_exciter'].read_text()[-300:]}")
    [bag] = (folder / "bags").iterdir()
    print(f"{given.rate:g} Hz, {given.duration:g} s, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}\n")
    for line in re.findall(r"\]: (\d+ commands at .*|recorded .*)", logs["chirp_exciter"].read_text()):
        print(re.sub(r" to /\S+,", ",", line))
    references, states = stamps(bag, REFERENCE), stamps(bag, "/joint_states")
    for what, times in (("references", references), ("joint states", states)):
        gone, spread = missing(times, 1.0 / given.rate), 1e6 * np.percentile(np.diff(times), (1, 50, 99, 100))
        print(
            f"{what} in the bag: {times.size}, {gone} missing ({100 * gone / times.size:.3f} %), "
            f"from one to the next {spread[0]:.0f} / {spread[1]:.0f} / {spread[2]:.0f} / {spread[3]:.0f} us "
            "(1 %, 50 %, 99 %, most)"
        )
    for name, start, stop in zip(NODES, before, after, strict=True):
        print(f"{name}: {100 * (stop - start) / took:.0f} % of one core")


if __name__ == "__main__":
    main()
