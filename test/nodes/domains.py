"""ROS domains of the tests: processes that run side by side share none, nor do a test and the one before it."""

from __future__ import annotations

import os
from itertools import count

DOMAINS = 100
"""From 1; those above 101 may take ports that Linux gives to others (docs.ros.org, "The ROS_DOMAIN_ID")."""
OWN = 4
"""Domains of a process in turn: a node that was killed is still known in its own for 20 s, Fast DDS's lease."""
WORKER = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
WORKERS = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
FIRST = int(os.environ.get("ROS_DOMAIN_ID") or os.getpid())
"""What the run was given, which its worker processes inherit."""
_turns = count()


def next_domain() -> str:
    """The domain of one more experiment, for `ROS_DOMAIN_ID`."""
    return str((FIRST - 1 + WORKER * (DOMAINS // WORKERS) + next(_turns) % OWN) % DOMAINS + 1)
