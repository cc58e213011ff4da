"""Signals from a table of columns: CSV, with column names guessed or mapped; what was taken for what is given back."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from flex_ident.errors import SignalError
from flex_ident.notices import Code, Notice
from flex_ident.parameters.documents import opened_file
from flex_ident.recording import Floats, Signal
from flex_ident.recording.cleaning import cleaned_signal, measurable
from flex_ident.recording.names import decoded, path_text
from flex_ident.recording.recording import Role

MOST_COLUMNS, LONGEST_LINE = 4096, 1 << 20
DELIMITERS = ",;"
"""Separators; a tab is read as a semicolon, and blanks separate where there is none of these."""
NAMES: dict[str, tuple[str, ...]] = {
    "time": ("time", "t", "timestamp", "stamp", "seconds", "sec", "time_s", "times"),
    "motor_position": (
        "motor_position", "position", "q", "qm", "pos", "theta_m", "motor_pos", "joint_position", "q_motor", "theta",
    ),
    "motor_torque": (
        "motor_torque", "effort", "torque", "tau", "taum", "tau_m", "tau_motor", "joint_torque", "joint_effort",
    ),
    "link_position": ("link_position", "ql", "q_link", "link_pos", "load_position", "theta_l", "position_link"),
    "reference": ("reference", "command", "qd", "q_ref", "position_command", "target", "desired_position"),
}  # fmt: skip
"""Names of columns, the likeliest first; case, spaces, units in brackets and the joint's number aside."""
NEEDED = ("time", "motor_position", "motor_torque")
ROLES: tuple[Role, ...] = ("motor_position", "link_position", "motor_torque", "reference")


@dataclass(frozen=True)
class Table:
    """Columns of numbers (n,) by name; what is no number is NaN."""

    source: str
    columns: Mapping[str, Floats]


def read_csv(path: Path) -> Table:
    """The columns of a CSV file with a header line, separated by comma, semicolon, tab or blanks.

    Raises SignalError in one line. Lines shorter than the header are NaN where they lack a number.
    """
    shown = path_text(path)
    try:
        with opened_file(path) as file:
            lines = (decoded(line.rstrip(b"\r\n").replace(b"\t", b";")) for line in _lines(file, shown))
            head = next(lines, "").lstrip("\ufeff# ")
            delimiter = max(DELIMITERS, key=head.count)
            delimiter = delimiter if delimiter in head else " "
            names = [name.strip() for name in next(csv.reader([head], delimiter=delimiter, skipinitialspace=True), [])]
            rows = _rows(lines, delimiter, len(names))
    except OSError as error:
        raise SignalError(f"{shown}: cannot be read ({error.strerror}).") from error
    except csv.Error as error:
        raise SignalError(f"{shown}: is not a table ({error}).") from error
    if len(names) < 2 or not any(name and not _is_number(name) for name in names):
        raise SignalError(f"{shown}: its first line names no columns: expected names such as time, position, effort.")
    if len(names) > MOST_COLUMNS:
        raise SignalError(f"{shown}: has {len(names)} columns: {MOST_COLUMNS} are read at most.")
    return Table(shown, {name or f"column_{i + 1}": rows[:, i] for i, name in enumerate(names)})


def guessed_columns(table: Table, joint: str | None = None) -> dict[str, str]:
    """Which column is taken for time and each signal, by its name; those of `joint` (a number or name) come first.

    Raises SignalError, listing the columns, when time, position or effort is not found.
    """
    found: dict[str, str] = {}
    plain = {name: _plain(name) for name in table.columns}
    for role, names in NAMES.items():
        for wanted in names:
            ends = [wanted] if joint is None or role == "time" else []
            ends += (
                [f"{wanted}_{joint}", f"{wanted}{joint}", f"{joint}_{wanted}"]
                if joint
                else [f"{wanted}_1", f"{wanted}1"]
            )
            taken = next((name for end in ends for name, own in plain.items() if own == _plain(end)), None)
            if taken is not None and taken not in found.values():
                found[role] = taken
                break
    missing = [role for role in NEEDED if role not in found]
    if missing:
        there = ", ".join(list(table.columns)[:24])
        raise SignalError(f"{table.source}: no column for {', '.join(missing)} among {there}: name them in a mapping.")
    return found


def table_signals(
    table: Table, columns: Mapping[str, str] | None = None, *, joint: str | None = None, time_scale: float = 1.0,
    factors: Mapping[Role, float] | None = None,
) -> tuple[list[Signal], list[Notice]]:  # fmt: skip
    """The signals of one joint, cleaned, and what was done, which columns were taken among it.

    `columns` maps time, motor_position, motor_torque, link_position and reference to names; without it they are
    guessed. `time_scale` is seconds per unit of the time column; values are multiplied by their role's factor. Raises
    SignalError.
    """
    guessed = columns is None
    chosen = guessed_columns(table, joint) if columns is None else dict(columns)
    for role, name in chosen.items():
        if role not in NAMES:
            raise SignalError(f"'{role}' is no signal: expected {', '.join(NAMES)}.")
        if name not in table.columns:
            raise SignalError(f"{table.source}: no column '{name}': it has {', '.join(list(table.columns)[:24])}.")
    for role in NEEDED:
        if role not in chosen:
            raise SignalError(f"{table.source}: the mapping names no column for {role}.")
    time = table.columns[chosen["time"]] * time_scale
    finite = time[measurable(time)]
    time = time - (float(finite[0]) if finite.size else 0.0)
    signals: list[Signal] = []
    notices: list[Notice] = []
    if guessed:
        taken = ", ".join(f"{name} for {role}" for role, name in chosen.items())
        notices.append(Notice(Code.COLUMNS_GUESSED, table.source, texts={"columns": taken}))
    for role in ROLES:
        if role in chosen:
            values = table.columns[chosen[role]] * (factors or {}).get(role, 1.0)
            signal, said = cleaned_signal(role, f"{table.source}:{chosen[role]}", "header", time, values)
            signals.append(signal)
            notices += said
    return signals, list(dict.fromkeys(notices))


def _lines(file: io.BufferedReader, shown: str) -> Iterator[bytes]:
    while line := file.readline(LONGEST_LINE + 1):
        if len(line) > LONGEST_LINE:
            raise SignalError(f"{shown}: has a line of over {LONGEST_LINE} bytes: this is no table.")
        if line.strip():
            yield line


def _rows(lines: Iterator[str], delimiter: str, columns: int) -> Floats:
    """Numbers (n, columns); a comma within is the decimal point where it does not separate."""
    made: list[Floats] = []
    block: list[list[float]] = []
    for cells in csv.reader(lines, delimiter=delimiter, skipinitialspace=True):
        row = [_number(cell, comma=delimiter != ",") for cell in cells[:columns]]
        block.append(row + [math.nan] * (columns - len(row)))
        if len(block) >= 1 << 14:
            made.append(np.array(block))
            block = []
    if block:
        made.append(np.array(block))
    return np.concatenate(made) if made else np.zeros((0, columns))


def _number(cell: str, *, comma: bool) -> float:
    try:
        return float(cell.replace(",", ".") if comma else cell)
    except ValueError:
        return math.nan


def _is_number(text: str) -> bool:
    return not math.isnan(_number(text, comma=True))


def _plain(name: str) -> str:
    """A column's name without case, units in brackets and separators."""
    bare = name.split("[")[0].split("(")[0].strip().lower()
    return "".join("_" if c in " -./:" else c for c in bare).replace("_", "")
