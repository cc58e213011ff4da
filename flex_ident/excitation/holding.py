"""How a guard brakes joints under effort commands and holds them, by feedback of its own; knows nothing of processes.

An effort that stands moves the joint on: without feedback nothing keeps it inside its bounds. The law, the gains and
the rules for feedback that is not to be believed are the exciter's own.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from flex_ident.excitation.command_stream import FADE_S
from flex_ident.excitation.commands import CommandLaw, Gains
from flex_ident.excitation.joint_states import IMPOSSIBLE, JITTER, SELDOM_S, JointSample, JointStateWatch
from flex_ident.excitation.limits import Limits
from flex_ident.excitation.motions import Braking, braking
from flex_ident.excitation.objections import STILL
from flex_ident.excitation.turns import Turns

ROOM = 0.5
"""Share of the way to a bound ahead in which the joint is braked: it follows the reference by an error."""
STOOD_S = 0.3
"""How long joints must have stood still to be left alone."""
SMOOTHING_S = 0.1
"""Time over which the effort that holds a joint at rest is averaged."""
UNCERTAIN_S = 0.15
"""Readings at hand may be older than the heartbeat by so much."""


@dataclass(frozen=True)
class Hold:
    """What it takes to hold joints: the one that moves is `joint`, `held` are the others.

    `start` is the joint states' sample in which they were at rest before anything moved; `others_effort` limits of
    the others, N m.
    """

    joint: str
    held: tuple[str, ...]
    gains: Gains
    limits: Limits
    start: JointSample
    carry: bool
    others_effort: tuple[float, ...]
    continuous: tuple[bool, ...]
    state_timeout_s: float

    @cached_property
    def text(self) -> str:
        """As JSON, in which numbers may be infinite."""
        g, b, s = self.gains, self.limits, self.start
        return json.dumps([
            self.joint, self.held, (g.position, g.velocity, g.others_position, g.others_velocity),
            (b.position_min, b.position_max, b.velocity, b.effort),
            (s.received, s.stamp, s.position, s.effort, s.others, s.others_effort),
            self.carry, self.others_effort, self.continuous, self.state_timeout_s,
        ], separators=(",", ":"))  # fmt: skip

    @staticmethod
    def of(content: list[object]) -> Hold:
        """From what `text` holds. Raises TypeError, ValueError or ConfigurationError when it is none."""
        joint, held, gains, limits, start, carry, others_effort, continuous, timeout_s = content
        position, velocity, others_position, others_velocity = _list(gains)
        received, stamp, at, effort, others, efforts = _list(start)
        return Hold(
            str(joint), tuple(map(str, _list(held))),
            Gains(_number(position), _number(velocity), _numbers(others_position), _numbers(others_velocity)),
            Limits(*_numbers(limits)),
            JointSample(_number(received), _number(stamp), _number(at), 0.0, _number(effort), _numbers(others), (),
                        _numbers(efforts)),
            bool(carry), _numbers(others_effort), tuple(map(bool, _list(continuous))), _number(timeout_s),
        )  # fmt: skip

    def law(self) -> CommandLaw:
        """The exciter's commands of effort."""
        return CommandLaw(
            "effort", self.gains, self.limits, self.start, carry=self.carry, others_effort=self.others_effort
        )


class Holding:
    """Brakes the joint that moves, then holds it where it has come to rest, and the others where they were."""

    def __init__(
        self, hold: Hold, since: float, position: float | None, command: float, others: tuple[float, ...],
    ) -> None:  # fmt: skip
        """At `since` s the joint was at `position`, rad, its turns counted, None: nowhere that is to be believed; the
        commands, N m, stand since then.
        """
        self._law = hold.law()
        self._limits = hold.limits
        self._since, self._position = since, math.nan if position is None else position
        self._watch = JointStateWatch(hold.joint, hold.state_timeout_s, hold.limits.velocity, SELDOM_S)
        self._turns = Turns(hold.continuous)
        self._turns.near((self._position, *hold.start.others))
        self._seen = False
        self._at = since
        self._command, self._others = command, others
        self._settled: tuple[float, tuple[float, ...]] | None = None
        self._braking: Braking | None = None
        self._goal: float | None = None
        self._still_since: float | None = None
        if not math.isfinite(self._position):
            self._watch.distrust()

    def distrust(self) -> None:
        """Believe no reading any more."""
        self._watch.distrust()

    def observe(self, sample: JointSample) -> None:
        """Take a joint state."""
        sample = self._turns.unwrapped(sample)
        if not self._seen and sample.position is not None:
            passed = abs(sample.received - self._since) + UNCERTAIN_S
            if not abs(sample.position - self._position) <= IMPOSSIBLE * self._limits.velocity * passed + JITTER:
                self._watch.distrust()
        self._watch.observe(sample)
        if not self._seen and sample.position is not None:
            self._seen = True
            distrusted = self._watch.distrusted
            self._watch.begin(sample.received)
            if distrusted:
                self._watch.distrust()

    def step(self, now: float) -> tuple[float, tuple[float, ...]]:
        """The efforts to command now: of the joint, and of the others."""
        passed, self._at = max(0.0, now - self._at), now
        reference = self._reference(now)
        if reference is not None and self._watch.fault(now, reference[0], exciting=False):
            self._watch.distrust()
        sample = self._watch.feedback(now)
        if sample is None or sample.position is None or reference is None:
            self._still_since = None
            self._fade(passed)
            return self._command, self._others
        late = self._watch.late_s(now)
        self._command = self._law.following(*reference, sample, late)
        self._others = self._law.others(sample, 1.0, late)
        self._look_for_rest(now, sample.position, passed)
        return self._command, self._others

    @property
    def last(self) -> tuple[float, tuple[float, ...]]:
        """What may stand when nobody watches any more: the efforts that hold the joints at rest, as far as known."""
        return self._settled if self._settled is not None else (self._law.rest, self._law.others(None, 0.0))

    def stood(self, now: float) -> bool:
        """Whether all joints have stood still for long enough, by readings that are to be believed."""
        return self._still_since is not None and now - self._still_since > STOOD_S

    @property
    def blind(self) -> bool:
        """Whether no reading will be believed any more."""
        return self._watch.distrusted

    def _reference(self, now: float) -> tuple[float, float] | None:
        """Position and velocity to follow; None as long as no reading has been believed."""
        if self._goal is not None:
            return self._goal, 0.0
        if self._braking is None:
            sample = self._watch.feedback(now)
            if sample is None or sample.position is None:
                return None
            speed = self._watch.speeds()[0]
            speed = min(max(speed, -self._limits.velocity), self._limits.velocity)
            position, b = sample.position, self._limits
            near = replace(
                b, position_min=position - ROOM * max(0.0, position - b.position_min) - JITTER,
                position_max=position + ROOM * max(0.0, b.position_max - position) + JITTER,
            )  # fmt: skip
            self._braking = braking(now, position, speed, near)
        position, velocity = self._braking.at(now)
        return self._limits.held(position), velocity

    def _look_for_rest(self, now: float, position: float, passed: float) -> None:
        """See whether the joints stand still, and hold the one that moved where it does."""
        assert self._braking is not None
        if now < self._braking.end or any(abs(speed) > STILL for speed in self._watch.speeds()):
            self._still_since = self._settled = None
            return
        if self._goal is None:
            self._goal = self._limits.held(position)
        if self._still_since is None:
            self._still_since = now
        before = self._settled or (self._command, self._others)
        weight = 1.0 - math.exp(-passed / SMOOTHING_S)
        row = zip((before[0], *before[1]), (self._command, *self._others), strict=True)
        command, *others = (old + weight * (new - old) for old, new in row)
        self._settled = command, tuple(others)

    def _fade(self, passed: float) -> None:
        share = math.exp(-passed / FADE_S)
        rest, others = self.last
        self._command = rest + share * (self._command - rest)
        self._others = tuple(r + share * (o - r) for o, r in zip(self._others, others, strict=True))


def _list(content: object) -> Sequence[object]:
    if not isinstance(content, list):
        raise TypeError(f"{content} is no list")
    return content


def _number(content: object) -> float:
    if not isinstance(content, int | float):
        raise TypeError(f"{content} is no number")
    return float(content)


def _numbers(content: object) -> tuple[float, ...]:
    return tuple(map(_number, _list(content)))
