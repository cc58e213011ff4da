"""The plants that tests take their truth from can be imported by every test; files of long tests come first."""

import os
import signal
import sys
from collections import Counter
from pathlib import Path

import pytest

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "plants"), str(HERE / "nodes")]

from domains import next_domain  # noqa: E402

os.environ["ROS_DOMAIN_ID"] = next_domain()
# The processes of tests shall not inherit what is ignored: SIGHUP by nohup, SIGINT in a script's `command &`.
if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, lambda _number, _frame: None)
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with most slow tests first: two processes that take whole files would else end far apart."""
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    items.sort(key=lambda item: -slow[item.path])
