"""A start for a dead band in the spring, where both positions were measured.

Simulations with backlash have many minima: which flank the link hits, and when, depends on every parameter. With both
positions measured the deflection is known, and for a given dead band eqs. 5 and 6 are linear; no simulation is needed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize

from flex_ident.likelihood.problem import FitProblem
from flex_ident.recording import Floats
from flex_ident.simulation.motion import motor_motion
from flex_ident.simulation.response import direction
from flex_ident.simulation.terms import GRAVITY

WIDTHS = np.geomspace(0.005, 0.7, 24)
"""Dead bands tried, relative to the whole range of deflection."""
MOTOR_KEYS = ("Jm", "FVm", "FSm", "offset", "K")
LINK_KEYS = ("JL", "FV", "FS", "MX", "MY")


def dead_band_start(problem: FitProblem) -> dict[str, float]:
    """Flat values of the base keys, `backlash.gap` and `link_zero` by least squares of eqs. 5 and 6.

    Empty without a link encoder, or where no dead band gives positive inertias and a positive stiffness.
    """
    recording, rows = problem.recording, problem.usable
    if problem.link is None or recording.link_position is None:
        return {}
    rate = recording.sample_rate_hz
    motor = motor_motion(recording.motor_position, rate, cutoff_hz=problem.cutoff_hz)
    link = motor_motion(recording.link_position, rate, cutoff_hz=problem.cutoff_hz)
    deflection = motor.position - link.position
    own = [motor.acceleration, motor.velocity, direction(motor, problem.resolution), np.ones_like(deflection)]
    motor_columns = [problem.reduced(c)[rows] for c in own]
    target = problem.torque[rows]

    def solved(gap: float, zero: float) -> tuple[float, Floats]:
        bent = deflection + zero
        beyond = problem.reduced(bent - np.clip(bent, -0.5 * gap, 0.5 * gap))[rows]
        return _least_squares([*motor_columns, beyond], target)

    reach = float(np.ptp(deflection))
    widest = min(WIDTHS * reach, key=lambda gap: solved(float(gap), 0.0)[0])
    best = minimize(
        lambda x: solved(abs(x[0]), x[1])[0], (widest, 0.0), method="Nelder-Mead",
        options={"initial_simplex": [(widest, 0.0), (1.2 * widest, 0.0), (widest, 0.2 * widest)], "maxiter": 60},
    )  # fmt: skip
    gap, zero = abs(float(best.x[0])), float(best.x[1])
    values = dict(zip(MOTOR_KEYS, map(float, solved(gap, zero)[1]), strict=True))
    bent = deflection + zero
    spring = values["K"] * (bent - np.clip(bent, -0.5 * gap, 0.5 * gap))
    moved = [link.acceleration, link.velocity, direction(link, problem.resolution)]
    pulled = [GRAVITY * np.cos(link.position), GRAVITY * np.sin(link.position)]
    link_columns = [problem.reduced(c)[rows] for c in (*moved, *pulled)]
    values.update(
        zip(LINK_KEYS, map(float, _least_squares(link_columns, problem.reduced(spring)[rows])[1]), strict=True)
    )
    if min(values["Jm"], values["K"], values["JL"]) <= 0.0:
        return {}
    for key in ("FVm", "FSm", "FV", "FS"):
        values[key] = max(values[key], 0.0)
    return {**values, "backlash.gap": gap, "link_zero": zero}


def _least_squares(columns: Sequence[Floats], target: Floats) -> tuple[float, Floats]:
    matrix = np.column_stack(columns)
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    solution = np.linalg.lstsq(matrix / scale, target, rcond=1e-9)[0] / scale
    return float(np.sum((target - matrix @ solution) ** 2)), solution
