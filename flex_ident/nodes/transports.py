"""How a process talks to others without memory in common with them, where ROS uses Fast DDS.

Fast DDS opens the shared memory of a receiver when it first sends there, and where that receiver is not just waiting it
sleeps for a third of a second before it looks again (`healthy_check` in its SharedMemGlobal.hpp); what a process that
was killed has locked stays so, for those who send to it too. Neither a command nor a joint state can wait for that.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path

from rclpy.utilities import get_rmw_implementation_identifier

LOOPBACK = Path(__file__).with_name("loopback.xml")
FAST_DDS = ("rmw_fastrtps_cpp", "rmw_fastrtps_dynamic_cpp")
PROFILES = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")
RANGE, LOCALHOST_ONLY, STATIC_PEERS = "ROS_AUTOMATIC_DISCOVERY_RANGE", "ROS_LOCALHOST_ONLY", "ROS_STATIC_PEERS"


def without_shared_memory(environment: Mapping[str, str], middleware: str) -> dict[str, str]:
    """An environment in which a process starts without shared memory and finds the same others; `middleware` is ROS's.

    Profiles that the user gives to Fast DDS, and peers on other computers, stay as they are.
    """
    found = dict(environment)
    if middleware not in FAST_DDS:
        return found
    found["FASTDDS_BUILTIN_TRANSPORTS"] = "UDPv4"
    local = found.get(RANGE, "").upper() == "LOCALHOST" or found.get(LOCALHOST_ONLY) == "1"
    if local and not any(found.get(name) for name in (*PROFILES, STATIC_PEERS)):
        # On one computer ROS sets transports of its own, whatever the variable above says.
        found |= {RANGE: "SYSTEM_DEFAULT", **{name: str(LOOPBACK) for name in PROFILES}}
        if LOCALHOST_ONLY in found:
            found[LOCALHOST_ONLY] = "0"
    return found


def share_no_memory() -> None:
    """Have this process, before it starts ROS, and those that it starts share no memory with others."""
    os.environ.update(without_shared_memory(os.environ, get_rmw_implementation_identifier()))
