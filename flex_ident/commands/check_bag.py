"""`flex_ident check-bag`: what a bag holds, how well it was recorded, and whether a joint can be identified from it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from flex_ident.bags import JointMotion, SignalSelection, joint_motions, read_recording
from flex_ident.bags.messages import Topic
from flex_ident.bags.motions import STILL
from flex_ident.bags.storage import Bag
from flex_ident.errors import ExcitationError, FlexIdentError
from flex_ident.filtering.design import filter_design
from flex_ident.recording import Notice, Recording, Sampling

SHORT_S = 10.0
"""Length of motion, s, below which error bars grow wide."""


def checked_bag(path: Path, selection: SignalSelection) -> str:
    """A page about the bag. Raises BagError when it cannot be opened."""
    return bag_check(path, selection)[0]


def bag_check(path: Path, selection: SignalSelection) -> tuple[str, FlexIdentError | None]:
    """A page about the bag, and the error that stands in the way when no joint can be identified from it.

    Without a joint in `selection`, each joint that moves is looked at. Raises BagError when the bag cannot be opened.
    """
    with Bag(path) as bag:
        topics, files, damage = bag.topics(), len(bag.files), bag.damage()
    motions = joint_motions(path)
    parts = [_contents(path, files, topics, damage), _motions_text(motions)]
    joints = _joints(selection, motions)
    errors: list[FlexIdentError] = []
    if not joints:
        errors.append(ExcitationError("no joint moved: record while a joint follows a chirp."))
        parts.append(f"cannot be identified: {errors[-1]}")
    for joint in joints:
        try:
            parts.append(_recording_text(read_recording(path, replace(selection, joint=joint))))
        except FlexIdentError as error:
            errors.append(error)
            parts.append(f"joint {joint or '?'} cannot be identified: {error}")
    return "\n\n".join(part for part in parts if part), errors[0] if len(errors) >= max(1, len(joints)) else None


def _joints(selection: SignalSelection, motions: Sequence[JointMotion]) -> list[str | None]:
    """The joints to look at; None is the reader's to find."""
    if selection.joint not in (None, "all"):
        return [selection.joint]
    if selection.motor_position is not None or not motions:
        return [None]
    return list(dict.fromkeys(m.name for m in motions if not m.link and m.range > STILL))


def _contents(path: Path, files: int, topics: Sequence[Topic], damage: Sequence[Notice]) -> str:
    rows = [
        (topic.name, topic.message_type, "" if topic.count is None else f"{topic.count} messages")
        for topic in sorted(topics, key=lambda t: t.name)
    ]
    lines = [f"{path}: {files} file{'s' if files > 1 else ''}", *_table(rows)]
    return "\n".join([*lines, *(f"  damage: {notice.message}" for notice in damage)])


def _motions_text(motions: Sequence[JointMotion]) -> str:
    if not motions:
        return ""
    rows = [
        (
            motion.topic,
            motion.name,
            f"{motion.messages} messages",
            f"moved {motion.range:.4g}" if motion.range > STILL else "held",
            f"effort up to {motion.largest_effort:.4g}" if motion.largest_effort else "no effort",
            "link side" if motion.link else "",
        )
        for motion in motions
    ]
    return "\n".join(["joints (rad or m, N m or N)", *_table(rows)])


def _recording_text(recording: Recording) -> str:
    rows: list[tuple[str, ...]] = [
        ("signal", "taken from", "rate", "clock", "jitter", "lost", "longest gap", "skew", "dropped")
    ]
    rows += [_sampling_row(sampling) for sampling in recording.sampling]
    lines = [f"joint {recording.joint}", *_table(rows), *(f"  {line}" for line in _prospects(recording))]
    lines += [f"  warning: {notice.message} [{notice.code}]" for notice in recording.notices]
    return "\n".join(lines)


def _sampling_row(sampling: Sampling) -> tuple[str, ...]:
    dropped = (
        (sampling.dropped_nonfinite, "not finite"),
        (sampling.dropped_duplicates, "twice"),
        (sampling.dropped_backwards, "out of order"),
    )
    return (
        sampling.role.replace("_", " "),
        sampling.source,
        f"{sampling.rate_hz:.2f} Hz",
        "header" if sampling.clock == "header" else "reception",
        f"{sampling.jitter_percent:.2g} %",
        f"{sampling.lost_percent:.2g} %",
        f"{1e3 * sampling.longest_gap_s:.3g} ms",
        f"{1e3 * sampling.skew_s:.3g} ms",
        ", ".join(f"{count} {what}" for count, what in dropped if count) or "-",
    )


def _prospects(recording: Recording) -> list[str]:
    """What the recording lets one identify, in words."""
    q, rate = recording.motor_position, recording.sample_rate_hz
    seconds = q.size / rate
    low, high = _band_hz(recording)
    lines = [
        f"{q.size} samples, {seconds:.4g} s; moves {np.ptp(q):.4g} at {low:.2g} to {high:.2g} Hz; effort from "
        f"{recording.motor_torque.min():.4g} to {recording.motor_torque.max():.4g}"
    ]
    both = recording.link_position is not None
    highest = rate / filter_design(1.0, derivative_order=2 if both else 4).required_rate_hz
    lines.append(
        f"{'with a' if both else 'no'} link position: the model of {'both positions' if both else 'the motor alone'}; "
        f"--method paper for a first mode below {highest:.3g} Hz (eq. 29)"
    )
    if seconds < SHORT_S:
        lines.append(f"short: {seconds:.3g} s of motion; {SHORT_S:.0f} s or more give narrower error bars")
    lines.append("can be identified, when the chirp crosses the joint's first mode")
    return lines


def _band_hz(recording: Recording) -> tuple[float, float]:
    """The frequencies between which 98 % of the power of the motor's velocity lies."""
    velocity = np.diff(recording.motor_position)
    power = np.cumsum(np.abs(np.fft.rfft(velocity * np.hanning(velocity.size))) ** 2)
    frequency = np.fft.rfftfreq(velocity.size, recording.sample_time)
    low, high = np.searchsorted(power, (0.01 * power[-1], 0.99 * power[-1]))
    return float(frequency[low]), float(frequency[high])


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))] if rows else []
    return [
        "  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows
    ]
