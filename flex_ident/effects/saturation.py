"""Commanded effort that the drive did not deliver."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from flex_ident.effects.effect import EXACT, FINE, Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, at_size
from flex_ident.simulation.terms import Term

LIMIT_SHARES = np.array((0.2, 0.4, 0.55, 0.7, 0.8, 0.88, 0.94))
LIMIT_QUANTILES = (0.6, 0.75, 0.9, 0.95, 0.98, 0.99, 0.995)
"""Limits that are tried: shares of the largest torque recorded, and quantiles of its magnitude."""


def _probes(scales: Scales) -> Iterator[Probe]:
    recorded = scales.recorded_torque
    for limit in (*(np.max(recorded) * LIMIT_SHARES), *np.quantile(recorded, LIMIT_QUANTILES)):
        yield at_size({"limit": float(limit)})


SATURATION = Effect(
    name="saturation",
    summary="commanded effort that the drive did not deliver",
    equation="delivered = clip(recorded, -limit, limit)",
    parameters=(
        EffectParameter("limit", "N m", "largest torque that the drive delivers", Term.TORQUE_LIMIT, lower=0.0),
    ),
    probes=_probes,
    refined=("limit", FINE),
    where="measurement",
    signature="a residual only where the recorded torque is largest",
    bin_by="recorded_torque",
    confused_with=("torque_ripple",),
    separated_by="a lower amplitude",
    law_error=EXACT,
)
