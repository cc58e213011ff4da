"""An effect as it is tried on a recording: its column of the regression, at sizes and shapes that make sense there."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from flex_ident.parameters.values import Values
from flex_ident.recording import Floats

SMOOTH_PROBE = 1e-3
"""Size of the probe of an effect that enters smoothly: what resonates is linear in small changes only."""
PLAUSIBLE = 0.05
"""Largest size worth testing for, in the units of the smooth probes."""
SAMPLES = 30.0
"""Samples by which a time that is recorded wrongly would change the prediction by about its own size."""
SIZES = (0.2, 3.0)
"""Smallest and largest multiple of a probe of its own size from which a fit starts."""
MOST_CYCLES = 90
"""Largest number of spatial frequencies tried for a periodic effect."""


@dataclass(frozen=True)
class Scales:
    """What the sizes of effects are measured against: one recording under the model as it stands."""

    torque: float
    """Standard deviation of the torque, N m."""
    speed: float
    """Root mean square of the motor's speed, rad/s."""
    load: float
    """Standard deviation of what the spring transmits, N m."""
    deflection: float
    """Of the spring under that load, rad."""
    travel: float
    """Range of the motor's motion, rad."""
    duration_s: float
    sample_time_s: float
    band_hz: float
    """Highest frequency that the fit sees."""
    most_cycles: float
    """Highest spatial frequency, rad/rad, that the filter passes at moderate speed."""
    recorded_torque: Floats
    """Its magnitude (n,), N m."""
    sides: tuple[str, ...]
    """Suffixes of parameters that exist on the motor's and on the link's side."""
    model: Values
    """The model's own values."""
    missing_moments: tuple[str, ...]
    """First moments that the model lacks and the joint may have."""
    link_mode: Callable[[], tuple[float, float] | None]
    """Frequency, Hz, and inertia over the link's, of a mass that the link drags along; None where none is seen."""


@dataclass(frozen=True)
class Probe:
    """An effect at one size and shape.

    `columns` are alternatives of its parameters: what each changes in the prediction is a column of the regression.
    `scaled` are the parameters that grow with the effect's size.
    """

    columns: tuple[Mapping[str, float], ...]
    scaled: tuple[str, ...]
    one_sided: bool = True
    """Only positive sizes exist."""
    smooth: bool = False
    """The prediction changes in proportion to the size: the probe is small and says by how much it must grow."""
    base: Values = field(default_factory=Values)
    """Values of the model's own keys from which a fit with this probe had better start."""
    raced: bool = False
    """Where the effect's refit races from several shapes: whether this is one of them."""
    phased: bool = False
    """Its columns are the sine and the cosine of one amplitude and phase."""
    inverse: bool = False
    """What grows with its size is the inverse of the scaled parameters: what gives way, gives way less with more."""

    def sized(self, value: float, size: float) -> float:
        """A scaled parameter of an effect of `size` times that of the probe."""
        return value / size if self.inverse else value * size

    def start(self, sizes: tuple[float, ...]) -> dict[str, float]:
        """Values of the parameters from which a fit starts, `sizes` being the linear estimates for each column."""
        values = dict(self.columns[0])
        if self.phased:
            values["amplitude"] *= math.hypot(*sizes)
            values["phase"] = math.atan2(sizes[1], sizes[0])
            return values
        if len(self.columns) > 1:
            return {k: sum(a * p[k] for a, p in zip(sizes, self.columns, strict=True)) for k in values}
        size = sizes[0] if self.smooth else float(np.clip(sizes[0], *SIZES))
        return {k: self.sized(v, size) if k in self.scaled else v for k, v in values.items()}


def at_size(parameters: Mapping[str, float], *, scaled: tuple[str, ...] = (), **base: float) -> Probe:
    """An effect that changes its shape as it grows: tried at the size that it may have. All is scaled by default."""
    return Probe((parameters,), scaled or tuple(parameters), base=Values(base))


def in_proportion(name: str, unit: float, *, one_sided: bool = False) -> Probe:
    """An effect of one parameter that the prediction follows in proportion; `unit` would change it by its own size."""
    return Probe(({name: SMOOTH_PROBE * unit},), (name,), one_sided, smooth=True)


def periodic(scales: Scales, unit: float) -> Iterator[Probe]:
    """Spatial frequencies from one period over the range of motion to what the band carries at moderate speed."""
    low = 2.0 * math.pi / scales.travel
    high = max(4.0 * low, min(scales.most_cycles, 2000.0))
    count = int(min(MOST_CYCLES, max(12, (high - low) / (0.35 * low))))
    for cycles in np.geomspace(low, high, count):
        sine = {"amplitude": SMOOTH_PROBE * unit, "cycles_per_turn": float(cycles), "phase": 0.0}
        yield Probe((sine, {**sine, "phase": 0.5 * math.pi}), ("amplitude",), one_sided=False, smooth=True, phased=True)
