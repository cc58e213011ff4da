"""The scale of the effort from a known mass: by what it adds to the inertia and by what it adds to gravity.

What is identified is in recorded units: each inertia and moment is b times the true one, b = 1 / scale. A mass m at
(x, y) adds to recording i, beside what the link has by itself,

    JL_i = a + b m (x^2 + y^2)
    MX_i = a_x + u m x - v m y      MY_i = a_y + v m x + u m y      b = sqrt(u^2 + v^2)

(u, v) turn the frame in which x and y are given to that of MX and MY (eq. 7), which is where the position is zero. No
friction is in these equations: it cannot be mixed up with the scale. On a joint that slides the mass adds b m.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.stats import chi2, norm, t

from flex_ident.errors import UsageError
from flex_ident.pooling.combining import NORMAL
from flex_ident.pooling.members import MemberValues
from flex_ident.pooling.thresholds import DIFFERENT_SCALES, LARGEST_SCALE_ERROR, SCALE_OFF_STDS, SCATTERS
from flex_ident.recording.recording import Floats

Outcome = Literal["found", "on_axis", "same_loads", "weak"]
INERTIAS = ("JL", "J")


@dataclass(frozen=True)
class Load:
    """A mass, kg, at `x` and `y`, m, in the link's frame. Raises UsageError for what is no mass, or no place."""

    mass: float = 0.0
    x: float = 0.0
    y: float = 0.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.mass) and self.mass >= 0.0 and math.isfinite(self.x) and math.isfinite(self.y)):
            raise UsageError(
                f"payload of {self.mass:g} kg at {self.x:g}, {self.y:g} m: expected a mass of 0 kg or more, and "
                "numbers for its place."
            )

    @property
    def inertia(self) -> float:
        """What it adds to the link's inertia, kg m^2."""
        return self.mass * (self.x**2 + self.y**2)


@dataclass(frozen=True)
class Estimate:
    """One number with its standard deviation and 95 % interval."""

    value: float
    std: float
    low: float
    high: float


@dataclass(frozen=True)
class TorqueScale:
    """What the recorded effort must be multiplied by, and from what that is known; None where it is not.

    `chance`: of the two to differ as much. `angle`: by which the frame of x and y lies off that of MX and MY, rad.
    `per_unit` (3,): b, u and v, with their covariance (3, 3), as far as they are known.
    """

    outcome: Outcome
    both: Estimate | None = None
    inertia: Estimate | None = None
    gravity: Estimate | None = None
    chance: float | None = None
    angle: float | None = None
    per_unit: Floats | None = None
    covariance: Floats | None = None

    @property
    def agree(self) -> bool | None:
        """Whether inertia and gravity say the same; None where one of them says nothing."""
        return None if self.chance is None else self.chance >= DIFFERENT_SCALES

    @property
    def off(self) -> bool:
        """Whether the scale is surely another than the one that the effort was taken with."""
        return self.both is not None and abs(self.both.value - 1.0) > SCALE_OFF_STDS * self.both.std


@dataclass(frozen=True)
class _Line:
    """Least squares with correlated errors: solution (p,), covariance (p, p), and the quantile of its interval."""

    solution: Floats
    covariance: Floats
    factor: float
    quantile: float


def torque_scale(given: MemberValues, loads: Sequence[Load], *, slides: bool = False) -> TorqueScale:
    """The scale from recordings with and without known masses, in the order of `given`."""
    added = np.array([load.mass if slides else load.inertia for load in loads])
    moments = np.array([(load.mass * load.x, load.mass * load.y) for load in loads])
    if np.ptp(added) == 0.0 and np.ptp(moments, axis=0).max() == 0.0:
        same = any(load.mass > 0.0 for load in loads) and len({load.mass for load in loads}) > 1
        return TorqueScale("on_axis" if same else "same_loads")
    by_inertia = _by_inertia(given, added)
    by_gravity = None if slides else _by_gravity(given, moments)
    inertia = None if by_inertia is None else _scale(by_inertia.solution[1], _std(by_inertia), by_inertia.quantile)
    gravity = angle = None
    if by_gravity is not None:
        size, std, angle = _size(by_gravity)
        gravity = _scale(size, std, by_gravity.quantile)
    known = [own for own in (inertia, gravity) if own is not None]
    if not known:
        return TorqueScale("weak")
    if inertia is None or gravity is None or by_inertia is None or by_gravity is None:
        return _alone(known[0], inertia, gravity, by_inertia, by_gravity, angle)
    return _joined(given, added, moments, by_inertia, by_gravity, (inertia, gravity), angle or 0.0)


def _by_inertia(given: MemberValues, added: Floats) -> _Line | None:
    """Intercept and b from the link's inertias; None where they do not tell."""
    key = next((key for key in INERTIAS if key in given.keys), None)
    if key is None:
        return None
    k = given.keys.index(key)
    rows = given.there[:, k]
    if rows.sum() < 2 or np.ptp(added[rows]) == 0.0:
        return None
    design = np.column_stack((np.ones(int(rows.sum())), added[rows]))
    return _fitted(design, given.values[rows, k], np.diag(given.covariances[rows, k, k]))


def _by_gravity(given: MemberValues, moments: Floats) -> _Line | None:
    """Intercepts, u and v from the link's first moments; None where they do not tell."""
    found = _gravity_rows(given, moments)
    if found is None:
        return None
    design, target, covariance, _ = found
    return _fitted(design, target, covariance)


def _gravity_rows(given: MemberValues, moments: Floats) -> tuple[Floats, Floats, Floats, list[int]] | None:
    """Design (2 m, 4), target (2 m,) and covariance of MX and MY of the m recordings that have both, and which.

    Without what the method shares between the recordings, as what pulls beside gravity: the intercepts have it.
    """
    if not {"MX", "MY"} <= set(given.keys):
        return None
    at = [given.keys.index("MX"), given.keys.index("MY")]
    rows = [int(i) for i in np.flatnonzero(given.there[:, at].all(axis=1))]
    if len(rows) < 2 or np.ptp(moments[rows], axis=0).max() == 0.0:
        return None
    design, covariance = np.zeros((2 * len(rows), 4)), np.zeros((2 * len(rows), 2 * len(rows)))
    for n, i in enumerate(rows):
        x, y = moments[i]
        design[2 * n : 2 * n + 2] = [(1.0, 0.0, x, -y), (0.0, 1.0, y, x)]
        own = given.covariances[i][np.ix_(at, at)] - np.diag(given.systematic[i, at] ** 2)
        covariance[2 * n : 2 * n + 2, 2 * n : 2 * n + 2] = own
    return design, given.values[np.ix_(rows, at)].ravel(), covariance, rows


def _fitted(design: Floats, target: Floats, covariance: Floats) -> _Line:
    """Generalised least squares; what scatters beyond chance widens it, with Student's quantile for the few."""
    root = np.linalg.cholesky(covariance)
    matrix, values = np.linalg.solve(root, design), np.linalg.solve(root, target)
    solution, *_ = np.linalg.lstsq(matrix, values, rcond=None)
    inverse = np.linalg.pinv(matrix.T @ matrix)
    more = target.size - design.shape[1]
    factor, quantile = 1.0, NORMAL
    if more > 0:
        left = float(np.sum((values - matrix @ solution) ** 2))
        if chi2.sf(left, more) < SCATTERS:
            factor, quantile = max(1.0, left / more), float(t.ppf(0.975, more))
    return _Line(solution, factor * inverse, factor, quantile)


def _std(line: _Line) -> float:
    return math.sqrt(float(line.covariance[1, 1]))


def _size(line: _Line) -> tuple[float, float, float]:
    """Length of (u, v), its standard deviation, and its angle."""
    u, v = (float(x) for x in line.solution[2:])
    size = math.hypot(u, v)
    slope = np.array([u, v]) / max(size, 1e-300)
    return size, math.sqrt(float(slope @ line.covariance[2:, 2:] @ slope)), math.atan2(v, u)


def _scale(per_unit: float, std: float, quantile: float) -> Estimate | None:
    """The scale 1 / b with its interval; None where b is not known well enough."""
    if not per_unit > 0.0 or std * quantile / NORMAL > LARGEST_SCALE_ERROR * per_unit:
        return None
    half = quantile * std
    return Estimate(1.0 / per_unit, half / NORMAL / per_unit**2, 1.0 / (per_unit + half), 1.0 / (per_unit - half))


def _alone(
    own: Estimate, inertia: Estimate | None, gravity: Estimate | None, by_inertia: _Line | None,
    by_gravity: _Line | None, angle: float | None,
) -> TorqueScale:  # fmt: skip
    """The result where only one of inertia and gravity tells; the other's part is taken from it."""
    per_unit, covariance = np.array([1.0 / own.value, 0.0, 0.0]), np.zeros((3, 3))
    variance = (own.std / own.value**2) ** 2
    turn = 0.0 if angle is None else angle
    per_unit[1:] = per_unit[0] * np.array([math.cos(turn), math.sin(turn)])
    direction = np.array([1.0, math.cos(turn), math.sin(turn)])
    covariance = variance * np.outer(direction, direction)
    known = gravity is not None and by_gravity is not None
    return TorqueScale("found", own, inertia, gravity, None, angle if known else None, per_unit, covariance)


def _joined(
    given: MemberValues, added: Floats, moments: Floats, by_inertia: _Line, by_gravity: _Line,
    own: tuple[Estimate, Estimate], angle: float,
) -> TorqueScale:  # fmt: skip
    """Both together, with what connects their errors within a recording, and the chance of them to differ as much."""
    inertia_at = given.keys.index(next(key for key in INERTIAS if key in given.keys))
    found_rows = _gravity_rows(given, moments)
    assert found_rows is not None
    design, target, covariance, rows = found_rows
    inertial = [int(i) for i in np.flatnonzero(given.there[:, inertia_at])]
    m, n = len(inertial), target.size
    matrix = np.zeros((m + n, 6))
    matrix[:m, 0], matrix[:m, 1], matrix[m:, 2:] = 1.0, added[inertial], design
    full = np.zeros((m + n, m + n))
    full[:m, :m] = np.diag(given.covariances[inertial, inertia_at, inertia_at]) * by_inertia.factor
    full[m:, m:] = covariance * by_gravity.factor
    at = [given.keys.index("MX"), given.keys.index("MY")]
    for a, i in enumerate(inertial):
        if i in rows:
            first = m + 2 * rows.index(i)
            cross = given.covariances[i][inertia_at, at] * math.sqrt(by_inertia.factor * by_gravity.factor)
            full[a, first : first + 2] = full[first : first + 2, a] = cross
    line = _fitted(matrix, np.concatenate((given.values[inertial, inertia_at], target)), full)
    b, u, v = float(line.solution[1]), float(line.solution[4]), float(line.solution[5])
    size = math.hypot(u, v)
    pick = np.array([[1.0, 0.0, 0.0], [0.0, u / size, v / size]])
    spread = pick @ line.covariance[np.ix_([1, 4, 5], [1, 4, 5])] @ pick.T
    difference = b - size
    chance = 2.0 * float(norm.sf(abs(difference) / math.sqrt(spread[0, 0] + spread[1, 1] - 2.0 * spread[0, 1])))
    weights = np.linalg.solve(spread, np.ones(2))
    variance = 1.0 / float(weights.sum())
    both = float(weights @ np.array([b, size])) * variance
    if chance < DIFFERENT_SCALES:  # the interval reaches over both
        variance += 0.25 * difference**2
    quantile = max(line.quantile, by_inertia.quantile if variance > spread[1, 1] else NORMAL)
    found = _scale(both, math.sqrt(variance), quantile)
    turn = math.atan2(v, u)
    direction = np.array([1.0, math.cos(turn), math.sin(turn)])
    return TorqueScale(
        "found" if found is not None else "weak", found, own[0], own[1], chance, angle,
        both * direction, variance * np.outer(direction, direction),
    )  # fmt: skip
