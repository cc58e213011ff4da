"""What must hold before a joint moves: each objection is a line with the number and the fix."""

from __future__ import annotations

import math

from flex_ident.excitation.chirp import Reference
from flex_ident.excitation.joint_states import SUSPECT_S, JointSample, JointStateWatch
from flex_ident.excitation.limits import Limits
from flex_ident.excitation.settings import ExciterSettings

TICKS_PER_PERIOD = 10.0
"""Commands that the highest frequency of the sweep needs in a period."""
STILL = 0.05
"""Speed, rad/s, above which a joint is not at rest."""
LAG = 0.5
"""Delay of the readings times the gain of a velocity that is closed over them, at most; it swings from pi / 2 on."""
LONGEST_PERIOD_S = 0.5 * SUSPECT_S
"""Between two joint states from which efforts are closed."""


def start_objection(
    settings: ExciterSettings, limits: Limits, reference: Reference, watch: JointStateWatch, now: float
) -> str:
    """Why a joint at rest must not begin to move now; empty when it may."""
    why = _open(settings, limits) or watch.absence(now)
    sample = watch.trusted(now)
    if why or sample is None or sample.position is None:
        return why
    here = sample.position
    center = here if settings.start_position is None else settings.start_position
    return (
        _moving(settings, sample, watch)
        or _feedback(settings, watch)
        or _placed(settings, limits, here)
        or _effort(settings, limits, sample)
        or chirp_objection(settings, limits, reference, center)
        or _wrapping(settings, reference, here, center)
    )


def _open(s: ExciterSettings, limits: Limits) -> str:
    """Limits without which nothing moves and that neither parameters nor URDF give."""
    needed = ("position_min", "position_max", "velocity", *(("effort",) if s.interface == "effort" else ()))
    missing = ", ".join(f"limits.{name}" for name in needed if not math.isfinite(getattr(limits, name)))
    return f"{missing} not known, neither from the parameters nor from robot_description: give them." if missing else ""


def _moving(s: ExciterSettings, sample: JointSample, watch: JointStateWatch) -> str:
    speeds = watch.speeds()
    for name, position, speed in zip((s.joint, *s.held), (sample.position, *sample.others), speeds, strict=False):
        if position is None or not math.isfinite(position):
            return f"joint '{name}' of command.joints has no position in the joint states: check its name."
        if abs(speed) > STILL:
            return f"'{name}' moves at {speed:.2g} rad/s: let it come to rest."
    return ""


def _feedback(s: ExciterSettings, watch: JointStateWatch) -> str:
    """Whether the readings come too late or too seldom for commands that are closed over them."""
    if s.interface == "position" or (s.interface == "velocity" and s.gains.position == 0.0):
        return ""
    allowed = SUSPECT_S if s.interface == "effort" else max(SUSPECT_S, LAG / s.gains.position)
    latency, period = watch.latency_s(), watch.period_s
    if latency > allowed:
        return (
            f"the joint states are {latency:.2f} s old when they come, {allowed:.2f} s allowed where {s.interface} is "
            "closed over them: is the network slow, or do the clocks of robot and computer differ?"
        )
    if s.interface == "effort" and period > LONGEST_PERIOD_S:
        return (
            f"the joint states come at {1.0 / period:.0f} Hz, effort that is closed over them needs "
            f"{1.0 / LONGEST_PERIOD_S:.0f} Hz: have the driver publish faster, or command positions."
        )
    return ""


def _placed(s: ExciterSettings, limits: Limits, here: float) -> str:
    if limits.position_min <= here <= limits.position_max:
        return ""
    return (
        f"'{s.joint}' stands at {here:.4g} rad, outside {limits.position_min:.4g} to {limits.position_max:.4g} rad: "
        "move it inside."
    )


def _effort(s: ExciterSettings, limits: Limits, sample: JointSample) -> str:
    if abs(sample.effort) > limits.effort:
        return (
            f"'{s.joint}' exerts {abs(sample.effort):.3g} N m at rest, allowed are {limits.effort:.3g} N m: raise "
            "limits.effort, or move it where gravity pulls less."
        )
    if s.interface == "effort" and s.carry_effort:
        efforts = (sample.effort, *(sample.others_effort or (math.nan,) * len(s.held)))
        for name, effort in zip((s.joint, *s.held), efforts, strict=False):
            if not math.isfinite(effort):
                return (
                    f"the joint states hold no effort of '{name}', which command.carry_effort would go on with: set it "
                    "false where the robot bears gravity on its own, else have the driver publish efforts."
                )
    return ""


def _wrapping(s: ExciterSettings, reference: Reference, here: float, center: float) -> str:
    """Commanded positions of a joint without end: whether its drive counts on or wraps at a half turn is not known."""
    if s.interface != "position" or not any(s.continuous[:1]):
        return ""
    low = min(here, center + reference.bounds.low)
    high = max(here, center + reference.bounds.high)
    if math.floor((low + math.pi) / math.tau) == math.floor((high + math.pi) / math.tau):
        return ""
    return (
        f"'{s.joint}' turns without end and the motion passes a half turn ({low:.3g} to {high:.3g} rad), where its "
        "positions may jump: start elsewhere, or command velocity."
    )


def chirp_objection(s: ExciterSettings, limits: Limits, reference: Reference, center: float) -> str:
    """Why the chirp around `center`, rad, must not be played."""
    bounds = reference.bounds
    low, high = center + bounds.low, center + bounds.high
    if not limits.position_min <= center <= limits.position_max:
        return (
            f"start_position {center:.4g} rad cannot be reached, allowed are {limits.position_min:.4g} to "
            f"{limits.position_max:.4g} rad: change start_position."
        )
    if low < limits.position_min or high > limits.position_max:
        room = min(
            (center - limits.position_min) / max(-bounds.low, 1e-12),
            (limits.position_max - center) / max(bounds.high, 1e-12),
        )
        return (
            f"the chirp reaches {low:.4g} to {high:.4g} rad, allowed are {limits.position_min:.4g} to "
            f"{limits.position_max:.4g} rad: reduce chirp.amplitude to {100 * room:.0f} % of what it is, or change "
            "start_position."
        )
    if bounds.speed > limits.velocity:
        return (
            f"the chirp reaches {bounds.speed:.3g} rad/s, allowed are {limits.velocity:.3g} rad/s: reduce "
            f"chirp.amplitude to {100 * limits.velocity / bounds.speed:.0f} % of what it is, or use chirp.profile "
            "constant_velocity or constant_acceleration."
        )
    needed = s.inertia * bounds.acceleration
    if needed > limits.effort:
        return (
            f"the chirp needs about {needed:.3g} N m, allowed are {limits.effort:.3g} N m: reduce chirp.amplitude "
            f"to {100 * limits.effort / needed:.0f} % of what it is, or use chirp.profile constant_acceleration."
        )
    highest = s.rate_hz / TICKS_PER_PERIOD
    if reference.highest_hz > highest:
        return (
            f"the chirp sweeps to {reference.highest_hz:g} Hz, commands at {s.rate_hz:g} Hz carry up to "
            f"{highest:g} Hz: raise rate_hz to {TICKS_PER_PERIOD * reference.highest_hz:g}, or reduce "
            "chirp.end_frequency_hz."
        )
    return ""
