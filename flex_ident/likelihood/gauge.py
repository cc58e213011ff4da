"""What of a measured curve base keys can do as well: which of both has it is agreed on, and no data can tell.

The curve has none of it, in the mean over its points: that is where the priors on its torques put the optimum, by their
being alike, and what is left open there is no uncertainty of either. A key at its bound cannot take its share.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from flex_ident.effects import CATALOGUE
from flex_ident.effects.curve import TORQUE
from flex_ident.parameters.keys import key_text
from flex_ident.parameters.prior import Prior
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats

AGREED = 1e-3
"""Standard deviation of what is agreed on, over that of the torque at a point."""
ALIKE = 1e-3
"""Singular value, over the largest, of shapes that are one and the same at all points."""


def gauge_information(
    keys: Sequence[str], values: Values, at_bound: Sequence[str], priors: Mapping[str, Prior]
) -> Floats:
    """Information (p, p) on the keys that says so, for all curves in the model; nothing where there is none."""
    found = np.zeros((len(keys), len(keys)))
    for name, own in values.effects.items():
        curve = CATALOGUE[name].curve
        torques = [] if curve is None else [key_text(name, f"{TORQUE}_{n}") for n in curve.points_in(own)]
        if curve is None or not set(torques) <= set(keys):
            continue
        at, _ = curve.table_in(own)
        index = [keys.index(k) for k in torques]
        held = curve.held_by([k for k in keys if k not in at_bound], at, rigid="J" in values)
        if not held:
            continue
        shapes = np.column_stack([curve.centred(shape) for shape in held.values()])
        rows, size, _ = np.linalg.svd(shapes / np.linalg.norm(shapes, axis=0), full_matrices=False)
        rows = rows[:, size > ALIKE * size[0]]
        std = AGREED * priors[torques[0]].std if torques[0] in priors else AGREED
        found[np.ix_(index, index)] += rows @ rows.T / std**2
    return found


def agreed(keys: Sequence[str], values: Values, bounds: Callable[[str], tuple[float, float]]) -> Values:
    """The values with each curve's share of what base keys can do handed over to them, as far as their bounds allow."""
    found = values
    for name, own in values.effects.items():
        curve = CATALOGUE[name].curve
        if curve is None:
            continue
        at, torque = curve.table_in(own)
        if not {key_text(name, f"{TORQUE}_{n}") for n in curve.points_in(own)} <= set(keys):
            continue
        held = curve.held_by(keys, at, rigid="J" in values)
        while held:
            shapes = np.column_stack(list(held.values()))
            solution = np.linalg.lstsq(curve.centred(shapes), curve.centred(torque), rcond=ALIKE)[0]
            sizes = dict(zip(held, solution, strict=True))
            moved = {k: found[k] + size for k, size in sizes.items()}
            beyond = [k for k, value in moved.items() if not bounds(k)[0] <= value <= bounds(k)[1]]
            if not beyond:
                break
            held.pop(beyond[0])
        else:
            continue
        rest = torque - shapes @ np.array(list(sizes.values()))
        found = found | moved | Values.of_effect(name, curve.parameters_of(at, rest))
    return found


def prior_root(information: Floats) -> Floats:
    """Rows (k, p) whose squares are an information (p, p): what is known beforehand as so many residuals."""
    size = np.sqrt(np.diag(information))
    if not (information - np.diag(size**2)).any():
        return np.diag(size)
    scale = np.where(size > 0.0, size, 1.0)
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    root: Floats = (vectors * np.sqrt(np.maximum(values, 0.0))).T * scale
    return root
