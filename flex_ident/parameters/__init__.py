"""Stage 4: identified numbers, each with its uncertainty and its verdict."""

from flex_ident.parameters.covariance import Covariance, joined_covariance
from flex_ident.parameters.identification import (
    CutoffSweep,
    FilterSettings,
    FitQuality,
    FrequencyResponse,
    Identification,
    Sensors,
    TorqueCurves,
    Verdict,
)
from flex_ident.parameters.joint_model import JointModel, read_joint_model
from flex_ident.parameters.parameter import (
    FLEXIBLE_KEYS,
    GRAVITY_KEYS,
    LOGARITHMIC,
    MEASUREMENT_UNITS,
    NON_NEGATIVE,
    PRISMATIC_UNITS,
    RIGID_KEYS,
    UNITS,
    Parameter,
    with_systematic,
)

__all__ = [
    "FLEXIBLE_KEYS", "GRAVITY_KEYS", "LOGARITHMIC", "MEASUREMENT_UNITS", "NON_NEGATIVE", "PRISMATIC_UNITS",
    "RIGID_KEYS", "UNITS", "Covariance", "CutoffSweep", "FilterSettings", "FitQuality", "FrequencyResponse",
    "Identification", "JointModel", "Parameter", "Sensors", "TorqueCurves", "Verdict", "joined_covariance",
    "read_joint_model", "with_systematic",
]  # fmt: skip
