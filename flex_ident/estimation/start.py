"""A start that needs no guess: the locked-motor frequency is scanned, everything else is linear.

For a link that is driven by the recorded motor position, the *shape* of its motion depends only on the locked-motor
frequency sqrt(K / JL) and the damping; the spring torque is JL times a known signal. So for each frequency of a grid
one simulation of a linear link gives columns in which motor inertia, friction, link inertia and gravity are linear.
"""

from __future__ import annotations

import math

import numpy as np

from flex_ident.errors import ExcitationError
from flex_ident.estimation.problem import Bools, FitProblem
from flex_ident.recording import Floats
from flex_ident.simulation.response import direction, link_motion
from flex_ident.simulation.terms import GRAVITY, Term, no_terms

DAMPING_RATIOS = (0.02, 0.15)
POINTS = 28
DELAYS_A_PERIOD = 16
"""Delays tried over a period of the end of the band."""


def scanned_start(problem: FitProblem, *, first_mode_hz: float | None = None) -> dict[str, float]:
    """Flat values of all base keys from which the simulation-based fit converges. Raises ExcitationError.

    The scan runs from a hundredth of the band to 1.5 times the band, or within a factor of two of `first_mode_hz`.
    """
    return _scanned(problem, first_mode_hz, problem.torque[problem.usable][:, None])[1]


def delay_scanned_start(problem: FitProblem) -> tuple[float, dict[str, float]]:
    """The same, the torque's delay scanned too: the delay, s, within half a period of the band's end, and the values.

    Raises ExcitationError.
    """
    step = 1.0 / (DELAYS_A_PERIOD * problem.band_hz)
    delays = step * np.arange(-DELAYS_A_PERIOD // 2, DELAYS_A_PERIOD // 2 + 1)
    recorded = problem.recording.motor_torque
    earlier = np.column_stack([problem.reduced(recorded, delay=-float(d))[problem.usable] for d in delays])
    which, values = _scanned(problem, None, earlier)
    return float(delays[which]), values


def _scanned(problem: FitProblem, first_mode_hz: float | None, targets: Floats) -> tuple[int, dict[str, float]]:
    """Which of the torques (m, d) fits best, and the values with it."""
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
    best: tuple[float, int, dict[str, float]] | None = None
    grid = np.geomspace(low, high, POINTS)
    for refinement in range(2):
        for frequency in grid:
            for ratio in DAMPING_RATIOS:
                candidate = _linear_fit(problem, float(frequency), ratio, reduced, targets, rows)
                if candidate is not None and (best is None or candidate[0] < best[0]):
                    best = candidate
        if best is None:
            break
        if refinement == 0:
            centre = best[2]["_frequency"]
            factor = (high / low) ** (1.0 / (POINTS - 1))
            grid = np.geomspace(centre / factor, centre * factor, 9)[1:-1]
    if best is None:
        raise ExcitationError(
            "no locked-motor frequency up to the excited band explains the torque with positive inertias: "
            "the joint may be rigid in this band (try --rigid), or torque and position may not belong together."
        )
    _, which, values = best
    values.pop("_frequency")
    return which, values


def _linear_fit(
    problem: FitProblem, frequency_hz: float, ratio: float, reduced: list[Floats], targets: Floats, rows: Bools
) -> tuple[float, int, dict[str, float]] | None:
    """Sum of squares, which torque, and values for one locked-motor frequency and damping ratio.

    None without positive inertias.
    """
    omega = 2.0 * math.pi * frequency_hz
    terms = no_terms()
    terms[Term.STIFFNESS] = omega * omega
    terms[Term.LINK_INERTIA] = 1.0
    terms[Term.LINK_VISCOUS] = 2.0 * ratio * omega
    link = link_motion(terms, problem.motion)
    if not np.isfinite(link.spring_torque).all():
        return None
    spring = problem.reduced(link.spring_torque)[rows]
    columns = np.column_stack([*reduced[:4], spring])
    gravity = np.column_stack([*reduced[:3], reduced[4], reduced[5], spring])
    found = _least_squares(gravity, targets)
    mx, my = 0.0, 0.0
    if found is not None:
        cost, which, (jm, fvm, fsm, mx, my, jl) = found
    else:
        found = _least_squares(columns, targets)
        if found is None:
            return None
        cost, which, (jm, fvm, fsm, _, jl) = found
    values = {
        "Jm": jm, "K": omega * omega * jl, "JL": jl, "FVm": max(fvm, 0.0), "FSm": max(fsm, 0.0),
        "FV": 2.0 * ratio * omega * jl, "FS": 0.0, "MX": mx / GRAVITY, "MY": my / GRAVITY, "_frequency": frequency_hz,
    }  # fmt: skip
    return cost, which, values


def _least_squares(columns: Floats, targets: Floats) -> tuple[float, int, Floats] | None:
    """Sum of squares, which target, and solution, of the best in which first and last, the inertias, are positive."""
    scale = np.linalg.norm(columns, axis=0)
    scale[scale == 0.0] = 1.0
    solutions = np.linalg.lstsq(columns / scale, targets, rcond=1e-8)[0] / scale[:, None]
    costs = np.sum((targets - columns @ solutions) ** 2, axis=0)
    costs[(solutions[0] <= 0.0) | (solutions[-1] <= 0.0)] = np.inf
    which = int(np.argmin(costs))
    if not np.isfinite(costs[which]):
        return None
    return float(costs[which]), which, solutions[:, which]
