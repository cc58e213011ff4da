"""What can go wrong on a robot, measured on its joints and not on the commands: under each kind of command.

`test_plant_faults.py` plays each, and the `SITUATIONS` of `situations.py`; `faults.py` writes the tables.
"""

from __future__ import annotations

import math
import os
import re
import resource
import signal
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from rig import JOINT, POSITION_LIMIT, VELOCITY_LIMIT, Rig
from stand_in import KINDS, STOPPED, exciting, guard_pid

EFFORT_LIMIT = 60.0
TIMEOUT_S = 0.6
"""Of joint states, where these are at fault."""
MORE_BYTES = 100_000
"""That a bag may grow on a disk that is about to be full."""
REFUSED = "refused"
ALL_KINDS = ("position", "velocity", "effort", "trajectory")
LEAST_MOTION, LONGEST_STAND_S = 1e-3, 3.0
"""What counts as motion, rad; time in which a joint must stand."""
HELD_AT = 0.5
"""Where the joint that shall hold stands, rad."""


@dataclass(frozen=True)
class PlantOutcome:
    """What came of it: exit status and reason; when the joint stood still after the fault, s, how far it ever was from
    where it began, rad, how fast, rad/s, and its largest effort, N m; how far the joint moved that shall hold, rad.

    The status of a node that refuses a call of ~/start, and stays, is `REFUSED`.
    """

    status: int | str | None
    reason: str
    seconds_to_stand: float
    farthest: float
    fastest: float
    strongest: float
    other: float

    @property
    def inside_limits(self) -> bool:
        """Whether the joint never left position, speed and effort limits, and the other one held."""
        return (
            self.farthest <= POSITION_LIMIT and self.fastest <= VELOCITY_LIMIT and self.strongest <= EFFORT_LIMIT
            and self.other < 0.02
        )  # fmt: skip


def measured(made: Rig, at: float, told: tuple[int | str | None, str]) -> PlantOutcome:
    """What came of a fault at that instant of the steady clock, once all is over; `told` are status and reason."""
    truth = made.truth()
    after = truth[truth[:, 0] > at]
    moving = after[np.abs(after[:, 4]) > STOPPED]
    still = after[-1, 0] - moving[-1, 0] > 0.3 if len(moving) else True
    stands = (moving[-1, 0] - at if len(moving) else 0.0) if still else math.inf
    return PlantOutcome(
        *told, max(0.0, stands),
        float(np.abs(truth[:, 2] - truth[0, 2]).max()), float(np.abs(truth[:, 4]).max()),
        float(np.abs(truth[:, 6]).max()), float(np.abs(truth[:, 1] - HELD_AT).max()),
    )  # fmt: skip


def last_words(said: str, wanted: str) -> str:
    """Why a node ended, from what it said; where that was nothing, what it noted of what is wanted, and empty else."""
    lines = said.splitlines()
    if ends := [line for line in lines if line.startswith("chirp_exciter")]:
        return ends[-1].partition(": ")[2]
    noted = [line.partition("[chirp_exciter]: ")[2] for line in lines if wanted and wanted in line]
    return noted[0] if noted else ""


Play = Callable[[Rig, str], float | str]
"""Plays a fault under a kind of command; the instant at which it happened, or why ~/start was refused."""


def signalled(name: str, *, later_s: float = 0.0) -> Play:
    """A signal to the exciter, so much later in the chirp than usual; one that stands still goes on after 2 s."""

    def play(made: Rig, kind: str) -> float:
        exciting(made, kind)
        made.spin(later_s)
        at = time.monotonic()
        made.processes["chirp_exciter"].send_signal(getattr(signal, name))
        if name == "SIGSTOP":
            made.spin(2.0)
            made.processes["chirp_exciter"].send_signal(signal.SIGCONT)
        return at

    return play


def guard_killed(made: Rig, kind: str) -> float:
    """The guard dies in mid-chirp."""
    exciting(made, kind)
    at = time.monotonic()
    os.kill(guard_pid(made), signal.SIGKILL)
    return at


def called_off(made: Rig, kind: str) -> float:
    """Somebody calls the run off."""
    exciting(made, kind)
    at = time.monotonic()
    assert made.call("/chirp_exciter/stop") == (True, "ramping down")
    return at


def full_disk(made: Rig, kind: str) -> float:
    """The bag's file cannot grow any more, as on a disk that is full."""
    exciting(made, kind)
    most = next(made.bag().glob("*.mcap")).stat().st_size + MORE_BYTES
    at = time.monotonic()
    resource.prlimit(made.processes["chirp_exciter"].pid, resource.RLIMIT_FSIZE, (most, most))
    return at


def robot_fault(name: str, *, later_s: float = 0.0, **parameters: Any) -> Play:
    """A fault of the robot in mid-chirp, so much later than usual."""

    def play(made: Rig, kind: str) -> float:
        exciting(made, kind, **{"limits.state_timeout_s": TIMEOUT_S, **parameters})
        made.spin(later_s)
        at = time.monotonic()
        made.set_parameter("robot", "fault", name)
        return at

    return play


def inactive(made: Rig, kind: str) -> float:
    """A controller that is loaded and not active, and nobody who says so."""
    its, ours = KINDS[kind]
    made.robot(**{**its, "active": False})
    made.exciter(**{"command.joints": ["shoulder", JOINT], "limits.state_timeout_s": 1.0, **ours})
    refusal = made.start_exciting()
    assert not refusal, refusal
    return time.monotonic()


@dataclass(frozen=True)
class PlantFault:
    """How a fault is played, under which kinds of command, and what must come of it.

    `still`: nothing may move; `after` looks at what else must be true in the end.
    """

    play: Play
    reason: str
    status: int | str = 3
    kinds: tuple[str, ...] = ALL_KINDS
    still: bool = False
    after: Callable[[Rig], None] | None = None

    def broken(self, found: PlantOutcome) -> str:
        """Which promise was broken; empty when none was."""
        moved = found.farthest > LEAST_MOTION
        kept = {
            f"status {self.status}": found.status == self.status,
            f"'{self.reason}'": self.reason in found.reason,
            "inside the limits": found.inside_limits,
            "at rest in the end": found.seconds_to_stand < LONGEST_STAND_S,
            "nothing moves": not (self.still and moved),
            "the joint is excited": moved or self.status != 0,
        }
        return ", ".join(what for what, is_so in kept.items() if not is_so)


BAD_READINGS = {
    "the reading wraps by a whole turn": ("wrap", "a whole turn: it wraps"),
    "the reading jumps by 0.3 rad": ("jump", "jumps by +0."),
    "the readings freeze, their stamps go on": ("freeze", "their stamps go on"),
    "the driver repeats one message": ("repeat", "the same stamp again"),
    "the readings go NaN": ("nan", "is nan"),
    "the readings lose the joint": ("lose_joint", "vanished"),
    "the readings come later and later": ("late", "behind, 0.600 s allowed"),
    "the readings' clock jumps by 5 s": ("time_jump", "time jumps by +"),
    "the readings stop": ("stop", "no joint state for"),
}
"""What the robot's driver does, and the cause that must be told."""
PLANT_FAULTS: dict[str, PlantFault] = {
    "kill -9 of the exciter": PlantFault(signalled("SIGKILL"), "no heartbeat for", status=-9),
    "kill -9 of the exciter where the chirp is fastest": PlantFault(
        signalled("SIGKILL", later_s=3.9), "no heartbeat for", status=-9
    ),
    "the exciter stands still where the chirp is fastest": PlantFault(
        signalled("SIGSTOP", later_s=3.9), "this node stood still for"
    ),
    "the exciter stands still (SIGSTOP) and goes on": PlantFault(signalled("SIGSTOP"), "this node stood still for"),
    "the terminal closes (SIGHUP)": PlantFault(signalled("SIGHUP"), "stopped by SIGHUP"),
    "SIGINT": PlantFault(signalled("SIGINT"), "stopped by SIGINT"),
    "SIGTERM": PlantFault(signalled("SIGTERM"), "stopped by SIGTERM"),
    "a call of ~/stop": PlantFault(called_off, "stopped by ~/stop"),
    "the disk is full": PlantFault(full_disk, "failed (File too large)"),
    "kill -9 of the guard": PlantFault(guard_killed, "has ended"),
    **{name: PlantFault(robot_fault(fault), reason) for name, (fault, reason) in BAD_READINGS.items()},
    "the controller is not active from the start": PlantFault(inactive, "does not follow"),
    "the controller is switched off at two thirds": PlantFault(
        robot_fault("inactive", later_s=3.0), "has stopped following", kinds=("position", "trajectory")
    ),
    "a protective stop at two thirds": PlantFault(robot_fault("halt", later_s=3.0), "has stopped following"),
}
"""A controller that is switched off leaves the last speed or effort standing, which nobody on the network can end: that
fault has no row under these kinds."""


def played(made: Rig, fault: PlantFault, kind: str) -> PlantOutcome:
    """Play one fault under one kind of command. A run that goes on to its end must leave the joint at rest."""
    at = fault.play(made, kind)
    status: int | str | None = REFUSED
    if not isinstance(at, str):
        status = made.ended("chirp_exciter")
    over = time.monotonic()
    while made.truth()[-1, 0] < over + 1.0 and time.monotonic() < over + 15.0:
        made.spin(0.5)
    if fault.after is not None:
        fault.after(made)
    if isinstance(at, str):
        return measured(made, over, (status, at))
    told = status, last_words(made.output("chirp_exciter"), fault.reason)
    return measured(made, over if status == 0 else at, told)


def plant_rows(outcomes: dict[tuple[str, str], PlantOutcome]) -> dict[str, str]:
    """The outcomes as rows of Markdown, by what they begin with."""
    return {
        f"| {name} | {kind} |": (
            f"| {name} | {kind} | {o.status}: {reason(o)} | {o.seconds_to_stand:.2f} | {o.farthest:.3f} | "
            f"{o.fastest:.2f} | {o.strongest:.1f} |"
        )
        for (name, kind), o in outcomes.items()
    }


def reason(found: PlantOutcome) -> str:
    """The reason as the page has it: without what differs from one computer to the next."""
    return re.sub(r"/tmp/\S*?/(bags/)?(?=\w+[. ])", ".../", found.reason) or "none"
