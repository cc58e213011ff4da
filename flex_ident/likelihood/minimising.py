"""Levenberg and Marquardt within bounds: few Jacobians, and no slowing down beside a bound."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from flex_ident.recording import Floats

FIRST_DAMPING = 1e-12
LARGEST_DAMPING = 1e6
ATTEMPTS = 9
"""Trial steps from one point, each more damped, before the search gives up."""


def bounded_minimum(
    residual: Callable[[Floats], Floats],
    jacobian: Callable[[Floats], Floats],
    start: Floats,
    lower: Floats,
    upper: Floats,
    *,
    iterations: int,
    tolerance: float,
    linearised: bool = True,
) -> tuple[Floats, Floats, Floats, bool]:
    """Where the sum of squares is least from `start` (p,) within the bounds: x, residual (r,), Jacobian (r, p), and
    whether it ended there by itself.

    Ends after as many steps as `iterations`, or when one saves less than `tolerance` of the sum. A variable that
    reaches its bound stays there as long as the gradient holds it; the others move as if it were fixed. Without
    `linearised` the Jacobian is that of the last step's start.
    """
    x = np.clip(start, lower, upper)
    rest = residual(x)
    cost = float(rest @ rest)
    slope = jacobian(x)
    damping, converged = FIRST_DAMPING, False
    for i in range(iterations):
        scale = np.linalg.norm(slope, axis=0)
        scale[scale == 0.0] = 1.0
        triangle, target = _reduced(slope / scale, rest)
        gain = 0.0
        for _attempt in range(ATTEMPTS):
            moved = _step(triangle, target, damping, x * scale, lower * scale, upper * scale) / scale
            moved = np.clip(moved, lower, upper)
            there = residual(moved)
            now = float(there @ there)
            if now < cost:
                gain, x, rest, cost = cost - now, moved, there, now
                damping = max(0.1 * damping, FIRST_DAMPING)
                break
            damping = max(10.0 * damping, 1e-5)
            if damping > LARGEST_DAMPING:
                break
        converged = gain == 0.0 or gain < tolerance * cost
        if gain == 0.0:
            break
        last = converged or i == iterations - 1
        if linearised or not last:
            slope = jacobian(x)
        if last:
            break
    return x, rest, slope, converged


def _reduced(slope: Floats, rest: Floats) -> tuple[Floats, Floats]:
    """Triangular factor (p, p) and right-hand side (p,) of the linear least squares problem slope step = -rest."""
    q, r = np.linalg.qr(slope)
    return r, -(q.T @ rest)


def _step(triangle: Floats, target: Floats, damping: float, x: Floats, lower: Floats, upper: Floats) -> Floats:
    """The damped Gauss-Newton point within bounds, in scaled units; bounds that hold are found one by one."""
    p = x.size
    fixed: NDArray[np.bool_] = np.zeros(p, bool)
    moved = x.copy()
    for _ in range(p):
        free = ~fixed
        if not free.any():
            break
        known = target - triangle[:, fixed] @ (moved - x)[fixed]
        matrix = np.vstack((triangle[:, free], np.sqrt(damping) * np.eye(int(free.sum()))))
        step = np.linalg.lstsq(matrix, np.concatenate((known, np.zeros(int(free.sum())))), rcond=1e-12)[0]
        moved[free] = x[free] + step
        beyond = free & ((moved < lower) | (moved > upper))
        if not beyond.any():
            break
        moved = np.where(beyond, np.clip(moved, lower, upper), moved)
        fixed |= beyond
    return moved
