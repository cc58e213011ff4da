"""A spring that is softer at small torque, as a harmonic drive is."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, at_size
from flex_ident.simulation.terms import Term

WIDTHS = (0.05, 0.15, 0.5, 1.5)
"""Deflections tried, over the rms deflection."""
SHARE = 0.2
"""Share of the stiffness tried."""
SOFTEST = 0.95
"""Share from which the zone is a dead band, which is another effect."""


def _probes(scales: Scales) -> Iterator[Probe]:
    for width in WIDTHS:
        yield at_size({"share": SHARE, "deflection": width * scales.deflection}, scaled=("share",))


SOFT_ZONE = Effect(
    name="soft_zone",
    summary="spring that is softer at small torque (harmonic drive)",
    equation="tau = K (d - share d / sqrt(1 + (d / deflection)^2))",
    parameters=(
        EffectParameter(
            "share", "1", "share of the stiffness that is missing at no torque", Term.SOFT_ZONE_SHARE, lower=0.0,
            upper=SOFTEST,
        ),
        EffectParameter(
            "deflection", "rad", "deflection up to which the spring is soft", Term.SOFT_ZONE_DEFLECTION, lower=1e-9
        ),
    ),
    probes=_probes,
    where="spring",
    signature="a residual odd in deflection that bends near zero and is level beyond",
    bin_by="spring_deflection",
    confused_with=("nonlinear_stiffness", "backlash", "hysteresis"),
    separated_by="torque swung slowly through zero, small and large",
    needs_spring=True,
)  # fmt: skip
