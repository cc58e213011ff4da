"""When a guard takes over: the commands stand for longer than they may, or whoever sent them is gone.

The exciter says with each command until when it may stand, and what may stand for ever; of efforts, none may: it says
how the joints are to be held by feedback. Knows nothing of processes.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from functools import lru_cache

from flex_ident.errors import ConfigurationError
from flex_ident.excitation.holding import Hold, Holding
from flex_ident.excitation.joint_states import JointSample

REPEAT_S, INSIST_S = 0.02, 2.0
"""A guard that has taken over repeats its command at this interval, for this long: a message may be lost."""
HOLD_S, LONGEST_HOLD_S = 0.002, 10.0
"""A guard with feedback commands at this interval, goes on until the joints stand still, and no longer than that."""
WAIT_S = 0.5
BETWEEN = "\t"


@dataclass(frozen=True)
class Beat:
    """A heartbeat, sent at `sent` s of the system's steady clock.

    `armed`: something moves, and when the next beat does not come within `lease_s`, the `row` is to be commanded to
    `joints`. Under effort commands `hold` says how the joints are held by feedback; `standing` are the efforts that
    stand now, of the joint that moves and of those that hold, and `position`, rad, where the former was seen latest,
    None: nowhere that is to be believed.
    """

    sent: float
    armed: bool
    lease_s: float
    row: tuple[float, ...]
    joints: tuple[str, ...] = ()
    hold: Hold | None = None
    standing: tuple[float, ...] = ()
    position: float | None = None

    def line(self) -> bytes:
        """As a line of text: what differs from beat to beat, and how to hold, which does not."""
        content = [self.sent, self.armed, self.lease_s, self.row, self.joints, self.standing, self.position]
        hold = "" if self.hold is None else self.hold.text
        return f"{json.dumps(content, separators=(',', ':'))}{BETWEEN}{hold}\n".encode()

    @staticmethod
    def read(line: bytes) -> Beat:
        """From a line of text. Raises ValueError when it is none."""
        content, _, hold = line.decode().strip().partition(BETWEEN)
        try:
            sent, armed, lease, row, joints, standing, position = json.loads(content)
            return Beat(
                float(sent), bool(armed), float(lease), tuple(map(float, row)), tuple(map(str, joints)),
                _hold(hold) if hold else None, tuple(map(float, standing)),
                None if position is None else float(position),
            )  # fmt: skip
        except (TypeError, ConfigurationError) as error:
            raise ValueError(str(error)) from error

    def holding(self) -> Holding | None:
        """What holds the joints by feedback, where they are to be held so."""
        if self.hold is None or self.hold.joint not in self.joints or len(self.standing) != len(self.joints):
            return None
        return Holding(self.hold, self.sent, self.position, self.standing[0], self.standing[1:])

    def with_efforts(self, effort: float, others: tuple[float, ...]) -> Beat:
        """The same with other efforts to be commanded."""
        assert self.hold is not None
        at = self.joints.index(self.hold.joint)
        return replace(self, row=(*others[:at], effort, *others[at:]))


class Guarding:
    """Stepped with each beat and whenever time has passed."""

    def __init__(self) -> None:
        self._beat: Beat | None = None
        self._gone = False
        self._taken_at: float | None = None
        self._sent_at: float | None = None
        self._holding: Holding | None = None
        self._left = False
        """Whether the joints have been left with what may stand for ever."""

    @property
    def hold(self) -> Hold | None:
        """How the joints are held by feedback, where they are."""
        return None if self._beat is None else self._beat.hold

    @property
    def taken_over(self) -> bool:
        """Whether the guard commands the joints now."""
        return self._taken_at is not None

    def beat(self, beat: Beat) -> None:
        """Take a heartbeat: who sends it commands the joints."""
        self._beat = beat
        self._taken_at = self._sent_at = self._holding = None
        self._left = False

    def observe(self, sample: JointSample | None) -> None:
        """Take a joint state, where joints are held by feedback; None: one that cannot be read."""
        if self._holding is not None and sample is not None:
            self._holding.observe(sample)
        elif self._holding is not None:
            self._holding.distrust()

    def gone(self) -> None:
        """No more heartbeats will come."""
        self._gone = True

    @property
    def alone(self) -> bool:
        """Whether no more heartbeats will come."""
        return self._gone

    def overdue(self, now: float) -> bool:
        """Whether something moves that nobody commands."""
        beat = self._beat
        return beat is not None and beat.armed and (self._gone or now - beat.sent > beat.lease_s)

    def due(self, now: float) -> Beat | None:
        """The beat whose row is to be commanded at this instant; None: nothing is."""
        beat = self._beat
        if beat is None or not self.overdue(now):
            return None
        if self._taken_at is None:
            self._taken_at, self._holding = now, beat.holding()
        if self._left or (self._sent_at is not None and now - self._sent_at < self._interval_s):
            return None
        holding, self._left = self._holding, self._over(now)
        if self._left and holding is None:
            return None
        self._sent_at = now
        if holding is None:
            return beat
        return beat.with_efforts(*(holding.last if self._left else holding.step(now)))

    @property
    def _interval_s(self) -> float:
        return REPEAT_S if self._holding is None else HOLD_S

    def _over(self, now: float) -> bool:
        """Whether a guard that has taken over has done what it can."""
        passed = math.inf if self._taken_at is None else now - self._taken_at
        if self._holding is None or self._holding.blind or self._holding.stood(now):
            return passed > INSIST_S
        return passed > LONGEST_HOLD_S

    def wait_s(self, now: float) -> float:
        """How long nothing is due, unless a beat comes, s."""
        beat = self._beat
        if beat is None or not beat.armed:
            return WAIT_S
        if self._taken_at is None:
            return max(0.0, beat.sent + beat.lease_s - now)
        return WAIT_S if self._left else self._interval_s

    def finished(self, now: float) -> bool:
        """Whether there is nothing left to guard."""
        if not self._gone:
            return False
        if self._beat is None or not self._beat.armed or self._left:
            return True
        return self._taken_at is not None and self._holding is None and self._over(now)


@lru_cache(maxsize=2)
def _hold(text: str) -> Hold:
    """How to hold; the same text comes with each beat of a motion."""
    return Hold.of(json.loads(text))
