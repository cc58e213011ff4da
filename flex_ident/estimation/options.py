"""What a user can ask of an identification."""

from __future__ import annotations

from dataclasses import dataclass

from flex_ident.errors import UsageError
from flex_ident.parameters import JointModel
from flex_ident.parameters.effort_kinds import check_effort_kind

METHODS = ("auto", "paper", "weighted")
SENSORS = ("auto", "motor", "motor+link")


@dataclass(frozen=True)
class IdentifyOptions:
    """Options of `identify_bag`, as INTERFACE.md names them. Raises UsageError on values that are none of these.

    `sensors`: auto, motor, motor+link. `method`: auto (maximum likelihood by simulation), paper (the 2001 paper to
    the letter), weighted (its equations with clean preprocessing and weights). `first_mode_hz`: the locked-motor
    frequency, if known. `model`: where the fit starts, effects included. `cutoff_sweep`: repeat the fit at other
    cutoffs, which shows whether the estimates depend on the filter. `effort_kind`: what the effort is; `auto` finds
    out.
    """

    sensors: str = "auto"
    method: str = "auto"
    rigid: bool = False
    first_mode_hz: float | None = None
    model: JointModel | None = None
    cutoff_sweep: bool = False
    effort_kind: str = "auto"

    def __post_init__(self) -> None:
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
