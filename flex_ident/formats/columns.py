"""Which column of a table holds what, of which joint: as the user says, or by the columns' names."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from math import pi

from flex_ident.errors import SignalError, UsageError
from flex_ident.formats.tables import listed

NAMES: dict[str, tuple[str, ...]] = {
    "time": ("time", "t", "timestamp", "stamp", "seconds", "sec", "times", "tout"),
    "position": (
        "motor position", "joint position", "joint positions", "position", "positions", "actual q", "qpos", "q", "q m",
        "qm", "pos", "theta", "theta m", "motor pos", "q motor", "q meas", "angle", "observation state",
        "observation position",
    ),
    "velocity": (
        "motor velocity", "joint velocity", "joint velocities", "velocity", "velocities", "actual qd", "qvel", "dq",
        "qdot", "q dot", "vel", "dtheta", "observation velocity",
    ),
    "effort": (
        "motor torque", "joint torque", "joint torques", "joint effort", "effort", "efforts", "torque", "torques",
        "actual torque", "tau", "tau m", "taum", "tau motor", "tau j", "tau meas", "observation effort",
        "observation torque", "force", "forces",
    ),
    "link_position": ("link position", "ql", "q l", "q link", "link pos", "load position", "theta l", "position link"),
    "reference": (
        "reference", "command", "q ref", "qref", "q d", "q des", "q cmd", "target q", "position command", "target",
        "target position", "desired position", "action",
    ),
}  # fmt: skip
"""Names of columns, the likeliest first; beside them may stand a joint's name or number."""
ROLES = tuple(NAMES)
UNITS = {
    "deg": pi / 180.0, "degree": pi / 180.0, "degrees": pi / 180.0, "°": pi / 180.0, "deg/s": pi / 180.0,
    "°/s": pi / 180.0, "rpm": pi / 30.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "mm": 1e-3, "mnm": 1e-3,
    "knm": 1e3, "ncm": 1e-2, "rev": 2.0 * pi, "revs": 2.0 * pi, "turn": 2.0 * pi, "turns": 2.0 * pi,
    "mrad": 1e-3, "mrad/s": 1e-3, "urad": 1e-6, "µrad": 1e-6, "cm": 1e-2,
    "rev/s": 2.0 * pi, "turns/s": 2.0 * pi,
}  # fmt: skip
"""SI units per unit, of units that are not SI and may stand in brackets behind a name."""
_TOKEN = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_UNIT = re.compile(r"[\[(]([^\])]*)[\])]\s*$")
_SPOKEN = {role: [tuple(name.split()) for name in names] for role, names in NAMES.items()}
_KINDS = ("pos", "position", "vel", "velocity", "eff", "effort", "torque")
"""Words that say again what the column holds, and are no part of a joint's name."""
_COMMANDED = ("des", "desired", "d", "cmd", "command", "ref", "reference", "target", "setpoint", "goal")
"""Words that say that a column holds what was asked for, and not what was measured."""


_CURRENTS = (("i", "q"), ("i", "d"), ("iq", "m"))
"""Beginnings of the names of currents, which are no joint's position `q`."""
_MEASURED = ("meas", "measured", "actual", "act", "raw")
"""Words that say that a column holds what was measured, and are no part of a joint's name."""


@dataclass(frozen=True)
class Columns:
    """The columns of one joint, and what each is multiplied by to be in SI units."""

    joint: str
    names: Mapping[str, str]
    scales: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Choice:
    """The column of time, if there is one, and those of each joint; `guessed` are the roles that names decided."""

    time: str | None
    joints: tuple[Columns, ...]
    guessed: tuple[str, ...]


def chosen_columns(
    columns: Collection[str], given: Mapping[str, Sequence[str]], *, source: str, timed: bool = True
) -> Choice:  # fmt: skip
    """Which columns to take: those `given` by role (`joints` names the joints), and what names tell of the rest.

    `timed`: a column of time is needed. Raises SignalError, listing the columns, when one is missing, and UsageError
    when what is given does not fit together.
    """
    given = {
        role: list(names) if role == "joints" else [own for n in names for own in _named(n, columns, role, source)]
        for role, names in given.items()
        if names
    }
    guesses = _guesses([name for name in columns if not any(name in own for own in given.values())])
    time = given["time"][0] if "time" in given else next(iter(guesses["time"].values()), None)
    if timed and time is None:
        raise SignalError(
            f"{source}: no column for time among {listed(columns)}: name it with --time, or give the samples a second "
            "with --rate."
        )
    places = _by_joint(given, guesses)
    roles = [role for role in ROLES if role != "time"]
    for role in ("position", "effort"):
        if not any(role in own for own in places.values()):
            raise SignalError(f"{source}: no column for {role} among {listed(columns)}: name it with --{role}.")
    complete = {label: own for label, own in places.items() if "position" in own}
    if not any("effort" in own for own in complete.values()):
        raise SignalError(
            f"{source}: no joint has position and effort both: {_shown(places)}: name them with --position and "
            "--effort."
        )
    names = given.get("joints") or [_joint_name(label) for label in complete]
    if len(names) != len(complete):
        raise UsageError(f"--joints names {len(names)} joints, and there are {len(complete)}: {_shown(complete)}.")
    if len(set(names)) < len(names):
        raise UsageError(f"two joints are called alike: {', '.join(names)}: name them with --joints.")
    guessed = tuple(r for r in ROLES if r not in given and (r == "time" or any(r in own for own in complete.values())))
    joints = (
        Columns(name, {role: own[role] for role in roles if role in own})
        for name, own in zip(names, complete.values(), strict=True)
    )
    return Choice(time, tuple(joints), guessed)


def unit_scale(name: str) -> float:
    """SI units per unit of a column, by the unit in brackets behind its name; 1 where there is none that is known."""
    match = _UNIT.search(name)
    return UNITS.get(match.group(1).strip().lower().replace("·", "").replace(" ", ""), 1.0) if match else 1.0


def _named(name: str, columns: Collection[str], role: str, source: str) -> list[str]:
    """The column of a name, or those from one to another, `FIRST..LAST`, in the file's order."""
    first, dots, last = name.partition("..")
    if not dots or name in columns:
        return [_known(name, columns, role, source)]
    order = list(columns)
    start, end = (order.index(_known(end, columns, role, source)) for end in (first, last))
    if end < start:
        raise UsageError(f"--{role.replace('_', '-')} {name}: {last} stands before {first}.")
    return order[start : end + 1]


def _known(name: str, columns: Collection[str], role: str, source: str) -> str:
    plain = re.sub(r"\[(\d+)\]", r".\1", name)
    found = next((known for known in (name, plain) if known in columns), None)
    if found is None:
        raise SignalError(f"{source}: no column '{name}' for {role}: it has {listed(columns)}.")
    return found


def _by_joint(
    given: Mapping[str, Sequence[str]], guesses: Mapping[str, Mapping[str, str]]
) -> dict[str, dict[str, str]]:
    """The columns of each joint by role. Raises UsageError when lists are of different lengths."""
    if "position" in given:
        labels = [(_parsed(name).get("position") or (name,))[0] for name in given["position"]]
        labels = labels if len(set(labels)) == len(labels) else list(given["position"])
    else:
        labels = list(guesses["position"]) or list(guesses["effort"])
    places: dict[str, dict[str, str]] = {label: {} for label in labels}
    for role in (role for role in ROLES if role != "time"):
        own = given.get(role)
        if own is not None and len(own) != len(labels):
            names = ", ".join(labels) or "none"
            raise UsageError(f"--{role.replace('_', '-')} names {len(own)} columns for {len(labels)} joints ({names}).")
        guess = guesses[role]
        alone = len(labels) == 1 and len(guess) == 1 and "" in (labels[0], *guess)
        for i, label in enumerate(labels):
            found = own[i] if own is not None else guess.get(label) or (next(iter(guess.values())) if alone else None)
            if found is not None:
                places[label][role] = found
    return places


def _guesses(columns: Sequence[str]) -> dict[str, dict[str, str]]:
    """Columns by role and joint; of several for the same the one whose name comes first in the table of names."""
    found: dict[str, dict[str, tuple[int, str]]] = {role: {} for role in ROLES}
    for name in columns:
        for role, (label, rank) in _parsed(name).items():
            key = "" if role == "time" else label
            rank += 100 * bool(label) if role == "time" else 0
            if key not in found[role] or rank < found[role][key][0]:
                found[role][key] = (rank, name)
    return {role: {label: name for label, (_, name) in own.items()} for role, own in found.items()}


def _parsed(name: str) -> dict[str, tuple[str, int]]:
    """The role that a column's name tells, with the joint's label and how far down its table the name stands.

    Where a name tells nothing, it may without the structures that it stands in: `q.0` of `log.q.0`.
    """
    bare = _UNIT.sub("", name).strip()
    while not (found := _spoken(bare)) and "." in bare:
        bare = bare.partition(".")[2]
    return found


def _spoken(bare: str) -> dict[str, tuple[str, int]]:
    tokens = [(match.group().lower(), match.span()) for match in _TOKEN.finditer(bare)]
    words = tuple(word for word, _ in tokens)
    if words[:2] in _CURRENTS:
        return {}
    best: tuple[int, bool, int, str, list[tuple[str, tuple[int, int]]]] | None = None
    for role, spoken in _SPOKEN.items():
        for rank, own in enumerate(spoken):
            size = len(own)
            behind = words[:size] != own
            if behind and words[len(words) - size :] != own:
                continue
            rest = tokens[: len(tokens) - size] if behind else tokens[size:]
            if best is None or (-size, behind, rank) < best[:3]:
                best = (-size, behind, rank, role, rest)
    if best is None:
        return {}
    _, _, rank, role, rest = best
    if any(word in _COMMANDED for word, _ in rest):
        if role != "position":
            return {}
        role, rest = "reference", [token for token in rest if token[0] not in _COMMANDED]
    rest = [token for token in rest if token[0] not in _MEASURED]
    while len(rest) > 1 and rest[-1][0] in _KINDS:
        rest = rest[:-1]
    while len(rest) > 1 and rest[0][0] in _KINDS:
        rest = rest[1:]
    return {role: (bare[rest[0][1][0] : rest[-1][1][1]] if rest else "", rank)}


def _joint_name(label: str) -> str:
    return f"joint_{label}" if label.isdigit() else label or "joint"


def _shown(places: Mapping[str, Mapping[str, str]]) -> str:
    return ", ".join(f"{_joint_name(label)} ({', '.join(own.values())})" for label, own in list(places.items())[:12])
