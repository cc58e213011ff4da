"""Smooth motions between states: the way to the start pose, and braking inside the limits."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flex_ident.excitation.limits import Limits

SHORTEST_TRAVEL_S = 1.0
BRAKING_S = 0.3
SLOWEST_S = 1e-3


@dataclass(frozen=True)
class Travel:
    """A way from one position to another along a raised cosine, from `start` to `end` s."""

    start: float
    end: float
    origin: float
    goal: float

    def at(self, now: float) -> tuple[float, float]:
        """Position and velocity at `now` s."""
        span = self.end - self.start
        x = min(1.0, max(0.0, (now - self.start) / span))
        way = self.goal - self.origin
        position = self.origin + way * (0.5 - 0.5 * math.cos(math.pi * x))
        return position, way * 0.5 * math.pi / span * math.sin(math.pi * x)


def travel(now: float, origin: float, goal: float, speed: float) -> Travel:
    """The way whose largest speed is `speed`, rad/s, and that takes a second at least."""
    span = max(SHORTEST_TRAVEL_S, 0.5 * math.pi * abs(goal - origin) / speed)
    return Travel(now, now + span, origin, goal)


@dataclass(frozen=True)
class Braking:
    """A speed that falls to zero along a cosine from `start` to `end` s, and the position that goes with it."""

    start: float
    end: float
    position: float
    velocity: float

    def share(self, now: float) -> float:
        """Share of the speed that is left, 1 to 0."""
        x = min(1.0, max(0.0, (now - self.start) / (self.end - self.start)))
        return 0.5 + 0.5 * math.cos(math.pi * x)

    def at(self, now: float) -> tuple[float, float]:
        """Position and velocity at `now` s."""
        span = self.end - self.start
        x = min(1.0, max(0.0, (now - self.start) / span))
        way = self.velocity * span * 0.5 * (x + math.sin(math.pi * x) / math.pi)
        return self.position + way, self.velocity * self.share(now)


def braking(now: float, position: float, velocity: float, limits: Limits) -> Braking:
    """Braking in 0.3 s, or faster where a bound of the position is nearer than that."""
    span = BRAKING_S
    if velocity != 0.0:
        room = limits.position_max - position if velocity > 0.0 else position - limits.position_min
        span = min(span, max(SLOWEST_S, 2.0 * max(room, 0.0) / abs(velocity)))
    return Braking(now, now + span, position, velocity)
