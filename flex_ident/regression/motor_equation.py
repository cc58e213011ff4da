"""K from the motor's equation alone: it holds whatever moves the link, coupled axes and counterweights included."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flex_ident.errors import DataError
from flex_ident.filtering.band import excited_band_hz
from flex_ident.notices import Code, Notice
from flex_ident.parameters import UNITS, Parameter
from flex_ident.recording import Recording
from flex_ident.regression.least_squares import least_squares
from flex_ident.regression.observation import clean_observation
from flex_ident.regression.thresholds import CORRELATION_S, DETERMINED, HIGHEST_BAND_HZ, OWN_ERROR

NAMES = ("Jm", "FVm", "FSm", "offset", "K", "jerk", "deflection_rate")


@dataclass(frozen=True)
class MotorEquation:
    """K of eq. 6 alone, and the coefficient of velocity, which is FVm less K times the link encoder's skew."""

    stiffness: Parameter
    velocity_coefficient: float
    error_percent: float

    @property
    def least_skew_s(self) -> float:
        """The smallest delay of the link encoder, s, that leaves FVm positive; 0 when none is needed."""
        return max(0.0, -self.velocity_coefficient / self.stiffness.value) if self.stiffness.value > 0 else 0.0


def motor_equation(recording: Recording) -> MotorEquation:
    """Least squares of eq. 6: Gamma_m = Jm qm'' + c qm' + FSm sign(qm') + offset + K (qm - q), and the rates of inertia
    and spring.

    Torque that is recorded a little late changes by the rate of both, a link that is by that of the spring. Without
    those K of arms whose other joints yield was 1 to 6 % low, up to 20 standard deviations, with half a period of the
    drive at 2 kHz for all lateness.

    Raises SignalError and ExcitationError. The recording must have a link position.
    """
    assert recording.link_position is not None
    at = clean_observation(recording, band_hz=min(HIGHEST_BAND_HZ, excited_band_hz(recording)))
    qm, vm, am, jerk = (at.derivative(recording.motor_position, k) for k in (0, 1, 2, 3))
    deflection, rate = (m - at.derivative(recording.link_position, k) for k, m in enumerate((qm, vm)))
    columns = np.column_stack([am, vm, at.sign(vm, am), np.ones_like(qm), deflection - deflection.mean(), jerk, rate])
    matrix, target = at.reduced(columns), at.reduced(recording.motor_torque[:, None])[:, 0]
    lag = max(1, round(CORRELATION_S / float(np.median(np.diff(at.time)))))
    fit = least_squares(matrix, target, NAMES, lag=min(lag, target.size // 20))
    value = fit.value("K")
    std = math.hypot(fit.std("K"), OWN_ERROR * value)
    error = 100.0 * float(np.linalg.norm(target - matrix @ fit.values) / np.linalg.norm(target))
    determined = math.isfinite(std) and 0.0 < std <= DETERMINED * value
    return MotorEquation(Parameter("K", value, std, UNITS["K"], determined), fit.value("FVm"), error)


def motor_equation_notice(recording: Recording) -> Notice | None:
    """What eq. 6 alone says of K; None without a link position or when it cannot be solved."""
    if recording.link_position is None:
        return None
    try:
        found = motor_equation(recording)
    except DataError:
        return None
    k = found.stiffness
    numbers = {
        "K": k.value, "std": k.std, "left_percent": found.error_percent, "least_skew_s": found.least_skew_s,
    }  # fmt: skip
    case = "determined" if k.identifiable else "undetermined"
    return Notice(Code.MOTOR_EQUATION, "K", numbers, {"case": case, "unit": k.unit})
