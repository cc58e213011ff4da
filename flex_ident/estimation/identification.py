"""One recording in, one `Identification` out: the seam between commands and nodes on one side and the core."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from flex_ident.effects import is_fixed, key_named
from flex_ident.errors import ExcitationError, SignalError
from flex_ident.estimation.base_fit import rough_values
from flex_ident.estimation.cutoff_sweep import cutoff_notices, swept_cutoffs
from flex_ident.estimation.estimate import (
    Estimate,
    estimated,
    fit_problem,
    rigid_keys,
    started_values,
)
from flex_ident.estimation.evidence import evidence_of
from flex_ident.estimation.far_mode import rigid_link_notice
from flex_ident.estimation.friction_curve import friction_curve
from flex_ident.estimation.gravity_share import with_gravity_told
from flex_ident.estimation.identified import identified_parameter, modes_hz
from flex_ident.estimation.kind_priors import as_told, base_priors, friction_keys
from flex_ident.estimation.mode_seen import with_mode_judged
from flex_ident.estimation.motion_told import with_motion_told
from flex_ident.estimation.motor_current import kind_beside_current, with_motor_side
from flex_ident.estimation.motor_side import motor_side_notice
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.estimation.ratios import ratios
from flex_ident.estimation.rigid import (
    may_be_rigid,
    rigid_beside_link,
    rigid_left_percent,
    rigid_notice,
    rigid_objection,
    spring_is_open,
)
from flex_ident.estimation.thresholds import SENSOR_LEFT
from flex_ident.estimation.unseen_effects import encoder_notice, gravity_notice, loss_notices
from flex_ident.filtering.frequency_response import first_mode
from flex_ident.filtering.spectral import ORDER
from flex_ident.judgement.priorities import LOADED
from flex_ident.judgement.rules import FIT_RULES, judged
from flex_ident.judgement.thresholds import GOOD_RIGID
from flex_ident.likelihood.problem import Bools, FitProblem, model_of, values_of
from flex_ident.notices import Code, Notice
from flex_ident.parameters import (
    FLEXIBLE_KEYS,
    GRAVITY_KEYS,
    Covariance,
    FilterSettings,
    FitQuality,
    FrequencyResponse,
    Identification,
    Parameter,
    Sensors,
    TorqueCurves,
    joined_covariance,
)
from flex_ident.parameters.current import is_current
from flex_ident.parameters.effort_kinds import (
    FRICTION_COMPENSATED,
    FRICTION_KEYS,
    GRAVITY_COMPENSATED,
    GRAVITY_REMOVED,
    JOINT_SENSOR,
    MOTOR,
    MOTOR_KEYS,
)  # fmt: skip
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats, Recording
from flex_ident.recording.by_position import refuse_by_position
from flex_ident.recording.signs import brakes, refuse_unsigned
from flex_ident.recording.stillness import refuse_held
from flex_ident.regression import identify_linear
from flex_ident.regression.motor_equation import motor_equation_notice
from flex_ident.simulation.terms import MEASUREMENT_KEYS

Progress = Callable[[float], None]
KINDS_FOUND = (
    Code.EFFORT_JOINT_SENSOR, Code.EFFORT_GRAVITY_COMPENSATED, Code.EFFORT_FRICTION_COMPENSATED,
    Code.EFFORT_KIND_UNCLEAR, Code.EFFORT_KIND_OPEN,
)  # fmt: skip
"""Codes of the kind of effort, which a fit that is rejected does not tell."""
GRAVITY_OPEN = {MOTOR: "", JOINT_SENSOR: "sensor", FRICTION_COMPENSATED: "both"}
"""Kinds of effort in which gravity may be missing as well, and the case of the notice that says so."""
REPORTED = (
    "torque_delay", "torque_averaging", "effort_lag", "link_skew", "link_zero", "link_scale", "link_drift",
    "reversal_speed", "presliding", "reversal_lead",
)  # fmt: skip
"""Measurement keys that are part of a result."""


def chosen_sensors(recording: Recording, sensors: str) -> Sensors:
    """Which model to use: motor+link when the recording has a link position and nothing else was asked for.

    Raises SignalError when motor+link is asked for and there is no link position.
    """
    if sensors == "motor+link" and recording.link_position is None:
        raise SignalError("sensors motor+link: the recording has no link position. Name one with --link-position.")
    if sensors == "motor" or recording.link_position is None:
        return "motor"
    return "motor+link"


def identify(
    recording: Recording,
    options: IdentifyOptions | None = None,
    *,
    prismatic: bool = False,
    progress: Progress | None = None,
) -> Identification:
    """The joint's parameters by the method asked for. Raises ExcitationError and SignalError.

    `auto` fits a simulation of the link, driven by the recorded motor position, to the recorded torque (and link
    position) by maximum likelihood; a rigid joint is linear and goes through weighted least squares, without MX and MY
    where it is `prismatic`. A recording with a notice that doubts, as of other units than SI, is not trusted. Where the
    link's position was not asked for and leads to nothing, it is the rigid joint that the motor alone shows, if any.
    """
    options = options or IdentifyOptions()
    recording = with_motion_told(recording)
    asked = options.effort_kind
    if options.method == "auto":  # the paper's equations are of the motor's torque
        sensors = chosen_sensors(recording, options.sensors)
        recording, asked = with_gravity_told(recording, asked, sensors, rigid=options.rigid)
    told, kind = as_told(recording, kind_beside_current(recording, asked))
    fitted = replace(options, effort_kind=kind)
    try:
        result = _identified(told, fitted, prismatic, progress)
    except ExcitationError:
        alone = _without_link(told, fitted, prismatic)
        if alone is None:
            raise
        result = alone
    if result.verdict == "rejected":
        result = _without_link(told, fitted, prismatic) or result
    codes = {notice.code for notice in result.notices}
    if result.verdict == "trusted" and any(notice.severity != "info" for notice in result.notices):
        result = replace(result, verdict="doubtful")
    if result.verdict == "rejected" and result.sensors == "motor+link" and Code.EFFORT_REVERSED not in codes:
        notice = motor_equation_notice(recording)
        if notice is not None:
            result = replace(result, notices=(notice, *result.notices))
    if result.verdict != "rejected":
        return result
    kept = tuple(n for n in result.notices if n.code not in KINDS_FOUND or n.case == "given")
    if kind != FRICTION_COMPENSATED and Code.EFFORT_REVERSED not in codes and brakes(told):
        kept = (Notice(Code.EFFORT_REVERSED, "motor_torque", texts={"case": "brakes"}), *kept)
    return replace(result, notices=kept)


def _without_link(recording: Recording, options: IdentifyOptions, prismatic: bool) -> Identification | None:
    """The rigid joint that the motor alone shows, where the link's position was used unasked and led to nothing; None
    where that is not so, or no rigid joint either. Doubtful at best: the link's position does not bear it out."""
    if recording.link_position is None or options.method != "auto":
        return None
    said = rigid_beside_link(recording, options, prismatic=prismatic)
    if said is None:
        return None
    try:
        found = _identified(recording, replace(options, sensors="motor"), prismatic, None)
    except (ExcitationError, SignalError):
        return None
    if found.verdict == "rejected" or all(n.code is not Code.TAKEN_AS_RIGID for n in found.notices):
        return None
    others = tuple(n for n in found.notices if n.code is not Code.TAKEN_AS_RIGID)
    return replace(found, verdict="doubtful", notices=(said, *others))


def refuse_unusable(recording: Recording, effort_kind: str = "auto") -> None:
    """Raises ExcitationError where the joint is held or its effort follows the position alone, and SignalError where
    the effort has lost its sign."""
    refuse_held(recording.joint, recording.motor_position)
    if effort_kind != JOINT_SENSOR:  # behind the gear little friction is left to tell
        refuse_by_position(recording)
    if effort_kind == "auto":
        refuse_unsigned(recording)


def _identified(
    recording: Recording, options: IdentifyOptions, prismatic: bool, progress: Progress | None
) -> Identification:
    refuse_unusable(recording, options.effort_kind)
    sensors = chosen_sensors(recording, options.sensors)
    if options.method != "auto":
        found = identify_linear(
            recording,
            sensors=sensors,
            method=options.method,
            rigid=options.rigid,
            first_mode_hz=options.first_mode_hz,
            gravity=not prismatic,
        )
        return found if options.model is None else replace(found, notices=(*found.notices, Notice(Code.MODEL_IGNORED)))
    try:
        return _simulated(recording, options, sensors, prismatic, progress)
    except ExcitationError as error:
        if options.rigid:
            raise
        if sensors == "motor+link":
            raise
        rigid = rigid_left_percent(recording, prismatic=prismatic, band_hz=options.band_hz)
        if rigid is None:
            why = rigid_objection(recording, prismatic=prismatic, band_hz=options.band_hz) or LOADED
            alone = all(notice.code is not Code.OTHER_JOINTS_MOVE for notice in recording.notices)
            raise ExcitationError(str(error) if alone and why.endswith(LOADED) else why) from error
        if rigid > GOOD_RIGID:
            raise
        if not may_be_rigid(options, sensors):
            raise ExcitationError(f"{error} A rigid joint leaves {rigid:.1f} % of the torque: try --rigid.") from error
        said = Notice(Code.TAKEN_AS_RIGID, "K", {"rigid_percent": rigid}, {"case": "alone"})
        return _rigid(recording, options, sensors, prismatic, progress, said)


def _rigid(
    recording: Recording, options: IdentifyOptions, sensors: Sensors, prismatic: bool, progress: Progress | None,
    said: Notice,
) -> Identification:  # fmt: skip
    """The result of a rigid joint, where the motion shows no spring, with the notice that says so."""
    found = _simulated(recording, replace(options, rigid=True), sensors, prismatic, progress)
    return replace(found, notices=(said, *found.notices))


def _simulated(
    recording: Recording, options: IdentifyOptions, sensors: Sensors, prismatic: bool, progress: Progress | None
) -> Identification:
    """Maximum likelihood by simulation; of a rigid joint where that does as well."""
    problem = fit_problem(
        recording, sensors=sensors, rigid=options.rigid, first_mode_hz=options.first_mode_hz, band_hz=options.band_hz
    )
    estimate = estimated(
        problem, *base_start(problem, options, prismatic=prismatic), prismatic=prismatic,
        kind=options.effort_kind, progress=None if progress is None else lambda x: progress(0.1 + 0.6 * x),
    )  # fmt: skip
    mode = first_mode(recording, hint_hz=options.first_mode_hz)
    response = mode.response
    if options.rigid:
        response = replace(response, modes_hz=())
    result = identification_of(recording, estimate, sensors=sensors, method="auto", response=response)
    result = with_motor_side(result, estimate)
    rigid = None
    if sensors != "motor+link" and not options.rigid:
        rigid = rigid_notice(
            recording, result.fit.relative_error_percent, open_spring=spring_is_open(estimate),
            prismatic=prismatic, band_hz=problem.band_hz, resting_speed=estimate.problem.resting_speed,
        )  # fmt: skip
    if rigid is not None and may_be_rigid(options, sensors):
        said = replace(rigid, code=Code.TAKEN_AS_RIGID, texts={"case": "as_well"})
        return _rigid(recording, options, sensors, prismatic, progress, said)
    if rigid is not None:
        result = replace(result, verdict="rejected", notices=(rigid, *result.notices))
    result = with_mode_judged(result, mode.confidence, problem.band_hz)
    if not options.cutoff_sweep or options.rigid or result.verdict == "rejected":
        return result
    sweep = swept_cutoffs(
        recording, estimate, result.parameters, progress=None if progress is None else lambda x: progress(0.7 + 0.3 * x)
    )
    assert result.filter is not None
    notices = cutoff_notices(sweep, result.parameters, result.filter.cutoff_rad_s)
    return replace(result, cutoff_sweep=sweep, notices=(*result.notices, *notices))


def base_start(
    problem: FitProblem, options: IdentifyOptions, *, prismatic: bool = False
) -> tuple[tuple[str, ...], Values]:
    """Keys of the base model, the effects of a given model included, and the values from which its fit starts.

    Without the motor's keys where the effort is a joint sensor's, or only that is possible.
    """
    kind = options.effort_kind
    if problem.rigid:
        keys = rigid_keys(problem, gravity=not prismatic and kind != GRAVITY_COMPENSATED)
    else:
        dropped = (*(GRAVITY_KEYS if prismatic else ()), *(MOTOR_KEYS if kind == JOINT_SENSOR else ()))
        keys = tuple(k for k in FLEXIBLE_KEYS if k not in dropped)
    if kind == FRICTION_COMPENSATED:
        keys = tuple(k for k in keys if k not in friction_keys(rigid=problem.rigid))
    try:
        start = started_values(problem, keys, first_mode_hz=options.first_mode_hz)
    except ExcitationError:
        keys = tuple(k for k in keys if k not in MOTOR_KEYS)
        if problem.rigid or kind != "auto" or options.model is not None:
            raise
        sensed = sensor_start(problem, keys, options.first_mode_hz)
        if sensed is None:
            raise
        start = sensed
    if kind == GRAVITY_COMPENSATED and not problem.rigid:
        start = start | {GRAVITY_REMOVED: 1.0}
    if options.model is None:
        return keys, start
    given = values_of(options.model)
    start = better_start(problem, Values(dict.fromkeys(keys, 0.0)) | given, start | given.without(given.base))
    if kind == JOINT_SENSOR:
        given = given.without(MOTOR_KEYS)
    return tuple(dict.fromkeys((*keys, *(k for k in given if not is_fixed(k))))), start


def sensor_start(problem: FitProblem, keys: tuple[str, ...], first_mode_hz: float | None) -> Values | None:
    """Where the fit of a joint sensor's torque starts, if that explains nearly all of it; else None.

    After a rough fit: a resonance that the start misses by some per cent leaves a third of the torque. A spring whose
    mode the motion does not reach explains friction alone, which any torque may hold.
    """
    try:
        start = started_values(problem, keys, first_mode_hz=first_mode_hz)
        start = rough_values(problem, keys, start, base_priors(problem, keys, JOINT_SENSOR)).only(keys)
    except ExcitationError:
        return None
    if not start["K"] < start["JL"] * (2.0 * math.pi * problem.band_hz) ** 2:
        return None
    residual, torque = problem.residuals(start)[0][problem.usable], problem.torque[problem.usable]
    left = float(residual @ residual) / max(float(torque @ torque), 1e-300)
    return start if left < SENSOR_LEFT else None


def better_start(problem: FitProblem, *starts: Values) -> Values:
    """The start that leaves least of the torque: a guess far off must not cost the result."""

    def left(values: Values) -> float:
        residual = problem.residuals(values)[0][problem.usable]
        return float(residual @ residual) if np.isfinite(residual).all() else math.inf

    return min(starts, key=left)


def _paper_order(parameter: Parameter) -> int:
    """Place of a parameter of eq. 11; effects come last."""
    order = ("J", *FLEXIBLE_KEYS)
    return order.index(parameter.key) if parameter.key in order else len(order)


def identification_of(
    recording: Recording,
    estimate: Estimate,
    *,
    sensors: Sensors,
    method: str,
    response: FrequencyResponse | None = None,
) -> Identification:
    """The public result of an estimate, judged."""
    problem, fit = estimate.problem, estimate.fit
    base_and_effects = [k for k in fit.free if k not in MEASUREMENT_KEYS]
    parameters = tuple(identified_parameter(estimate, k) for k in base_and_effects)
    measurement = tuple(identified_parameter(estimate, k) for k in fit.free if k in REPORTED)
    predicted = problem.prediction(fit.values).torque
    unseen = problem.prediction(estimate.trained).torque
    measured = problem.measured_torque(fit.values)
    rows, held = problem.usable, estimate.validation

    def relative(prediction: Floats, where: Bools) -> float:
        size = float(np.linalg.norm(measured[where]))
        return 100.0 * float(np.linalg.norm((measured - prediction)[where])) / size if size else math.inf

    error, validation = relative(predicted, rows), relative(unseen, held)
    derived = {} if problem.rigid else modes_hz(fit.values)
    evidence = evidence_of(
        estimate, parameters, measurement, error_percent=error, validation_percent=validation,
        locked_motor_hz=derived.get("locked_motor_hz", 0.0),
    )  # fmt: skip
    verdict, objections = judged(evidence, FIT_RULES)
    notices = [*recording.notices, *objections]
    absent: tuple[Parameter, ...] = ()
    if estimate.kind is not None:
        notices = [*estimate.kind.notices, *notices]
        absent = estimate.kind.absent
        there = (p for p in parameters if all(p.key != a.key for a in absent))
        parameters = tuple(sorted((*absent, *there), key=_paper_order))
        if estimate.kind.unclear and estimate.kind.kind in GRAVITY_OPEN:
            matters = estimate.kind.matters
            code = Code.EFFORT_KIND_UNCLEAR if matters else Code.EFFORT_KIND_OPEN
            case = {"case": GRAVITY_OPEN[estimate.kind.kind]}
            notices.insert(len(estimate.kind.notices), Notice(code, "motor_torque", texts=case))
            verdict = "doubtful" if matters and verdict == "trusted" else verdict
        if estimate.kind.frictionless:
            parameters = tuple(
                replace(p, identifiable=p.identifiable and p.key not in FRICTION_KEYS) for p in parameters
            )
            said = Notice(Code.EFFORT_KIND_OPEN, "motor_torque", texts={"case": "friction"})
            notices.insert(len(estimate.kind.notices), said)
    placed = tuple(Parameter(k, v, 0.0, key_named(k).unit) for k, v in fit.values.items() if is_fixed(k))
    rigid_link = rigid_link_notice(estimate.solver, fit, estimate.uncertainty)
    notices += [rigid_link] if rigid_link is not None else []
    gravity = gravity_notice(estimate.unseen, fit, estimate.uncertainty)
    on_motor = motor_side_notice(problem, fit, estimate.uncertainty, estimate.unseen)
    encoder = encoder_notice(estimate.eccentric, fit, estimate.uncertainty)
    notices += [notice for notice in (gravity, on_motor, encoder, estimate.steps) if notice is not None]
    notices += loss_notices(estimate.lossy, fit.values)
    for group in estimate.uncertainty.undetermined:
        notices.append(Notice(Code.UNDETERMINED, ", ".join(group)))
    if response is not None and derived:
        shown = tuple(round(f, 4) for f in sorted(derived.values()))
        response = FrequencyResponse(
            response.title, response.frequency_hz, response.magnitude, response.coherence, shown
        )
    return Identification(
        joint=recording.joint,
        sensors=sensors,
        method=method,
        verdict=verdict,
        parameters=(*parameters, *placed),
        combined=ratios(estimate, parameters) if is_current(recording.notices) else (),
        fit=FitQuality(
            samples=int(rows.sum()),
            condition_number=estimate.uncertainty.condition_number,
            rank=estimate.uncertainty.rank,
            relative_error_percent=error,
            validation_relative_error_percent=validation,
        ),
        model=model_of(fit.values, rigid=problem.rigid, joint=recording.joint).without(tuple(p.key for p in absent)),
        derived=derived,
        measurement=measurement,
        filter=FilterSettings(
            bandwidth_rad_s=2.0 * math.pi * problem.band_hz,
            cutoff_rad_s=2.0 * math.pi * problem.cutoff_hz,
            order=ORDER,
            sample_rate_hz=recording.sample_rate_hz,
            decimation=problem.decimation,
        ),
        notices=tuple(notices),
        curves=TorqueCurves(problem.time, measured, predicted, held),
        frequency_response=response,
        covariance=covariance_of(estimate, parameters),
        friction_curve=friction_curve(problem, fit, estimate.uncertainty) if problem.rigid else None,
    )


def covariance_of(estimate: Estimate, parameters: Sequence[Parameter]) -> Covariance:
    """How the parameters are uncertain together: the estimate's covariance, with what the method adds to each alone."""
    uncertainty = estimate.uncertainty
    known = [p for p in parameters if p.key in uncertainty.free]
    rows = [uncertainty.free.index(p.key) for p in known]
    part = uncertainty.covariance[np.ix_(rows, rows)]
    return joined_covariance([p.key for p in known], part, [p.std for p in known])
