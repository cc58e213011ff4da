"""A dead band in the transmission."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from flex_ident.effects.effect import Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, at_size
from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term


def _contribute(terms: Floats, p: Mapping[str, float]) -> None:
    terms[Term.HALF_GAP] += p.get("gap", 0.0) / 2.0


def _probes(scales: Scales) -> Iterator[Probe]:
    for share in (0.01, 0.03, 0.1, 0.3, 1.0):
        yield at_size({"gap": share * scales.deflection})


BACKLASH = Effect(
    name="backlash",
    summary="dead band in the transmission",
    equation="tau = K dead_band(d, gap / 2)",
    parameters=(EffectParameter("gap", "rad", "full width of the dead band", lower=0.0),),
    contribute=_contribute,
    probes=_probes,
    where="spring",
    signature="a step of the residual where the deflection crosses zero",
    bin_by="spring_deflection",
    confused_with=("nonlinear_stiffness",),
    separated_by="small amplitude, so that the load crosses zero often",
    needs_spring=True,
)
