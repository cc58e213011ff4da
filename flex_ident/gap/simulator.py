"""A user's own simulation against the measurement: which of its parameters are off, and which effect it lacks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from flex_ident.errors import DataError
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.gap.explain import explain
from flex_ident.gap.options import GapOptions
from flex_ident.gap.thresholds import OFF_SIGMAS
from flex_ident.parameters import Identification, Parameter
from flex_ident.parameters.keys import effect_in
from flex_ident.recording import Recording


@dataclass(frozen=True)
class Difference:
    """A parameter of the simulation beside the measured one; `sigmas` is their distance in standard deviations."""

    simulated: Parameter
    measured: Parameter

    @property
    def key(self) -> str:
        """The parameter's key."""
        return self.measured.key

    @property
    def percent(self) -> float:
        """By how much the simulation's value lies above the measured one, in percent of the latter."""
        if self.measured.value == 0.0:
            return math.inf
        return 100.0 * (self.simulated.value / self.measured.value - 1.0)

    @property
    def sigmas(self) -> float:
        """Distance in standard deviations of both."""
        std = math.hypot(self.simulated.std, self.measured.std)
        return abs(self.simulated.value - self.measured.value) / std if 0.0 < std < math.inf else 0.0

    @property
    def off(self) -> bool:
        """Whether the difference is beyond chance, both values being determined."""
        return self.simulated.identifiable and self.measured.identifiable and self.sigmas > OFF_SIGMAS


@dataclass(frozen=True)
class SimulatorGap:
    """What the simulation says of itself, and its parameters against the measured ones."""

    simulated: Identification
    differences: tuple[Difference, ...]
    lacks: tuple[str, ...]
    """Effects that the measurement shows and the simulation does not have."""
    has_too_much: tuple[str, ...]
    """Effects that the simulation has and the measurement does not show."""


def compared_with_simulator(
    simulated: Recording, measured: Sequence[Parameter], shown: Sequence[str], options: GapOptions, sensors: str
) -> SimulatorGap:
    """The simulated recording explained, against `measured` parameters and the effects that the measurement has
    `shown` with those `sensors`.

    Raises DataError when the simulated recording says nothing of its own model.
    """
    sensors = sensors if simulated.link_position is not None else "motor"
    own = explain(simulated, replace(options, sensors=sensors, model=None, add=()))
    if not own.determined:
        raise DataError(
            f"the simulated recording, {simulated.path}, does not determine its own model: let the simulation play the "
            "same motion, and record position and torque."
        )
    base = own.final
    if not own.findings:
        base = identify(simulated, IdentifyOptions(sensors=sensors, rigid=options.rigid), prismatic=options.prismatic)
    found = {p.key: p for p in base.parameters}
    has = [f.effect for f in own.findings]
    return SimulatorGap(
        simulated=base,
        differences=tuple(
            Difference(found[p.key], p) for p in measured if p.key in found and effect_in(p.key) is None
        ),
        lacks=tuple(effect for effect in shown if effect not in has),
        has_too_much=tuple(effect for effect in has if effect not in shown),
    )  # fmt: skip


def simulator_content(gap: SimulatorGap) -> dict[str, Any]:
    """The JSON form: each parameter with both values, and what the simulation lacks."""
    return {
        "parameters": {
            d.key: {
                "simulated": d.simulated.value, "measured": d.measured.value,
                "off_percent": d.percent if math.isfinite(d.percent) else None, "sigmas": d.sigmas, "off": d.off,
            }
            for d in gap.differences
        },
        "lacks": list(gap.lacks),
        "has_too_much": list(gap.has_too_much),
    }  # fmt: skip
