"""From the reference to commands of position, velocity or effort, for the joint that moves and those that hold."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from flex_ident.errors import ConfigurationError
from flex_ident.excitation.agility import Agility
from flex_ident.excitation.joint_states import JointSample
from flex_ident.excitation.limits import Limits

Interface = Literal["position", "velocity", "effort"]
INTERFACES: tuple[Interface, ...] = ("position", "velocity", "effort")
SLOWEST_GAIN = 1.0
"""Near a bound of the position the speed towards it falls with the distance by this gain, 1/s, at least."""
FASTEST = 0.99
"""Share of the speed limit at which no effort accelerates a joint any more."""
STANDS_S = 0.025
"""Time for which an effort may stand without carrying the joint past its speed limit: what the guard allows at least,
and a little."""
OLD_S = 0.01
"""Time constant with which efforts beyond those at rest fall with the lateness of the reading that they act on."""


@dataclass(frozen=True)
class Gains:
    """Around the reference: `position` in 1/s (velocity interface) or N m/rad, `velocity` in N m s/rad (effort).

    `others_position` and `others_velocity` hold the other joints under effort commands, one of each a joint; raises
    ConfigurationError when they are negative or no numbers.
    """

    position: float = 5.0
    velocity: float = 0.0
    others_position: tuple[float, ...] = ()
    others_velocity: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        for key, values in (
            ("position_gain", (self.position,)), ("velocity_gain", (self.velocity,)),
            ("hold_position_gains", self.others_position), ("hold_velocity_gains", self.others_velocity),
        ):  # fmt: skip
            if not all(math.isfinite(v) and v >= 0.0 for v in values):
                raise ConfigurationError(f"command.{key} is {values}: expected numbers that are not negative.")


class CommandLaw:
    """Commands in the interface's unit; whatever comes in, they stay inside the limits.

    Effort commands are a gentle hold around the reference, on top of the efforts that held the joints before.
    """

    def __init__(
        self, interface: Interface, gains: Gains, limits: Limits, start: JointSample, *, carry: bool,
        others_effort: tuple[float, ...] = (),
    ) -> None:  # fmt: skip
        """`start` is the joint at rest; `carry`: its efforts there go on, as a robot needs that has gravity to bear.

        `others_effort` are the limits of the joints that hold, N m. Raises ConfigurationError when they have no gains.
        """
        self.interface = interface
        self.gains = gains
        self.limits = limits
        self._start = start
        n = len(start.others)
        if interface == "effort" and (len(gains.others_position), len(gains.others_velocity)) != (n, n):
            raise ConfigurationError(
                f"command.hold_position_gains and hold_velocity_gains hold {len(gains.others_position)} and "
                f"{len(gains.others_velocity)} numbers: effort commands need one of each for the {n} other joints."
            )
        self._base = _finite(start.effort) if carry else 0.0
        self._others_base = tuple(_finite(e) if carry else 0.0 for e in start.others_effort) or (0.0,) * n
        self.agility = Agility()
        self._others_limits = others_effort if len(others_effort) == n else (math.inf,) * n

    @property
    def others_at(self) -> tuple[float, ...]:
        """Where the joints that hold were at the start, rad."""
        return self._start.others

    @property
    def rest(self) -> float:
        """The command of a joint at rest that nothing drives: no speed, or the effort that held it before."""
        return 0.0 if self.interface == "velocity" else self._inside(self._base)

    def following(self, position: float, velocity: float, sample: JointSample | None, late: float = 0.0) -> float:
        """The command that follows a reference, rad and rad/s; without a trusted sample one that drives nothing.

        `late`, s: by how much older the sample is than it usually is. A loop of efforts that is closed over the past
        swings up, so that its gains fall with that.
        """
        if self.interface == "position":
            return self.limits.held(position)
        if sample is None or sample.position is None:
            return self.rest
        error = position - sample.position
        if self.interface == "velocity":
            return self.bounded_velocity(velocity + self.gains.position * error, sample)
        speed = _finite(sample.velocity)
        wanted = self.gains.position * error + self.gains.velocity * (velocity - speed)
        return self._inside(self._base + believed(late) * self._bounded_push(wanted, speed))

    def _bounded_push(self, wanted: float, speed: float) -> float:
        """An effort beyond that at rest, N m, that falls with the speed it accelerates, to none at the speed limit.

        It falls as the velocity gain has it, or from the effort limit at rest where that is steeper: a reference that
        is far ahead then asks for no speed that is not allowed. Nor may it stand for less than `STANDS_S` until the
        joint has that speed, once it is known how fast efforts make it. What brakes is not bounded.
        """
        if wanted == 0.0:
            return wanted
        limits = self.limits
        room = FASTEST * limits.velocity - math.copysign(speed, speed * wanted)
        if room <= 0.0:
            return 0.0
        steepest = max(self.gains.velocity, limits.effort / limits.velocity if math.isfinite(limits.velocity) else 0.0)
        steepest = min(steepest, 1.0 / (STANDS_S * self.agility.per_effort)) if self.agility.per_effort else steepest
        most = steepest * room
        return math.copysign(min(abs(wanted), most), wanted) if math.isfinite(most) else wanted

    def bounded_velocity(self, wanted: float, sample: JointSample | None) -> float:
        """A speed inside its limit that also falls as a bound of the position comes near."""
        wanted = _clipped(wanted, self.limits.velocity)
        if sample is None or sample.position is None:
            return wanted
        gain = max(self.gains.position, SLOWEST_GAIN)
        high = gain * max(0.0, self.limits.position_max - sample.position)
        low = -gain * max(0.0, sample.position - self.limits.position_min)
        return min(max(wanted, low), high)

    def others(self, sample: JointSample | None, share: float, late: float = 0.0) -> tuple[float, ...]:
        """Commands of the joints that hold; `share` of their hold, 1 while moving, falls to 0 when it is let go.

        `late` as in `following`.
        """
        if self.interface == "position":
            return self._start.others
        if self.interface == "velocity":
            return (0.0,) * len(self._start.others)
        if sample is None or len(sample.others) != len(self._start.others):
            return self._others_base
        share *= believed(late)
        speeds = sample.others_velocity or (0.0,) * len(sample.others)
        rows = zip(
            self._others_base, self.gains.others_position, self.gains.others_velocity, self._start.others,
            sample.others, speeds, self._others_limits, strict=True,
        )  # fmt: skip
        return tuple(
            _clipped(base + share * (gain * _finite(goal - here) - damping * _finite(speed)), limit)
            for base, gain, damping, goal, here, speed, limit in rows
        )

    def _inside(self, effort: float) -> float:
        return _clipped(effort, self.limits.effort)


def believed(late: float) -> float:
    """Share of an effort that is still given where the reading that it acts on is late by `late`, s."""
    return math.exp(-late / OLD_S)


def _clipped(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


def _finite(value: float) -> float:
    return value if math.isfinite(value) else 0.0
