"""A parameter never travels without its uncertainty, its unit and whether the data determine it."""

from __future__ import annotations

import math
from dataclasses import dataclass

UNITS: dict[str, str] = {
    "Jm": "kg m^2", "K": "N m/rad", "JL": "kg m^2", "FVm": "N m s/rad", "FSm": "N m",
    "FV": "N m s/rad", "FS": "N m", "MX": "kg m", "MY": "kg m", "offset": "N m", "J": "kg m^2",
}  # fmt: skip
"""Units of the base parameters (eq. 11 of the paper, and `offset`) of a revolute joint."""

PRISMATIC_UNITS: dict[str, str] = {
    "Jm": "kg", "K": "N/m", "JL": "kg", "FVm": "N s/m", "FSm": "N",
    "FV": "N s/m", "FS": "N", "MX": "kg", "MY": "kg", "offset": "N", "J": "kg",
}  # fmt: skip

FLEXIBLE_KEYS = ("Jm", "K", "JL", "FVm", "FSm", "FV", "FS", "MX", "MY", "offset")
RIGID_KEYS = ("J", "FV", "FS", "offset", "MX", "MY")
GRAVITY_KEYS = ("MX", "MY")
"""First moments; a joint that slides has none."""
NON_NEGATIVE = ("Jm", "K", "JL", "FVm", "FSm", "FV", "FS", "J")
LOGARITHMIC = ("Jm", "K", "JL", "J")
"""Keys fitted by their logarithm: positive by construction, and a factor is a factor."""
FAR_MODE = "far_mode"
"""Measurement key that is no term of the simulation: the share of the link's inertia behind a mode above the band, of
which `FitProblem.terms` makes a second mass."""
MEASUREMENT_UNITS = {
    "torque_delay": "s", "link_skew": "s", "link_zero": "rad", "link_scale": "", "link_drift": "", "far_mode": "",
    "torque_averaging": "sample^2",
    "initial_deflection": "rad", "initial_velocity": "rad/s", "effort_lag": "s", "reversal_speed": "rad/s",
    "presliding": "rad", "reversal_lead": "s", "link_turnover": "rad/s", "gravity_removed": "",
    "friction_removed": "N m", "friction_removed_speed": "rad/s",
}  # fmt: skip
"""Units of what is estimated beside the joint: the measurement chain and the state at the start."""
SYSTEMATIC = {"Jm": 2e-3, "K": 1e-3, "JL": 1e-3, "J": 1e-3}
SYSTEMATIC_FRICTION = 5e-3
"""Relative standard deviation of what the methods get wrong themselves (reversals rounded by the filter, the drive's
torque within a sample), found on plants that are not their model (docs/benchmarks.md)."""


def with_systematic(key: str, value: float, std: float) -> float:
    """The statistical standard deviation of a parameter joined with what the method itself gets wrong."""
    return math.hypot(std, SYSTEMATIC.get(key, SYSTEMATIC_FRICTION) * value)


@dataclass(frozen=True)
class Parameter:
    """One identified number. `std` is one standard deviation; `ci95` the 95 % interval, symmetric unless given.

    With `identifiable` False the value is what the fit happened to return and means nothing by itself.
    """

    key: str
    value: float
    std: float
    unit: str = ""
    identifiable: bool = True
    ci95: tuple[float, float] | None = None
    at_bound: bool = False

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval, in the unit of the value."""
        if self.ci95 is not None:
            return self.ci95
        return (self.value - 1.96 * self.std, self.value + 1.96 * self.std)

    @property
    def relative_std_percent(self) -> float:
        """Standard deviation in percent of the value (%σ of the paper's tables); infinite for a value of zero."""
        return 100.0 * self.std / abs(self.value) if self.value else math.inf
