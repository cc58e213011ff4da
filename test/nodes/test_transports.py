"""Neither the exciter nor its guard shares memory with others, in which a killed process may hold them up."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from rig import rig
from stand_in import TOPIC, guard_pid

from flex_ident.nodes.transports import (
    FAST_DDS,
    LOCALHOST_ONLY,
    LOOPBACK,
    PROFILES,
    RANGE,
    STATIC_PEERS,
    without_shared_memory,
)

BUILTIN = "FASTDDS_BUILTIN_TRANSPORTS"


def test_on_a_network_a_variable_does_and_all_else_stays() -> None:
    given = {RANGE: "SUBNET", "HOME": "/root"}
    assert without_shared_memory(given, FAST_DDS[0]) == {**given, BUILTIN: "UDPv4"}


@pytest.mark.parametrize("local", [{RANGE: "LOCALHOST"}, {LOCALHOST_ONLY: "1"}])
def test_on_one_computer_it_takes_a_profile_on_loopback_alone(local: dict[str, str]) -> None:
    found = without_shared_memory(local, FAST_DDS[0])
    assert found[RANGE] == "SYSTEM_DEFAULT"
    assert found.get(LOCALHOST_ONLY, "0") == "0"
    assert {found[name] for name in PROFILES} == {str(LOOPBACK)}
    assert "<address>127.0.0.1</address>" in LOOPBACK.read_text()
    assert without_shared_memory(found, FAST_DDS[0]) == found


def test_what_the_user_says_of_fast_dds_and_other_middlewares_stay_as_they_are() -> None:
    given = {RANGE: "LOCALHOST", PROFILES[0]: "/mine.xml"}
    assert without_shared_memory(given, FAST_DDS[0]) == {**given, BUILTIN: "UDPv4"}
    assert without_shared_memory(given, "rmw_cyclonedds_cpp") == given
    peers = {RANGE: "LOCALHOST", STATIC_PEERS: "192.0.2.1"}
    assert without_shared_memory(peers, FAST_DDS[0])[RANGE] == "LOCALHOST"


@pytest.mark.ros
def test_the_processes_have_none_and_stay_on_loopback(tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.exciter(**{"command.topic": TOPIC})
        assert made.node_appears("chirp_exciter")
        assert made.node_appears("chirp_exciter_guard")
        for pid in (made.processes["chirp_exciter"].pid, guard_pid(made)):
            names = {task.read_text().strip() for task in Path(f"/proc/{pid}/task").glob("*/comm")}
            assert any(name.startswith("dds.udp") for name in names), names
            assert not any(name.startswith("dds.shm") for name in names), names
            assert all(address == "127.0.0.1" for address in udp_addresses(pid))


def udp_addresses(pid: int) -> list[str]:
    """Where the UDP sockets of a process are bound."""
    links = [str(file.readlink()) for file in Path(f"/proc/{pid}/fd").iterdir()]
    rows = [line.split() for line in Path("/proc/net/udp").read_text().splitlines()[1:]]
    mine = [row[1].partition(":")[0] for row in rows if f"socket:[{row[9]}]" in links]
    return [".".join(str(byte) for byte in reversed(bytes.fromhex(address))) for address in mine]
