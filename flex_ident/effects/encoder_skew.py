"""Link and motor positions recorded at different times."""

from __future__ import annotations

from collections.abc import Iterator

from flex_ident.effects.effect import EXACT, Effect, EffectParameter
from flex_ident.effects.probe import SAMPLES, Probe, Scales, in_proportion
from flex_ident.simulation.terms import Term


def _probes(scales: Scales) -> Iterator[Probe]:
    yield in_proportion("skew", SAMPLES * scales.sample_time_s)


ENCODER_SKEW = Effect(
    name="encoder_skew",
    summary="link and motor positions recorded at different times",
    equation="link position recorded at t is that of t - skew",
    parameters=(
        EffectParameter(
            "skew", "s", "time by which the link position is recorded late", Term.LINK_SKEW, lower=-0.1, upper=0.1
        ),
    ),
    probes=_probes,
    replaces="link_skew",
    where="measurement",
    of_recording=True,
    signature="an error of the link position proportional to its velocity",
    bin_by="link_velocity",
    confused_with=("joint_damping",),
    separated_by="a wide band",
    needs_spring=True,
    needs_link=True,
    law_error=EXACT,
)
