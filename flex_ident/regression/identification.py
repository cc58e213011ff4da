"""One recording in, one `Identification` out, by linear regression: the paper's way, or weighted."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flex_ident.errors import ExcitationError, SignalError, UsageError
from flex_ident.filtering.band import excited_band_hz
from flex_ident.filtering.design import FilterDesign, filter_design
from flex_ident.filtering.frequency_response import FirstMode, first_mode
from flex_ident.judgement.evidence import LinearEvidence
from flex_ident.judgement.rules import LINEAR_RULES, judged
from flex_ident.judgement.thresholds import EFFECT_LIMIT
from flex_ident.parameters import (
    FLEXIBLE_KEYS,
    GRAVITY_KEYS,
    RIGID_KEYS,
    UNITS,
    FilterSettings,
    FitQuality,
    Identification,
    JointModel,
    Parameter,
    Sensors,
    TorqueCurves,
    with_systematic,
)
from flex_ident.recording import Floats, Recording, extent_text, more_needed
from flex_ident.regression.gravity import shows_gravity
from flex_ident.regression.inversion import PHYSICAL, table_3, weighted_inversion
from flex_ident.regression.least_squares import LinearFit, least_squares
from flex_ident.regression.models import Equations, both_positions, motor_only, rigid
from flex_ident.regression.observation import Observation, clean_observation, paper_observation

Rows = NDArray[np.bool_]
BLOCKS = 10
HELD_OUT = (2, 5, 8)
"""Blocks of the recording, of BLOCKS, that the validation fit does not see."""
CORRELATION_S = 0.5
"""Time over which residuals are allowed to be correlated when the weighted method states its uncertainty, s."""
MEASUREMENT = {"torque_delay": "s", "link_zero": "rad", "link_skew": "s"}


def identify_linear(
    recording: Recording,
    *,
    sensors: Sensors,
    method: str = "weighted",
    rigid: bool = False,
    first_mode_hz: float | None = None,
    gravity: bool = True,
    order: int | None = None,
    decimation: int | None = None,
) -> Identification:
    """The joint's parameters by eq. 13 (both positions), eqs. 14 to 20 (motor only) or the rigid model.

    `method` is `paper` (to the letter, ordinary least squares) or `weighted` (exact derivatives, weights, uncertainty
    for correlated residuals). The rigid model has MX and MY where the recording shows gravity; without `gravity` (a
    prismatic joint) it never has them. Raises SignalError, ExcitationError and UsageError.
    """
    if method not in ("paper", "weighted"):
        raise UsageError(f"method is '{method}': expected paper or weighted.")
    _check_signals(recording, sensors)
    mode = first_mode(recording, hint_hz=first_mode_hz)
    kind: Literal["rigid", "both", "motor"] = "rigid" if rigid else ("both" if sensors == "motor+link" else "motor")
    band = excited_band_hz(recording)
    design = _design(recording, kind, mode, band, first_mode_hz, order, decimation)
    if method == "paper":
        at, settings = paper_observation(recording, design), design.settings()
    else:
        at = clean_observation(recording, band_hz=band)
        kept = max(1, round(recording.sample_rate_hz * float(np.median(np.diff(at.time)))))
        settings = FilterSettings(2 * math.pi * band, 2 * math.pi * 1.2 * band, 6, recording.sample_rate_hz, kept)
    halves = _equations(recording, at, kind, method, gravity)
    matrix, target, names = _reduced(halves, at)
    count = at.time.size
    held = np.isin(np.arange(count) * BLOCKS // count, HELD_OUT)
    step = float(np.median(np.diff(at.time)))
    correlated = max(1, min(round(CORRELATION_S / step), count // 20))
    lag = 0 if method == "paper" else correlated
    if kind == "rigid" and gravity and not shows_gravity(matrix, target, names, held, correlated):
        plain = [i for i, name in enumerate(names) if name not in GRAVITY_KEYS]
        matrix, names = matrix[:, plain], tuple(names[i] for i in plain)
    fit = _solved(matrix, target, names, np.ones(count, bool), len(halves), method, lag)
    trained = _solved(matrix, target, names, ~held, len(halves), method, lag)
    parameters, combined, derived, possible = _physical(fit, kind, method)
    motor, torque = matrix[:count], target[:count]
    if kind == "rigid":
        parameters = tuple(_judged_by_effect(p, motor[:, names.index(p.key)], torque) for p in parameters)
    unseen = motor @ trained.values
    predicted = np.where(held, unseen, motor @ fit.values)

    def relative(prediction: Floats, rows: Rows) -> float:
        size = float(np.linalg.norm(torque[rows]))
        return 100.0 * float(np.linalg.norm((torque - prediction)[rows])) / size if size else math.inf

    quality = FitQuality(
        count,
        fit.condition_number,
        fit.rank,
        relative(motor @ fit.values, np.ones(count, bool)),
        relative(unseen, held),
    )
    measurement = _measurement(fit)
    evidence = LinearEvidence(
        parameters, quality.relative_error_percent, quality.validation_relative_error_percent, measurement,
        recording.sample_time, possible=possible, opposed=_reversed(fit, kind), undetermined=fit.undetermined,
        x5_stds=derived.get("x5_sigmas"), required_rate_hz=design.required_rate_hz if method == "paper" else 0.0,
    )  # fmt: skip
    verdict, notices = judged(evidence, LINEAR_RULES)
    keys = RIGID_KEYS if rigid else FLEXIBLE_KEYS
    model = {p.key: p.value for p in parameters if p.key in keys and math.isfinite(p.value)}
    return Identification(
        joint=recording.joint, sensors=sensors, method=method, verdict=verdict, parameters=parameters, fit=quality,
        model=JointModel(model, joint=recording.joint), combined=combined, derived=derived, measurement=measurement,
        filter=settings, notices=(*recording.notices, *notices),
        curves=TorqueCurves(at.time, torque, predicted, held),
        frequency_response=replace(mode.response, modes_hz=()) if rigid else mode.response,
    )  # fmt: skip


def _check_signals(recording: Recording, sensors: Sensors) -> None:
    if sensors == "motor+link" and recording.link_position is None:
        raise SignalError("sensors motor+link: the recording has no link position. Name one with --link-position.")
    if float(np.ptp(recording.motor_position)) == 0.0:
        raise ExcitationError(f"joint {recording.joint} does not move: record a chirp.")
    if float(np.ptp(recording.motor_torque)) == 0.0:
        raise SignalError(f"the effort of joint {recording.joint} is constant: name the right one with --effort.")
    if recording.motor_position.size < 100:
        samples, rate = recording.motor_position.size, recording.sample_rate_hz
        raise ExcitationError(f"{extent_text(samples, rate)} are too few: {more_needed(samples, rate)}")


def _design(
    recording: Recording,
    kind: str,
    mode: FirstMode,
    band_hz: float,
    first_mode_hz: float | None,
    order: int | None,
    decimation: int | None,
) -> FilterDesign:
    """The paper's filter; without any mode the bandwidth is that of the excitation."""
    found = first_mode_hz if first_mode_hz is not None else mode.frequency_hz
    if kind == "rigid" or not math.isfinite(found):
        found = band_hz / 6.0
    derivatives = 4 if kind == "motor" else 2
    rate = recording.sample_rate_hz
    design = filter_design(found, derivative_order=derivatives, order=order, sample_rate_hz=rate, decimation=decimation)
    if kind == "motor" and design.required_rate_hz > rate:
        raise ExcitationError(
            f"sampling at {rate:.4g} Hz is too slow for four derivatives at a first mode of {found:.3g} Hz: eq. 29 "
            f"asks for {design.required_rate_hz:.0f} Hz. Record faster, or use --method auto."
        )
    return design


def _equations(recording: Recording, at: Observation, kind: str, method: str, gravity: bool) -> tuple[Equations, ...]:
    if kind == "rigid":
        return (rigid(recording, at, gravity=gravity),)
    if kind == "both":
        return both_positions(recording, at, measurement=method == "weighted")
    return (motor_only(recording, at),)


def _reduced(halves: tuple[Equations, ...], at: Observation) -> Equations:
    """Matrix and target of all halves, one below the other, filtered and decimated alike."""
    matrices = [at.reduced(matrix) for matrix, _, _ in halves]
    targets = [at.reduced(target[:, None])[:, 0] for _, target, _ in halves]
    return np.vstack(matrices), np.concatenate(targets), halves[0][2]


def _solved(
    matrix: Floats, target: Floats, names: tuple[str, ...], rows: Rows, halves: int, method: str, lag: int
) -> LinearFit:
    """Least squares over `rows` of each half; weighted: each half divided by the rms of its own residual."""
    used = np.tile(rows, halves)
    matrix, target = matrix[used], target[used]
    count = int(rows.sum())
    if halves == 1 or method == "paper":
        return least_squares(matrix, target, names, lag=lag)
    weight = np.ones(target.size)
    for _ in range(4):
        fit = least_squares(matrix * weight[:, None], target * weight, names, lag=lag)
        residual = target - matrix @ fit.values
        for half in range(halves):
            part = slice(half * count, (half + 1) * count)
            weight[part] = 1.0 / max(float(np.sqrt(np.mean(residual[part] ** 2))), 1e-12)
    return fit


def _physical(
    fit: LinearFit, kind: str, method: str
) -> tuple[tuple[Parameter, ...], tuple[Parameter, ...], Mapping[str, float], bool]:
    """Parameters, combined parameters, derived quantities, and whether the values are physically possible."""
    if kind != "motor":
        keys = RIGID_KEYS if kind == "rigid" else FLEXIBLE_KEYS
        known = {
            n: fit.std(n) if method == "paper" else with_systematic(n, fit.value(n), fit.std(n)) for n in fit.names
        }
        parameters = tuple(_parameter(n, fit.value(n), known[n]) for n in fit.names if n in keys)
        if kind == "rigid":
            return parameters, (), {}, fit.value("J") > 0.0
        derived = _modes(fit.value("Jm"), fit.value("K"), fit.value("JL"))
        return parameters, (), derived, bool(derived)
    inversion = table_3(fit) if method == "paper" else weighted_inversion(fit)
    stds = np.sqrt(np.maximum(np.diag(inversion.covariance), 0.0))
    parameters = tuple(
        _parameter(k, float(v), float(s)) for k, v, s in zip(PHYSICAL, inversion.values, stds, strict=True)
    )
    combined = tuple(Parameter(n, fit.value(n), fit.std(n)) for n in fit.names)
    derived = {
        **_modes(*(float(v) for v in inversion.values[:3])),
        "x5_predicted": inversion.x5_predicted,
        "x5_sigmas": inversion.x5_sigmas,
    }
    return parameters, combined, derived, inversion.possible


def _modes(jm: float, k: float, jl: float) -> dict[str, float]:
    if min(jm, k, jl) <= 0.0:
        return {}
    return {
        "free_resonance_hz": math.sqrt(k * (1.0 / jm + 1.0 / jl)) / (2.0 * math.pi),
        "locked_motor_hz": math.sqrt(k / jl) / (2.0 * math.pi),
    }


def _parameter(key: str, value: float, std: float) -> Parameter:
    return Parameter(key, value, std, UNITS.get(key, ""), bool(math.isfinite(std) and std <= 0.3 * abs(value)))


def _judged_by_effect(p: Parameter, column: Floats, torque: Floats) -> Parameter:
    """A parameter near zero counts as known where its uncertainty hardly moves the torque; an inertia never does."""
    moved = p.std * float(np.linalg.norm(column))
    small = p.key != "J" and moved <= EFFECT_LIMIT * float(np.linalg.norm(torque))
    return replace(p, identifiable=p.identifiable or small)


def _reversed(fit: LinearFit, kind: str) -> bool:
    """Whether all inertias and the stiffness come out negative for certain: the torque has the other sign."""
    forces = {"rigid": ("J",), "both": ("Jm", "K", "JL"), "motor": ("X3", "X5")}[kind]
    return all(fit.value(name) < -3.0 * fit.std(name) for name in forces)


def _measurement(fit: LinearFit) -> tuple[Parameter, ...]:
    """Delay of the torque, zero and skew of the link encoder, where they were columns of the fit."""
    if "torque_delay" not in fit.names:
        return ()
    k = fit.value("K")
    found = {"torque_delay": 1.0}
    if fit.std("K") < 0.3 * k:
        found.update({"K link_zero": k, "K link_skew": k})
    return tuple(
        Parameter(n.removeprefix("K "), fit.value(n) / by, abs(fit.std(n) / by), MEASUREMENT[n.removeprefix("K ")])
        for n, by in found.items()
        if by
    )
