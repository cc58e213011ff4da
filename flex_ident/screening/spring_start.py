"""A start for a spring whose law has a size, such as a dead band, where both positions were measured.

Simulations with a dead band have many minima: which flank the link hits, and when, depends on every parameter. With
both positions measured the deflection is known, and for a given size eqs. 5 and 6 are linear; no simulation is needed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.optimize import minimize

from flex_ident.likelihood.problem import FitProblem
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.simulation.motion import motor_motion
from flex_ident.simulation.response import direction
from flex_ident.simulation.terms import GRAVITY

MOTOR_KEYS = ("Jm", "FVm", "FSm", "offset", "K")
LINK_KEYS = ("JL", "FV", "FS", "MX", "MY")


def measured_spring_start(
    problem: FitProblem, law: Callable[[Floats, float], Floats], shares: Floats
) -> tuple[float, Values] | None:
    """Size of the spring's law, rad, and values of the base keys and `link_zero`, by least squares of eqs. 5 and 6.

    `law(deflection, size)` (n,) is torque over stiffness; `shares` are sizes over the range of deflection, tried first.
    None without a link encoder, or where no size gives positive inertias and a positive stiffness.
    """
    recording, rows = problem.recording, problem.usable
    if problem.link is None or recording.link_position is None:
        return None
    rate = recording.sample_rate_hz
    motor = motor_motion(recording.motor_position, rate, cutoff_hz=problem.cutoff_hz)
    link = motor_motion(recording.link_position, rate, cutoff_hz=problem.cutoff_hz)
    deflection = motor.position - link.position
    own = [motor.acceleration, motor.velocity, direction(motor, problem.resolution), np.ones_like(deflection)]
    motor_columns = [problem.reduced(c)[rows] for c in own]
    target = problem.torque[rows]

    def solved(size: float, zero: float) -> tuple[float, Floats]:
        beyond = problem.reduced(law(deflection + zero, size))[rows]
        return _least_squares([*motor_columns, beyond], target)

    reach = float(np.ptp(deflection))
    first = min(shares * reach, key=lambda size: solved(float(size), 0.0)[0])
    best = minimize(
        lambda x: solved(abs(x[0]), x[1])[0], (first, 0.0), method="Nelder-Mead",
        options={"initial_simplex": [(first, 0.0), (1.2 * first, 0.0), (first, 0.2 * first)], "maxiter": 60},
    )  # fmt: skip
    size, zero = abs(float(best.x[0])), float(best.x[1])
    values = Values().with_vector(MOTOR_KEYS, solved(size, zero)[1])
    spring = values["K"] * law(deflection + zero, size)
    moved = [link.acceleration, link.velocity, direction(link, problem.resolution)]
    pulled = [GRAVITY * np.cos(link.position), GRAVITY * np.sin(link.position)]
    link_columns = [problem.reduced(c)[rows] for c in (*moved, *pulled)]
    values = values.with_vector(LINK_KEYS, _least_squares(link_columns, problem.reduced(spring)[rows])[1])
    if min(values["Jm"], values["K"], values["JL"]) <= 0.0:
        return None
    friction = {key: max(values[key], 0.0) for key in ("FVm", "FSm", "FV", "FS")}
    return size, values | friction | {"link_zero": zero}


def _least_squares(columns: Sequence[Floats], target: Floats) -> tuple[float, Floats]:
    matrix = np.column_stack(columns)
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    solution = np.linalg.lstsq(matrix / scale, target, rcond=1e-9)[0] / scale
    return float(np.sum((target - matrix @ solution) ** 2)), solution
