"""What effects that may be in any joint, and that base keys can imitate, do to them where the recording is silent.

A spring to ground, or a balancing spring on a lever, is over a small range of motion what gravity is: first moments
and constant torque follow it, and nothing is left to show it. A spring that loses a little of what it stores damps the
mode as viscous friction of motor and link does. With M what the parameters follow by, D what is left of
the effect then (whitened, a column each at one standard deviation) and r the residual, the amplitudes have the
covariance P = (1 + D'D)^-1 and the mean P D'r, and the parameters are open by M (P + mean mean') M'.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from flex_ident.effects import CATALOGUE, Probe
from flex_ident.estimation.thresholds import LOSS_MATTERS, MOST_OF_IT, NOTED_OF_ALL, NOTED_SHARE, NOTED_STDS
from flex_ident.likelihood.comparison import correlation_factor
from flex_ident.likelihood.covariance import Uncertainty
from flex_ident.likelihood.fit import Fit
from flex_ident.likelihood.steady import SteadyFit
from flex_ident.notices import Code, Notice
from flex_ident.parameters import GRAVITY_KEYS
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.screening.scoring import following_of, whitened_change

LOSS_KEYS, LOST_IN = ("FV", "FVm"), ("FV", "FVm", "Jm")
"""Frictions by which a loss is judged, and what it is taken for."""
PROBE = 1e-3
"""Share of one standard deviation that is simulated."""


def unseen_stds(solver: SteadyFit, fit: Fit, where: str) -> dict[str, float]:
    """What effects `where` they act leave open of each free key, one standard deviation; nothing where none may be."""
    opened = unseen_covariance(solver, fit, where)
    if opened is None:
        return {}
    return dict(zip(fit.free, map(float, np.sqrt(np.maximum(np.diag(opened), 0.0))), strict=True))


def unseen_covariance(solver: SteadyFit, fit: Fit, where: str) -> Floats | None:
    """What effects `where` they act leave open of the free keys, (p, p); None where none may be."""
    sizes: list[Values] = []
    for name, effect in CATALOGUE.items():
        apart = (effect.needs_spring and solver.problem.rigid) or (effect.needs_link and solver.problem.link is None)
        if effect.unseen is not None and effect.where == where and not apart:
            sizes += [_small(name, probe) for probe in effect.unseen(fit.values)]
    if not sizes:
        return None
    columns = np.column_stack([whitened_change(solver, fit, one) for one in sizes]) / PROBE
    if not np.isfinite(columns).all():
        return None
    return opened_by(fit, columns)


def opened_by(fit: Fit, columns: Floats) -> Floats:
    """What is left open (p, p) of the free keys by what changes the whitened residual by `columns` (r, k), at one
    standard deviation each."""
    moves = following_of(fit) @ columns
    left = columns + fit.jacobian @ moves
    correlated = correlation_factor(fit)
    spread = np.linalg.inv(np.eye(columns.shape[1]) + left.T @ left / correlated)
    mean = -spread @ (left.T @ fit.residual) / correlated
    opened: Floats = moves @ (spread + np.outer(mean, mean)) @ moves.T
    return opened


def _small(name: str, probe: Probe) -> Values:
    """A share of an effect, in proportion."""
    column = probe.columns[0]
    return Values.of_effect(name, {k: PROBE * v if k in probe.scaled else v for k, v in column.items()})


def loss_error(key: str, values: Values, lossy: Mapping[str, float]) -> float:
    """Standard deviation of viscous friction and the motor's inertia for a loss of the spring that nobody sees, where
    its share of one of the frictions matters.

    Below, friction is what the model without loss calls it: in all of it, FV of clean recordings would be ten times as
    uncertain as it is off (`bench/coverage.py`, seed 251). What one friction gains the other loses: FVm of a series
    elastic joint was 5 % off, 46 standard deviations, where FV was 41 % off and its interval held that (seed 493).
    """
    return lossy.get(key, 0.0) if key in LOST_IN and any(_matters(k, values, lossy) for k in LOSS_KEYS) else 0.0


def _matters(key: str, values: Values, lossy: Mapping[str, float]) -> bool:
    value = abs(values.get(key, 0.0))
    return 0.0 < LOSS_MATTERS * value < lossy.get(key, 0.0)


def loss_notices(lossy: Mapping[str, float], values: Values) -> Iterator[Notice]:
    """That the interval of viscous friction holds a loss of the spring."""
    for key in LOSS_KEYS:
        if _matters(key, values, lossy):
            yield Notice(Code.LOSS_UNSEEN, key, {"moved_percent": 100.0 * lossy[key] / abs(values[key])})


def gravity_notice(unseen: Mapping[str, float], fit: Fit, known: Uncertainty) -> Notice | None:
    """By how much the larger first moment would be off beside a cable that nobody sees; None where its interval holds
    that, and for a model that has one.

    In the intervals instead, it made MX and MY of all clean recordings uncertain by a tenth.
    """
    moments = [k for k in GRAVITY_KEYS if fit.values.get(k, 0.0) != 0.0 and 0.0 < known.std(k) < math.inf]
    if not moments or fit.values.effects:
        return None
    key = max(moments, key=lambda k: abs(fit.values[k]))
    moved, std = unseen.get(key, 0.0), known.std(key)
    if not moved > max(NOTED_STDS * std, NOTED_SHARE * abs(fit.values[key])):
        return None
    sizes = {"moved_percent": 100.0 * moved / abs(fit.values[key]), "moved_stds": moved / std}
    return Notice(Code.GRAVITY_TAKEN_ALONE, key, sizes)


def encoder_notice(eccentric: Mapping[str, float], fit: Fit, known: Uncertainty) -> Notice | None:
    """That most of the interval of a first moment is what an error of the link encoder that nobody sees would do; None
    where it is not, or little of all gravity."""
    moments = [k for k in GRAVITY_KEYS if fit.values.get(k, 0.0) != 0.0 and 0.0 < known.std(k) < math.inf]
    if not moments or not eccentric:
        return None
    key = max(moments, key=lambda k: eccentric.get(k, 0.0) / known.std(k))
    moved, whole = eccentric.get(key, 0.0), math.hypot(*(fit.values[k] for k in moments))
    if not moved > max(MOST_OF_IT * known.std(key), NOTED_OF_ALL * whole):
        return None
    return Notice(Code.ENCODER_TAKEN_AS_TRUE, key, {"moved": moved})
