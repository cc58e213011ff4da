"""A joint that follows its command as a servo does, stepped with the exciter sample by sample."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

from flex_ident.excitation import (
    ChirpSettings,
    Exciter,
    ExciterSettings,
    Gains,
    JointSample,
    Limits,
    Output,
    chirp_reference,
)

RATE_HZ = 500.0
CHIRP = ChirpSettings(0.5, 20.0, 4.0, 0.1, profile="constant_velocity", fade_s=0.5)
LIMITS = Limits(-0.5, 0.5, 1.0, 50.0, 0.2)
GAINS = Gains(5.0, 0.0, (30.0,), (3.0,))
INERTIA = 0.5
GRAVITY = 1.0


class Servo:
    """A joint behind a position loop of 10 ms, an ideal velocity drive, or a mass that an effort accelerates."""

    def __init__(self, exciter: Exciter, position: float = 0.0) -> None:
        self.exciter, self.position, self.velocity, self.effort, self.now = exciter, position, 0.0, GRAVITY, 100.0
        self.outputs: list[tuple[float, Output]] = []
        self.sample: Callable[[JointSample], JointSample | None] = lambda s: s

    def tick(self, step: float = 1.0 / RATE_HZ) -> Output:
        self.now += step
        sample = self.sample(
            JointSample(
                self.now, self.now, self.position, self.velocity, self.effort, (0.7,), (0.0,), (2.0,), ("elbow",)
            )
        )
        if sample is not None:
            self.exciter.observe(sample)
        output = self.exciter.step(self.now)
        before = self.position
        if output.command is not None:
            interface = self.exciter.settings.interface
            if interface == "position":
                self.position += (output.command - self.position) * min(1.0, step / 0.01)
                self.effort = GRAVITY + 0.1 * self.velocity
            elif interface == "velocity":
                self.position += output.command * step
                self.effort = GRAVITY + 0.1 * self.velocity
            else:
                self.effort = output.command
                friction = 2.0 * self.velocity
                speed = self.velocity + (output.command - GRAVITY - friction) / INERTIA * step
                self.position += speed * step
        self.velocity = (self.position - before) / step
        self.outputs.append((self.now, output))
        return output

    def run(self, seconds: float) -> Output:
        output = self.tick()
        for _ in range(round(seconds * RATE_HZ)):
            output = self.tick()
        return output

    @property
    def states(self) -> list[str]:
        return list(dict.fromkeys(o.state for _, o in self.outputs))

    def commands(self) -> list[float]:
        return [o.command for _, o in self.outputs if o.command is not None]


def servo(limits: Limits = LIMITS, chirp: ChirpSettings = CHIRP, position: float = 0.0, **settings: Any) -> Servo:
    """A servo at rest that has been seen once."""
    given = ExciterSettings("elbow", rate_hz=RATE_HZ, gains=GAINS, held=("shoulder",))
    made = Servo(Exciter(replace(given, **settings), chirp_reference(chirp), limits), position)
    made.tick()
    return made


def started(**kwargs: Any) -> Servo:
    """A servo that begins to move."""
    made = servo(**kwargs)
    assert made.exciter.start(made.now) == ""
    return made


def commands_stay_inside(made: Servo, limits: Limits = LIMITS) -> None:
    """No command may leave the limits, nor, of positions, the speed from one command to the next."""
    given = [(t, o.command) for t, o in made.outputs if o.command is not None]
    interface = made.exciter.settings.interface
    if interface == "position":
        assert all(limits.position_min <= c <= limits.position_max for _, c in given)
        speeds = [abs(b - a) / (t1 - t0) for (t0, a), (t1, b) in pairwise(given)]
        assert max(speeds, default=0.0) <= limits.velocity * (1.0 + 1e-6)
    else:
        most = limits.velocity if interface == "velocity" else limits.effort
        assert all(abs(c) <= most for _, c in given)
    assert all(abs(o.velocity) <= limits.velocity for _, o in made.outputs)
