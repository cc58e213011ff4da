"""Whether a joint follows, to the end: a controller that is inactive, of other joints or stopped takes commands and
does nothing.

A first small motion is to show it before the chirp, which is watched to its end. The joint's motion is projected onto
the reference's position and velocity, period by period: what it moves of itself, and the noise of its readings, do not
look like following. A joint that follows less and less, as the frequency rises above what its controller can do, is
none that stops.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

LEAST_GAIN = 0.1
"""Share of the reference that a joint which follows moves, the first time that can be told."""
FALL = 0.2
"""Below that share, and that share of its gain before, a joint has stopped."""
SHORTEST_S, PERIODS = 0.5, 1
"""Time and periods over which a gain is taken."""
LEAST_AMPLITUDE = 5e-4
"""Root mean square motion of the reference, rad, below which friction and encoders hide whether the joint follows."""
MOST_NOISE = 0.3
"""The same in terms of how much the joint's readings scatter about what follows."""


@dataclass
class _Sums:
    """Sums over one window, of the reference's position p and velocity v and the joint's position j."""

    n: int = 0
    p: float = 0.0
    v: float = 0.0
    j: float = 0.0
    pp: float = 0.0
    vv: float = 0.0
    pv: float = 0.0
    jp: float = 0.0
    jv: float = 0.0
    jj: float = 0.0
    low: float = math.inf
    high: float = -math.inf
    turns: int = 0
    ahead: float = 0.0

    def add(self, p: float, v: float, j: float) -> None:
        """Add an instant."""
        self.n += 1
        self.p, self.v, self.j = self.p + p, self.v + v, self.j + j
        self.pp, self.vv, self.pv = self.pp + p * p, self.vv + v * v, self.pv + p * v
        self.jp, self.jv, self.jj = self.jp + j * p, self.jv + j * v, self.jj + j * j
        self.low, self.high = min(self.low, j), max(self.high, j)
        if v != 0.0:
            sign = math.copysign(1.0, v)
            self.turns += sign != self.ahead and self.ahead != 0.0
            self.ahead = sign

    def gain(self) -> tuple[float, float, float]:
        """Share of the reference that the joint moves; root mean square of the reference's motion, and of the rest."""
        n = float(self.n)
        pp, vv, pv = self.pp - self.p**2 / n, self.vv - self.v**2 / n, self.pv - self.p * self.v / n
        jp, jv, jj = self.jp - self.j * self.p / n, self.jv - self.j * self.v / n, self.jj - self.j**2 / n
        if pp <= 0.0 or vv <= 0.0:
            return 0.0, 0.0, 0.0
        # Least squares of j on p and v; both are scaled, as v is larger than p by the frequency.
        det = 1.0 - pv**2 / (pp * vv)
        a, b = jp / pp, jv / vv
        if det > 1e-6:
            a, b = (jp / pp - pv / pp * jv / vv) / det, (jv / vv - pv / vv * jp / pp) / det
        gain = math.sqrt(max(0.0, a**2 + b**2 * vv / pp))
        rest = max(0.0, jj - a * jp - b * jv)
        return gain, math.sqrt(pp / n), math.sqrt(rest / n)


def never(sums: _Sums, gain: float, amplitude: float) -> str:
    """That a joint which is seen for the first time does not follow, empty where it does."""
    if gain >= LEAST_GAIN:
        return ""
    return (
        f"the joint does not follow: {_moved(sums, amplitude)}: is the controller active, and does command.joints hold "
        "all of its joints?"
    )


def _moved(sums: _Sums, amplitude: float) -> str:
    return f"it moved {sums.high - sums.low:.2g} rad while the reference moved {2.83 * amplitude:.2g} rad"


class FirstMotion:
    """Fed with the same as `Following` while the joint makes its first motion."""

    def __init__(self) -> None:
        self._sums = _Sums()

    def add(self, position: float, velocity: float, joint: float) -> None:
        """Add an instant."""
        self._sums.add(position, velocity, joint)

    def fault(self) -> str:
        """That the joint did not move with the reference; empty when it did, or when that cannot be told."""
        gain, amplitude, rest = self._sums.gain() if self._sums.n else (0.0, 0.0, 0.0)
        tells = amplitude >= LEAST_AMPLITUDE and rest <= MOST_NOISE * amplitude
        return never(self._sums, gain, amplitude) if tells else ""


class Following:
    """Fed at each tick with the reference's position, rad, and velocity, rad/s, and the joint's position, rad."""

    def __init__(self, start: float) -> None:
        self._sums = _Sums()
        self._since = start
        self._before: float | None = None

    def fault(self, now: float, position: float, velocity: float, joint: float) -> str:
        """What is wrong when the joint does not move with the reference any more, or never has; empty else."""
        self._sums.add(position, velocity, joint)
        if now - self._since < SHORTEST_S or self._sums.turns < 2 * PERIODS:
            return ""
        sums, self._sums, self._since = self._sums, _Sums(), now
        gain, amplitude, rest = sums.gain()
        if amplitude < LEAST_AMPLITUDE or rest > MOST_NOISE * amplitude:
            return ""
        before, self._before = self._before, gain
        if before is None:
            return never(sums, gain, amplitude)
        if gain < FALL and gain < FALL * before:
            return (
                f"the joint has stopped following: {_moved(sums, amplitude)}, and followed by {100 * before:.0f} % "
                "just before: was the robot stopped, or the controller switched?"
            )
        return ""
