"""The fit under one kind of effort, and how far a kind that the recording cannot tell from it would move the joint."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from flex_ident.estimation.kind_priors import friction_keys, kept_priors
from flex_ident.judgement.rules import ESSENTIAL
from flex_ident.judgement.thresholds import WEAK_PERCENT
from flex_ident.likelihood.covariance import Uncertainty
from flex_ident.likelihood.fit import Fit, Prior, SimulationFit
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.notices import Notice
from flex_ident.parameters import GRAVITY_KEYS, UNITS, Parameter
from flex_ident.parameters.effort_kinds import (
    FRICTION_COMPENSATED,
    FRICTION_REMOVED,
    GRAVITY_COMPENSATED,
    JOINT_SENSOR,
    MOTOR_KEYS,
    REVERSAL_KEYS,
    EffortKind,
)  # fmt: skip
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.simulation.terms import GRAVITY

SCALED = ("Jm", "K", "JL", "FVm", "FSm", "FV", "FS")
USUAL_ADDED, SLOW_S, SHAPE_KNOWN = 0.3, 0.01, 0.02
"""Share of the torque, rms, that viscous friction usually takes; time by which a controller's gravity may be late, one
standard deviation; share of the dry friction it adds by which its shape at reversals may pass for the link's. Set by
hand, the last two on an adversary's joints (a low-pass of 20 ms: FVm 6 standard deviations off; one of 2 ms on the
speed that friction was taken at: FS 9)."""
ROUGH_ROUNDS = ((12, 1e-3), (10, 1e-4))
ROUNDS = ((12, 1e-4), (10, 1e-6))


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
    frictionless: bool = False
    """Whether the motor's side rubs so little that a controller may add what its friction takes."""

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
        asked = (*ESSENTIAL, *GRAVITY_KEYS)
        sizes = [float(d) / max(uncertainty.std(k), 1e-300) for k, d in moved if k in asked]
        weak = any(
            float(np.hypot(d, uncertainty.std(k))) > 0.01 * WEAK_PERCENT * abs(self.fit.values[k])
            for k, d in zip(self.fit.free, np.sqrt(self.rival**2 + np.diag(self.open)), strict=True)
            if k in ESSENTIAL
        )
        return replace(self, unclear=max(sizes, default=0.0) > 1.96, matters=weak)

    def joined(self, uncertainty: Uncertainty) -> Uncertainty:
        """The uncertainty joined with what the rival would move.

        Of an effort less what the controller adds also with what its clock leaves open: gravity taken at a position
        that is up to a sample older or newer than the torque looks like viscous friction of the motor, and viscous
        friction taken at such a speed like inertia. Gravity at the position that is wanted, from which the joint is as
        far as the torque over the stiffness of its loop, scales all forces: a loop is about as stiff as the spring.
        """
        sample = self.solver.problem.recording.sample_time
        late = {"FVm": GRAVITY * self._slope_added() * math.hypot(sample, SLOW_S)}
        if self.kind == FRICTION_COMPENSATED or self.frictionless:
            late |= dict.fromkeys(("Jm", "J"), self._viscous_added(uncertainty) * sample)
        if self.kind == FRICTION_COMPENSATED and FRICTION_REMOVED in self.fit.free:
            late["FS"] = SHAPE_KNOWN * self.fit.values[FRICTION_REMOVED]
        extra = np.diag([late.get(key, 0.0) ** 2 for key in self.fit.free])
        if self.kind == GRAVITY_COMPENSATED and "K" in self.fit.free:
            scale = GRAVITY * self._slope_added() / self.fit.values["K"]
            forces = np.array([self.fit.values[k] if k in SCALED else 0.0 for k in self.fit.free])
            extra += scale**2 * np.outer(forces, forces)
        uncertainty = replace(uncertainty, covariance=uncertainty.covariance + extra)
        if self.rival is None or self.open is None:
            return uncertainty
        joined = uncertainty.covariance + np.outer(self.rival, self.rival) + self.open
        return replace(uncertainty, covariance=joined)

    def _slope_added(self) -> float:
        """Stiffness, over g, kg m, of the gravity that the controller adds, or may add for all that the fit tells."""
        if self.kind == GRAVITY_COMPENSATED:
            return gravity_slope(self.fit.values, float(np.mean(self.solver.problem.motion.position)))
        if self.rival is None or self.open is None:
            return 0.0
        apart = np.sqrt(self.rival**2 + np.diag(self.open))
        return max((float(d) for k, d in zip(self.fit.free, apart, strict=True) if k in GRAVITY_KEYS), default=0.0)

    def _viscous_added(self, uncertainty: Uncertainty) -> float:
        """Viscous friction that the controller may add, N m s/rad: at the rms speed as much as the dry friction that
        it is seen to add, or a share of the torque where that is not seen."""
        problem = self.solver.problem
        torque, speed = float(np.std(problem.torque[problem.usable])), float(np.std(problem.motion.velocity))
        dry = USUAL_ADDED * torque
        if FRICTION_REMOVED in self.fit.free and uncertainty.std(FRICTION_REMOVED) < self.fit.values[FRICTION_REMOVED]:
            dry = self.fit.values[FRICTION_REMOVED]
        return dry / max(speed, 1e-300)


def refitted(
    problem: FitProblem,
    solver: SteadyFit,
    keys: Sequence[str],
    start: Values,
    *,
    rough: bool = False,
    moments: Mapping[str, Prior] | None = None,
) -> tuple[SteadyFit, Fit]:
    """The fit over other keys, from values near its optimum, or `rough` ones, with what is known of the first `moments`
    beforehand. Raises ExcitationError."""
    priors = {**kept_priors(solver.priors, keys), **(moments or {})}
    keys = [k for k in keys if k not in priors]
    values = start.without([k for k in REVERSAL_KEYS if k not in priors])
    own = SteadyFit(problem, priors=priors, marks=solver.marks, local=solver.local)
    if rough:
        first = SimulationFit(problem, priors=priors)
        few = (*keys, *(k for k in priors if k not in REVERSAL_KEYS))
        for iterations, tolerance in ROUGH_ROUNDS:
            found = first.solve(few, values, first.whitenings(values), iterations=iterations, tolerance=tolerance)
            values = found.values
    fit: Fit | None = None
    for iterations, tolerance in ROUNDS:
        fit = own.solve((*keys, *priors), values, own.whitenings(values), iterations=iterations, tolerance=tolerance)
        values = fit.values
    assert fit is not None
    return own, fit


def gravity_slope(values: Values, position: float) -> float:
    """Gravity's stiffness at a position over g, kg m."""
    return values.get("MY", 0.0) * math.cos(position) - values.get("MX", 0.0) * math.sin(position)
