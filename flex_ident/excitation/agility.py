"""How fast an effort makes a joint: what may stand for a moment without carrying it past its speed limit."""

from __future__ import annotations

import math

WINDOW_S = 0.01
"""Time over which a change of the speed is taken: encoders' speeds are coarse from one reading to the next."""
FORGET = 0.02
"""Weight of the latest window."""
LEAST = 5
"""Windows from which on it is known."""
AGREE = 0.3
"""Share by which a window's time, by the stamps of the readings, may differ from that of the commands."""


class Agility:
    """Fed at each tick with what was commanded and what is read; `per_effort`: acceleration, rad/s^2, per N m.

    By least squares of accelerations on efforts beyond that at rest: large ones count most, and beside them friction
    and gravity are small.
    """

    def __init__(self) -> None:
        self._start: tuple[float, float, float] | None = None
        self._at = math.nan
        self._impulse = self._both = self._square = 0.0
        self._windows = 0

    @property
    def per_effort(self) -> float:
        """Acceleration, rad/s^2, that an effort of 1 N m beyond that at rest gives the joint; 0: not known yet."""
        known = self._windows >= LEAST and self._square > 0.0
        return max(0.0, self._both / self._square) if known else 0.0

    def observe(self, now: float, stamp: float, speed: float, effort: float) -> None:
        """Take a reading, its stamp in s and its speed in rad/s; `effort`, N m, was commanded until `now`."""
        if not math.isfinite(speed):
            return
        if self._start is None or not 0.0 <= stamp - self._start[1] < 10.0 * WINDOW_S:
            self._restart(now, stamp, speed)
            return
        self._impulse += effort * max(0.0, now - self._at)
        self._at = now
        began, first, before = self._start
        passed = stamp - first
        if passed < WINDOW_S:
            return
        if abs(now - began - passed) < AGREE * passed:
            mean, gained = self._impulse / (now - began), (speed - before) / passed
            self._both += FORGET * (gained * mean - self._both)
            self._square += FORGET * (mean * mean - self._square)
            self._windows += 1
        self._restart(now, stamp, speed)

    def _restart(self, now: float, stamp: float, speed: float) -> None:
        self._start, self._at, self._impulse = (now, stamp, speed), now, 0.0
