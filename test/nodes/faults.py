"""What can go wrong on a robot, one by one: each plays a fault and says what came of it."""

from __future__ import annotations

import signal
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from rig import POSITION_LIMIT, Rig

from flex_ident.bags import SignalSelection, read_recording
from flex_ident.errors import FlexIdentError

ABORTED = 3


@dataclass(frozen=True)
class Outcome:
    """Exit status of the exciter, its reason, seconds of the bag that can be read, largest command, rad."""

    status: int | None
    reason: str
    seconds: float
    largest_command: float


def bag_seconds(path: Path) -> float:
    """Length of what can be read of a recording, s; 0 when nothing can."""
    try:
        return float(read_recording(path, SignalSelection(joint="elbow", sensors="motor")).time[-1])
    except FlexIdentError:
        return 0.0


def outcome(made: Rig) -> Outcome:
    """What came of it, once the exciter has ended."""
    status = made.ended("chirp_exciter")
    lines = [line for line in made.output("chirp_exciter").splitlines() if line.startswith("chirp_exciter: ")]
    reason = lines[-1].removeprefix("chirp_exciter: ") if lines else ""
    folders = list((made.folder / "bags").glob("*")) if (made.folder / "bags").exists() else []
    return Outcome(status, reason, bag_seconds(made.bag()) if folders else 0.0, made.largest_command())


def exciting(made: Rig) -> None:
    """A joint in mid-chirp."""
    made.simulated_joint(other_joints=["shoulder"], **{"controller.joints": ["shoulder", "elbow"]})
    made.exciter(**{"command.joints": ["shoulder", "elbow"]})
    refusal = made.start_exciting()
    assert not refusal, refusal
    assert made.until("exciting"), made.output("chirp_exciter")
    made.spin(2.0)


def state_fault(name: str) -> Callable[[Rig], Outcome]:
    """The joint states stop, freeze, go NaN, jump in time or lose the joint in mid-chirp."""

    def play(made: Rig) -> Outcome:
        exciting(made)
        made.fault(name)
        return outcome(made)

    return play


def killed_robot(made: Rig) -> Outcome:
    """kill -9 of the simulated joint in mid-chirp."""
    exciting(made)
    made.processes["simulated_joint"].kill()
    return outcome(made)


def killed_exciter(made: Rig) -> Outcome:
    """kill -9 of the exciter in mid-chirp: the bag reads."""
    exciting(made)
    made.processes["chirp_exciter"].kill()
    return outcome(made)


def signalled(number: signal.Signals) -> Callable[[Rig], Outcome]:
    """SIGINT or SIGTERM in mid-chirp."""

    def play(made: Rig) -> Outcome:
        exciting(made)
        made.processes["chirp_exciter"].send_signal(number)
        return outcome(made)

    return play


def start_outside(made: Rig) -> Outcome:
    """The joint stands outside of its limits."""
    made.simulated_joint(start_position=0.6)
    made.exciter(auto_start=True)
    return outcome(made)


def start_unreachable(made: Rig) -> Outcome:
    """The start position is one that the joint does not get to: its states freeze on the way."""
    made.simulated_joint()
    made.exciter(start_position="0.15", **{"limits.tracking_error": 0.5})
    refusal = made.start_exciting()
    assert not refusal, refusal
    made.until("moving_to_start")
    made.fault("freeze")
    return outcome(made)


def full_disk(made: Rig) -> Outcome:
    """The disk has less room than the recorder asks for, from the start."""
    made.simulated_joint()
    made.exciter(auto_start=True, environment={"FLEX_IDENT_LEAST_FREE_BYTES": str(2**60)})
    return outcome(made)


def two_starts_and_stops(made: Rig) -> Outcome:
    """A stop before a start, two starts, a stop."""
    made.simulated_joint()
    made.exciter()
    made.spin(1.0)
    success, message = made.call("/chirp_exciter/stop")
    assert not success
    assert "nothing to stop" in message
    refusal = made.start_exciting()
    assert not refusal, refusal
    made.until("moving_to_start")
    success, message = made.call("/chirp_exciter/start")
    assert not success
    assert "already" in message
    made.until("exciting")
    made.spin(1.0)
    success, _ = made.call("/chirp_exciter/stop")
    assert success
    return outcome(made)


FAULTS: dict[str, tuple[Callable[[Rig], Outcome], str]] = {
    "joint states stop": (state_fault("stop"), "no joint state for"),
    "joint states freeze": (state_fault("freeze"), "tracking error"),
    "joint states go NaN": (state_fault("nan"), "is nan"),
    "joint states jump in time": (state_fault("time_jump"), "jumps by"),
    "joint states lose the joint": (state_fault("lose_joint"), "vanished"),
    "kill -9 of the robot": (killed_robot, ""),
    "kill -9 of the exciter": (killed_exciter, ""),
    "SIGINT in mid-chirp": (signalled(signal.SIGINT), "stopped by SIGINT"),
    "SIGTERM in mid-chirp": (signalled(signal.SIGTERM), "stopped by SIGTERM"),
    "start outside the limits": (start_outside, "move it inside"),
    "start position not reached": (start_unreachable, "was not reached"),
    "no room on the disk": (full_disk, "MiB needed"),
    "stop before start, two starts, stop": (two_starts_and_stops, "stopped by ~/stop"),
}


def inside_limits(found: Outcome) -> bool:
    """Whether no command ever left the limits."""
    return found.largest_command <= POSITION_LIMIT
