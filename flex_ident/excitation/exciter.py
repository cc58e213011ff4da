"""The exciter's rules: what must hold before a joint moves, what it is commanded, and what makes it stop.

Stepped sample by sample with a steady clock's time; ROS, threads and files are the node's business. Whatever comes in,
the commanded position and speed stay inside the limits.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

from flex_ident.errors import ConfigurationError
from flex_ident.excitation.chirp import Reference
from flex_ident.excitation.limits import Limits
from flex_ident.excitation.motions import Braking, Travel, braking, travel

State = Literal["idle", "moving_to_start", "exciting", "ramping_down", "done", "aborted"]
INTERFACES = ("position", "velocity", "effort")
MOVING: tuple[State, ...] = ("moving_to_start", "exciting", "ramping_down")
TICKS_PER_PERIOD = 10.0
"""Commands that the highest frequency of the sweep needs in a period."""
SETTLING_S = 2.0
"""Time after the way to the start pose in which the joint must arrive."""
STILL = 0.05
"""Speed, rad/s, above which a joint is not at rest."""
EFFORT_MARGIN = 1.05
"""A drive that works at its limit reads a little more than that, for noise; more is a fault."""
RELEASE_S = 0.5
"""Time in which an effort command returns to what held the joint before."""


@dataclass(frozen=True)
class ExciterSettings:
    """How to excite: `start_position` None starts where the joint is; gains are used by `velocity` and `effort`.

    `approach_velocity`, rad/s, on the way to the start pose; `inertia`, kg m^2, when known, lets the effort be checked
    before anything moves. Raises ConfigurationError.
    """

    joint: str
    interface: str = "position"
    rate_hz: float = 500.0
    start_position: float | None = None
    state_timeout_s: float = 0.1
    approach_velocity: float = 0.2
    position_gain: float = 5.0
    velocity_gain: float = 0.0
    inertia: float = 0.0

    def __post_init__(self) -> None:
        if not self.joint:
            raise ConfigurationError("joint is empty: name the joint that shall move.")
        if self.interface not in INTERFACES:
            raise ConfigurationError(
                f"command.interface is '{self.interface}': expected one of {', '.join(INTERFACES)}."
            )
        for name in ("rate_hz", "state_timeout_s", "approach_velocity"):
            if not getattr(self, name) > 0.0:
                raise ConfigurationError(f"{name} is {getattr(self, name)}: it must be positive.")


@dataclass(frozen=True)
class JointSample:
    """One joint state as received at `received` s of the steady clock; `stamp` s of the robot's; NaN where missing.

    `others` are the positions of the joints that hold. `position` None: the message does not hold the joint.
    """

    received: float
    stamp: float
    position: float | None
    velocity: float = math.nan
    effort: float = math.nan
    others: tuple[float, ...] = ()


@dataclass(frozen=True)
class Output:
    """What to do now: `command` in the interface's unit, None: command nothing. Reference in rad and rad/s."""

    state: State
    command: float | None
    position: float
    velocity: float
    others: tuple[float, ...]
    progress: float
    reason: str


class Exciter:
    """The state machine. `step(now)` is called at each tick, everything else whenever it happens."""

    def __init__(self, settings: ExciterSettings, reference: Reference, limits: Limits) -> None:
        self.settings = settings
        self.reference = reference
        self.limits = limits
        self.state: State = "idle"
        self.reason = ""
        self._sample: JointSample | None = None
        self._missing = False
        self._jump = 0.0
        self._others: tuple[float, ...] = ()
        self._center = 0.0
        self._began = 0.0
        self._last = (0.0, 0.0)
        self._last_command: float | None = None
        self._travel: Travel | None = None
        self._braking: Braking | None = None
        self._after: State = "done"
        self._hold_effort = 0.0
        self._brake_command = 0.0

    def observe(self, sample: JointSample) -> None:
        """Take a joint state. Messages without the joint are noted, and time that jumps."""
        if sample.position is None:
            self._missing = True
            return
        self._missing = False
        if self._sample is not None:
            passed = sample.stamp - self._sample.stamp
            if passed < 0.0 or passed > sample.received - self._sample.received + self.settings.state_timeout_s:
                self._jump = passed
        self._sample = sample

    def objection(self, now: float) -> str:
        """Why the joint must not move now: the number and the fix in one line; empty when it may."""
        s, limits = self.settings, self.limits
        if self.state in MOVING:
            return f"already {self.state.replace('_', ' ')}: call ~/stop first."
        sample = self._sample
        if sample is None or sample.position is None:
            if self._missing:
                return f"joint '{s.joint}' is not in the joint states: check the name."
            return "no joint states arrive: check the topic and that the robot's driver runs."
        if self._missing:
            return f"joint '{s.joint}' has vanished from the joint states."
        age = now - sample.received
        if age > s.state_timeout_s:
            return (
                f"the latest joint state is {age:.2f} s old, {s.state_timeout_s:.2f} s allowed: is the driver running?"
            )
        if not math.isfinite(sample.position):
            return f"the position of '{s.joint}' is {sample.position}: the driver publishes no number."
        if math.isfinite(sample.velocity) and abs(sample.velocity) > STILL:
            return f"'{s.joint}' moves at {sample.velocity:.2g} rad/s: let it come to rest."
        center = sample.position if s.start_position is None else s.start_position
        if not limits.position_min <= sample.position <= limits.position_max:
            return (
                f"'{s.joint}' stands at {sample.position:.4g} rad, outside {limits.position_min:.4g} to "
                f"{limits.position_max:.4g} rad: move it inside."
            )
        return self._chirp_objection(center)

    def _chirp_objection(self, center: float) -> str:
        s, limits = self.settings, self.limits
        low, high, speed, acceleration = self.reference.bounds()
        if center + low < limits.position_min or center + high > limits.position_max:
            return (
                f"the chirp reaches {center + low:.4g} to {center + high:.4g} rad, allowed are "
                f"{limits.position_min:.4g} to {limits.position_max:.4g} rad: reduce chirp.amplitude, or change "
                "start_position."
            )
        if speed > limits.velocity:
            return (
                f"the chirp reaches {speed:.3g} rad/s, allowed are {limits.velocity:.3g} rad/s: reduce "
                "chirp.amplitude, or use chirp.profile constant_velocity or constant_acceleration."
            )
        if s.inertia > 0.0 and s.inertia * acceleration > limits.effort:
            return (
                f"the chirp needs about {s.inertia * acceleration:.3g} N m, allowed are {limits.effort:.3g} N m: "
                "reduce chirp.amplitude, or use chirp.profile constant_acceleration."
            )
        highest = s.rate_hz / TICKS_PER_PERIOD
        if self.reference.highest_hz > highest:
            return (
                f"the sweep ends at {self.reference.highest_hz:.3g} Hz, commands at {s.rate_hz:.4g} Hz carry up to "
                f"{highest:.3g} Hz: lower chirp.end_frequency_hz or raise rate_hz."
            )
        return ""

    def start(self, now: float) -> str:
        """Begin to move to the start pose; the objection when that must not be, else empty."""
        why = self.objection(now)
        if why:
            return why
        sample = self._sample
        assert sample is not None
        assert sample.position is not None
        s = self.settings
        self._center = sample.position if s.start_position is None else s.start_position
        self._others = sample.others
        self._hold_effort = sample.effort if math.isfinite(sample.effort) else 0.0
        self._travel = travel(now, sample.position, self._center, min(s.approach_velocity, 0.5 * self.limits.velocity))
        self._last = (sample.position, 0.0)
        self._jump = 0.0
        self.state, self.reason = "moving_to_start", ""
        return ""

    def stop(self, now: float, why: str, *, abort: bool = True) -> str:
        """Ramp the joint down; the objection when nothing moves, else empty."""
        if self.state not in MOVING:
            return f"nothing to stop: {self.state}."
        if self.state == "ramping_down":
            return ""
        self._ramp_down(now, why, "aborted" if abort else "done")
        return ""

    def _ramp_down(self, now: float, why: str, after: State) -> None:
        position, velocity = self._last
        self._braking = braking(now, position, velocity, self.limits)
        self._brake_command = self._last_command if self._last_command is not None else 0.0
        self.state, self.reason, self._after = "ramping_down", why, after

    def step(self, now: float) -> Output:
        """What to command at this tick."""
        if self.state in ("moving_to_start", "exciting"):
            why = self._fault(now)
            if why:
                self._ramp_down(now, why, "aborted")
        position, velocity = self._motion(now)
        inside = self.limits.held(position)
        limit = self.limits.velocity
        if inside != position or abs(velocity) > limit:
            if self.state in ("moving_to_start", "exciting"):
                self._ramp_down(now, f"the reference leaves its bounds at {position:.4g} rad", "aborted")
            position, velocity = inside, min(max(velocity, -limit), limit)
        self._last = (position, velocity)
        return Output(
            self.state, self._command(now, position, velocity), position, velocity, self._others, self._progress(now),
            self.reason,
        )  # fmt: skip

    def _motion(self, now: float) -> tuple[float, float]:
        """Position and velocity of the reference now; moves on to the next state when its time has come."""
        if self.state == "moving_to_start":
            assert self._travel is not None
            if now < self._travel.end:
                return self._travel.at(now)
            if self._arrived():
                self.state, self._began = "exciting", now
            elif now > self._travel.end + SETTLING_S:
                here = self._sample.position if self._sample is not None else math.nan
                self._ramp_down(now, f"the start position {self._center:.4g} rad was not reached: at {here:.4g} rad",
                                "aborted")  # fmt: skip
            return self._center, 0.0
        if self.state == "exciting":
            t = now - self._began
            if t < self.reference.total_s:
                deviation, velocity = self.reference.at(t)
                return self._center + deviation, velocity
            self._ramp_down(now, "", "done")
        if self.state == "ramping_down":
            assert self._braking is not None
            if now >= self._braking.end + (RELEASE_S if self.settings.interface == "effort" else 0.0):
                self.state = self._after
            return self._braking.at(now)
        return self._last[0], 0.0

    def _arrived(self) -> bool:
        sample = self._sample
        if sample is None or sample.position is None:
            return False
        allowed = min(0.02, 0.5 * self.limits.tracking_error)
        moving = math.isfinite(sample.velocity) and abs(sample.velocity) > STILL
        return abs(sample.position - self._center) <= allowed and not moving

    def _fault(self, now: float) -> str:
        """What is wrong with the robot at this moment, in one line; empty when nothing is."""
        s, limits, sample = self.settings, self.limits, self._sample
        assert sample is not None
        if self._missing:
            return f"joint '{s.joint}' has vanished from the joint states"
        if now - sample.received > s.state_timeout_s:
            return f"no joint state for {now - sample.received:.3f} s, {s.state_timeout_s:.3f} s allowed"
        if self._jump:
            jump, self._jump = self._jump, 0.0
            return f"the joint states' time jumps by {jump:+.3f} s"
        if sample.position is None or not math.isfinite(sample.position):
            return f"the position of '{s.joint}' is {sample.position}"
        if not limits.position_min <= sample.position <= limits.position_max:
            bounds = f"{limits.position_min:.4g} to {limits.position_max:.4g} rad"
            return f"the position, {sample.position:.4g} rad, has left {bounds}"
        if abs(sample.velocity) > limits.velocity:
            return f"the speed, {abs(sample.velocity):.3g} rad/s, exceeds {limits.velocity:.3g} rad/s"
        if abs(sample.effort) > EFFORT_MARGIN * limits.effort:
            return f"the effort, {abs(sample.effort):.3g} N m, exceeds {limits.effort:.3g} N m"
        error = abs(sample.position - self._last[0])
        if error > limits.tracking_error:
            return f"the tracking error, {error:.3g} rad, exceeds {limits.tracking_error:.3g} rad"
        return ""

    def _command(self, now: float, position: float, velocity: float) -> float | None:
        """The command in the interface's unit, inside its limits."""
        if self.state == "idle":
            return None
        s = self.settings
        if s.interface == "position":
            command = position
        elif s.interface == "velocity":
            command = self._velocity_command(now, position, velocity)
        else:
            command = self._effort_command(now, position, velocity)
        self._last_command = command
        return command

    def _measured(self, now: float) -> JointSample | None:
        """The latest joint state when it can be relied on."""
        sample = self._sample
        if sample is None or sample.position is None or not math.isfinite(sample.position) or self._missing:
            return None
        return sample if now - sample.received <= self.settings.state_timeout_s else None

    def _velocity_command(self, now: float, position: float, velocity: float) -> float:
        if self.state in ("done", "aborted"):
            return 0.0
        if self.state == "ramping_down":
            assert self._braking is not None
            return self._brake_command * self._braking.share(now)
        sample = self._measured(now)
        if sample is None or sample.position is None:
            return 0.0
        wanted = velocity + self.settings.position_gain * (position - sample.position)
        limit = self.limits.velocity
        wanted = min(max(wanted, -limit), limit)
        # Near a bound the speed towards it falls with the distance.
        gain = max(self.settings.position_gain, 1.0)
        high = gain * max(0.0, self.limits.position_max - sample.position)
        low = -gain * max(0.0, sample.position - self.limits.position_min)
        return min(max(wanted, low), high)

    def _effort_command(self, now: float, position: float, velocity: float) -> float:
        s, limit = self.settings, self.limits.effort
        if self.state in ("done", "aborted"):
            return min(max(self._hold_effort, -limit), limit)
        sample = self._measured(now)
        if sample is None or sample.position is None:
            end = self._braking.start + RELEASE_S if self._braking is not None else now
            share = min(1.0, max(0.0, (end - now) / RELEASE_S))
            wanted = self._hold_effort + share * (self._brake_command - self._hold_effort)
            return min(max(wanted, -limit), limit)
        speed = sample.velocity if math.isfinite(sample.velocity) else 0.0
        wanted = self._hold_effort + s.position_gain * (position - sample.position)
        wanted += s.velocity_gain * (velocity - speed)
        return min(max(wanted, -limit), limit)

    def _progress(self, now: float) -> float:
        match self.state:
            case "exciting":
                return min(1.0, max(0.0, (now - self._began) / self.reference.total_s))
            case "done":
                return 1.0
            case _:
                return 0.0

    def with_limits(self, limits: Limits) -> None:
        """Tighten the limits before anything moves."""
        if self.state not in MOVING:
            self.limits = self.limits.tightened(limits)

    def with_start(self, position: float) -> None:
        """Set the start position before anything moves."""
        if self.state not in MOVING:
            self.settings = replace(self.settings, start_position=position)
