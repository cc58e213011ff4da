"""A start that needs no guess: the locked-motor frequency is scanned, everything else is linear.

For a link that is driven by the recorded motor position, the *shape* of its motion depends only on the locked-motor
frequency sqrt(K / JL) and the damping; the spring torque is JL times a known signal. So for each frequency of a grid
one simulation of a linear link gives columns in which motor inertia, friction, link inertia and gravity are linear.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flex_ident.errors import ExcitationError
from flex_ident.judgement.priorities import REVERSED
from flex_ident.likelihood.problem import Bools, FitProblem
from flex_ident.likelihood.thresholds import POOR
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.recording.signs import DRIVES, work_share
from flex_ident.simulation.batch import LANES
from flex_ident.simulation.response import LinkMotion, direction, link_motions
from flex_ident.simulation.terms import GRAVITY, Term, no_terms

Shape = Mapping[Term, float]
DAMPING_RATIOS = (0.02, 0.15)
POINTS = 28


@dataclass(frozen=True)
class _Scanned:
    """A point of the scan: sum of squares left, which of the torques fits best, and the base keys' values."""

    cost: float
    which: int
    frequency_hz: float
    values: Values


def scanned_start(problem: FitProblem, *, first_mode_hz: float | None = None, motor: bool = True) -> Values:
    """Values of all base keys from which the simulation-based fit converges. Raises ExcitationError.

    The scan runs from a hundredth of the band to 1.5 times the band, or within a factor of two of `first_mode_hz`.
    Without `motor`, the torque is that through the spring alone.
    """
    target = problem.torque[problem.usable][:, None]
    poor = POOR * float(np.sum(target**2))
    try:
        found = _best_scanned(problem, first_mode_hz, target, _linear_spring, motor=motor)
    except ExcitationError:
        _check_sign(problem, first_mode_hz, target, poor)
        raise
    if found.cost > poor:
        _check_sign(problem, first_mode_hz, target, 0.5 * poor)
    return found.values


def _check_sign(problem: FitProblem, first_mode_hz: float | None, target: Floats, limit: float) -> None:
    """Raises ExcitationError when the torque (m, 1) of opposite sign leaves a sum of squares below `limit`.

    Not where the torque drives the motion: what has lost its sign brakes it.
    """
    if drives(problem):
        return
    try:
        found = _best_scanned(problem, first_mode_hz, -target, _linear_spring)
    except ExcitationError:
        return
    if found.cost < limit:
        raise ExcitationError(REVERSED)


def drives(problem: FitProblem) -> bool:
    """Whether the torque drives the joint, and so has its sign."""
    rows = problem.usable
    return work_share(problem.reduced(problem.motion.velocity)[rows], problem.torque[rows]) > DRIVES


def torque_scanned_start(problem: FitProblem, torques: Floats) -> tuple[int, Values]:
    """The same, the torque's record scanned too: which of `torques` (r, d), N m, at the usable samples, fits best.

    Raises ExcitationError.
    """
    found = _best_scanned(problem, None, torques, _linear_spring)
    return found.which, found.values


def spring_scanned_start(problem: FitProblem, shapes: Sequence[Callable[[float], Shape]]) -> tuple[int, Values]:
    """The same, the spring's law scanned too: which of `shapes` fits best, and the values.

    A shape gives, for the square of the locked-motor frequency, (rad/s)^2, terms of a spring on a link of unit inertia.
    Raises ExcitationError.
    """
    best: tuple[int, _Scanned] | None = None
    target = problem.torque[problem.usable][:, None]
    for which, shape in enumerate(shapes):
        try:
            found = _best_scanned(problem, None, target, shape)
        except ExcitationError:
            continue
        if best is None or found.cost < best[1].cost:
            best = which, found
    if best is None:
        raise ExcitationError("no such spring explains the torque with positive inertias.")
    return best[0], best[1].values


def _linear_spring(_square: float) -> Shape:
    """The shape that adds nothing to a spring."""
    return {}


def _best_scanned(
    problem: FitProblem,
    first_mode_hz: float | None,
    targets: Floats,
    shape: Callable[[float], Shape],
    *,
    motor: bool = True,
) -> _Scanned:
    """The point that leaves least of one of the torques (m, d). Raises ExcitationError."""
    motion = problem.motion
    sign = direction(motion, problem.resolution)
    rows = problem.usable
    position = motion.position
    common = [motion.acceleration, motion.velocity, sign, np.ones_like(position), np.cos(position), np.sin(position)]
    reduced = [problem.reduced(c)[rows] for c in common]
    if first_mode_hz is None:
        low, high = max(0.15, 0.01 * problem.band_hz), 1.5 * problem.band_hz
    else:
        low, high = 0.5 * first_mode_hz, 2.0 * first_mode_hz
    best: _Scanned | None = None
    grid = np.geomspace(low, high, POINTS)
    for refinement in range(2):
        ways = [(float(frequency), ratio) for frequency in grid for ratio in DAMPING_RATIOS]
        for (frequency, ratio), link in zip(ways, _unit_links(problem, ways, shape), strict=True):
            candidate = _linear_fit(problem, frequency, ratio, link, reduced, targets, rows, motor=motor)
            if candidate is not None and (best is None or candidate.cost < best.cost):
                best = candidate
        if best is None:
            break
        if refinement == 0:
            centre, factor = best.frequency_hz, (high / low) ** (1.0 / (POINTS - 1))
            grid = np.geomspace(centre / factor, centre * factor, 9)[1:-1]
    if best is None:
        raise ExcitationError(
            "no locked-motor frequency up to the excited band explains the torque with positive inertias: "
            "the joint may be rigid in this band (try --rigid), the link may stick for most of the motion (move with a "
            "larger amplitude), or torque and position may not belong together."
        )
    return best


def _unit_links(
    problem: FitProblem, ways: Sequence[tuple[float, float]], shape: Callable[[float], Shape]
) -> Iterator[LinkMotion]:
    """The motion of a link of unit inertia for each locked-motor frequency, Hz, and damping ratio."""
    for first in range(0, len(ways), LANES):
        many = []
        for frequency_hz, ratio in ways[first : first + LANES]:
            omega = 2.0 * math.pi * frequency_hz
            terms = no_terms()
            terms[Term.STIFFNESS], terms[Term.LINK_INERTIA] = omega * omega, 1.0
            terms[Term.LINK_VISCOUS] = 2.0 * ratio * omega
            for term, value in shape(omega * omega).items():
                terms[term] = value
            many.append(terms)
        yield from link_motions(many, problem.motion)


def _linear_fit(
    problem: FitProblem,
    frequency_hz: float,
    ratio: float,
    link: LinkMotion,
    reduced: list[Floats],
    targets: Floats,
    rows: Bools,
    *,
    motor: bool = True,
) -> _Scanned | None:
    """The point of one locked-motor frequency and damping ratio; None without positive inertias."""
    omega = 2.0 * math.pi * frequency_hz
    if not np.isfinite(link.spring_torque).all():
        return None
    spring = problem.reduced(link.spring_torque)[rows]
    if not motor:
        reduced = [np.zeros_like(spring)] * 3 + reduced[3:]
    columns = np.column_stack([*reduced[:4], spring])
    gravity = np.column_stack([*reduced[:3], reduced[4], reduced[5], spring])
    found = _least_squares(gravity, targets, motor=motor)
    mx, my = 0.0, 0.0
    if found is not None:
        cost, which, (jm, fvm, fsm, mx, my, jl) = found
    else:
        found = _least_squares(columns, targets, motor=motor)
        if found is None:
            return None
        cost, which, (jm, fvm, fsm, _, jl) = found
    values = {
        "Jm": jm, "K": omega * omega * jl, "JL": jl, "FVm": max(fvm, 0.0), "FSm": max(fsm, 0.0),
        "FV": 2.0 * ratio * omega * jl, "FS": 0.0, "MX": mx / GRAVITY, "MY": my / GRAVITY,
    }  # fmt: skip
    return _Scanned(cost, which, frequency_hz, Values(values))


def _least_squares(columns: Floats, targets: Floats, *, motor: bool = True) -> tuple[float, int, Floats] | None:
    """Sum of squares, which target, and solution, of the best in which first and last, the inertias, are positive.

    Without `motor`, the last only.
    """
    scale = np.linalg.norm(columns, axis=0)
    scale[scale == 0.0] = 1.0
    solutions = np.linalg.lstsq(columns / scale, targets, rcond=1e-8)[0] / scale[:, None]
    costs = np.sum((targets - columns @ solutions) ** 2, axis=0)
    costs[(motor & (solutions[0] <= 0.0)) | (solutions[-1] <= 0.0)] = np.inf
    which = int(np.argmin(costs))
    if not np.isfinite(costs[which]):
        return None
    return float(costs[which]), which, solutions[:, which]
