"""A dead band in the transmission."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, at_size
from flex_ident.effects.starting import Scans, Start
from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term

WIDTHS = np.geomspace(0.005, 0.7, 24)
"""Dead bands tried, relative to the whole range of deflection."""


def _probes(scales: Scales) -> Iterator[Probe]:
    for share in (0.01, 0.03, 0.1, 0.3, 1.0):
        yield at_size({"gap": share * scales.deflection})


def beyond(deflection: Floats, gap: float) -> Floats:
    """Deflection (n,) of the spring behind a dead band of full width `gap`."""
    rest: Floats = deflection - np.clip(deflection, -0.5 * gap, 0.5 * gap)
    return rest


def dead_band_start(scans: Scans) -> Start | None:
    """The dead band as both positions show it."""
    found = scans.measured_spring(beyond, WIDTHS)
    return None if found is None else Start(found[1], {"gap": found[0]})


BACKLASH = Effect(
    name="backlash",
    summary="dead band in the transmission",
    equation="tau = K dead_band(d, gap / 2)",
    parameters=(EffectParameter("gap", "rad", "full width of the dead band", Term.HALF_GAP, factor=0.5, lower=0.0),),
    probes=_probes,
    start=dead_band_start,
    where="spring",
    signature="a step of the residual where the deflection crosses zero",
    bin_by="spring_deflection",
    confused_with=("nonlinear_stiffness",),
    separated_by="small amplitude, so that the load crosses zero often",
    needs_spring=True,
)
