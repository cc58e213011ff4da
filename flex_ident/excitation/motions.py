"""Smooth motions between states: the way to the start pose, a first small one there, braking inside the limits."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from flex_ident.excitation.chirp import Bounds
from flex_ident.excitation.limits import Limits

SHORTEST_TRAVEL_S = 1.0
FIRST_MOTION = 0.02
"""How far the first small motion goes, rad, at most: more than drives' dead bands and steps of encoders."""
SHARE = 0.5
"""The same as a share of the chirp's reach and of the tracking error that is allowed."""
BRAKING_S = 0.3
SLOWEST_S = 1e-3


@dataclass(frozen=True)
class Travel:
    """A way from one position to another along a raised cosine, from `start` to `end` s, `aside` rad out and back."""

    start: float
    end: float
    origin: float
    goal: float
    aside: float = 0.0

    def at(self, now: float) -> tuple[float, float]:
        """Position and velocity at `now` s."""
        span = self.end - self.start
        x = min(1.0, max(0.0, (now - self.start) / span))
        way = self.goal - self.origin
        position = self.origin + way * (0.5 - 0.5 * math.cos(math.pi * x))
        velocity = way * 0.5 * math.pi / span * math.sin(math.pi * x)
        out = self.aside * (0.5 - 0.5 * math.cos(math.tau * x))
        return position + out, velocity + self.aside * math.pi / span * math.sin(math.tau * x)


def travel(now: float, origin: float, goal: float, speed: float) -> Travel:
    """The way whose largest speed is `speed`, rad/s, and that takes a second at least."""
    span = max(SHORTEST_TRAVEL_S, 0.5 * math.pi * abs(goal - origin) / speed)
    return Travel(now, now + span, origin, goal)


def with_first_motion(way: Travel, speed: float, chirp: Bounds, limits: Limits) -> Travel:
    """A way that is short, with a motion out and back to the side to which the chirp goes farther; others as they are.

    It is no faster than `speed`, rad/s, and neither farther, faster nor harder than the chirp.
    """
    side = chirp.high if chirp.high >= -chirp.low else chirp.low
    span, shift = way.end - way.start, abs(way.goal - way.origin)
    size = min(
        FIRST_MOTION, SHARE * abs(side), SHARE * limits.tracking_error,
        min(chirp.speed, speed) * span / math.pi - 0.5 * shift, chirp.acceleration * span**2 / (2.0 * math.pi**2),
    )  # fmt: skip
    return replace(way, aside=math.copysign(size, side)) if size > shift else way


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
