"""Whether a machine was too busy for a test of nodes: measured beside it, on each of its processors.

`python busy.py PROCESSOR` prints a line for each time that it slept too long there, by how much, s: a virtual machine's
processors may pause one by one.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from contextlib import suppress
from typing import IO

NAP_S, LEAST_S = 0.005, 0.03
"""How long it sleeps at a time, and by how much longer it must have slept to say so."""
PAUSE_S = 0.1
"""A pause that may end any run: what the guard allows the exciter, and three periods of a slow driver."""
TOO_BUSY = (
    "no joint state for", "stood still", "no heartbeat", "old when they come", "behind, ", "saw no joint state",
    "does not answer", "stopped the joint, as no",
)  # fmt: skip
"""What nodes say of a machine that pauses, each time for a shorter while."""


class MachineBusyError(Exception):
    """A test failed while the machine was too busy for it: it is to be played again."""


class Witness:
    """The processes, one on each processor, and the pauses that they have seen."""

    def __init__(self) -> None:
        self._processes = [
            subprocess.Popen([sys.executable, __file__, str(processor)], stdout=subprocess.PIPE, bufsize=0)
            for processor in sorted(os.sched_getaffinity(0))
        ]
        for process in self._processes:
            os.set_blocking(stream(process).fileno(), False)

    def forget(self) -> float:
        """The longest pause, s, since it was asked the last time."""
        said = (stream(process).read() or b"" for process in self._processes)
        return max((float(line) for text in said for line in text.split()), default=0.0)

    def end(self) -> None:
        """End the processes."""
        for process in self._processes:
            process.kill()
            process.wait()
            stream(process).close()


def stream(process: subprocess.Popen[bytes]) -> IO[bytes]:
    """What a process says."""
    assert process.stdout is not None
    return process.stdout


def excuse(said: str, pause: float) -> str:
    """Why a failure that said this may be the machine's, where this was its longest pause, s; empty when it is not."""
    reasons = [text for text in TOO_BUSY if text in said]
    if pause < (LEAST_S if reasons else PAUSE_S):
        return ""
    return f"the machine paused for {pause:.3f} s" + (f", and '{reasons[0]}' was said" if reasons else "")


def main() -> None:
    """Watch one processor until the process is killed, or nobody listens any more."""
    os.sched_setaffinity(0, {int(sys.argv[1])})
    before = time.monotonic()
    while True:
        time.sleep(NAP_S)
        now = time.monotonic()
        if now - before > NAP_S + LEAST_S:
            # One write, whatever PYTHONUNBUFFERED says: who reads then sees whole lines only.
            os.write(sys.stdout.fileno(), f"{now - before - NAP_S:.6f}\n".encode())
        before = now


if __name__ == "__main__":
    with suppress(BrokenPipeError, KeyboardInterrupt):
        main()
