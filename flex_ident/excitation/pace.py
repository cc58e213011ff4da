"""The pace of a recorded topic: how fast its messages come; when they stop, thin out, freeze, or come again; losses."""

from __future__ import annotations

PACE_S = 1.0
"""Time over which the pace of a topic is taken."""
SILENT_S, PERIODS = 0.5, 10.0
"""A topic has stopped after that time and that many of its own periods."""
THINNED = 0.5
"""Share of the pace at first below which a topic has thinned out."""
FEW = 5
"""Messages in `PACE_S` that a pace needs: a latched topic has none."""
SAME_STREAM = 10_000
"""Sequence numbers further apart than that are of two publishers."""


FROZEN_S = 1.0
"""Time without a change after which a topic has frozen that changed for `LIVELY` looks in a row before."""
LIVELY = 8


class Losses:
    """Messages that their publishers sent and that never came, by the numbers that DDS gives to those of each."""

    def __init__(self) -> None:
        self.lost = 0
        self._latest: list[int] = []

    def count(self, number: int, publishers: int) -> None:
        """Take the number of a message that came, of one of so many publishers."""
        latest = self._latest
        before = [n for n in latest if 0 < number - n <= SAME_STREAM]
        if number - 1 in latest:
            latest.remove(number - 1)
        elif before and len(latest) >= max(1, publishers):
            nearest = max(before)
            self.lost += number - nearest - 1
            latest.remove(nearest)
        elif len(latest) >= max(1, publishers):
            latest.pop(0)  # a publisher that has begun anew
        latest.append(number)


class Pace:
    """Fed with each message's arrival, s, and looked at now and then."""

    def __init__(self, topic: str, now: float) -> None:
        self.topic = topic
        self.count = 0
        self.longest_gap_s = 0.0
        self._began = self._latest = now
        self._window_at, self._window = now, 0
        self.first_hz: float | None = None
        self.latest_hz: float | None = None
        self._stopped = self._thin = False

    def arrived(self, now: float) -> None:
        """Count a message."""
        if self.count:
            self.longest_gap_s = max(self.longest_gap_s, now - self._latest)
        else:
            self._began = self._window_at = now
        self.count += 1
        self._window += 1
        self._latest = now

    def look(self, now: float) -> str:
        """What has changed for the worse or the better since the last look; empty when nothing has."""
        if not self.count:
            return ""
        silent = now - self._latest
        self.longest_gap_s = max(self.longest_gap_s, silent)
        if now - self._window_at >= PACE_S:
            pace = self._window / (now - self._window_at)
            self._window_at, self._window = now, 0
            if self.first_hz is None:
                self.first_hz = pace if pace * PACE_S >= FEW else 0.0
            self.latest_hz = pace
        if not self.first_hz or self.latest_hz is None:
            return ""
        stopped = silent > max(SILENT_S, PERIODS / self.first_hz)
        if stopped != self._stopped:
            self._stopped = stopped
            return f"{self.topic} has stopped" if stopped else f"{self.topic} comes again"
        thin = self.latest_hz < THINNED * self.first_hz
        if thin != self._thin and not stopped:
            self._thin = thin
            came, now_comes = f"{self.first_hz:.0f}", f"{self.latest_hz:.0f}"
            return (
                f"{self.topic} has thinned out from {came} to {now_comes} Hz"
                if thin
                else f"{self.topic} comes at {now_comes} Hz again"
            )
        return ""

    def summary(self) -> str:
        """How many came, how fast, and the longest gap."""
        span = self._latest - self._began
        if self.count < 2 or span <= 0.0:
            return f"{self.topic}: {self.count}"
        return f"{self.topic}: {self.count} at {(self.count - 1) / span:.1f} Hz, longest gap {self.longest_gap_s:.3f} s"


class Stillness:
    """Fed now and then with what a topic says, without its stamp: whether that is still the same."""

    def __init__(self, topic: str) -> None:
        self.topic = topic
        self._content: object = None
        self._changes, self._lively, self._frozen = 0, False, False
        self._changed_at = 0.0

    def look(self, now: float, content: object) -> str:
        """What has changed for the worse or the better, `content` being that of a new message; empty: nothing."""
        if content == self._content:
            self._changes = 0
            if self._lively and not self._frozen and now - self._changed_at > FROZEN_S:
                self._frozen = True
                return f"{self.topic} has frozen: the same for {now - self._changed_at:.1f} s, though messages come"
            return ""
        self._content, self._changed_at = content, now
        self._changes += 1
        self._lively = self._lively or self._changes > LIVELY
        if self._frozen:
            self._frozen = False
            return f"{self.topic} changes again"
        return ""
