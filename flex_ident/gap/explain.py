"""One recording in, one explanation of the gap out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flex_ident.effects import effect_named
from flex_ident.errors import ExcitationError
from flex_ident.estimation.covariance import uncertainty_of
from flex_ident.estimation.estimate import Estimate, fit_problem, validation_blocks
from flex_ident.estimation.fit import Fit
from flex_ident.estimation.identification import chosen_sensors, identification_of, identified_parameter
from flex_ident.estimation.problem import FitProblem, values_of
from flex_ident.filtering import first_mode
from flex_ident.gap.explanation import (
    Alternative,
    Finding,
    GapCurves,
    GapExplanation,
    GapVerdict,
    Profile,
    Region,
    Step,
)
from flex_ident.gap.fitting import GapFit, base_fit
from flex_ident.gap.options import GapOptions
from flex_ident.gap.remainder import remainder
from flex_ident.gap.search import Accepted, Progress, Search, searched
from flex_ident.gap.trials import effects_in
from flex_ident.gap.where import Variable, profile, regions, variables
from flex_ident.parameters import Identification
from flex_ident.parameters.keys import key_parts, key_text
from flex_ident.recording import Floats, Notice, Recording
from flex_ident.regression.motor_equation import motor_equation_notice
from flex_ident.regression.verdict import ESSENTIAL

VALIDATION_ITERATIONS = 5
STIFFEST = 0.75
"""Fastest mode that is integrated finely, in excited bands: hundreds of simulations are made."""
VISIBLE = 1.03
"""Gap over the noise floor from which it makes sense to say where it lies."""
NOT_A_MODEL = 0.95
"""Gap of the base over the torque's standard deviation from which the recording is not of such a joint."""
AT_THE_LIMIT = 0.99
"""Of a sample: a delay or skew that the fit would have larger."""
LEAST_S, LEAST_HELD_S = 4.0, 0.8
"""Usable motion, s, and of it the part kept for validation, under which nothing can be looked for."""
PERIODS = 2.0
"""Periods within the range of motion from which an effect can be called periodic."""


def explain(
    recording: Recording, options: GapOptions | None = None, *, progress: Progress | None = None
) -> GapExplanation:
    """Where simulation and measurement disagree, which effects are missing, and how far the gap shrinks with them.

    Raises ExcitationError, SignalError and ConfigurationError.
    """
    options = options or GapOptions()
    report: Progress = progress or (lambda _share, _text: None)
    sensors = chosen_sensors(recording, options.sensors)
    problem = fit_problem(
        recording, sensors=sensors, rigid=options.rigid, first_mode_hz=options.first_mode_hz, stiffest=STIFFEST
    )
    held = validation_blocks(problem)
    _refuse_short(problem, held)
    report(0.02, "fitting the base model")
    solver, base = base_fit(problem, options)
    report(0.2, "screening")
    search = searched(solver, base, options, lambda x, text: report(0.2 + 0.6 * x, text))
    report(0.82, "measuring the gap on data not fitted")
    chain = [(solver, base), *((a.trial.solver, search.after(i)) for i, a in enumerate(search.accepted))]
    trained = [_trained(s, f, problem, held) for s, f in chain]
    gaps = [_gap(problem, values, held) for values in trained]
    report(0.92, "describing what is left")
    final = _final(recording, problem, search, trained[-1], held, sensors)
    determined = all(p.identifiable for p in final.parameters if p.key in ESSENTIAL)
    notices = (*_as_given(problem, options, gaps[0], held), *_notices(search, problem))
    if not determined:
        notices = (*notices, _refusal([a.trial.effect for a in search.accepted]))
        if search.accepted:  # nothing is added to a base that is not determined
            search = Search(solver, base, base, rejected=search.rejected, untestable=search.untestable)
            gaps = gaps[:1]
            final = _final(recording, problem, search, trained[0], held, sensors)
    first, left = remainder(solver, base, held), remainder(search.solver, search.fit, held)
    floor = min(left.floor, gaps[-1])
    steps = _steps(search, gaps)
    findings = tuple(_finding(search, i, gaps, problem, held) for i in range(len(search.accepted)))
    before_variables = variables(problem, base.values)
    after_variables = variables(problem, search.fit.values)
    where: tuple[Region, ...] = ()
    if gaps[0] > VISIBLE * floor:
        where = regions(before_variables, first.residual, problem.usable, problem.rate_hz, floor)
    where_left = regions(after_variables, left.residual, problem.usable, problem.rate_hz, floor)
    structured = left.structured(gaps[-1])
    named = any(not a.trial.objection for a in search.accepted) and bool(findings)
    hopeless = gaps[0] > NOT_A_MODEL * float(np.std(problem.measured_torque(base.values)[held]))
    verdict = _verdict(named=named, sound=determined or (structured and not hopeless), structured=structured)
    unexplained = None
    if structured:
        tried = "that was tried" if options.effects else "of the catalogue"
        place = where_left[0].text if where_left else "it is spread evenly"
        unexplained = (
            f"{gaps[-1]:.3g} N m rms remain, the noise is {floor:.3g} N m: no effect {tried} accounts for it; {place}."
        )
    if not findings and verdict != "complete" and sensors == "motor+link":
        said = motor_equation_notice(recording)
        notices = (*notices, *([said] if said is not None else []))
    report(1.0, "explained")
    return GapExplanation(
        joint=recording.joint,
        sensors=sensors,
        verdict=verdict,
        unit="N m",
        before=gaps[0],
        after=gaps[-1],
        noise_floor=floor,
        method_error=left.own_error,
        steps=steps,
        where=where,
        findings=findings,
        rejected=tuple(r for n, r in search.rejected.items() if n not in effects_in(search.fit.free)),
        not_testable=tuple(search.untestable.values()),
        final=final,
        unexplained=unexplained,
        where_left=where_left,
        repeats=first.repeats,
        repeats_left=left.repeats,
        notices=notices,
        curves=_curves(problem, base.values, search.fit.values),
        profiles=_profiles(before_variables, after_variables, first.residual, left.residual, problem.usable),
    )


def _trained(solver: GapFit, fit: Fit, problem: FitProblem, held: NDArray[np.bool_]) -> Mapping[str, float]:
    """The same keys fitted without the validation part."""
    own = GapFit(problem.restricted(problem.usable & ~held), priors=solver.priors, marks=solver.marks)
    return own.solve(fit.free, fit.values, fit.whitenings, iterations=VALIDATION_ITERATIONS, tolerance=1e-5).values


def _torque_residual(problem: FitProblem, values: Mapping[str, float]) -> Floats:
    return problem.residuals(values)[0]


def _gap(problem: FitProblem, values: Mapping[str, float], held: NDArray[np.bool_]) -> float:
    return float(np.sqrt(np.mean(_torque_residual(problem, values)[held] ** 2)))


def _steps(search: Search, gaps: Sequence[float]) -> tuple[Step, ...]:
    names = ["base"]
    for a in search.accepted:
        names.append(f"{names[-1]} + {a.trial.effect}")
    return tuple(Step(name, gap) for name, gap in zip(names, gaps, strict=True))


def _estimate(problem: FitProblem, fit: Fit, trained: Mapping[str, float], held: NDArray[np.bool_]) -> Estimate:
    return Estimate(problem, fit, uncertainty_of(fit, problem.rate_hz), held, trained)


def _final(
    recording: Recording, problem: FitProblem, search: Search, trained: Mapping[str, float],
    held: NDArray[np.bool_], sensors: str,
) -> Identification:  # fmt: skip
    response = first_mode(recording).response
    result = identification_of(
        recording, _estimate(problem, search.fit, trained, held), sensors=chosen_sensors(recording, sensors),
        method="auto", response=None if problem.rigid else response,
    )  # fmt: skip
    return replace(result, method="explain_gap")


def _finding(
    search: Search, index: int, gaps: Sequence[float], problem: FitProblem, held: NDArray[np.bool_]
) -> Finding:
    accepted = search.accepted[index]
    trial = accepted.trial
    estimate = _estimate(problem, search.fit, search.fit.values, held)
    found = []
    for key in trial.candidate.keys:
        p = identified_parameter(estimate, key)
        found.append(replace(p, key=key_parts(key)[1]))
    others = tuple(
        Alternative(t.effect, _gap(problem, t.fit.values, held)) for t in accepted.others if t.effect != trial.effect
    )[:3]
    effect = effect_named(trial.effect)
    return Finding(
        effect=trial.effect,
        verdict="by_hand" if accepted.by_hand else "accepted",
        confidence=_confidence(accepted),
        gap_before=gaps[index],
        gap_after=gaps[index + 1],
        parameters=tuple(found),
        evidence=_evidence(trial.effect, accepted, gaps[index], gaps[index + 1]) + _periods_seen(accepted, problem),
        also_considered=others,
        indistinguishable_from=accepted.ties,
        experiment=effect.separated_by if accepted.ties else "",
    )


def _confidence(accepted: Accepted) -> float:
    """Probability of this effect among all that were tried, none included, by their BIC; never quite certain."""
    best = accepted.trial.evidence
    rivals = [0.0, *(t.evidence for t in accepted.others if t.effect != accepted.trial.effect)]
    odds = sum(math.exp(min(0.0, 0.5 * (r - best))) for r in rivals)
    return min(0.99, 1.0 / (1.0 + odds))


def _evidence(name: str, accepted: Accepted, before: float, after: float) -> str:
    effect = effect_named(name)
    trial = accepted.trial
    text = (
        f"{effect.summary}: on data not fitted the gap falls from {before:.3g} to {after:.3g} N m; blocks of 0.25 s "
        f"left out of the fit are predicted better by {100 * trial.held_out.share:.0f} % (t = {trial.held_out.t:.1f}), "
        f"the BIC falls by {trial.evidence:.0f}; {100 * max(0.0, min(1.0, trial.share)):.0f} % of the closable gap"
    )
    if trial.objection:
        text += f"; against it: {trial.objection}"
    return text + "."


def _periods_seen(accepted: Accepted, problem: FitProblem) -> str:
    """A reservation about what is periodic in the motor's angle and was seen over little more than one period."""
    trial = accepted.trial
    cycles = trial.fit.values.get(key_text(trial.effect, effect_named(trial.effect).cycles))
    if cycles is None:
        return ""
    periods = cycles * float(np.ptp(problem.motion.position)) / (2.0 * math.pi)
    if periods >= PERIODS:
        return ""
    return (
        f" Only {periods:.1f} periods lie within the range of motion: it may be any torque that depends on the angle; "
        "a larger range would tell."
    )


def _verdict(*, named: bool, sound: bool, structured: bool) -> GapVerdict:
    """`named`: whether an effect was found, or put in by hand and nothing speaks against it.

    `sound`: whether the base is determined, or at least explains some of the torque and misses something that shows.
    """
    if not sound:
        return "rejected"
    if named:
        return "partly_explained" if structured else "explained"
    return "unexplained" if structured else "complete"


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
    given = _gap(problem, {k: v for k, v in values_of(options.model).items() if k not in options.without}, held)
    text = f"the model as given leaves {given:.3g} N m"
    text += f"; with its parameters identified again, which is the base here, {refitted:.3g} N m."
    return (Notice("model_as_given", text),)


def _notices(search: Search, problem: FitProblem) -> tuple[Notice, ...]:
    notices = []
    for key, signal in (("torque_delay", "torque"), ("link_skew", "link position")):
        value = search.fit.values.get(key, 0.0)
        samples = abs(value) / problem.recording.sample_time
        if key not in search.fit.free or samples < 0.05:
            continue
        text = f"{signal} fits best when recorded {1e3 * value:+.3f} ms against the motor position, "
        if samples < AT_THE_LIMIT:
            text += "less than a sample: measurement, corrected for, not a finding."
        else:
            text += "the most that counts as measurement: it may be larger, or stand in for something else."
        notices.append(Notice(f"{key}_below_a_sample", text))
    return tuple(notices)


def _refusal(effects: Sequence[str]) -> Notice:
    """Why nothing is named on a recording that does not determine the base model."""
    text = "the recording does not determine the base model, so nothing is named"
    if effects:
        text += f" ({', '.join(effects)} would close some of the gap, by chance for all we know)"
    return Notice("base_not_determined", text + ".")


def _curves(problem: FitProblem, base: Mapping[str, float], final: Mapping[str, float]) -> GapCurves:
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
