"""Commanded effort that the drive did not deliver."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from flex_ident.effects.effect import EXACT, FINE, Effect, EffectParameter
from flex_ident.effects.probe import Probe, Scales, at_size
from flex_ident.effects.starting import Scans, Start, far_off
from flex_ident.notices import Reason, Why
from flex_ident.parameters.prior import Prior
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term

LIMIT_SHARES = np.array((0.2, 0.4, 0.55, 0.7, 0.8, 0.88, 0.94))
LIMIT_QUANTILES = (0.6, 0.75, 0.9, 0.95, 0.98, 0.99, 0.995)
"""Limits that are tried: shares of the largest torque recorded, and quantiles of its magnitude."""
LIMITS = np.geomspace(0.04, 1.0, 36)
"""Limits scanned for a start, relative to the largest torque that was asked for."""

OVER_NOISE = 2.0
"""Of the recorded torque, that what a limit cuts off must exceed, rms: noise alone around a level exceeds it by 1. Seed
401 of `bench/coverage.py`, recording 20: a torque that rested at 37 N m for 15 % of the time, and 0.98."""


def _probes(scales: Scales) -> Iterator[Probe]:
    recorded = scales.recorded_torque
    for limit in (*(np.max(recorded) * LIMIT_SHARES), *np.quantile(recorded, LIMIT_QUANTILES)):
        yield at_size({"limit": float(limit)})


def _start(scans: Scans) -> Start | None:
    """The limit, of many, with which a joint explains most: a fit that had to do without it may be lost."""
    if not far_off(scans):
        return None
    recorded = scans.recorded_torque
    limits = np.max(np.abs(recorded)) * LIMITS
    clipped = np.column_stack([scans.reduced(np.clip(recorded, -x, x)) for x in limits])
    sizes = np.linalg.norm(clipped, axis=0)  # a lower limit leaves less torque, and less error for that reason alone
    which, model = scans.scanned(clipped / sizes)
    scaled = Values({k: v * float(sizes[which]) for k, v in model.items()})
    return Start(scaled, {"limit": float(limits[which])})


def _priors(asked: Floats) -> dict[str, Prior]:
    """A limit that is reached half of the time would clip the measurement itself away."""
    least, largest = float(np.median(asked)), float(np.max(asked))
    return {"limit": Prior(0.7 * largest, 100.0 * largest, least, 1.1 * largest)}


def _of_noise(values: Mapping[str, float], recorded: Floats, noise: float) -> Reason | None:
    """A torque that rests at one level exceeds it by its noise: a limit there takes off half of that noise."""
    over = np.abs(recorded) - values["limit"]
    over = over[over > 0.0]
    size = float(np.sqrt(np.mean(over**2))) if over.size else 0.0
    if size >= OVER_NOISE * noise:
        return None
    return Reason(Why.WITHIN_TORQUE_NOISE, numbers={"over": size, "noise": noise})


SATURATION = Effect(
    name="saturation",
    summary="commanded effort that the drive did not deliver",
    equation="delivered = clip(recorded, -limit, limit)",
    parameters=(
        EffectParameter("limit", "N m", "largest torque that the drive delivers", Term.TORQUE_LIMIT, lower=0.0),
    ),
    probes=_probes,
    start=_start,
    priors=_priors,
    of_noise=_of_noise,
    refined=("limit", FINE),
    where="measurement",
    signature="a residual only where the recorded torque is largest",
    bin_by="recorded_torque",
    confused_with=("torque_ripple",),
    separated_by="a lower amplitude",
    law_error=EXACT,
)
