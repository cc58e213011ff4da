"""Runs that record thirty topics at 300 Hz beside busy processes: none may hang, whatever the machine is doing.

    python bench/many_topics.py [--runs 40] [--seconds 2] [--topics 30] [--rate 300] [--busy 2]

Each run starts the exciter and a robot anew as processes over DDS. A run that has not ended a minute after it should
hangs; a machine that cannot keep up may end a run with a reason, and that is counted apart. Of each topic what is
missing in the bag is counted by the numbers in its messages, and compared with what the exciter said it lost. Exit
status 1 when a run hangs, or loses what it does not say.
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

NODES = Path(__file__).resolve().parent.parent / "test" / "nodes"
sys.path.insert(0, str(NODES))

from rig import JOINT, Rig, rig  # noqa: E402
from rosbags.highlevel import AnyReader  # noqa: E402
from stand_in import TOPIC  # noqa: E402

BUSY = "while True: sum(range(10000))"
PATIENCE_S = 60.0


@dataclass
class Outcome:
    """How a run ended, and what of its topics is in the bag."""

    ending: str
    seconds: float = 0.0
    received: int = 0
    missing: int = 0
    said: int = 0

    @property
    def silent(self) -> bool:
        """Whether messages are missing that were not said to be lost."""
        return self.missing > self.said


def load(made: Rig, given: argparse.Namespace) -> None:
    """Start who publishes the topics, and the busy processes."""
    commands = {"many": [sys.executable, str(NODES / "many_topics.py"), str(given.topics), str(given.rate)]}
    commands |= {f"busy_{k}": [sys.executable, "-c", BUSY] for k in range(given.busy)}
    for name, command in commands.items():
        with made.log(name).open("ab") as out:
            made.processes[name] = subprocess.Popen(command, stdout=out, stderr=out)


def played(made: Rig, given: argparse.Namespace) -> Outcome:
    """One run."""
    names = [f"/many_{k}" for k in range(given.topics)]
    made.robot()
    load(made, given)
    parameters: dict[str, Any] = {
        "command.joints": ["shoulder", JOINT], "command.topic": TOPIC, "limits.state_timeout_s": 1.0,
        "recording.topics": names, "chirp.duration_s": given.seconds,
    }  # fmt: skip
    made.exciter(**parameters)
    began = time.monotonic()
    try:
        refusal = made.start_exciting(PATIENCE_S)
    except AssertionError as error:
        return Outcome(f"hang: {str(error).splitlines()[0]}")
    if refusal:
        return Outcome(f"refused: {refusal}")
    status = made.ended("chirp_exciter", given.seconds + PATIENCE_S)
    if status is None:
        return Outcome("hang: the exciter does not end", time.monotonic() - began)
    said = made.output("chirp_exciter")
    reason = re.search(r"aborted: (.*)", said)
    outcome = Outcome("done" if status == 0 else f"status {status}: {reason[1] if reason else said[-100:]}")
    outcome.seconds = time.monotonic() - began
    outcome.said = sum(map(int, re.findall(r", (\d+) lost", said)))
    with AnyReader([made.bag()]) as reader:
        for connection in (c for c in reader.connections if c.topic in names):
            numbers = [int(reader.deserialize(raw, connection.msgtype).data) for _, _, raw in
                       reader.messages([connection])]  # fmt: skip
            outcome.received += len(numbers)
            outcome.missing += numbers[-1] - numbers[0] + 1 - len(numbers) if numbers else 0
    return outcome


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=40)
    parser.add_argument("--seconds", type=float, default=2.0, help="of the chirp")
    parser.add_argument("--topics", type=int, default=30)
    parser.add_argument("--rate", type=float, default=300.0, help="of each topic, Hz")
    parser.add_argument("--busy", type=int, default=os.cpu_count(), help="busy processes")
    given = parser.parse_args()
    outcomes = []
    for number in range(given.runs):
        with tempfile.TemporaryDirectory() as folder, rig(Path(folder)) as made:
            outcome = played(made, given)
        outcomes.append(outcome)
        print(
            f"run {number + 1}: {outcome.ending}, {outcome.seconds:.1f} s, {outcome.received} messages recorded, "
            f"{outcome.missing} missing between them, {outcome.said} said to be lost",
            flush=True,
        )
    endings = Counter(re.split(r"[:;]", o.ending)[0] for o in outcomes)
    silent = sum(o.silent for o in outcomes)
    print(f"{len(outcomes)} runs: {', '.join(f'{n} {e}' for e, n in endings.items())}; {silent} with silent losses")
    return int(endings["hang"] > 0 or silent > 0)


if __name__ == "__main__":
    sys.exit(main())
