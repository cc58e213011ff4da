"""The commands of one motion, one after the other: with feedback as long as it can be believed, without it else."""

from __future__ import annotations

import math

from flex_ident.excitation.commands import CommandLaw, believed
from flex_ident.excitation.joint_states import JointSample
from flex_ident.excitation.motions import Braking

RELEASE_S = 0.5
"""Time in which an effort command returns to what held the joint before."""
FADE_S = 0.03
"""Time constant of the same without feedback: efforts of a fast chirp must not stand for longer."""
POSITION_LEASE_S = 1.0
"""How long a commanded position may stand: the drive stays there."""
LEASE_S, SHORTEST_LEASE_S = 0.12, 0.04
"""How long a commanded speed or effort may stand, and how long at least where a bound of the position is near."""
SHORTEST_OF_EFFORT_S = 0.02
"""The same of an effort, where it would carry the joint past its speed limit: less would end runs on a busy machine."""
HELD_BACK_S = 0.5
"""Time over which it is seen how much efforts are held back, as the joint states come late."""
LEASE_SHARE = 0.5
"""Share of the way to the bound ahead that a commanded speed, or that of a joint under efforts, may go meanwhile."""


class CommandStream:
    """Commands of the joint that moves and of the others, in the interface's unit; all stay inside the limits."""

    def __init__(self, law: CommandLaw, now: float, position: float, sample: JointSample) -> None:
        """The joint is at rest at `position`, rad."""
        self.law = law
        self._at = now
        self._position = position
        self.command = law.following(position, 0.0, sample)
        self.others = law.others(sample, 1.0)
        self._braked = self.command
        self.seen: float | None = position
        """Where the joint was seen, rad, at the latest command; None: nowhere that is to be believed."""
        self._speed = 0.0
        self.held_back = 0.0
        """Share of the efforts that late joint states have taken of late."""
        self._wanted = self._acceleration = 0.0
        """Speed, rad/s, and acceleration, rad/s^2, of the reference."""

    def follow(
        self, now: float, position: float, velocity: float, sample: JointSample | None, late: float = 0.0
    ) -> None:
        """Follow a reference, rad and rad/s; without a sample by what is known without one.

        `late`, s: by how much older the sample is than it usually is.
        """
        law = self.law
        self._look(now, sample)
        self._accelerate(now, velocity)
        if law.interface == "effort":
            weight = min(1.0, max(0.0, now - self._at) / HELD_BACK_S)
            self.held_back += weight * (1.0 - (0.0 if sample is None else believed(late)) - self.held_back)
        if law.interface == "effort" and sample is None:
            self._fade(now)
        else:
            blind = law.interface == "velocity" and sample is None
            self.command = (
                law.bounded_velocity(velocity, None) if blind else law.following(position, velocity, sample, late)
            )
            self.others = law.others(sample, 1.0, late)
        self._at, self._position = now, position if sample is None or sample.position is None else sample.position

    def brake(self) -> None:
        """Remember the command at which braking begins."""
        self._braked = self.command

    def ramp_down(
        self,
        now: float,
        position: float,
        velocity: float,
        braking: Braking,
        sample: JointSample | None,
        late: float = 0.0,
    ) -> None:
        """Brake along a reference, rad and rad/s; without a sample no faster than that, and efforts fade."""
        law = self.law
        self._look(now, sample)
        self._accelerate(now, velocity)
        if law.interface == "position":
            self.command = law.following(position, velocity, sample)
        elif law.interface == "velocity":
            wanted = law.bounded_velocity(self._braked * braking.share(now), sample)
            self.command = wanted if sample is not None else _between(wanted, velocity)
        elif sample is None:
            self._fade(now)
        else:
            share = min(1.0, max(0.0, 1.0 - (now - braking.end) / RELEASE_S))
            held = law.following(position, velocity, sample, late)
            self.command = law.rest + share * (held - law.rest)
            self.others = law.others(sample, share, late)
        self._at, self._position = now, position

    def rest(self, position: float) -> None:
        """Nothing moves any more: the position is held, no speed, the effort that held the joint before."""
        law = self.law
        self.command = law.limits.held(position) if law.interface == "position" else law.rest
        self.others = law.others(None, 0.0)

    def _look(self, now: float, sample: JointSample | None) -> None:
        self.seen = None if sample is None else sample.position
        if sample is not None and math.isfinite(sample.velocity):
            self._speed = sample.velocity
            self.law.agility.observe(now, sample.stamp, sample.velocity, self.command - self.law.rest)

    def _accelerate(self, now: float, velocity: float) -> None:
        """Take the reference's speed, rad/s."""
        if now > self._at:
            self._acceleration = (velocity - self._wanted) / (now - self._at)
        self._wanted = velocity

    def _fade(self, now: float) -> None:
        share = math.exp(-max(0.0, now - self._at) / FADE_S)
        rest = self.law.others(None, 0.0)
        self.command = self.law.rest + share * (self.command - self.law.rest)
        self.others = tuple(r + share * (o - r) for o, r in zip(self.others, rest, strict=True))

    @property
    def safe(self) -> tuple[float, tuple[float, ...]]:
        """What may be commanded for any length of time after the latest command: of the joint and of the others."""
        law = self.law
        command = self.command if law.interface == "position" else law.rest
        return command, law.others(None, 0.0)

    @property
    def lease_s(self) -> float:
        """How long the latest command may stand with nobody there to change it, s."""
        law = self.law
        if law.interface == "position":
            return POSITION_LEASE_S
        speed = self._speed if law.interface == "effort" else self.command
        return min(self._until_bound(speed), self._until_fast(speed) if law.interface == "effort" else LEASE_S)

    def _until_bound(self, speed: float) -> float:
        """How long the joint may go on at that speed, rad/s, towards the bound ahead, s."""
        if speed == 0.0:
            return LEASE_S
        limits = self.law.limits
        room = limits.position_max - self._position if speed > 0.0 else self._position - limits.position_min
        return min(LEASE_S, max(SHORTEST_LEASE_S, LEASE_SHARE * room / abs(speed)))

    def _until_fast(self, speed: float) -> float:
        """How long it may go on to accelerate as the reference does, or as the effort has it, s."""
        pushed = self.law.agility.per_effort * (self.command - self.law.rest)
        return min(self._until_limit(speed, acceleration) for acceleration in (self._acceleration, pushed))

    def _until_limit(self, speed: float, acceleration: float) -> float:
        if acceleration == 0.0:
            return LEASE_S
        room = self.law.limits.velocity - math.copysign(speed, speed * acceleration)
        return min(LEASE_S, max(SHORTEST_OF_EFFORT_S, LEASE_SHARE * room / abs(acceleration)))


def _between(value: float, bound: float) -> float:
    """The value nearest to `value` between zero and `bound`."""
    return min(max(value, min(0.0, bound)), max(0.0, bound))
