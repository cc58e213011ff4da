"""A table of another program as a rosbag2 of joint states, and what was taken for what."""

from __future__ import annotations

import math
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.selection import JOINT_STATES, LINK_STATES, REFERENCE
from flex_ident.bags.writing import write_joint_states
from flex_ident.errors import SignalError, UsageError
from flex_ident.formats.columns import Choice, Columns, chosen_columns, unit_scale
from flex_ident.formats.opening import opened_tables
from flex_ident.formats.tables import Table
from flex_ident.notices import Code, Notice
from flex_ident.recording import Floats
from flex_ident.recording.cleaning import measurable
from flex_ident.recording.names import path_text
from flex_ident.report.sentences import sentence

LISTS = ("joints", "time", "position", "velocity", "effort", "link_position", "reference")
SLOWEST_HZ, FASTEST_HZ = 2.0, 1e5
"""Rates out of which the time is taken to be in another unit."""
LONGEST_S = 1e7
"""Time from the first row to the last, at most."""
TURNS = 4.0 * math.pi
"""Range of a position, rad, beyond which it may be in degrees."""
MOST_DROPPED = 0.05
"""Share of rows whose time does not advance, beyond which the rows are no recording."""
FEWEST = 3
LARGEST = 1e301
"""Magnitude of a number from which it is damage, as differences of two such numbers may be none."""


@dataclass(frozen=True)
class Imported:
    """The bag written, and lines that say what is in it."""

    bag: Path
    lines: tuple[str, ...]


def imported(files: Path | Sequence[Path], bag: Path, values: Mapping[str, object]) -> Imported:
    """Write the joints of a table, or of several whose rows belong together, as a bag.

    `values` are those of IMPORT_SETTINGS.

    Raises SignalError where the table does not hold what is needed, and UsageError where what was asked for does not
    fit together, a library is missing or the bag cannot be written.
    """
    if bag.exists() or bag.is_symlink():
        raise UsageError(f"--out {path_text(bag)}: exists already: name another, or remove it.")
    table = opened_tables([files] if isinstance(files, Path) else files, _episode(values))
    rate = float(str(values["import.rate_hz"]))
    choice = chosen_columns(table.columns, _given(values), source=table.source, timed=rate == 0.0)
    if rate:
        choice = Choice(None, choice.joints, tuple(role for role in choice.guessed if role != "time"))
    names = dict.fromkeys(
        [*([choice.time] if choice.time else []), *(n for j in choice.joints for n in j.names.values())]
    )
    content = {name: _believable(column) for name, column in table.read(names).items()}
    _refuse_unequal(table, content)
    time, keep, lines = _time(table, choice, content, values, rate)
    joints = [_scaled(table, joint, values) for joint in choice.joints]
    signals = _signals(joints, content, keep)
    lines += [_joint_line(joint) for joint in joints] + _doubts(joints, signals)
    if choice.guessed:
        taken = ", ".join(choice.guessed).replace("_", " ")
        lines.append(sentence(Notice(Code.COLUMNS_GUESSED, table.source, texts={"columns": taken})))
    _write(bag, time, joints, signals)
    return Imported(bag, tuple(lines))


def _believable(column: Floats) -> Floats:
    """The column with NaN for what damage made of its numbers: anything with which no one can reckon on."""
    with np.errstate(invalid="ignore"):  # a signalling NaN is one with which not even a comparison is quiet
        found: Floats = np.where(np.abs(column) < LARGEST, column, np.nan)
    return found


def _refuse_unequal(table: Table, content: Mapping[str, Floats]) -> None:
    """Raise SignalError when columns are of different lengths."""
    if len({column.size for column in content.values()}) > 1:
        sizes = ", ".join(f"{name} ({column.size})" for name, column in list(content.items())[:12])
        raise SignalError(f"{table.source}: columns of different lengths: {sizes}: name those that belong together.")


def _episode(values: Mapping[str, object]) -> int | None:
    episode = float(str(values["import.episode"]))
    if episode != int(episode):
        raise UsageError(f"--episode is {episode}: expected a whole number.")
    return int(episode) if episode >= 0.0 else None


def _given(values: Mapping[str, object]) -> dict[str, list[str]]:
    texts = {role: str(values[f"import.{role}"]) for role in LISTS}
    return {role: [n.strip() for n in text.split(",") if n.strip()] for role, text in texts.items() if text}


def _time(
    table: Table, choice: Choice, content: Mapping[str, Floats], values: Mapping[str, object], rate: float
) -> tuple[Floats, NDArray[np.bool_], list[str]]:
    """Times (n,), s, from 0 on; which rows of the table they are of; and a line about them."""
    if choice.time is None:
        size = min(column.size for column in content.values())
        _enough(table, size)
        return np.arange(size) / rate, np.ones(size, bool), [f"time: {size} samples at {rate:g} Hz, as said"]
    column = content[choice.time]
    scale = float(str(values["import.time_scale"])) or table.scales.get(choice.time) or unit_scale(choice.time)
    finite = np.isfinite(column)
    _enough(table, int(finite.sum()))
    raw = np.where(finite, column - column[finite][0], -np.inf)
    keep = finite & (raw > np.concatenate(([-np.inf], np.maximum.accumulate(raw)[:-1])))
    dropped = int(column.size - keep.sum())
    if dropped > MOST_DROPPED * column.size:
        raise SignalError(
            f"{table.source}: {choice.time} does not advance in {dropped} of {column.size} rows: name another column "
            "with --time, or import one recording at a time."
        )
    time = scale * raw[keep]
    _enough(table, time.size)
    if not time[-1] < LONGEST_S:
        raise SignalError(
            f"{table.source}: by {choice.time}, the rows span {time[-1]:.3g} s: say how many seconds its unit is with "
            "--time-scale, or import one recording at a time."
        )
    measured = 1.0 / float(np.median(np.diff(time)))
    if not SLOWEST_HZ <= measured <= FASTEST_HZ:
        raise SignalError(
            f"{table.source}: by {choice.time}, samples come at {measured:.3g} Hz: say how many seconds its unit is "
            "with --time-scale (0.001 for milliseconds, 1e-9 for nanoseconds)."
        )
    unit = f" times {scale:g}" if scale != 1.0 else ""
    line = f"time: {choice.time}{unit}, {time.size} samples at {measured:.2f} Hz"
    return time, keep, [line + (f", {dropped} rows dropped that do not advance" if dropped else "")]


def _enough(table: Table, samples: int) -> None:
    if samples < FEWEST:
        raise SignalError(f"{table.source}: {samples} rows of numbers: this is no recording.")


def _scaled(table: Table, joint: Columns, values: Mapping[str, object]) -> Columns:
    """The joint's columns with what each is multiplied by: as said, by the file, or by the unit in its name."""
    scales = {}
    for role, name in joint.names.items():
        kind = "position" if role in ("link_position", "reference") else role
        given = float(str(values[f"import.{kind}_scale"]))
        scales[role] = given or table.scales.get(name) or unit_scale(name)
    return Columns(joint.joint, joint.names, scales)


def _signals(joints: Sequence[Columns], content: Mapping[str, Floats], keep: NDArray[np.bool_]) -> dict[str, Floats]:
    """Values (n, joints) by role, NaN where a joint has none; (n, 0) where no joint has."""
    rows = int(keep.sum())
    found: dict[str, Floats] = {}
    for role in ("position", "velocity", "effort", "link_position", "reference"):
        own = [joint for joint in joints if role in joint.names]
        kept = joints if role in ("position", "velocity", "effort") else own
        columns = [
            joint.scales[role] * content[joint.names[role]][keep] if role in joint.names else np.full(rows, np.nan)
            for joint in kept
        ]
        found[role] = np.column_stack(columns) if own else np.zeros((rows, 0))
    return found


def _joint_line(joint: Columns) -> str:
    parts = (
        f"{role.replace('_', ' ')} {name}" + (f" times {joint.scales[role]:g}" if joint.scales[role] != 1.0 else "")
        for role, name in joint.names.items()
    )
    return f"{joint.joint}: {', '.join(parts)}"


def _doubts(joints: Sequence[Columns], signals: Mapping[str, Floats]) -> list[str]:
    """What looks as if it were not in SI units."""
    lines = []
    for i, joint in enumerate(joints):
        values = signals["position"][:, i]
        values = values[measurable(values)]
        if values.size and float(np.ptp(values)) > TURNS and joint.scales["position"] == 1.0:
            lines.append(
                f"{joint.joint} moves {np.ptp(values):.4g}: if that is in degrees, import it again with "
                "--position-scale 0.0174533"
            )
        effort = joint.names.get("effort", "")
        if joint.scales.get("effort") == 1.0 and any(
            word in effort.lower() for word in ("current", "[a]", "[ma]", "load")
        ):
            lines.append(
                f"{joint.joint}: the effort {effort} is no torque by its name: import it again with --effort-scale, "
                "N m per unit, or tell identify_bag its --effort-kind"
            )
    return lines


def _write(bag: Path, time: Floats, joints: Sequence[Columns], signals: Mapping[str, Floats]) -> None:
    """The bag with what is there of joint states, link positions and references. Raises UsageError."""
    more = {}
    for role, topic in (("link_position", LINK_STATES), ("reference", REFERENCE)):
        values = signals[role]
        if values.shape[1]:
            more[topic] = (time, [joint.joint for joint in joints if role in joint.names], values)
    try:
        write_joint_states(
            bag,
            time,
            [joint.joint for joint in joints],
            signals["position"],
            signals["velocity"],
            signals["effort"],
            topic=JOINT_STATES,
            more=more,
        )
    except OSError as error:
        shutil.rmtree(bag, ignore_errors=True)
        raise UsageError(f"--out {path_text(bag)}: cannot be written ({error.strerror}).") from error
    except BaseException:
        shutil.rmtree(bag, ignore_errors=True)
        raise
