"""Residuals, torques and fits that are made up: what the rules are tested with, without a simulation."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flex_ident.filtering.spectral import SpectralFilter
from flex_ident.likelihood.fit import Fit
from flex_ident.parameters.values import Values

Floats = NDArray[np.float64]
RATE, CUTOFF, DECIMATION, SECONDS = 1000.0, 30.0, 10, 40
TIME: Floats = np.arange(SECONDS * int(RATE)) / RATE


def white(seed: int = 0, size: int = TIME.size) -> Floats:
    return np.random.default_rng(seed).standard_normal(size)


def reduced(signal: Floats, decimation: int = DECIMATION) -> Floats:
    """A signal at `RATE` as a problem compares it."""
    return SpectralFilter(signal.size, RATE, CUTOFF, decimation=decimation)(signal)[0]


def problem(
    torque: Floats, position: Floats | None = None, *, rate_hz: float = RATE, decimation: int = DECIMATION,
    residual: Floats | None = None,
) -> Any:  # fmt: skip
    """What of a `FitProblem` the rules about noise ask for; `residual` is the torque's at any values."""
    filtered = reduced(torque, decimation) if rate_hz == RATE else torque[::decimation]
    moved = np.cumsum(white(99, torque.size)) if position is None else position
    return SimpleNamespace(
        recording=SimpleNamespace(motor_torque=torque, motor_position=moved, sample_rate_hz=rate_hz, reference=None),
        motion=SimpleNamespace(position=moved, velocity=np.ones(moved.size), acceleration=np.zeros(moved.size)),
        resolution=0.0, resting_speed=0.0, decimation=decimation, rate_hz=rate_hz / decimation,
        cutoff_hz=CUTOFF, band_hz=CUTOFF / 1.2, torque=filtered, usable=np.ones(filtered.size, bool),
        time=np.arange(filtered.size) * decimation / rate_hz,
        residuals=lambda _values: (filtered if residual is None else residual,),
    )  # fmt: skip


def linear_fit(matrix: Floats, target: Floats, *, prior: Floats | None = None, at_bound: tuple[str, ...] = ()) -> Fit:
    """The optimum of |target - matrix x|^2 with every key free, residual `target - matrix x`, as a fit holds it.

    `prior` (p,): information of independent priors of mean zero.
    """
    p = matrix.shape[1]
    information = np.zeros(p) if prior is None else prior
    x = np.linalg.solve(matrix.T @ matrix + np.diag(information), matrix.T @ target)
    rest = target - matrix @ x
    keys = tuple(f"k{i}" for i in range(p))
    return Fit(
        keys, Values().with_vector(keys, x), -matrix, rest, (np.arange(target.size),),
        np.diag(information), (), at_bound, 0.5 * float(rest @ rest),
    )  # fmt: skip
