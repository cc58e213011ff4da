#!/usr/bin/env python3
"""Joints under effort commands while exciter, guard and joint states are held up at random: how fast do they become?

.venv/bin/python bench/effort_stalls.py --joints 300 --seed 100

Joints of 0.01 to 10 kg m^2 with Coulomb and viscous friction, in simulated time; gains, rates and chirps are drawn.
Exciter, guard and network pause independently of each other. Exit status 1 where a joint leaves its position limits.
"""

from __future__ import annotations

import argparse
import math
import random
import sys
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from flex_ident.excitation import (
    ChirpSettings,
    Exciter,
    ExciterSettings,
    Gains,
    JointSample,
    Limits,
    chirp_reference,
)
from flex_ident.excitation.guarding import Beat, Guarding
from flex_ident.excitation.output import MOVING

STEP_S, LENGTH_S, START_S = 5e-4, 8.0, 0.3
LONGEST_PAUSE_S = 0.15
POSITION_LIMIT = 0.5
GUARD_S = 0.002
KEPT = 50
"""Joint states that the guard keeps."""


@dataclass
class Joint:
    """A mass with gravity's constant pull and friction, N m, N m s/rad, that an effort moves."""

    inertia: float
    viscous: float
    coulomb: float
    gravity: float
    most: float
    position: float = 0.0
    velocity: float = 0.0
    effort: float = 0.0

    def step(self, command: float) -> None:
        """Let a step of time pass."""
        self.effort = max(-self.most, min(self.most, command))
        drive = self.effort - self.gravity - self.viscous * self.velocity
        if self.velocity == 0.0 and abs(drive) <= self.coulomb:
            return
        ahead = math.copysign(1.0, self.velocity if self.velocity != 0.0 else drive)
        after = self.velocity + (drive - ahead * self.coulomb) / self.inertia * STEP_S
        self.velocity = 0.0 if self.velocity * after < 0.0 and abs(drive) <= self.coulomb else after
        self.position += self.velocity * STEP_S


class Pauses:
    """When something stands still: asked in the order of time."""

    def __init__(self, draw: random.Random, per_s: float, mean_s: float) -> None:
        self._draw, self._per_s, self._mean_s = draw, per_s, mean_s
        self._until = 0.0
        self._next = draw.expovariate(per_s) if per_s else math.inf

    def __call__(self, now: float) -> bool:
        """Whether it stands still now."""
        if now >= self._next:
            self._until = now + min(LONGEST_PAUSE_S, self._draw.expovariate(1.0 / self._mean_s))
            self._next = self._until + self._draw.expovariate(self._per_s)
        return now < self._until


@dataclass(frozen=True)
class Outcome:
    """How a run ended, the joint's highest speed over its limit, and its farthest position, rad."""

    end: str
    speed: float
    position: float
    still: bool


def played(seed: int, per_s: float | None = None) -> Outcome | None:
    """One run; None where the exciter refuses to start. `per_s`: pauses a second of each, drawn where not given."""
    draw = random.Random(seed)
    inertia, natural, damping = 10.0 ** draw.uniform(-2, 1), draw.uniform(8, 40), draw.uniform(0.3, 1.0)
    fastest = draw.choice([1.0, 2.0, 4.0])
    rate, read_hz = draw.choice([200.0, 500.0, 1000.0]), draw.choice([100.0, 200.0, 500.0, 1000.0])
    viscous, coulomb, gravity = (inertia * draw.uniform(*ends) for ends in ((0, 5), (0, 5), (-5, 5)))
    most = abs(gravity) + coulomb + inertia * draw.uniform(1.2, 4.0) * natural * fastest
    joint = Joint(inertia, viscous, coulomb, gravity, most, effort=gravity)
    chirp = ChirpSettings(
        0.5, draw.uniform(5, 15), 4.0, draw.uniform(0.05, 0.2), profile="constant_velocity", fade_s=0.5
    )
    speed = chirp_reference(chirp).bounds.speed
    chirp = replace(chirp, amplitude=chirp.amplitude * min(1.0, 0.6 * fastest / speed))
    gains = Gains(inertia * natural**2, 2.0 * damping * inertia * natural)
    settings = ExciterSettings("elbow", rate_hz=rate, gains=gains, interface="effort", state_timeout_s=0.6)
    limits = Limits(-POSITION_LIMIT, POSITION_LIMIT, fastest, most, 0.3)
    exciter, guard = Exciter(settings, chirp_reference(chirp), limits), Guarding()
    per_s = draw.choice([0.5, 2.0, 8.0]) if per_s is None else per_s
    mean_s = draw.choice([0.005, 0.015, 0.03])
    exciter_stands, guard_stands, network_stands = (Pauses(draw, per_s, mean_s) for _ in range(3))

    command, on_its_way = gravity, gravity
    waiting: list[JointSample] = []
    to_exciter: list[JointSample] = []
    to_guard: list[JointSample] = []
    beat: Beat | None = None
    read_at, tick_at, guard_at, started, end = 0.0, 0.05, 0.0, False, ""
    highest = farthest = 0.0
    for k in range(round(LENGTH_S / STEP_S)):
        now = k * STEP_S
        command = on_its_way
        joint.step(command)
        highest, farthest = max(highest, abs(joint.velocity)), max(farthest, abs(joint.position))
        if now >= read_at:
            read_at += 1.0 / read_hz
            waiting.append(
                JointSample(now, now, joint.position, joint.velocity, joint.effort, names=("elbow",), age=0.0)
            )
        if not network_stands(now):
            to_exciter += waiting
            to_guard += waiting
            waiting = []
        if not exciter_stands(now):
            for sample in to_exciter:
                exciter.observe(replace(sample, received=now, age=now - sample.stamp))
            to_exciter = []
            if not started and now > START_S:
                if exciter.start(now):
                    return None
                started = True
            if started and now >= tick_at:
                tick_at = max(tick_at + 1.0 / rate, now + 0.3 / rate)
                output = exciter.step(now)
                moving = output.state in MOVING
                if output.command is not None and not output.left:
                    on_its_way = output.command
                    lease = output.lease_s if moving else 0.0
                    beat = Beat(now, moving, lease, (output.safe[0],), ("elbow",), output.hold, (output.command,),
                                output.seen)  # fmt: skip
                end = end or ("" if moving else output.reason or "done")
        if now >= guard_at and not guard_stands(now):
            guard_at = now + GUARD_S
            if beat is not None:
                guard.beat(beat)
                beat = None
            if guard.taken_over:
                for sample in to_guard:
                    guard.observe(replace(sample, received=now, age=now - sample.stamp))
                to_guard = []
            to_guard = to_guard[-KEPT:]
            if (due := guard.due(now)) is not None:
                on_its_way = due.row[0]
    return Outcome(end, highest / fastest, farthest, abs(joint.velocity) < 0.02 * fastest)


def main() -> int:
    """Play the runs and print what came of them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--joints", type=int, default=300)
    parser.add_argument("--seed", type=int, default=100, help="of the first joint; the next has the next")
    parser.add_argument("--pauses", type=float, default=None, help="a second, of each; drawn when not given")
    given = parser.parse_args()
    runs = {seed: played(seed, given.pauses) for seed in range(given.seed, given.seed + given.joints)}
    found = {seed: run for seed, run in runs.items() if run is not None}
    fast = {seed: run for seed, run in found.items() if run.speed > 1.0}
    far = {seed: run for seed, run in found.items() if run.position > POSITION_LIMIT}
    print(f"{len(found)} runs, {sum(run.end == 'done' for run in found.values())} to their end")
    print(f"faster than allowed: {len(fast)}, at most {max(run.speed for run in found.values()):.2f} of the limit")
    moving = sum(not run.still for run in found.values())
    print(f"outside their position limits: {len(far)}; still moving in the end: {moving}")
    for reason, count in Counter(run.end.split(":")[0][:60] for run in found.values()).most_common(8):
        print(f"  {count:4d}  {reason or 'has not ended'}")
    for seed, run in sorted((fast | far).items(), key=lambda item: -item[1].speed)[:10]:
        print(f"  seed {seed}: {run.speed:.2f} of the speed limit, {run.position:.2f} rad; {run.end}")
    return int(bool(far))


if __name__ == "__main__":
    sys.exit(main())
