"""The nodes' console scripts, and how one comes to an end by signal at any time.

A node imports for a second or two. Signals are noted from before that until the process ends, and looked at ten times
a second: none is lost, and none is an exception in the middle of something. Nothing here may import what takes long.
"""

from __future__ import annotations

import signal
import sys
from importlib import import_module
from typing import Any

NODES = ("chirp_exciter", "identifier", "simulated_joint")
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
asked: list[str] = []
"""The names of the signals that have come."""


def note_signals() -> dict[signal.Signals, Any]:
    """Have signals add their names to `asked`; returns the handlers before. A handler may not take locks.

    SIGHUP stays ignored where it is: whoever started the node with nohup wants it to outlive the terminal.
    """
    noted = [n for n in SIGNALS if n != signal.SIGHUP or signal.getsignal(n) != signal.SIG_IGN]
    return {n: signal.signal(n, lambda number, _frame: asked.append(signal.Signals(number).name)) for n in noted}


def start(node: str) -> int:
    """Import a node and run it; returns its exit status."""
    note_signals()
    status: int = import_module(f"flex_ident.nodes.{node}").main()
    return status


def chirp_exciter() -> int:
    """Moves one joint along a chirp and records the run."""
    return start("chirp_exciter")


def identifier() -> int:
    """Answers service calls with identified parameters."""
    return start("identifier")


def simulated_joint() -> int:
    """A virtual robot joint."""
    return start("simulated_joint")


def main() -> int:
    """`python -m flex_ident.nodes NODE`, for what has no `ros2 run`; returns the exit status."""
    if len(sys.argv) < 2 or sys.argv[1] not in NODES:
        print(f"usage: python -m flex_ident.nodes {{{','.join(NODES)}}} [--ros-args ...]", file=sys.stderr)
        return 2
    return start(sys.argv.pop(1))
