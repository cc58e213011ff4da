"""One exciter that plays a hundred runs in a row: its memory must stay flat, and every bag must be whole.

    python bench/runs_in_a_row.py [--runs 100] [--seconds 1] [--storage mcap]

A bag is whole when it holds each reference that a third process received while the joint moved, opens with its index
and metadata, and its counts are those of its messages. Memory is what the process has resident once a run is closed.
Exit status 1 when memory grows by more than 5 MiB after the first ten runs, or a run or a bag is not whole.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "test" / "nodes"))

from rig import JOINT, Rig, rig
from rosbags.highlevel import AnyReader
from stand_in import TOPIC

from flex_ident.bags.storage import Bag

SETTLED = 10
"""Runs after which everything that is made once is there."""
MOST_MIB = 5.0
REFERENCE = "/chirp_exciter/reference"


def resident_mib(process: int) -> float:
    """What a process has in memory."""
    line = next(s for s in Path(f"/proc/{process}/status").read_text().splitlines() if s.startswith("VmRSS"))
    return int(line.split()[1]) / 1024.0


def flaw(bag: Path, references: list[tuple[float, float, float]]) -> str:
    """What a bag lacks of the references that somebody else received; empty when it is whole."""
    with Bag(bag) as opened:
        counted = {t.name: t.count for t in opened.topics()}
        damage = opened.damage()
    if damage:
        return f"damaged: {damage[0].code}"
    with AnyReader([bag]) as reader:
        read: dict[str, int] = {}
        stamps = set()
        for connection, _, raw in reader.messages():
            read[connection.topic] = read.get(connection.topic, 0) + 1
            if connection.topic == REFERENCE:
                stamp = reader.deserialize(raw, connection.msgtype).header.stamp
                stamps.add((stamp.sec, stamp.nanosec))
    if any(count is not None and count != read.get(name, 0) for name, count in counted.items()):
        return f"announces {counted}, holds {read}"
    if not read.get("/joint_states"):
        return "holds no joint states"
    missing = sum((int(t), round(1e9 * (t % 1.0))) not in stamps for t, _, _ in references)
    near = {round(s + 1e-9 * n, 6) for s, n in stamps}
    missing = min(missing, sum(round(t, 6) not in near for t, _, _ in references))
    return f"lacks {missing} of {len(references)} references" if missing else ""


def run(made: Rig, seconds: float) -> str:
    """Play one run; what went wrong, else empty."""
    made.listen_up()
    made.states.clear()
    made.references.clear()
    made.commands.clear()
    refusal = made.start_exciting(30.0)
    if refusal:
        return f"refused: {refusal}"
    end = time.monotonic() + seconds + 30.0
    while made.state.get("state") not in ("done", "aborted") or "moving_to_start" not in made.states:
        if time.monotonic() > end:
            return "does not end"
        made.spin(0.05)
    made.listen_up()
    return "" if made.state["state"] == "done" else f"aborted: {made.state.get('reason', '')}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=1.0, help="of the chirp")
    parser.add_argument("--storage", default="mcap", choices=("mcap", "sqlite3"))
    given = parser.parse_args()
    memory, troubles = [], []
    with tempfile.TemporaryDirectory() as folder, rig(Path(folder)) as made:
        made.robot()
        made.exciter(**{
            "command.joints": ["shoulder", JOINT], "command.topic": TOPIC, "limits.state_timeout_s": 1.0,
            "exit_when_done": False, "chirp.duration_s": given.seconds, "chirp.start_frequency_hz": 2.0,
            "chirp.amplitude": 0.1, "chirp.fade_s": 0.2, "recording.storage": given.storage,
        })  # fmt: skip
        for number in range(given.runs):
            trouble = run(made, given.seconds)
            played = [r for r in made.references if r[2] != 0.0]
            trouble = trouble or flaw(made.bag(), played)
            memory.append(resident_mib(made.processes["chirp_exciter"].pid))
            if trouble:
                troubles.append(trouble)
            if trouble or number % 10 == 9:
                print(f"run {number + 1}: {memory[-1]:.1f} MiB{', ' + trouble if trouble else ''}", flush=True)
            if trouble == "does not end":
                break
    grown = max(memory[SETTLED:], default=0.0) - memory[min(SETTLED, len(memory)) - 1]
    slope = float(np.polyfit(np.arange(len(memory[SETTLED:])), memory[SETTLED:], 1)[0]) if len(memory) > 20 else 0.0
    early = min(SETTLED, len(memory))
    print(
        f"{len(memory)} runs, {len(troubles)} with trouble; {memory[0]:.1f} MiB after the first, "
        f"{memory[early - 1]:.1f} MiB after {early}, {memory[-1]:.1f} MiB at the end ({1024.0 * slope:+.1f} KiB a run)"
    )
    return int(bool(troubles) or grown > MOST_MIB)


if __name__ == "__main__":
    sys.exit(main())
