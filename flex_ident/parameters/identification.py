"""What an identification hands to the report: parameters, how they were found, and how far to trust them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flex_ident.errors import DataError
from flex_ident.notices import Notice
from flex_ident.parameters.covariance import Covariance
from flex_ident.parameters.friction_curve import FrictionCurve
from flex_ident.parameters.joint_model import JointModel
from flex_ident.parameters.parameter import Parameter
from flex_ident.recording.recording import Floats

Sensors = Literal["motor", "motor+link"]
Verdict = Literal["trusted", "doubtful", "rejected"]


@dataclass(frozen=True)
class FilterSettings:
    """The filter that was used (eqs. 22 to 29 of the paper)."""

    bandwidth_rad_s: float
    cutoff_rad_s: float
    order: int
    sample_rate_hz: float
    decimation: int


@dataclass(frozen=True)
class FitQuality:
    """How well the model reproduces the torque. Errors are norms relative to the measured torque's, in percent."""

    samples: int
    condition_number: float
    rank: int
    relative_error_percent: float
    validation_relative_error_percent: float


@dataclass(frozen=True)
class TorqueCurves:
    """Measured and predicted motor torque (Figure 2 of the paper), N m, (n,), filtered alike; `time`, s.

    `validation` (n,) is True where the fit did not see the sample.
    """

    time: Floats
    measured: Floats
    predicted: Floats
    validation: NDArray[np.bool_]


@dataclass(frozen=True)
class FrequencyResponse:
    """Frequency response (m,) and coherence (m,) of motor torque to motor acceleration or position; see `title`."""

    title: str
    frequency_hz: Floats
    magnitude: Floats
    coherence: Floats
    modes_hz: tuple[float, ...] = ()


@dataclass(frozen=True)
class CutoffSweep:
    """Each estimate against the filter's cutoff: `values[key]` (m,) and one standard deviation `stds[key]` (m,)."""

    cutoff_rad_s: Floats
    values: Mapping[str, Floats]
    stds: Mapping[str, Floats]


@dataclass(frozen=True)
class Identification:
    """The result of identifying one joint; `result.json` is its public form."""

    joint: str
    sensors: Sensors
    method: str
    verdict: Verdict
    parameters: tuple[Parameter, ...]
    fit: FitQuality
    model: JointModel
    combined: tuple[Parameter, ...] = ()
    derived: Mapping[str, float] = field(default_factory=dict)
    measurement: tuple[Parameter, ...] = ()
    """Parameters of the measurement chain, corrected for: torque delay, encoder skew (s)."""
    filter: FilterSettings | None = None
    notices: tuple[Notice, ...] = ()
    curves: TorqueCurves | None = None
    frequency_response: FrequencyResponse | None = None
    cutoff_sweep: CutoffSweep | None = None
    covariance: Covariance | None = None
    """How the parameters that the data determine are uncertain together; None where the method does not say."""
    friction_curve: FrictionCurve | None = None
    """Friction over speed, of a rigid joint."""

    def parameter(self, key: str) -> Parameter:
        """The parameter of that key. Raises DataError when the result has none."""
        for parameter in (*self.parameters, *self.combined):
            if parameter.key == key:
                return parameter
        raise DataError(f"the result has no parameter {key}.")
