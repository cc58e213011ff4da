"""What a user can ask of a search for the gap."""

from __future__ import annotations

from dataclasses import dataclass

from flex_ident.effects import effect_named
from flex_ident.errors import UsageError
from flex_ident.estimation.options import SENSORS, check_band
from flex_ident.parameters import FLEXIBLE_KEYS, GRAVITY_KEYS, RIGID_KEYS, JointModel
from flex_ident.parameters.effort_kinds import check_effort_kind


@dataclass(frozen=True)
class GapOptions:
    """Options of `explain_gap`, as INTERFACE.md names them. Raises UsageError and ConfigurationError.

    `without`: base parameters to drop. `effects`: names the catalogue is restricted to, all when empty. `add`:
    effects put in by hand before the search. `model`: the base whose gap is sought. `first_mode_hz`: the
    locked-motor frequency, if known. `prismatic`: the joint slides, and gravity is a constant force.
    `effort_kind`: what the effort is; `auto` finds out. `band_hz`: the frequency up to which model and recording are
    compared; None: as far as both are coherent.
    """

    sensors: str = "auto"
    rigid: bool = False
    without: tuple[str, ...] = ()
    effects: tuple[str, ...] = ()
    add: tuple[str, ...] = ()
    model: JointModel | None = None
    first_mode_hz: float | None = None
    prismatic: bool = False
    effort_kind: str = "auto"
    band_hz: float | None = None
    searching: bool = True
    """Whether to look for effects beside those that are added."""
    staying: tuple[str, ...] = ()
    """Effects that the base keeps what stands for them of, although it is certain: the search did not find them."""

    def __post_init__(self) -> None:
        if self.sensors not in SENSORS:
            raise UsageError(f"sensors is '{self.sensors}': expected one of {', '.join(SENSORS)}.")
        check_effort_kind(self.effort_kind)
        check_band(self.band_hz)
        for name in (*self.effects, *self.add):
            effect_named(name)
        if twice := [name for name in self.add if self.add.count(name) > 1]:
            raise UsageError(f"--add names {twice[0]} twice.")
        essential = ("J",) if self.rigid else ("Jm", "K", "JL")
        known = [k for k in self.base_catalogue if k not in essential]
        for key in self.without:
            if key not in known:
                raise UsageError(f"--without {key}: expected one of {', '.join(known)}.")
        if self.model is not None and self.model.rigid != self.rigid:
            raise UsageError(
                "the model is of a rigid joint: add --rigid." if self.model.rigid else
                "the model has a spring: leave --rigid out."
            )  # fmt: skip

    @property
    def base_catalogue(self) -> tuple[str, ...]:
        """Base keys: eq. 11 and a constant torque; J, FV, FS, offset and gravity of a rigid joint.

        What slides has no first moments: a constant force is its weight.
        """
        keys = RIGID_KEYS if self.rigid else FLEXIBLE_KEYS
        return tuple(k for k in keys if not (self.prismatic and k in GRAVITY_KEYS))
