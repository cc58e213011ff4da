"""A motion that holds one frequency or one speed is told: nothing that is fitted to it can be trusted."""

from __future__ import annotations

from dataclasses import replace

from flex_ident.filtering.motion_kind import constant_speed, single_tone_hz
from flex_ident.notices import Code, Notice
from flex_ident.recording import Recording

ONE_OF_MANY = (Code.SINGLE_TONE, Code.CONSTANT_SPEED)
"""Motions that leave most of a joint open."""


def with_motion_told(recording: Recording) -> Recording:
    """The recording with a notice where its motion holds one frequency or one speed; the same where it does not."""
    said = motion_notice(recording)
    if said is None or any(notice.code is said.code for notice in recording.notices):
        return recording
    return replace(recording, notices=(*recording.notices, said))


def motion_notice(recording: Recording) -> Notice | None:
    """That the motion holds one frequency, or one speed: then inertia, spring and gravity, or inertia and friction, act
    alike, and no fit tells them apart."""
    speed = constant_speed(recording.motor_position, recording.sample_rate_hz)
    if speed is not None:
        return Notice(Code.CONSTANT_SPEED, recording.joint, {"speed": speed})
    tone = single_tone_hz(recording.motor_position, recording.motor_torque, recording.sample_rate_hz)
    return None if tone is None else Notice(Code.SINGLE_TONE, recording.joint, {"frequency_hz": tone})
