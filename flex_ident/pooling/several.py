"""Several recordings' results as one: parameters, what scatters and why, who disagrees, the effort's scale."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from flex_ident.errors import DataError
from flex_ident.judgement.rules import ESSENTIAL, not_determined
from flex_ident.notices import Code, Notice
from flex_ident.parameters import Covariance, Parameter, Verdict
from flex_ident.pooling.combining import NORMAL, Pooled, pooled_all, pooled_covariance
from flex_ident.pooling.conditions import Cause, causes
from flex_ident.pooling.disagreement import Disagreement, disagreements, distance
from flex_ident.pooling.members import Member, MemberValues, side_by_side
from flex_ident.pooling.thresholds import FEW_TOGETHER, LARGEST_ERROR, SCATTERS
from flex_ident.pooling.torque_scale import Estimate, Load, TorqueScale, torque_scale
from flex_ident.pooling.unloading import unloaded
from flex_ident.recording.recording import Floats

FEW = 3
"""Recordings up to which it is said that they are few."""


@dataclass(frozen=True)
class Several:
    """What several recordings say together: `parameters` with their covariance, and what each of them weighs.

    `given` are the values without the known loads, in recorded units; `pooled` (p) is in the order of its keys, and
    `multiplied` what the parameters were multiplied by to be in N m.
    """

    members: tuple[Member, ...]
    given: MemberValues
    pooled: tuple[Pooled, ...]
    parameters: tuple[Parameter, ...]
    covariance: Covariance
    causes: tuple[Cause, ...]
    disagreements: tuple[Disagreement, ...]
    scale: TorqueScale | None
    multiplied: float
    verdict: Verdict
    notices: tuple[Notice, ...]


def several(
    members: Sequence[Member], loads: Sequence[Load] | None = None, *, current: bool = False, slides: bool = False
) -> Several:
    """The members as one. `loads`: the known mass in each; `current`: the effort is a current of unknown scale, which
    the mass turns into a torque. Raises DataError for fewer than two members."""
    if len(members) < 2:
        raise DataError("fewer than two recordings can be used: there is nothing to put together.")
    raw = side_by_side(members)
    scale = None if loads is None else torque_scale(raw, loads, slides=slides)
    given = raw if loads is None or scale is None else unloaded(raw, loads, scale, slides=slides, assumed=not current)
    given = _only(given, [k for k in range(len(given.keys)) if given.there[:, k].any()])
    found = pooled_all(given)
    named = causes(given, found, [m.conditions for m in members])
    apart = disagreements(given, {c.key for c in named})
    matrix, multiplied = pooled_covariance(given, found), 1.0
    values = np.array([own.value for own in found])
    if current and scale is not None and scale.both is not None:
        multiplied = scale.both.value
        matrix = multiplied**2 * matrix + scale.both.std**2 * np.outer(values, values)
    parameters = _parameters(members, given, multiplied * values, np.sqrt(np.diag(matrix)), multiplied)
    units = {p.key: p.unit for p in parameters}
    scattering = _scatter_notices(members, given, found, named, units)
    objections = [*_apart(members, apart, given), *_doubtful(members)]
    objections += [n for p in parameters if p.key in ESSENTIAL and not p.identifiable for n in _open(p)]
    of_scale = [] if scale is None else scale_notices(scale, current=current)
    said = _few(len(members), len(set(given.sessions)))
    notices = (*objections, *of_scale, *scattering, *said)
    verdict: Verdict = "trusted"
    if any(n.severity != "info" for n in notices):
        verdict = "doubtful"
    if any(p.key in ESSENTIAL and not p.identifiable for p in parameters):
        verdict = "rejected"
    covariance = Covariance(given.keys, matrix, np.array([multiplied * own.shared for own in found]))
    return Several(
        tuple(members), given, found, parameters, covariance, named, apart, scale, multiplied, verdict, notices
    )  # fmt: skip


def _few(recordings: int, sessions: int) -> list[Notice]:
    """That they are few; and, where recordings are more than their days, that the days are."""
    said = [Notice(Code.FEW_RECORDINGS, numbers={"count": recordings})] if recordings <= FEW else []
    if sessions < recordings and sessions <= FEW:
        said.append(Notice(Code.FEW_SESSIONS, numbers={"count": sessions, "recordings": recordings}))
    return said


def _open(p: Parameter) -> list[Notice]:
    """Why a parameter without which there is no result is not determined: by none of them, or not by all together."""
    if not math.isfinite(p.std):
        return [not_determined(p)]
    return [Notice(Code.SCATTER_TOO_LARGE, p.key, {"value": p.value, "two_std": 2.0 * p.std}, {"unit": p.unit})]


def _only(given: MemberValues, columns: Sequence[int]) -> MemberValues:
    """The values of some of the keys."""
    return MemberValues(
        tuple(given.keys[k] for k in columns), given.values[:, columns],
        given.covariances[:, columns][:, :, columns], given.systematic[:, columns], given.sessions,
    )  # fmt: skip


def _parameters(
    members: Sequence[Member], given: MemberValues, values: Floats, stds: Floats, multiplied: float
) -> tuple[Parameter, ...]:
    """The parameters of all members in their order; those that none determines with an infinite deviation."""
    found = []
    firsts: dict[str, Parameter] = {}
    for p in (p for m in members for p in m.parameters):
        firsts.setdefault(p.key, p)
    for key, first in firsts.items():
        if key not in given.keys:
            value = multiplied * first.value
            found.append(Parameter(key, value, math.inf, first.unit, identifiable=False))
            continue
        k = given.keys.index(key)
        value, std = float(values[k]), float(stds[k])
        small = 0.0 if key in ESSENTIAL else FEW_TOGETHER * multiplied * _small(members, key)
        known = bool(std <= max(LARGEST_ERROR * abs(value), small))
        ci95 = (value - NORMAL * std, value + NORMAL * std)
        found.append(Parameter(key, value, std, first.unit, known, ci95))
    return tuple(found)


def _small(members: Sequence[Member], key: str) -> float:
    """The largest standard deviation of a key that hardly matters in a recording: it is identifiable there although it
    is known worse than others must be; 0 where there is none."""
    own = [p for m in members for p in m.parameters if p.key == key and p.identifiable and math.isfinite(p.std)]
    return max((p.std for p in own if p.std > LARGEST_ERROR * abs(p.value)), default=0.0)


def _scatter_notices(
    members: Sequence[Member],
    given: MemberValues,
    found: Sequence[Pooled],
    named: Sequence[Cause],
    units: dict[str, str],
) -> list[Notice]:
    by_key = {cause.key: cause for cause in named}
    notices = []
    for k, (key, own) in enumerate(zip(given.keys, found, strict=True)):
        if own.chance >= SCATTERS / len(given.keys):
            continue
        cause = by_key.get(key)
        share, cause_chance = (0.0, 1.0) if cause is None else (100.0 * cause.share, cause.chance)
        sizes = {
            "scatter": own.scatter, "chance": own.chance, "share_percent": share, "cause_chance": cause_chance,
            "apart": float(np.ptp(given.values[given.there[:, k], k])),
        }  # fmt: skip
        texts = {
            "case": _case(cause, own), "unit": units[key],
            "farthest": members[farthest(given, k)].name, "condition": "" if cause is None else cause.condition,
            "alike": "" if cause is None else ", ".join(cause.alike),
        }  # fmt: skip
        notices.append(Notice(Code.RECORDINGS_SCATTER, key, sizes, texts))
    return notices


def _case(cause: Cause | None, own: Pooled) -> str:
    """Which sentence tells of a parameter's scatter."""
    if cause is None:
        return "two" if own.weights.size == 2 else ""
    return "alike" if cause.alike else "condition"


def farthest(given: MemberValues, k: int) -> int:
    """The recording that lies farthest from what the others say of parameter `k`, in standard deviations."""
    rows = [int(i) for i in np.flatnonzero(given.there[:, k])]
    if len(rows) < 2:
        return rows[0]
    return max(rows, key=lambda i: distance(given, [j for j in rows if j != i], i, k))


def _apart(members: Sequence[Member], apart: Sequence[Disagreement], given: MemberValues) -> list[Notice]:
    found = []
    for own in apart:
        sizes = {"stds": own.stds, "chance": own.chance, "others": given.values.shape[0] - 1.0}
        found.append(Notice(Code.RECORDING_DISAGREES, members[own.index].name, sizes, {"key": own.key}))
    return found


def _doubtful(members: Sequence[Member]) -> list[Notice]:
    names = [m.name for m in members if m.verdict == "doubtful"]
    if not names:
        return []
    sizes = {"count": float(len(names)), "total": float(len(members))}
    return [Notice(Code.RECORDINGS_DOUBTFUL, numbers=sizes, texts={"names": ", ".join(names)})]


def scale_notices(scale: TorqueScale, *, current: bool) -> list[Notice]:
    """What a known mass says of the effort's scale."""
    if scale.both is None:
        return [Notice(Code.TORQUE_SCALE_UNKNOWN, "motor_torque", texts={"case": scale.outcome})]
    both, angle = scale.both, math.nan if scale.angle is None else math.degrees(scale.angle)
    sizes = {"scale": both.value, "two_std": 2.0 * both.std, "angle_deg": angle, "least_deg": LEAST_ANGLE_DEG,
             "inertia": _value(scale.inertia), "weight": _value(scale.gravity)}  # fmt: skip
    found = [Notice(Code.TORQUE_SCALE, "motor_torque", sizes)]
    if scale.agree is False and scale.inertia is not None and scale.gravity is not None and scale.chance is not None:
        apart = {"inertia": scale.inertia.value, "weight": scale.gravity.value, "chance": scale.chance}
        found.insert(0, Notice(Code.TORQUE_SCALES_DIFFER, "motor_torque", apart))
    elif scale.off and not current:
        found.insert(0, Notice(Code.TORQUE_SCALE_OFF, "motor_torque", sizes))
    return found


def _value(own: Estimate | None) -> float:
    return math.nan if own is None else own.value


LEAST_ANGLE_DEG = 5.0
"""Turn of the link's frame from which it is told."""
