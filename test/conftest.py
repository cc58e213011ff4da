"""The plants that tests take their truth from can be imported by every test; files of long tests come first."""

import os
import sys
from collections import Counter
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent / "plants"))

# Nodes of two test processes must not hear each other: each process has a ROS domain of its own.
WORKER = os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw")
if "ROS_DOMAIN_ID" in os.environ and WORKER.isdigit():
    os.environ["ROS_DOMAIN_ID"] = str((int(os.environ["ROS_DOMAIN_ID"]) + 50 * int(WORKER)) % 101)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Files with most slow tests first: two processes that take whole files would else end far apart."""
    slow = Counter(item.path for item in items if item.get_closest_marker("slow"))
    items.sort(key=lambda item: -slow[item.path])
