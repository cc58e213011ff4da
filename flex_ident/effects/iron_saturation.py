"""A torque constant that falls as the current grows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flex_ident.effects.effect import BEYOND_THE_LAW, Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, in_proportion
from flex_ident.parameters.prior import Prior
from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term

USUAL_LOSS, LARGEST_LOSS = 0.1, 1.0
"""Part of the torque that is lost at the largest one, over what is left of it: one standard deviation, and the most."""


def _probes(scales: Scales) -> Iterator[Probe]:
    yield in_proportion("loss", 1.0 / float(np.max(scales.recorded_torque)) ** 2, one_sided=True)


def _priors(asked: Floats) -> dict[str, Prior]:
    square = float(np.max(asked)) ** 2
    return {"loss": Prior(0.0, USUAL_LOSS / square, 0.0, LARGEST_LOSS / square)}


IRON_SATURATION = Effect(
    name="iron_saturation",
    summary="torque constant that falls as the current grows",
    equation="delivered = recorded / (1 + loss recorded^2)",
    parameters=(
        EffectParameter(
            "loss", "1/(N m)^2", "share of the torque that is lost, over its square", Term.IRON_LOSS, lower=0.0
        ),
    ),
    probes=_probes,
    priors=_priors,
    where="measurement",
    scales_torque=BEYOND_THE_LAW,
    signature="a residual against the torque that grows with its cube",
    bin_by="recorded_torque",
    confused_with=("saturation", "nonlinear_stiffness"),
    separated_by="a lower amplitude, or a torque sensor",
)
