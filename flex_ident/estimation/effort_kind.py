"""What the recorded effort is, told from the fit: the motor's torque, the torque through the gear, less gravity."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flex_ident.effects import key_named
from flex_ident.errors import ExcitationError
from flex_ident.estimation.kind_gain import Gain, gain_of, linear_gain
from flex_ident.estimation.kind_priors import friction_keys, friction_priors, kept_priors
from flex_ident.estimation.thresholds import (
    AS_LIKELY,
    CLEARLY,
    FAR,
    MOST_WITH_LINK,
    NO_FRICTION,
    NO_INERTIA,
    NO_TORQUE,
    PENDULUM_M,
    SEEN,
)
from flex_ident.judgement.rules import ESSENTIAL
from flex_ident.judgement.thresholds import WEAK_PERCENT
from flex_ident.likelihood.covariance import Uncertainty, uncertainty_of
from flex_ident.likelihood.fit import Fit, Prior, SimulationFit
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.remainder import remainder
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.notices import Code, Notice
from flex_ident.parameters import GRAVITY_KEYS, UNITS, Parameter
from flex_ident.parameters.effort_kinds import (
    FRICTION_COMPENSATED,
    FRICTION_KEYS,
    GRAVITY_COMPENSATED,
    GRAVITY_REMOVED,
    JOINT_SENSOR,
    MOTOR,
    MOTOR_KEYS,
    REVERSAL_KEYS,
    EffortKind,
)  # fmt: skip
from flex_ident.recording import Floats
from flex_ident.simulation.terms import GRAVITY

ROUGH_ROUNDS = ((12, 1e-3), (10, 1e-4))
ROUNDS = ((12, 1e-4), (10, 1e-6))
GRAVITY_SIZES = (0.0, 0.003, 0.01, 0.03, 0.1)
"""First moments times g that are tried, over the stiffness of the joint."""
GRAVITY_ANGLES = 8


@dataclass(frozen=True)
class KindFit:
    """The fit under the kind of effort that holds, and what speaks for it.

    `rival` (p,): by how much a fit under another kind differs that the recording cannot tell from this one, and `open`
    (p, p) the covariance of that fit; None where there is none.
    """

    kind: EffortKind
    solver: SteadyFit
    fit: Fit
    notices: tuple[Notice, ...] = ()
    rival: Floats | None = None
    open: Floats | None = None
    unclear: bool = False
    """Whether the rival leaves a parameter of the joint open beyond the interval that it has without it."""
    matters: bool = False
    """Whether the joint's parameters are poorly known for that."""

    @property
    def absent(self) -> tuple[Parameter, ...]:
        """Parameters of which this kind of effort says nothing."""
        keys: tuple[str, ...] = ()
        if self.kind == JOINT_SENSOR and not self.fit.values.get("J"):
            keys = MOTOR_KEYS
        if self.kind == FRICTION_COMPENSATED:
            keys = friction_keys(rigid="J" in self.fit.values)
        return tuple(Parameter(key, 0.0, math.inf, UNITS[key], identifiable=False) for key in keys)

    def refitted(self, solver: SteadyFit, fit: Fit) -> KindFit:
        """The same kind, of a fit with other keys: a rival's difference follows the keys that both have."""
        rival, covariance = self.rival, self.open
        if rival is not None and covariance is not None and fit.free != self.fit.free:
            both = [(i, self.fit.free.index(k)) for i, k in enumerate(fit.free) if k in self.fit.free]
            here, there = ([pair[side] for pair in both] for side in (0, 1))
            size, before = len(fit.free), (rival, covariance)
            rival, covariance = np.zeros(size), np.zeros((size, size))
            rival[here], covariance[np.ix_(here, here)] = before[0][there], before[1][np.ix_(there, there)]
        return replace(self, solver=solver, fit=fit, rival=rival, open=covariance)

    def weighed(self, uncertainty: Uncertainty) -> KindFit:
        """The same, told the uncertainty that the fit has without its rival."""
        if self.rival is None:
            return self
        assert self.open is not None
        moved = zip(self.fit.free, np.sqrt(self.rival**2 + np.diag(self.open)), strict=True)
        sizes = [float(d) / max(uncertainty.std(k), 1e-300) for k, d in moved if k in ESSENTIAL]
        weak = any(
            float(np.hypot(d, uncertainty.std(k))) > 0.01 * WEAK_PERCENT * abs(self.fit.values[k])
            for k, d in zip(self.fit.free, np.sqrt(self.rival**2 + np.diag(self.open)), strict=True)
            if k in ESSENTIAL
        )
        return replace(self, unclear=max(sizes, default=0.0) > 1.96, matters=weak)

    def joined(self, uncertainty: Uncertainty) -> Uncertainty:
        """The uncertainty joined with what the rival would move.

        Of an effort less gravity also with what the controller's clock leaves open: gravity taken at a position that is
        up to a sample older or newer than the torque looks like viscous friction of the motor.
        """
        if self.kind == GRAVITY_COMPENSATED and "FVm" in self.fit.free:
            problem, at = self.solver.problem, self.fit.free.index("FVm")
            slope = GRAVITY * _pull(self.fit.values, float(np.mean(problem.motion.position)))
            covariance = uncertainty.covariance.copy()
            covariance[at, at] += (slope * problem.recording.sample_time) ** 2
            uncertainty = replace(uncertainty, covariance=covariance)
        if self.rival is None or self.open is None:
            return uncertainty
        joined = uncertainty.covariance + np.outer(self.rival, self.rival) + self.open
        return replace(uncertainty, covariance=joined)


def resolved(problem: FitProblem, solver: SteadyFit, fit: Fit, kind: str) -> KindFit:
    """The fit of a base model under the kind of effort asked for, or under the one that `auto` finds. Raises nothing
    that the fit has not raised already."""
    sensor = not problem.rigid and "Jm" not in fit.free
    if kind == JOINT_SENSOR or sensor:
        case = {"case": "found" if kind == "auto" else "given"}
        said = Notice(Code.EFFORT_JOINT_SENSOR, "motor_torque", {"inertia_percent": 0.0}, case)
        return KindFit(JOINT_SENSOR, solver, fit, (said,))
    if kind == GRAVITY_COMPENSATED:
        said = Notice(Code.EFFORT_GRAVITY_COMPENSATED, "motor_torque", {}, {"case": "given"})
        return KindFit(GRAVITY_COMPENSATED, solver, fit, (said,))
    if kind == FRICTION_COMPENSATED:
        texts = {"case": "given", "absent": " and ".join(friction_keys(rigid=problem.rigid))}
        return KindFit(FRICTION_COMPENSATED, solver, fit, (Notice(Code.EFFORT_FRICTION_COMPENSATED, texts=texts),))
    if problem.rigid or kind != "auto" or any(key_named(k).effect for k in fit.free):
        return KindFit(MOTOR, solver, fit)
    try:
        found = _joint_sensor(problem, solver, fit) or _friction_compensated(problem, solver, fit)
        return found if found is not None else _gravity_compensated(problem, solver, fit)
    except ExcitationError:  # the other kind's model runs away: it is not this one
        return KindFit(MOTOR, solver, fit)


def _refitted(
    problem: FitProblem,
    solver: SteadyFit,
    keys: Sequence[str],
    start: Mapping[str, float],
    *,
    rough: bool = False,
    moments: Mapping[str, Prior] | None = None,
) -> tuple[SteadyFit, Fit]:
    """The fit over other keys, from values near its optimum, or `rough` ones, with what is known of the first `moments`
    beforehand. Raises ExcitationError."""
    priors = {**kept_priors(solver.priors, keys), **(moments or {})}
    keys = [k for k in keys if k not in priors]
    values = {k: v for k, v in start.items() if k not in REVERSAL_KEYS or k in priors}
    own = SteadyFit(problem, priors=priors, marks=solver.marks, local=solver.local)
    if rough:
        first = SimulationFit(problem, priors=priors)
        few = (*keys, *(k for k in priors if k not in REVERSAL_KEYS))
        for iterations, tolerance in ROUGH_ROUNDS:
            found = first.solve(few, values, first.whitenings(values), iterations=iterations, tolerance=tolerance)
            values = dict(found.values)
    fit: Fit | None = None
    for iterations, tolerance in ROUNDS:
        fit = own.solve((*keys, *priors), values, own.whitenings(values), iterations=iterations, tolerance=tolerance)
        values = dict(fit.values)
    assert fit is not None
    return own, fit


def _joint_sensor(problem: FitProblem, solver: SteadyFit, fit: Fit) -> KindFit | None:
    """The fit without the motor's side, where that is negligible and nothing is lost; else None."""
    values, known = fit.values, uncertainty_of(fit, problem.rate_hz)
    std = {k: min(known.std(k), 1e300) if k not in fit.at_bound else 0.0 for k in MOTOR_KEYS}
    inertia = values["Jm"] + 2.0 * std["Jm"]
    if inertia > NO_INERTIA * values["JL"]:
        return None
    speed = float(np.std(problem.motion.velocity))
    torque = float(np.std(problem.torque[problem.usable]))
    link = values.get("FV", 0.0) * speed + values.get("FS", 0.0)
    if values.get("FVm", 0.0) * speed + values.get("FSm", 0.0) > max(NO_FRICTION * link, NO_TORQUE * torque):
        return None
    keys = [k for k in fit.free if k in UNITS and k not in MOTOR_KEYS]
    own, found = _refitted(problem, solver, keys, {k: v for k, v in values.items() if k not in MOTOR_KEYS})
    if gain_of(problem, own, fit, found).size < -AS_LIKELY:
        return None
    sizes = {"inertia_percent": 100.0 * inertia / values["JL"]}
    notice = Notice(Code.EFFORT_JOINT_SENSOR, "motor_torque", sizes, {"case": "found"})
    return KindFit(JOINT_SENSOR, own, found, (notice,))


def _friction_compensated(problem: FitProblem, solver: SteadyFit, fit: Fit) -> KindFit | None:
    """The fit with friction of either sign, where what is left of the motor's is negative and that explains all."""
    if not set(FRICTION_KEYS) & set(fit.at_bound):
        return None
    keys = [k for k in fit.free if k in UNITS and k not in FRICTION_KEYS]
    own = SteadyFit(problem, priors={**solver.priors, **friction_priors(problem)}, marks=solver.marks, local=True)
    found: Fit | None = None
    values = fit.values
    for iterations, tolerance in ROUNDS:
        found = own.solve(
            (*keys, *own.priors), values, own.whitenings(values), iterations=iterations, tolerance=tolerance
        )
        values = found.values
    assert found is not None
    gain, known, left = gain_of(problem, own, fit, found), uncertainty_of(found, problem.rate_hz), remainder(own, found)
    negative = any(found.values[k] < -SEEN * known.std(k) for k in FRICTION_KEYS)
    explains = left.evidence != "none" and not left.structured(left.gap)
    if gain.size < CLEARLY or not negative or not explains:
        return None
    notice = Notice(Code.EFFORT_FRICTION_COMPENSATED, "motor_torque", {"gain": gain.size}, {"case": "found"})
    return KindFit(FRICTION_COMPENSATED, own, found, (notice,))


def _gravity_compensated(problem: FitProblem, solver: SteadyFit, fit: Fit) -> KindFit:
    """The better of the fits with and without gravity in the effort, or the latter and how far the other is off."""
    motor = KindFit(MOTOR, solver, fit)
    if not all(k in fit.free for k in GRAVITY_KEYS):
        return motor
    linear = linear_gain(problem, solver, fit)
    if linear < -FAR:
        return motor
    keys = [k for k in fit.free if k in UNITS]
    usual = fit.values["JL"] / PENDULUM_M
    moments = {k: Prior(0.0, usual, -math.inf, math.inf) for k in GRAVITY_KEYS}
    tried: list[tuple[Gain, SteadyFit, Fit]] = []
    for start in _gravity_starts(problem, solver, fit):
        try:
            own, found = _refitted(problem, solver, keys, start, moments=moments)
        except ExcitationError:
            continue
        tried.append((gain_of(problem, own, fit, found), own, found))
    tried.sort(key=lambda one: -one[0].size)
    if not tried or tried[0][0].size < -CLEARLY:
        return motor
    gain, own, found = tried[0]
    if gain.size > CLEARLY:  # it may be the model to report: fitted as carefully as the other
        again = _refitted(problem, solver, keys, found.values, rough=True, moments=moments)
        better = gain_of(problem, own, fit, again[1])
        if better.size > gain.size:
            gain, own, found = better, *again
            tried[0] = (gain, own, found)
    alike = [f for g, _, f in tried if g.size > gain.size - CLEARLY]
    left = remainder(own, found)
    known_noise = left.evidence != "none" and not left.structured(left.gap)
    explains = problem.link is not None and gain.share > MOST_WITH_LINK and known_noise
    likely = math.hypot(*(found.values[k] for k in GRAVITY_KEYS)) < 3.0 * usual
    known = uncertainty_of(found, problem.rate_hz)
    alone = all(abs(f.values[k] - found.values[k]) < SEEN * known.std(k) for f in alike for k in keys)
    if gain.size > CLEARLY and likely and explains and alone and _gravity_sigmas(found, problem.rate_hz) > SEEN:
        notice = Notice(Code.EFFORT_GRAVITY_COMPENSATED, "motor_torque", {"gain": gain.size}, {"case": "found"})
        kind = KindFit(GRAVITY_COMPENSATED, own, found, (notice,))
        if gain.size > FAR:
            return kind
        # An eccentric link encoder has passed for it: the other fit stays in the uncertainty.
        other = np.array([fit.values.get(k, found.values[k]) - found.values[k] for k in found.free])
        size = len(found.free)
        return replace(kind, rival=other, open=np.zeros((size, size)))
    rivals = [np.array([f.values[k] - fit.values[k] for k in fit.free]) for f in alike]
    moved = max(rivals, key=lambda r: abs(float(r[fit.free.index("K")])))
    both = [found.free.index(k) for k in fit.free]
    return replace(motor, rival=moved, open=known.covariance[np.ix_(both, both)])


def _gravity_starts(problem: FitProblem, solver: SteadyFit, fit: Fit) -> list[dict[str, float]]:
    """Where fits of an effort without gravity start: the best of gravities of several sizes and directions.

    Such a torque is, to first order in gravity's stiffness k over K, that of a joint without gravity of a stiffness
    K - k and a link inertia smaller in the ratio of the squares: so the fit with the motor's torque lies in a valley
    along which gravity is open, with K and JL following. Only what is of second order in k, or a link encoder, tells.
    """
    values, here = fit.values, float(np.mean(problem.motion.position))
    many = [{**values, GRAVITY_REMOVED: 1.0}]
    for size in GRAVITY_SIZES:
        for angle in np.arange(GRAVITY_ANGLES) * 2.0 * math.pi / GRAVITY_ANGLES:
            moment = size * values["K"] / GRAVITY
            slope = -GRAVITY * moment * math.sin(here - angle)
            stiffness = values["K"] + slope
            ratio = (stiffness + slope) / values["K"]
            own = {"K": stiffness, "MX": moment * math.cos(angle), "MY": moment * math.sin(angle), "offset": 0.0}
            own |= {k: ratio * values[k] for k in ("JL", "FV", "FS") if k in values}
            many.append({**values, **own, GRAVITY_REMOVED: 1.0})
    rests = solver.whitened_residuals(many, fit.whitenings)
    costs = [float(r @ r) if np.isfinite(r).all() else math.inf for r in rests]
    order = sorted(range(len(many)), key=lambda i: costs[i])
    first = many[order[0]]
    # The next that lies elsewhere: of gravity that pulls the other way, if there is one.
    apart = next((many[i] for i in order[1:] if _pull(many[i], here) * _pull(first, here) < 0.0), many[order[1]])
    return [first, apart]


def _pull(values: Mapping[str, float], position: float) -> float:
    """Gravity's stiffness at a position over g, kg m."""
    return values.get("MY", 0.0) * math.cos(position) - values.get("MX", 0.0) * math.sin(position)


def _gravity_sigmas(fit: Fit, rate_hz: float) -> float:
    known = uncertainty_of(fit, rate_hz)
    ratios = [abs(fit.values[k]) / known.std(k) for k in GRAVITY_KEYS if known.std(k) > 0.0]
    return max(ratios, default=0.0)
