"""When a guard takes over: the commands stand for longer than they may, or whoever sent them is gone.

The exciter says with each command until when it may stand, and what may stand for ever. Knows nothing of processes.
"""

from __future__ import annotations

import json
from dataclasses import dataclass

REPEAT_S, INSIST_S = 0.02, 2.0
"""A guard that has taken over repeats its command at this interval, for this long: a message may be lost."""
WAIT_S = 0.5


@dataclass(frozen=True)
class Beat:
    """A heartbeat, sent at `sent` s of the system's steady clock.

    `armed`: something moves, and when the next beat does not come within `lease_s`, the `row` is to be commanded to
    `joints`.
    """

    sent: float
    armed: bool
    lease_s: float
    row: tuple[float, ...]
    joints: tuple[str, ...] = ()

    def line(self) -> bytes:
        """As a line of text."""
        content = [self.sent, self.armed, self.lease_s, self.row, self.joints]
        return json.dumps(content, separators=(",", ":")).encode() + b"\n"

    @staticmethod
    def read(line: bytes) -> Beat:
        """From a line of text. Raises ValueError when it is none."""
        sent, armed, lease, row, joints = json.loads(line)
        return Beat(float(sent), bool(armed), float(lease), tuple(map(float, row)), tuple(map(str, joints)))


class Guarding:
    """Stepped with each beat and whenever time has passed."""

    def __init__(self) -> None:
        self._beat: Beat | None = None
        self._gone = False
        self._taken_at: float | None = None
        self._sent_at: float | None = None

    @property
    def taken_over(self) -> bool:
        """Whether the guard commands the joints now."""
        return self._taken_at is not None

    def beat(self, beat: Beat) -> None:
        """Take a heartbeat: who sends it commands the joints."""
        self._beat = beat
        self._taken_at = self._sent_at = None

    def gone(self) -> None:
        """No more heartbeats will come."""
        self._gone = True

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
            self._taken_at = now
        if now - self._taken_at > INSIST_S or (self._sent_at is not None and now - self._sent_at < REPEAT_S):
            return None
        self._sent_at = now
        return beat

    def wait_s(self, now: float) -> float:
        """How long nothing is due, unless a beat comes, s."""
        beat = self._beat
        if beat is None or not beat.armed:
            return WAIT_S
        if self._taken_at is None:
            return max(0.0, beat.sent + beat.lease_s - now)
        return REPEAT_S if now - self._taken_at <= INSIST_S else WAIT_S

    def finished(self, now: float) -> bool:
        """Whether there is nothing left to guard."""
        if not self._gone:
            return False
        moving = self._beat is not None and self._beat.armed
        return not moving or (self._taken_at is not None and now - self._taken_at > INSIST_S)
