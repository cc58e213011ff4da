"""What an estimate tells of itself: which parameters the data determine, and the numbers that a verdict is made of."""

from __future__ import annotations

import math

import numpy as np

from flex_ident.estimation.estimate import Estimate
from flex_ident.judgement.evidence import Cause, FitEvidence, OtherJoints
from flex_ident.judgement.rules import ESSENTIAL
from flex_ident.judgement.thresholds import EFFECT_LIMIT, RELATIVE_LIMIT
from flex_ident.parameters import UNITS, Parameter


def torque_per_std(estimate: Estimate, key: str) -> float:
    """Rms of the motor torque, N m, that one standard deviation of a key moves (link channel left out)."""
    std = estimate.uncertainty.std(key)
    if not math.isfinite(std):
        return math.inf
    problem, values = estimate.problem, estimate.fit.values
    step = max(abs(values[key]), std, 1e-9) * 1e-3
    rows = problem.usable
    here = problem.prediction(values).torque[rows]
    there = problem.prediction(values | {key: values[key] + step}).torque[rows]
    return float(np.sqrt(np.mean((there - here) ** 2))) / step * std


def is_identifiable(estimate: Estimate, key: str) -> bool:
    """Whether the data determine a key: known to 30 %, or known to be too small to matter."""
    std = estimate.uncertainty.std(key)
    value = estimate.fit.values[key]
    if not math.isfinite(std):
        return False
    if std <= RELATIVE_LIMIT * abs(value):
        return True
    if key in ESSENTIAL:
        return False
    rms = float(np.sqrt(np.mean(estimate.problem.torque[estimate.problem.usable] ** 2)))
    return torque_per_std(estimate, key) <= EFFECT_LIMIT * rms


def moved_stds(estimate: Estimate) -> dict[str, float]:
    """For each suspect the most standard deviations by which it would move a base parameter, were the model right."""
    fit, plain = estimate.fit, estimate.plain
    found: dict[str, float] = {}
    for suspect in estimate.suspects:
        sizes = [
            abs(float(suspect.shift[i])) / plain.std(key)
            for i, key in enumerate(fit.free)
            if key in UNITS and 0.0 < plain.std(key) < math.inf and is_identifiable(estimate, key)
        ]
        found[suspect.effect] = max(found.get(suspect.effect, 0.0), *sizes, 0.0)
    return found


def evidence_of(
    estimate: Estimate,
    parameters: tuple[Parameter, ...],
    measurement: tuple[Parameter, ...],
    *,
    error_percent: float,
    validation_percent: float,
    locked_motor_hz: float,
) -> FitEvidence:
    """What the verdict of an estimate is made of; errors in percent of the torque."""
    left, moved, coupling = estimate.left, moved_stds(estimate), estimate.coupling
    return FitEvidence(
        parameters=parameters,
        error_percent=error_percent,
        validation_percent=validation_percent,
        measurement=measurement,
        sample_time=estimate.problem.recording.sample_time,
        seconds=float(estimate.problem.time[-1]),
        locked_motor_hz=locked_motor_hz,
        band_hz=estimate.problem.band_hz,
        gap=left.gap,
        noise=left.floor,
        structured=left.structured(left.gap),
        burst=left.burst(estimate.problem.time),
        link=(left.link.gap, left.link.floor) if left.link is not None and left.link.structured else None,
        noise_known=left.evidence != "none",
        causes=tuple(
            Cause(s.effect, s.gain, moved.get(s.effect, 0.0), s.strong, s.scales_torque > 0.0)
            for s in estimate.suspects
        ),
        other_joints=None
        if coupling is None or not coupling.seen
        else OtherJoints(coupling.joints, coupling.share, coupling.chance),
        strained=estimate.strained,
        other_end=None if estimate.other is None else (estimate.other.key, estimate.other.here, estimate.other.there),
    )
