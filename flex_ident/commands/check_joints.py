"""How well a joint was recorded, and whether it can be identified from that: `flex_ident check-bag`, joint by joint."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from flex_ident.bags.motions import JointMotion, moving_joint
from flex_ident.bags.reading import read_recording
from flex_ident.bags.selection import SignalSelection
from flex_ident.commands.check_tables import first_rows, messages_text, table_lines
from flex_ident.errors import DataError, ExcitationError, FlexIdentError
from flex_ident.estimation.estimate import fit_problem
from flex_ident.estimation.identification import identify, refuse_unusable
from flex_ident.estimation.motion_told import ONE_OF_MANY, with_motion_told
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.filtering.design import filter_design
from flex_ident.notices import Code
from flex_ident.notices.codes import NOT_SI
from flex_ident.recording import Recording, Sampling, extent_text, more_needed
from flex_ident.recording.recording import SHORT_S, SLOW_HZ
from flex_ident.report.answers import answer_text
from flex_ident.report.sentences import sentence
from flex_ident.report.table import percent_text

LEAST_S = 2.0
"""Length of motion, s, below which there is nothing to fit."""
HIGHEST_MODE = 0.1
"""Frequency of a mode over the sampling rate up to which its resonance is seen well."""
MUCH_PERCENT = 5.0
"""Share of messages, lost or dropped, that is worth a word."""


def joint_check(path: Path, selection: SignalSelection) -> tuple[str, FlexIdentError | None]:
    """How one joint was recorded, and the error that stands in the way when it cannot be identified."""
    try:
        recording = with_motion_told(read_recording(path, selection))
        text, obstacle = _recording_text(recording), _obstacle(recording)
        said = f"cannot be identified: {obstacle}" if obstacle is not None else _answer(recording, selection.sensors)
    except FlexIdentError as error:
        return f"joint {selection.joint or '?'} cannot be identified: {error}", error
    return f"{text}\n  {said}", obstacle


def why_none(motions: Sequence[JointMotion]) -> FlexIdentError:
    """Why no joint of the bag can be identified: none moved, or what was recorded does not tell."""
    try:
        moving_joint(motions)
    except FlexIdentError as error:
        return error
    return ExcitationError("no joint moved: record while a joint follows a chirp.")


def joints_to_check(selection: SignalSelection, motions: Sequence[JointMotion]) -> list[str | None]:
    """The joints to look at; None is the reader's to find."""
    if selection.joint not in (None, "all"):
        return [selection.joint]
    if selection.motor_position is not None or not motions:
        return [None]
    return list(dict.fromkeys(m.name for m in motions if not m.link and m.moves))


def motions_text(motions: Sequence[JointMotion]) -> str:
    """What each joint of the bag did, as a table; nothing without a joint."""
    if not motions:
        return ""
    rows = [
        (
            motion.topic,
            motion.name,
            messages_text(motion.messages),
            f"moved {motion.range:.4g}" if motion.moves else "held" if motion.has_position else "no position",
            f"effort up to {motion.largest_effort:.4g}" if motion.largest_effort else "no effort",
            "link side" if motion.link else "",
        )
        for motion in motions
    ]
    return "\n".join(["joints (numbers as recorded)", *first_rows(rows)])


def _answer(recording: Recording, sensors: str) -> str:
    """What the recording can answer, as identify_bag finds it without being told anything of the joint."""
    try:
        return answer_text(identify(recording, IdentifyOptions(sensors=sensors)), recording)
    except DataError as error:
        return f"this recording answers: nothing so far: {error}"


def _obstacle(recording: Recording) -> DataError | None:
    """What keeps an identification from starting: too few samples that say anything; None where nothing does."""
    if recording.time.size < LEAST_S * recording.sample_rate_hz:
        size, rate = recording.time.size, recording.sample_rate_hz
        return ExcitationError(f"{extent_text(size, rate)} are too short: {more_needed(size, rate)}")
    try:
        refuse_unusable(recording)
        fit_problem(recording, sensors="motor" if recording.link_position is None else "motor+link")
    except DataError as error:
        return error
    return None


def _recording_text(recording: Recording) -> str:
    rows: list[tuple[str, ...]] = [
        ("signal", "taken from", "rate", "clock", "jitter", "lost", "longest gap", "skew", "dropped")
    ]
    rows += [_sampling_row(sampling) for sampling in recording.sampling]
    lines = [f"joint {recording.joint}", *table_lines(rows), *(f"  {line}" for line in _prospects(recording))]
    lines += [f"  warning: {sentence(notice)} [{notice.code}]" for notice in recording.notices]
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
        percent_text(sampling.jitter_percent),
        percent_text(sampling.lost_percent),
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
    doubts = _doubts(recording)
    lines += doubts
    if _obstacle(recording) is None:
        lines.append(f"can be identified{_how_far(recording, doubts)}")
    return lines


def _how_far(recording: Recording, doubts: Sequence[str]) -> str:
    """How far a joint can be identified from a recording in which nothing stands in the way."""
    if doubts:
        return f" only in part: see the {len(doubts)} line{'s' if len(doubts) > 1 else ''} above"
    if any(notice.code is Code.OTHER_JOINTS_MOVE for notice in recording.notices):
        return " only where the motion of other joints hardly loads this one: record it alone"
    return ", when the chirp crosses the joint's first mode"


def _doubts(recording: Recording) -> list[str]:
    """What speaks against a good identification: too short, too slow, too much lost."""
    rate, seconds = recording.sample_rate_hz, recording.motor_position.size / recording.sample_rate_hz
    found = []
    if seconds < SHORT_S:
        found.append(f"short: {seconds:.3g} s of motion; {SHORT_S:.0f} s or more give narrower error bars")
    if rate < SLOW_HZ:
        found.append(
            f"slow: {rate:.4g} Hz shows modes below {HIGHEST_MODE * rate:.2g} Hz only; {SLOW_HZ:.0f} Hz or more do well"
        )
    for sampling in recording.sampling:
        dropped = sampling.dropped_duplicates + sampling.dropped_backwards + sampling.dropped_nonfinite
        share = 100.0 * dropped / (sampling.samples + dropped)
        name = sampling.role.replace("_", " ")
        if sampling.role != "reference" and share > MUCH_PERCENT:
            found.append(f"{percent_text(share)} of the messages of the {name} were dropped")
        if sampling.role != "reference" and sampling.lost_percent > MUCH_PERCENT:
            found.append(f"{percent_text(sampling.lost_percent)} of the {name} were lost on the way to the bag")
    if any(notice.code is Code.BAG_DAMAGED for notice in recording.notices):
        found.append("part of the bag is lost, by the warning below")
    if any(notice.code in NOT_SI for notice in recording.notices):
        found.append("not in SI units, by the warning below: no result will be trusted")
    if any(notice.code in ONE_OF_MANY for notice in recording.notices):
        found.append("one frequency or one speed only, by the warning below: no result will be trusted")
    if any(n.severity != "info" and n.code not in (*NOT_SI, *ONE_OF_MANY) for n in recording.notices):
        found.append("repaired where that can leave a mark, by the warning below: no result will be trusted")
    return found


def _band_hz(recording: Recording) -> tuple[float, float]:
    """The frequencies between which 98 % of the power of the motor's velocity lies."""
    velocity = np.diff(recording.motor_position)
    power = np.cumsum(np.abs(np.fft.rfft(velocity * np.hanning(velocity.size))) ** 2)
    frequency = np.fft.rfftfreq(velocity.size, recording.sample_time)
    low, high = np.searchsorted(power, (0.01 * power[-1], 0.99 * power[-1]))
    return float(frequency[low]), float(frequency[high])
