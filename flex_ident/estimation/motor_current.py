"""The motor's side from its current, where the effort is a torque sensor's behind the gear.

    current = (Jm qm'' + FVm qm' + FSm sign(qm') + tau + offset) / kt        (eq. 6 with tau measured)

linear in 1/kt, Jm/kt, FVm/kt, FSm/kt, offset/kt; the current may be late, which is found by steps. All is filtered
alike. What the sensor measured is replaced by what the fitted joint explains of it (two-stage least squares): its noise
would make the torque constant too large. The sensor gives N m, and so the torque constant kt: N m on the link side per
ampere, gear and efficiency included.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from flex_ident.errors import UsageError
from flex_ident.estimation.estimate import Estimate
from flex_ident.estimation.identified import modes_hz
from flex_ident.estimation.thresholds import CURRENT_ERROR, REVERSAL_ERROR
from flex_ident.judgement.thresholds import POOR_PERCENT, RELATIVE_LIMIT
from flex_ident.likelihood.covariance import uncertainty_of
from flex_ident.likelihood.fit import Fit
from flex_ident.notices import Code, Notice
from flex_ident.parameters import UNITS, Identification, JointModel, Parameter
from flex_ident.parameters.effort_kinds import JOINT_SENSOR
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats, Recording

NAMES = ("torque", "Jm", "FVm", "FSm", "offset", "late")
LATE = NAMES.index("late")
LATE_STEPS, LATE_ENOUGH = 8, 1e-3
"""Steps by which the current's lateness is found, and samples from which a step is small."""
BLOCKS = 10
MOTOR_SIDE = ("Jm", "FVm", "FSm")


def kind_beside_current(recording: Recording, kind: str) -> str:
    """The kind of effort that a motor current beside it makes it. Raises UsageError where it was said to be another."""
    if recording.motor_current is None:
        return kind
    if kind not in ("auto", JOINT_SENSOR):
        raise UsageError(f"--motor-current goes with --effort-kind {JOINT_SENSOR}, not {kind}.")
    return JOINT_SENSOR


def with_motor_side(result: Identification, estimate: Estimate) -> Identification:
    """The result of a joint sensor's torque, with the motor's parameters and its torque constant from the current."""
    current = estimate.problem.recording.motor_current
    if current is None or estimate.problem.rigid:
        return result
    values, covariance, left = _regressed(estimate, current)
    constant = 1.0 / values[0]
    known = {"torque_constant": _ratio(values, covariance, 0, "N m/A")}
    known |= {k: _ratio(values, covariance, NAMES.index(k), UNITS[k]) for k in MOTOR_SIDE}
    found = {k: replace(p, key=k) for k, p in known.items()}
    parameters = tuple(found.get(p.key, p) for p in result.parameters)
    model = JointModel(
        {**{k: found[k].value for k in MOTOR_SIDE}, **result.model.parameters}, result.model.effects, result.joint
    )
    sizes = {"torque_constant": constant, "std": found["torque_constant"].std, "left_percent": left}
    said = Notice(Code.MOTOR_CURRENT, "motor_current", sizes, {"case": "poor" if left > POOR_PERCENT else "well"})
    notices = tuple(n for n in result.notices if n.code is not Code.EFFORT_JOINT_SENSOR)
    return replace(
        result, parameters=parameters, measurement=(*result.measurement, found["torque_constant"]), model=model,
        derived={**result.derived, **modes_hz(Values(model.parameters))}, notices=(said, *notices),
    )  # fmt: skip


def _regressed(estimate: Estimate, current: Floats) -> tuple[Floats, Floats, float]:
    """Coefficients (6,) of NAMES in amperes, their covariance (6, 6), and percent of the current left unexplained.

    The covariance is the larger one of what the residual's correlation and of what blocks of the recording say, as
    those differ by more where the model is wrong.
    """
    problem, values = estimate.problem, estimate.fit.values
    recording, rows = problem.recording, np.flatnonzero(problem.usable)
    share, motion = problem.friction_share(problem.terms(values)), problem.motion
    sensed = problem.reduced(recording.motor_torque, delay=-values.get("torque_delay", 0.0))[rows]
    plain = (motion.acceleration, motion.velocity, share, np.ones_like(share))
    moved = np.column_stack([problem.reduced(column) for column in plain])[rows]
    explained = problem.prediction(values | {"torque_delay": 0.0}).torque[rows]
    rate = np.gradient(current) * recording.sample_rate_hz
    late = 0.0
    for _ in range(LATE_STEPS):
        target, shape = (problem.reduced(column, delay=-late)[rows] for column in (current, -rate))
        known = np.column_stack([moved, shape])
        instruments = np.column_stack([explained, known])
        cleaned = instruments @ _least_squares(instruments, sensed)
        matrix = np.column_stack([cleaned, known])
        solution = _least_squares(matrix, target)
        late += float(solution[LATE])
        if abs(solution[LATE]) < LATE_ENOUGH * recording.sample_time:
            break
    residual = target - np.column_stack([sensed, known]) @ solution
    size, moving = float(np.std(residual)) or 1.0, float(np.std(target)) or 1.0
    whole = Fit(
        NAMES, Values().with_vector(NAMES, solution), matrix / size, residual / size, (rows,),
        np.zeros((len(NAMES), len(NAMES))), (), (), 0.5 * residual.size,
    )  # fmt: skip
    covariance, dry = uncertainty_of(whole, problem.rate_hz).covariance, NAMES.index("FSm")
    spread = _jackknife(matrix, target)
    larger = np.sqrt(np.maximum(np.diag(spread) / np.maximum(np.diag(covariance), 1e-300), 1.0))
    covariance = covariance * np.outer(larger, larger)
    covariance[dry, dry] += (REVERSAL_ERROR * solution[dry]) ** 2
    covariance += np.diag((CURRENT_ERROR * solution) ** 2)
    return solution, covariance, 100.0 * size / moving


def _least_squares(matrix: Floats, target: Floats) -> Floats:
    """The solution (p,) of a least squares problem whose columns differ in size."""
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    solution: Floats = np.linalg.lstsq(matrix / scale, target, rcond=1e-12)[0] / scale
    return solution


def _jackknife(matrix: Floats, target: Floats) -> Floats:
    """Covariance (p, p) of the solution from leaving out each of `BLOCKS` blocks of the recording in turn."""
    edges = np.linspace(0, target.size, BLOCKS + 1).astype(int)
    kept = [np.r_[0:a, b : target.size] for a, b in pairwise(edges)]
    without = np.array([_least_squares(matrix[k], target[k]) for k in kept])
    apart = without - without.mean(axis=0)
    covariance: Floats = (BLOCKS - 1.0) / BLOCKS * apart.T @ apart
    return covariance


def _ratio(values: Floats, covariance: Floats, index: int, unit: str) -> Parameter:
    """A coefficient over that of the torque, or 1 over that one alone, with its standard deviation, to first order."""
    slope = np.zeros(values.size)
    lower = float(values[0])
    value = 1.0 / lower if index == 0 else float(values[index]) / lower
    slope[0] = -value / lower
    if index:
        slope[index] = 1.0 / lower
    std = float(np.sqrt(slope @ covariance @ slope))
    return Parameter(NAMES[index], value, std, unit, identifiable=std <= RELATIVE_LIMIT * abs(value))
