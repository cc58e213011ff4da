"""One recording in, one explanation of the gap out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flex_ident.errors import ExcitationError, SignalError
from flex_ident.estimation.estimate import Estimate, estimate_of, fit_problem, of_kind, validation_blocks
from flex_ident.estimation.evidence import is_identifiable
from flex_ident.estimation.gravity_share import with_gravity_told
from flex_ident.estimation.identification import chosen_sensors, identification_of, refuse_unusable
from flex_ident.estimation.kind_priors import as_told
from flex_ident.estimation.motion_told import with_motion_told
from flex_ident.estimation.rigid import rigid_beside_link
from flex_ident.filtering.frequency_response import first_mode
from flex_ident.gap.base import GapBase, fitted_base, search_start
from flex_ident.gap.explanation import (
    GapCurves,
    GapExplanation,
    GapVerdict,
    Profile,
    Region,
    Step,
)
from flex_ident.gap.final import judged_again
from flex_ident.gap.findings import finding_of
from flex_ident.gap.found import Search
from flex_ident.gap.left import Leftover, reasons_left
from flex_ident.gap.options import GapOptions
from flex_ident.gap.rigid_base import rigid_alone, rigid_as_well
from flex_ident.gap.search import Progress, searched
from flex_ident.gap.sizes import GapSize, gap_size
from flex_ident.gap.thresholds import AT_THE_LIMIT, NOT_A_MODEL, VISIBLE
from flex_ident.gap.where import Variable, profile, regions, variables
from flex_ident.judgement.rules import ESSENTIAL
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.problem import FitProblem, values_of
from flex_ident.likelihood.remainder import remainder
from flex_ident.notices import Code, Notice
from flex_ident.parameters import Identification, Sensors
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats, Recording
from flex_ident.regression.motor_equation import motor_equation_notice
from flex_ident.screening.sketching import effects_in

STIFFEST = 0.75
"""Fastest mode that is integrated finely, in excited bands: hundreds of simulations are made."""
BELOW_A_SAMPLE = {"torque_delay": Code.TORQUE_DELAY_BELOW_A_SAMPLE, "link_skew": Code.LINK_SKEW_BELOW_A_SAMPLE}
LEAST_S, LEAST_HELD_S = 4.0, 0.8
"""Usable motion, s, and of it the part kept for validation, under which nothing can be looked for."""


def explain(
    recording: Recording, options: GapOptions | None = None, *, progress: Progress | None = None
) -> GapExplanation:
    """Where simulation and measurement disagree, which effects are missing, and how far the gap shrinks with them.

    Raises ExcitationError, SignalError and ConfigurationError.
    """
    options = options or GapOptions()
    sensors = chosen_sensors(recording, options.sensors)
    told = with_gravity_told(with_motion_told(recording), options.effort_kind, sensors, rigid=options.rigid)
    recording, kind = as_told(*told)
    options = replace(options, effort_kind=kind)
    refuse_unusable(recording, options.effort_kind)
    report: Progress = progress or (lambda _share, _text: None)
    problem = fit_problem(
        recording, sensors=sensors, rigid=options.rigid, first_mode_hz=options.first_mode_hz, band_hz=options.band_hz
    )
    _refuse_short(problem, validation_blocks(problem))
    report(0.02, "fitting the base model")
    try:
        base = fitted_base(problem, options)
    except ExcitationError:
        rigid = rigid_alone(recording, problem, options)
        if rigid is None:
            alone = _without_link(recording, options, progress)
            if alone is None:
                raise
            return alone
        return _explained_as_rigid(recording, options, progress, rigid)
    report(0.2, "screening")
    missed = _not_borne_out(recording, base, options)
    if missed:
        options = replace(options, staying=(*options.staying, *missed))
        base = fitted_base(problem, options, base.whole)
    kinds, stood_for = base.kinds, {effect.name for effect in base.stood_for}
    solver, fit = kinds.solver, kinds.fit
    problem = solver.problem
    held = validation_blocks(problem)
    try:
        searching, start = search_start(_coarse(recording, problem, options), solver, fit)
    except ExcitationError:  # at the edge of what can be simulated, fewer samples or other weights go beyond it
        searching, start = solver, fit
    search = searched(searching, start, options, lambda x, text: report(0.2 + 0.6 * x, text), sure=stood_for)
    report(0.82, "measuring the gap on data not fitted")
    search, gaps, estimate = judged_again(search, searching, start, (solver, fit), problem, options)
    lost = tuple(stood_for - {a.trial.effect for a in search.accepted})
    if lost:  # then what stood for them was what it was taken for
        return explain(recording, replace(options, staying=(*options.staying, *lost)), progress=progress)
    report(0.92, "describing what is left")
    final = _final(recording, of_kind(estimate, kinds), sensors)
    determined = all(
        is_identifiable(replace(estimate, uncertainty=estimate.plain), k) for k in fit.free if k in ESSENTIAL
    )
    notices = (*_as_given(problem, options, gaps[0].torque, held), *_notices(estimate.fit, problem))
    if not determined:
        notices = (*notices, _refusal([a.trial.effect for a in search.accepted]))
        if search.accepted:  # nothing is added to a base that is not determined
            search = Search(searching, start, start, rejected=search.rejected, untestable=search.untestable)
            gaps, estimate = gaps[:1], estimate_of(solver, fit, prismatic=options.prismatic)
            final = _final(recording, of_kind(estimate, kinds), sensors)
    if not search.accepted:
        rigid = rigid_as_well(recording, of_kind(estimate, kinds), options)
        if rigid is not None:
            return _explained_as_rigid(recording, options, progress, rigid)
        alone = _without_link(recording, options, progress) if final.verdict == "rejected" else None
        if alone is not None:
            return alone
    first, left = remainder(solver, fit, held), remainder(estimate.solver, estimate.fit, held)
    before, after = gaps[0].torque, gaps[-1].torque
    named = any(not a.trial.objection for a in search.accepted)
    leftover = Leftover(estimate, left, after, named)
    floor = leftover.floor
    steps = _steps(search, gaps)
    findings = tuple(finding_of(search, i, gaps, estimate) for i in range(len(search.accepted)))
    before_variables = variables(problem, fit.values)
    after_variables = variables(problem, estimate.fit.values)
    where: tuple[Region, ...] = ()
    if before > VISIBLE * floor:
        where = regions(before_variables, first.residual, problem.usable, problem.rate_hz, floor)
    where_left = regions(after_variables, left.residual, problem.usable, problem.rate_hz, floor)
    hopeless = before > NOT_A_MODEL * float(np.std(problem.measured_torque(fit.values)[held]))
    sound = determined or (leftover.structured and not hopeless)
    reasons = tuple(reasons_left(leftover, options, recording.notices, final.notices))
    verdict = _verdict(named=named and bool(findings), sound=sound, more=bool(reasons))
    if not findings and verdict != "complete" and sensors == "motor+link":
        said = motor_equation_notice(recording)
        notices = (*notices, *([said] if said is not None else []))
    report(1.0, "explained")
    return GapExplanation(
        joint=recording.joint,
        sensors=sensors,
        verdict=verdict,
        unit="N m",
        before=before,
        after=after,
        noise_floor=floor,
        method_error=left.own_error,
        steps=steps,
        where=where,
        findings=findings,
        rejected=tuple(r for n, r in search.rejected.items() if n not in effects_in(estimate.fit.free)),
        not_testable=tuple(search.untestable.values()),
        final=final,
        unexplained=reasons,
        where_left=where_left,
        repeats=first.repeats,
        repeats_left=left.repeats,
        notices=notices,
        curves=_curves(problem, fit.values, estimate.fit.values),
        profiles=_profiles(before_variables, after_variables, first.residual, left.residual, problem.usable),
    )


def _nothing_left(base: GapBase) -> bool:
    """Whether the base with all its nuisances leaves no more than noise and the method's own error."""
    left = remainder(base.whole.solver, base.whole.fit)
    return not left.structured(left.gap)


def _not_borne_out(recording: Recording, base: GapBase, options: GapOptions) -> tuple[str, ...]:
    """The effects that the base left something out for and that are not found where they are sought alone.

    Where the base leaves more than noise with all that it has, only those are asked for that a key of the joint stands
    for: a search that takes them along and does not find them would have to be made again.
    """
    quiet = bool(base.stood_for) and _nothing_left(base)
    wanted = [e for e in base.stood_for if quiet or any(k in options.base_catalogue for k in e.shown_by)]
    names = tuple(effect.name for effect in wanted if effect.name not in options.add)
    if not names or not options.searching:
        return ()
    coarse = _coarse(recording, base.kinds.solver.problem, options)
    own, start = replace(options, effects=names, add=()), search_start(coarse, base.kinds.solver, base.kinds.fit)
    found = searched(*start, own, lambda _share, _text: None, sure=names)
    return tuple(name for name in names if all(name != a.trial.effect for a in found.accepted))


def _explained_as_rigid(
    recording: Recording, options: GapOptions, progress: Progress | None, said: Notice
) -> GapExplanation:
    found = explain(recording, replace(options, rigid=True), progress=progress)
    return replace(found, notices=(said, *found.notices))


def _without_link(recording: Recording, options: GapOptions, progress: Progress | None) -> GapExplanation | None:
    """The rigid joint that the motor alone shows, as identification takes it where the link's position, which nobody
    asked for, led to nothing; None otherwise."""
    if recording.link_position is None:
        return None
    said = rigid_beside_link(recording, options, prismatic=options.prismatic)
    if said is None:
        return None
    try:
        found = explain(recording, replace(options, sensors="motor"), progress=progress)
    except (ExcitationError, SignalError):
        return None
    if all(n.code is not Code.TAKEN_AS_RIGID for n in found.notices):
        return None
    return replace(found, notices=(said, *(n for n in found.notices if n.code is not Code.TAKEN_AS_RIGID)))


def _coarse(recording: Recording, problem: FitProblem, options: GapOptions) -> FitProblem:
    """The problem with the fewest steps of integration that will do: the search makes hundreds of simulations."""
    coarse = fit_problem(
        recording, sensors=problem.sensors, rigid=options.rigid, first_mode_hz=options.first_mode_hz,
        stiffest=STIFFEST, band_hz=options.band_hz,
    )  # fmt: skip
    return coarse.resting_below(problem.resting_speed) if coarse.substeps < problem.substeps else problem


def _steps(search: Search, gaps: Sequence[GapSize]) -> tuple[Step, ...]:
    names = ["base"]
    for a in search.accepted:
        names.append(f"{names[-1]} + {a.trial.effect}")
    return tuple(Step(name, gap.torque, gap.link) for name, gap in zip(names, gaps, strict=True))


def _final(recording: Recording, estimate: Estimate, sensors: Sensors) -> Identification:
    response = first_mode(recording).response
    result = identification_of(
        recording, estimate, sensors=sensors, method="auto", response=None if estimate.problem.rigid else response
    )
    return replace(result, method="explain_gap")


def _verdict(*, named: bool, sound: bool, more: bool) -> GapVerdict:
    """`more`: whether more than noise is left, or may be.

    `named`: whether an effect was found, or put in by hand and nothing speaks against it.
    `sound`: whether the base is determined, or at least explains some of the torque and misses something that shows.
    """
    if not sound:
        return "rejected"
    if named:
        return "partly_explained" if more else "explained"
    return "unexplained" if more else "complete"


def _refuse_short(problem: FitProblem, held: NDArray[np.bool_]) -> None:
    usable_s, held_s = (float(np.count_nonzero(rows)) / problem.rate_hz for rows in (problem.usable, held))
    if usable_s < LEAST_S or held_s < LEAST_HELD_S:
        raise ExcitationError(
            f"{usable_s:.1f} s of usable motion, {held_s:.1f} s of them to check with, are too few to look for what is "
            "missing: record at least ten seconds of motion."
        )


def _as_given(problem: FitProblem, options: GapOptions, refitted: float, held: NDArray[np.bool_]) -> tuple[Notice, ...]:
    """How far the model as it was given is from the measurement, before its parameters are identified again."""
    if options.model is None:
        return ()
    given = gap_size(problem, values_of(options.model).without(options.without), held).torque
    return (Notice(Code.MODEL_AS_GIVEN, numbers={"given": given, "refitted": refitted}, texts={"unit": "N m"}),)


def _notices(fit: Fit, problem: FitProblem) -> tuple[Notice, ...]:
    notices = []
    for key, code in BELOW_A_SAMPLE.items():
        value = fit.values.get(key, 0.0)
        samples = abs(value) / problem.recording.sample_time
        if key not in fit.free or samples < 0.05:
            continue
        case = "within" if samples < AT_THE_LIMIT else "at_limit"
        notices.append(Notice(code, key, {"delay_ms": 1e3 * value, "samples": samples}, {"case": case}))
    return tuple(notices)


def _refusal(effects: Sequence[str]) -> Notice:
    """Why nothing is named on a recording that does not determine the base model."""
    return Notice(Code.BASE_NOT_DETERMINED, texts={"effects": ", ".join(effects)})


def _curves(problem: FitProblem, base: Values, final: Values) -> GapCurves:
    return GapCurves(
        problem.time, problem.measured_torque(final), problem.prediction(base).torque,
        problem.prediction(final).torque, problem.usable.astype(float),
    )  # fmt: skip


def _profiles(
    before: Sequence[Variable], after: Sequence[Variable], first: Floats, last: Floats, rows: NDArray[np.bool_]
) -> dict[str, tuple[Profile, Profile]]:
    found = {}
    for one, two in zip(before, after, strict=True):
        found[one.name] = (profile(one, first, rows), profile(two, last, rows))
    return found
