"""Levenberg and Marquardt within bounds: few Jacobians, and no slowing down beside a bound."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flex_ident.recording import Floats

FIRST_DAMPING = 1e-12
LARGEST_DAMPING = 1e6
ATTEMPTS = 9
"""Trial steps from one point, each more damped, before the search gives up."""
AS_FORETOLD = 0.5
"""Share of the foretold saving from which a Jacobian still holds and serves for the next step as well: chord steps cost
a residual each where a Jacobian costs one for each variable."""
DAMPINGS_WITHOUT = (FIRST_DAMPING, 1e-5, 1e-3, 1e-1)
"""How steps without a variable in which there is a kink are damped, in turn."""
BLOCK_ROWS = 128
CHORDS = 4
"""Steps in a row that one Jacobian may serve."""


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

    Ends after as many Jacobians as `iterations`, or when a step with a Jacobian of its own saves no more than
    `tolerance` of the sum. A Jacobian serves several steps as long as they save what it foretells. A variable that
    reaches its bound stays there as long as the gradient holds it; the others move as if it were fixed. A variable in
    which the sum has a kink spoils every step: where no step saves anything, each variable is held in turn, and the one
    without which most is saved is held from then on. The Jacobian is that of the start of the last step, if that was
    small, or without `linearised`; else that of its end.
    """
    x = np.clip(start, lower, upper)
    rest = residual(x)
    cost = float(rest @ rest)
    slope, served = jacobian(x), 0
    damping, used = FIRST_DAMPING, 1
    held: NDArray[np.bool_] = np.zeros(x.size, bool)
    while True:
        scale = np.linalg.norm(slope, axis=0)
        scale[scale == 0.0] = 1.0
        triangle, target = _reduced(slope / scale, rest)
        gain, foretold, fresh, start = 0.0, 0.0, served == 0, x
        for _attempt in range(ATTEMPTS):
            moved = _step(triangle, target, damping, x * scale, lower * scale, upper * scale, held) / scale
            moved = np.clip(moved, lower, upper)
            there = residual(moved)
            now = float(there @ there)
            if now < cost:
                foretold = _foretold(triangle, target, (moved - x) * scale)
                gain, x, rest, cost = cost - now, moved, there, now
                damping = max(0.1 * damping, FIRST_DAMPING)
                break
            if not fresh:
                break
            damping = max(10.0 * damping, 1e-5)
            if damping > LARGEST_DAMPING:
                break
        served += 1
        if gain == 0.0 and fresh:
            whole = _step(triangle, target, FIRST_DAMPING, start * scale, lower * scale, upper * scale, held)
            if _foretold(triangle, target, whole - start * scale) <= tolerance * cost:
                return x, rest, slope, True  # nothing is left to save, kink or not
            for damped in DAMPINGS_WITHOUT:
                for j in np.flatnonzero(~held):
                    without = held | (np.arange(x.size) == j)
                    moved = _step(triangle, target, damped, start * scale, lower * scale, upper * scale, without)
                    moved = np.clip(moved / scale, lower, upper)
                    there = residual(moved)
                    now = float(there @ there)
                    if now < cost:
                        kink, gain, x, rest, cost = j, gain + cost - now, moved, there, now
                if gain > tolerance * cost:
                    held[kink], damping = True, damped
                    break
        small = gain <= tolerance * cost
        if small and fresh:
            return x, rest, slope, True
        if not small and served < CHORDS and gain >= AS_FORETOLD * foretold:
            continue
        if used == iterations:
            return x, rest, jacobian(x) if linearised else slope, False
        slope, served, used = jacobian(x), 0, used + 1


def _foretold(triangle: Floats, target: Floats, step: Floats) -> float:
    """What a step, in scaled units, saves of the sum of squares if the Jacobian holds."""
    moved = triangle @ step
    return float(2.0 * target @ moved - moved @ moved)


def _reduced(slope: Floats, rest: Floats) -> tuple[Floats, Floats]:
    """Triangular factor (p, p) and right-hand side (p,) of the linear least squares problem slope step = -rest.

    Of blocks of rows first and then of their factors: blocks that the processor's cache holds, and that no BLAS splits
    among threads, which took fifty times as long where other processes kept the cores busy.
    """
    rows, p = np.column_stack((slope, -rest)), slope.shape[1]
    size = max(BLOCK_ROWS, 4 * (p + 1))
    while rows.shape[0] > 2 * size:
        whole = rows.shape[0] // size
        blocks = rows[: whole * size].reshape(whole, size, p + 1)
        rows = np.concatenate((_triangle(blocks).reshape(-1, p + 1), rows[whole * size :]))
    triangle = _triangle(rows)
    return triangle[:p, :p], triangle[:p, p]


def _triangle(rows: Floats) -> Floats:
    """The triangular factor alone, of each matrix."""
    factor: Any = np.linalg.qr(rows, mode="r")  # numpy's types know the whole factorisation only
    return np.asarray(factor)


def _step(
    triangle: Floats, target: Floats, damping: float, x: Floats, lower: Floats, upper: Floats, held: NDArray[np.bool_]
) -> Floats:
    """The damped Gauss-Newton point within bounds, in scaled units; bounds that hold are found one by one."""
    p = x.size
    fixed = held.copy()
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
