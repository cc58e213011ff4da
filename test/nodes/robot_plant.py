"""The joints and drives of the tests' robot, in a process of their own, which the death of the driver leaves alone."""

from __future__ import annotations

import math
import mmap
import os
import time
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

INERTIA, DAMPING, GRAVITY = 1.0, 8.0, 2.0
"""Of each joint under effort commands: kg m^2, N m s/rad, N m that a joint at rest must be held with."""
POSITION_S, VELOCITY_S = 0.01, 0.005
"""Time constants of the position and the velocity drives."""
STEP_S, LONGEST_STEP_S = 1e-3, 0.05
ORPHAN_S = 10.0
"""How long the drives outlive a driver that was killed."""
PRIORITY = 30


@dataclass
class Robot:
    """How the robot is; `joints` in the order of the joint states, `controlled` in the controller's."""

    joints: list[str] = field(default_factory=lambda: ["shoulder", "elbow"])
    controlled: list[str] = field(default_factory=lambda: ["shoulder", "elbow"])
    positions: list[float] = field(default_factory=lambda: [0.5, 0.0])
    interface: str = "position"
    controller: str = "forward_position_controller"
    trajectory: bool = False
    partial: bool = False
    active: bool = True
    manager: bool = False
    """Whether a controller manager says once a second which controllers are active."""
    from_desired: bool = False
    rate_hz: float = 500.0
    limit: float = 0.4
    speed: float = 2.0
    most_effort: float = 60.0
    kind: str = "revolute"
    wraps: bool = False
    efforts: bool = True
    description: str = "latched"
    best_effort: bool = False
    """Whether the joint states are."""
    extra: str = ""
    """Further XML in each joint of the description."""
    beside: str = ""
    """Further XML beside the joints."""
    namespace: str = ""
    truth: str = ""
    wall: float = math.inf
    """Where something is in the way of the last joint, rad."""
    age_s: float = 0.0
    """How old the joint states are when they are published."""
    pace: float | None = None
    """A simulator's: seconds of its own time, from zero, in one second; the joint states are stamped in that time."""
    clock: bool = False
    """Whether the simulator publishes its time on /clock."""
    links: bool = False
    """Whether there are encoders on the links, on a topic of their own."""


class Plant:
    """The joints and their drives, in memory that several processes share."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        n = len(robot.joints)
        shared = np.frombuffer(mmap.mmap(-1, 8 * (4 * n + 1)), float)
        self.position, self.velocity, self.effort, self._commands = shared[: 4 * n].reshape(4, n)
        self._halted = shared[4 * n :]
        self.position[:] = robot.positions
        self.effort[:] = GRAVITY
        self._commands[:] = {"position": self.position, "velocity": 0.0, "effort": GRAVITY}[robot.interface]

    def command(self, joint: str, value: float) -> None:
        """Take a command, which stands until another comes."""
        if math.isfinite(value):
            self._commands[self._robot.joints.index(joint)] = value

    def halt(self) -> None:
        """Stand still at once, as in a protective stop."""
        if self._robot.interface == "effort":
            self._halted[:] = 1.0
        else:
            self._commands[:] = self.position if self._robot.interface == "position" else 0.0

    def step(self, dt: float) -> None:
        """Let time pass; who reads meanwhile finds what was before or what is after, each number for itself."""
        position, velocity, effort = self._after(dt)
        if position[-1] > self._robot.wall:
            position[-1], velocity[-1] = self._robot.wall, 0.0
            if self._robot.interface != "effort":
                effort[-1] = GRAVITY
        self.position[:], self.velocity[:], self.effort[:] = position, velocity, effort

    def _after(self, dt: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions, speeds and efforts after a while."""
        position, velocity, robot = self.position.copy(), self.velocity.copy(), self._robot
        if self._halted[0]:
            return position, 0.0 * velocity, np.full(len(position), GRAVITY)
        if robot.interface == "position":
            position += (self._commands - position) * (1.0 - math.exp(-dt / POSITION_S))
            velocity = (position - self.position) / dt
        elif robot.interface == "velocity":
            velocity += (self._commands - velocity) * (1.0 - math.exp(-dt / VELOCITY_S))
            position += velocity * dt
        else:
            effort = np.clip(self._commands, -robot.most_effort, robot.most_effort)
            velocity += (effort - GRAVITY - DAMPING * velocity) / INERTIA * dt
            return position + velocity * dt, velocity, effort
        return position, velocity, GRAVITY + DAMPING * velocity


def in_real_time() -> None:
    """A robot does not wait for the computer of its user."""
    with suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))


def driven(plant: Plant, robot: Robot) -> int:
    """Start the drives in a process of their own, which lives on for a while where this one is killed; the process."""
    parent = os.getpid()
    process = os.fork()
    if process:
        return process
    with suppress(KeyboardInterrupt):
        in_real_time()
        path = Path(robot.truth)
        path.unlink(missing_ok=True)  # those of a robot before this one may still write to it
        _drive(plant, path, parent, 1.0 if robot.pace is None else robot.pace)
    os._exit(0)


def _drive(plant: Plant, path: Path, parent: int, pace: float) -> None:
    """Let time pass for the joints, and write down what they do."""
    before = alone_since = time.monotonic()
    with path.open("w", buffering=1) as truth:
        while before - alone_since < ORPHAN_S:
            time.sleep(STEP_S)
            now = time.monotonic()
            if os.getppid() == parent:
                alone_since = now
            plant.step(pace * min(now - before, LONGEST_STEP_S))
            before = now
            row = [*plant.position, *plant.velocity, *plant.effort]
            truth.write(f"{now:.6f} " + " ".join(f"{float(value):.7g}" for value in row) + "\n")
