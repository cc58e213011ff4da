"""What can go wrong on a robot, one by one: each plays a fault and says what came of it.

`python test/nodes/faults.py [TEXT]` plays those whose name holds a text, and writes their rows into docs/faults.md.
"""

from __future__ import annotations

import re
import resource
import signal
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeVar

from plant_faults import PlantOutcome, plant_rows, played
from rig import JOINT, POSITION_LIMIT, VELOCITY_LIMIT, Rig, rig
from situations import JOINT_FAULTS

from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.errors import ExcitationError, FlexIdentError

PAGE = Path(__file__).resolve().parents[2] / "docs" / "faults.md"
ABORTED = 3
TRIES = 3
MORE_BYTES = 300_000
SILENCE_S = 0.5
"""Allowed to joint states that stop; those that freeze are allowed twice what they are given."""
PATIENT_S = 1.0
"""A machine that pauses for longer than `SILENCE_S` would win the race against a fault of another kind."""


@dataclass(frozen=True)
class Outcome:
    """What came of a fault: the exciter's exit status and reason, and time from the fault to standstill, s.

    `largest` command, rad, and `fastest`, rad/s; `lost_s` of the recording, s, None: nothing was recorded.
    """

    status: int | None
    reason: str
    seconds_to_stop: float | None
    largest: float
    fastest: float
    lost_s: float | None

    @property
    def inside_limits(self) -> bool:
        """Whether no command ever left the limits."""
        return self.largest <= POSITION_LIMIT and self.fastest <= VELOCITY_LIMIT


def lost_s(made: Rig) -> float | None:
    """How much earlier than the last reference that was published the recording ends, s; None without a recording."""
    folder = made.folder / "bags"
    if not folder.exists() or not any(folder.iterdir()):
        return None
    try:
        selection = SignalSelection(joint=JOINT, sensors="motor", reference="/chirp_exciter/reference")
        recording = read_recording(made.bag(), selection)
    except ExcitationError:  # nothing moved
        return None
    except FlexIdentError as error:
        raise AssertionError(f"the bag does not read: {error}") from error
    began = made.references[0][0]
    return max(0.0, (made.references[-1][0] - began) - float(recording.time[-1] - recording.time[0]))


def outcome(made: Rig, fault_at: float | None = None) -> Outcome:
    """What came of it, once the exciter has ended."""
    status = made.ended("chirp_exciter")
    lines = [line for line in made.output("chirp_exciter").splitlines() if line.startswith("chirp_exciter: ")]
    reason = lines[-1].removeprefix("chirp_exciter: ") if lines else ""
    stopped = None
    if fault_at is not None and made.references:
        moving = [stamp for stamp, _, velocity in made.references if velocity != 0.0]
        assert moving, f"nothing was seen to move:\n{made.output('chirp_exciter')}"
        stopped = max(0.0, moving[-1] - fault_at)
    return Outcome(status, reason, stopped, made.largest_command(), made.largest_speed(), lost_s(made))


def exciting(made: Rig, **parameters: object) -> None:
    """A joint in mid-chirp."""
    made.simulated_joint(other_joints=["shoulder"], **{"controller.joints": ["shoulder", JOINT]})
    made.exciter(**{"command.joints": ["shoulder", JOINT], **parameters})
    refusal = made.start_exciting(60.0)
    assert not refusal, refusal
    assert made.until("exciting"), made.output("chirp_exciter")
    made.spin(1.2)


def state_fault(name: str, state_timeout_s: float = SILENCE_S) -> Callable[[Rig], Outcome]:
    """A fault of the joint states in mid-chirp."""

    def play(made: Rig) -> Outcome:
        exciting(made, **{"limits.state_timeout_s": state_timeout_s})
        at = time.time()
        made.fault(name)
        return outcome(made, at)

    return play


def signalled(name: str, number: signal.Signals) -> Callable[[Rig], Outcome]:
    """A signal to a node in mid-chirp."""

    def play(made: Rig) -> Outcome:
        exciting(made)
        at = time.time()
        made.processes[name].send_signal(number)
        return outcome(made, at)

    return play


def killed_exciter(storage: str) -> Callable[[Rig], Outcome]:
    """kill -9 of the exciter in mid-chirp."""

    def play(made: Rig) -> Outcome:
        exciting(made, **{"recording.storage": storage})
        made.processes["chirp_exciter"].kill()
        return outcome(made)

    return play


def killed_identifier(made: Rig) -> Outcome:
    """kill -9 of the identifier while a joint is excited: the exciter goes on to its end."""
    made.start("identifier", {"bag_directories": [str(made.folder)]})
    exciting(made, **{"chirp.duration_s": 3.0})
    made.processes["identifier"].kill()
    return outcome(made)


def nobody_listens(made: Rig) -> Outcome:
    """No controller takes the commands from the start."""
    made.simulated_joint()
    made.exciter(auto_start=True, **{"command.topic": "/commands_of_nobody"})
    return outcome(made)


def lost_subscriber(made: Rig) -> Outcome:
    """The controller that takes the commands leaves in mid-chirp, while joint states still come."""
    made.relay("/relayed")
    exciting(made, **{"command.topic": "/relayed", "chirp.amplitude": 0.1})  # small, as a relay may be late
    at = time.time()
    made.processes["relay"].send_signal(signal.SIGINT)
    return outcome(made, at)


def ignored(made: Rig) -> Outcome:
    """A controller of two joints that is given commands for one: it ignores them."""
    made.simulated_joint(other_joints=["shoulder"])
    made.exciter()
    refusal = made.start_exciting()
    assert not refusal, refusal
    return outcome(made)


def refused(*, joint: dict[str, object] | None = None, **parameters: object) -> Callable[[Rig], Outcome]:
    """An automatic start that must be refused."""

    def play(made: Rig) -> Outcome:
        made.simulated_joint(**(joint or {}))
        made.exciter(auto_start=True, **parameters)
        return outcome(made)

    return play


def blocked_way(made: Rig) -> Outcome:
    """On the way to the start position the joint states freeze: it is never seen to get there."""
    made.simulated_joint()
    made.exciter(start_position=0.2, **{"limits.state_timeout_s": 0.5 * SILENCE_S})
    refusal = made.start_exciting()
    assert not refusal, refusal
    assert made.until("moving_to_start"), made.output("chirp_exciter")
    made.spin(0.3)  # so that the recording shows it move
    at = time.time()
    made.fault("freeze")
    return outcome(made, at)


def weak_drive(made: Rig) -> Outcome:
    """A drive too weak for gravity at the start position: it sags and does not get there."""
    made.simulated_joint(MY=200.0, **{"limits.effort": 120.0})
    made.exciter(start_position=0.15, **{"limits.tracking_error": 5.0, "limits.effort": 500.0})
    refusal = made.start_exciting()
    assert not refusal, refusal
    return outcome(made)


def full_disk(made: Rig) -> Outcome:
    """The bag's file cannot grow any more in mid-chirp, as on a disk that is full."""
    exciting(made)
    bag = next(made.bag().glob("*.mcap"))
    most = bag.stat().st_size + MORE_BYTES
    at = time.time()
    resource.prlimit(made.processes["chirp_exciter"].pid, resource.RLIMIT_FSIZE, (most, most))
    return outcome(made, at)


def two_starts_and_stops(made: Rig) -> Outcome:
    """A stop before a start, two starts, a parameter while it moves, a stop."""
    made.simulated_joint()
    made.exciter()
    made.spin(1.0)
    assert made.call("/chirp_exciter/stop") == (False, "nothing to stop: idle.")
    refusal = made.start_exciting()
    assert not refusal, refusal
    assert made.until("moving_to_start"), made.output("chirp_exciter")
    success, message = made.call("/chirp_exciter/start")
    assert not success
    assert "already" in message
    assert "call ~/stop first" in made.set_parameter("chirp_exciter", "chirp.amplitude", 0.3)
    assert made.until("exciting"), made.output("chirp_exciter")
    made.spin(1.0)
    at = time.time()
    assert made.call("/chirp_exciter/stop") == (True, "ramping down")
    return outcome(made, at)


@dataclass(frozen=True)
class Fault:
    """How a fault is played and what must come of it; `recorded`: the bag must read; None: nothing moved in it."""

    play: Callable[[Rig], Outcome]
    reason: str
    status: int = ABORTED
    recorded: bool | None = True
    cut: bool = False
    """Whether the recording ends before the motion."""
    campaign: bool = False
    """Whether it promises the same as another one, and is played by `make test-campaign` alone."""

    def broken(self, found: Outcome) -> str:
        """What is not as promised; empty when all is."""
        kept = found.status == self.status and self.reason in found.reason and found.inside_limits
        return "" if kept else f"expected status {self.status}, '{self.reason}', inside the limits"


FAULTS: dict[str, Fault] = {
    "joint states stop": Fault(state_fault("stop"), "no joint state for"),
    "joint states freeze": Fault(state_fault("freeze", 0.5 * SILENCE_S), "frozen"),
    "joint states go NaN": Fault(state_fault("nan", PATIENT_S), "is nan"),
    "joint states jump in time": Fault(state_fault("time_jump", PATIENT_S), "jumps by +", campaign=True),
    "joint states lose the joint": Fault(state_fault("lose_joint"), "vanished", campaign=True),
    "kill -9 of the robot": Fault(signalled("simulated_joint", signal.SIGKILL), "no joint state for", campaign=True),
    "kill -9 of the exciter, MCAP": Fault(killed_exciter("mcap"), "", status=-9, cut=True),
    "kill -9 of the exciter, sqlite3": Fault(killed_exciter("sqlite3"), "", status=-9, cut=True, campaign=True),
    "kill -9 of the identifier": Fault(killed_identifier, "", status=0),
    "SIGINT in mid-chirp": Fault(signalled("chirp_exciter", signal.SIGINT), "stopped by SIGINT", campaign=True),
    "SIGTERM in mid-chirp": Fault(signalled("chirp_exciter", signal.SIGTERM), "stopped by SIGTERM", campaign=True),
    "the disk is full in mid-chirp": Fault(full_disk, "failed (File too large)", cut=True),
    "too little room on the disk": Fault(
        refused(**{"recording.least_free_mib": 1e6}), "MiB needed: make room", recorded=False
    ),
    "nobody takes the commands": Fault(
        nobody_listens, "nobody listens on /commands_of_nobody:", recorded=False, campaign=True
    ),
    "the controller leaves in mid-chirp": Fault(lost_subscriber, "nobody listens on /relayed any more"),
    "the controller ignores the commands": Fault(ignored, "does not follow", recorded=None, campaign=True),
    "stands outside its limits": Fault(refused(joint={"start_position": 0.6}), "move it inside", recorded=False),
    "start position outside the limits": Fault(
        refused(start_position=1.0), "cannot be reached", recorded=False, campaign=True
    ),
    "joint states freeze on the way to the start": Fault(blocked_way, "frozen", campaign=True),
    "a start position never reached": Fault(weak_drive, "was not reached"),
    "stop before start, two starts, stop": Fault(two_starts_and_stops, "stopped by ~/stop"),
}


def rows(outcomes: dict[str, Outcome]) -> dict[str, str]:
    """The outcomes as rows of Markdown, by what they begin with."""
    found = {}
    for name, o in outcomes.items():
        reason = re.sub(r"/tmp/\S*/bags/", ".../", o.reason)
        stop = "" if o.seconds_to_stop is None else f"{o.seconds_to_stop:.2f}"
        lost = f"{o.lost_s:.2f}" if o.lost_s is not None and FAULTS[name].cut else ""
        found[f"| {name} |"] = (
            f"| {name} | {o.status}: {reason or 'none'} | {stop} | {o.largest:.3f} | {o.fastest:.2f} | {lost} |"
        )
    return found


def with_rows(page: str, new: dict[str, str]) -> str:
    """The page with rows put in place of those that begin alike. Raises AssertionError where one has no place."""
    lines = page.splitlines()
    for begin, row in new.items():
        places = [i for i, line in enumerate(lines) if line.startswith(begin)]
        assert len(places) == 1, f"{PAGE.name} has {len(places)} rows '{begin}'"
        lines[places[0]] = row
    return "\n".join(lines) + "\n"


Found = TypeVar("Found", Outcome, PlantOutcome)


def as_expected(play: Callable[[Rig], Found], broken: Callable[[Found], str], name: str) -> Found:
    """What came of a fault, played again where a machine busy with other things had another one of its own.

    Raises AssertionError when what must come of it does not.
    """
    for attempt in range(TRIES):
        with tempfile.TemporaryDirectory() as folder, rig(Path(folder)) as made:
            try:
                found = play(made)
            except AssertionError as error:
                print(f"{name}, {attempt}: {error}", flush=True)
                continue
            print(name, found, flush=True)
            if not (what := broken(found)):
                return found
            print(f"{name}, {attempt}: broken: {what}", flush=True)
    raise AssertionError(f"{name} is not as it must be")


def main() -> int:
    """Play the faults whose name holds the text that is given, all without one, and write their rows into the page."""
    text = sys.argv[1] if len(sys.argv) > 1 else ""
    plays = {name: partial(_row, name) for name in FAULTS if text in name}
    plays |= {f"{name}, {kind}": partial(_plant_row, name, kind) for name, fault in JOINT_FAULTS.items()
              for kind in fault.kinds if text in f"{name}, {kind}"}  # fmt: skip
    failed = False
    for name, play in plays.items():
        try:
            new = play()
            PAGE.write_text(with_rows(PAGE.read_text(encoding="utf-8"), new), encoding="utf-8")
        except AssertionError as error:
            print(f"{name}: {error}; its row stays as it was", file=sys.stderr)
            failed = True
    return int(failed)


def _row(name: str) -> dict[str, str]:
    return rows({name: as_expected(FAULTS[name].play, FAULTS[name].broken, name)})


def _plant_row(name: str, kind: str) -> dict[str, str]:
    fault = JOINT_FAULTS[name]
    play = partial(played, fault=fault, kind=kind)
    return plant_rows({(name, kind): as_expected(play, fault.broken, f"{name}, {kind}")})


if __name__ == "__main__":
    sys.exit(main())
