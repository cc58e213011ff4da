"""What a user can ask of an identification."""

from __future__ import annotations

from dataclasses import dataclass

from flex_ident.errors import UsageError
from flex_ident.parameters import JointModel
from flex_ident.parameters.effort_kinds import check_effort_kind

METHODS = ("auto", "paper", "weighted")
SENSORS = ("auto", "motor", "motor+link")


def check_band(band_hz: float | None, *, method: str = "auto") -> None:
    """Raises UsageError on a band that is no frequency, or of a method that has its own."""
    if band_hz is not None and not 0.0 < band_hz < 1e4:
        raise UsageError(f"--band is {band_hz} Hz: expected a positive frequency below 10 kHz.")
    if band_hz is not None and method != "auto":
        raise UsageError(f"--band goes with --method auto: {method} has a filter of its own.")


@dataclass(frozen=True)
class IdentifyOptions:
    """Options of `identify_bag`, as INTERFACE.md names them. Raises UsageError on values that are none of these.

    `sensors`: auto, motor, motor+link. `method`: auto (maximum likelihood by simulation), paper (the 2001 paper to
    the letter), weighted (its equations with clean preprocessing and weights). `first_mode_hz`: the locked-motor
    frequency, if known. `model`: where the fit starts, effects included. `cutoff_sweep`: repeat the fit at other
    cutoffs, which shows whether the estimates depend on the filter. `effort_kind`: what the effort is; `auto` finds
    out. `band_hz`: the frequency up to which model and recording are compared; None: as far as both are coherent.
    """

    sensors: str = "auto"
    method: str = "auto"
    rigid: bool = False
    first_mode_hz: float | None = None
    model: JointModel | None = None
    cutoff_sweep: bool = False
    effort_kind: str = "auto"
    band_hz: float | None = None

    def __post_init__(self) -> None:
        check_band(self.band_hz, method=self.method)
        if self.sensors not in SENSORS:
            raise UsageError(f"sensors is '{self.sensors}': expected one of {', '.join(SENSORS)}.")
        if self.method not in METHODS:
            raise UsageError(f"method is '{self.method}': expected one of {', '.join(METHODS)}.")
        check_effort_kind(self.effort_kind, method=self.method)
        if self.first_mode_hz is not None and not 0.0 < self.first_mode_hz < 1e4:
            raise UsageError(f"first mode is {self.first_mode_hz} Hz: expected a positive frequency below 10 kHz.")
        if self.model is not None and self.model.rigid and not self.rigid:
            raise UsageError("the model is of a rigid joint: add --rigid.")
        if self.rigid and self.model is not None and not self.model.rigid:
            raise UsageError("the model has a spring: leave --rigid out.")
