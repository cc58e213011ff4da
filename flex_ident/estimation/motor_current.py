"""The motor's side from its current, where the effort is a torque sensor's behind the gear.

    current = (Jm qm'' + FVm qm' + FSm sign(qm') + tau + offset) / kt        (eq. 6 with tau measured)

linear in 1/kt, Jm/kt, FVm/kt, FSm/kt, offset/kt and the time by which the current is late, all filtered alike. The
sensor gives N m, and so the torque constant kt: N m on the link side per ampere, gear and efficiency included.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from flex_ident.errors import UsageError
from flex_ident.estimation.estimate import Estimate
from flex_ident.estimation.identified import modes_hz
from flex_ident.estimation.thresholds import REVERSAL_ERROR
from flex_ident.judgement.thresholds import POOR_PERCENT, RELATIVE_LIMIT
from flex_ident.likelihood.covariance import uncertainty_of
from flex_ident.likelihood.fit import Fit
from flex_ident.notices import Code, Notice
from flex_ident.parameters import UNITS, Identification, JointModel, Parameter
from flex_ident.parameters.effort_kinds import JOINT_SENSOR
from flex_ident.recording import Floats, Recording

NAMES = ("torque", "Jm", "FVm", "FSm", "offset", "late")
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
        derived={**result.derived, **modes_hz(dict(model.parameters))}, notices=(said, *notices),
    )  # fmt: skip


def _regressed(estimate: Estimate, current: Floats) -> tuple[Floats, Floats, float]:
    """Coefficients (6,) of NAMES in amperes, their covariance (6, 6), and percent of the current left unexplained."""
    problem, values = estimate.problem, estimate.fit.values
    recording, rows = problem.recording, np.flatnonzero(problem.usable)
    share, motion = problem.friction_share(problem.terms(values)), problem.motion
    sensed = problem.reduced(recording.motor_torque, delay=-values.get("torque_delay", 0.0))
    rate = np.gradient(current) * recording.sample_rate_hz
    columns = [motion.acceleration, motion.velocity, share, np.ones_like(share), -rate]
    matrix = np.column_stack([sensed, *(problem.reduced(column) for column in columns)])[rows]
    target = problem.reduced(current)[rows]
    scale = np.linalg.norm(matrix, axis=0)
    scale[scale == 0.0] = 1.0
    solution = np.linalg.lstsq(matrix / scale, target, rcond=1e-12)[0] / scale
    residual = target - matrix @ solution
    size = float(np.std(residual)) or 1.0
    whole = Fit(
        NAMES, dict(zip(NAMES, map(float, solution), strict=True)), matrix / size, residual / size, (rows,),
        np.zeros((len(NAMES), len(NAMES))), (), (), 0.5 * residual.size,
    )  # fmt: skip
    moving = float(np.std(target)) or 1.0
    covariance, dry = uncertainty_of(whole, problem.rate_hz).covariance, NAMES.index("FSm")
    covariance[dry, dry] += (REVERSAL_ERROR * solution[dry]) ** 2
    return solution, covariance, 100.0 * size / moving


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
