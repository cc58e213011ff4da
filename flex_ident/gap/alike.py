"""Effects that several recordings of one joint show, under the same keys in each.

A recording numbers the harmonics of what is periodic by their size, and gives an angle up to whole turns.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from flex_ident.effects import CATALOGUE, Effect
from flex_ident.parameters import Covariance, Identification, Parameter
from flex_ident.parameters.keys import key_parts, key_text

SAME_CYCLES = 0.02
"""Relative difference of the periods in a turn under which two harmonics are one. Set by hand."""


def aligned(results: Sequence[Identification]) -> list[Identification]:
    """The results with harmonics numbered alike, and angles within half a turn of those of the first that has them."""
    found = list(results)
    for effect in CATALOGUE.values():
        if len(effect.again) > 1:
            found = _renumbered(found, effect)
    known: dict[str, float] = {}
    return [_turned(result, known) for result in found]


def _renumbered(results: Sequence[Identification], effect: Effect) -> list[Identification]:
    numbers: dict[str, float] = {}
    found = []
    for result in results:
        own = {
            s: next((p.value for p in result.parameters if p.key == key_text(effect.name, effect.cycles + s)), None)
            for s in effect.again
        }
        names: dict[str, str] = {}
        free = [s for s in effect.again if s not in numbers]
        for suffix, cycles in own.items():
            if cycles is None:
                continue
            near = [s for s, c in numbers.items() if s not in names.values() and abs(c / cycles - 1.0) < SAME_CYCLES]
            if near:
                names[suffix] = min(near, key=lambda s: abs(numbers[s] / cycles - 1.0))
            elif free:
                names[suffix] = free.pop(0)
                numbers[names[suffix]] = cycles
        keys = {
            key_text(effect.name, p.name): key_text(effect.name, p.name[: len(p.name) - len(s)] + names[s])
            for p in effect.parameters for s in [_suffix(p.name, effect.again)] if s in names
        }  # fmt: skip
        found.append(_renamed(result, keys))
    return found


def _suffix(name: str, suffixes: Sequence[str]) -> str:
    return next((s for s in suffixes if s and name.endswith(s)), "")


def _renamed(result: Identification, keys: Mapping[str, str]) -> Identification:
    if all(old == new for old, new in keys.items()):
        return result
    parameters = tuple(replace(p, key=keys.get(p.key, p.key)) for p in result.parameters)
    known = result.covariance
    if known is not None:
        known = Covariance(tuple(keys.get(k, k) for k in known.keys), known.matrix, known.systematic)
    return replace(result, parameters=parameters, covariance=known)


def _turned(result: Identification, known: dict[str, float]) -> Identification:
    """The result with each angle turned by whole turns towards that in `known`, where the first of each is noted."""
    return replace(result, parameters=tuple(_nearest(p, known) for p in result.parameters))


def _nearest(p: Parameter, known: dict[str, float]) -> Parameter:
    effect, name = key_parts(p.key)
    if effect is None or not CATALOGUE[effect].parameter(name).angle:
        return p
    first = known.setdefault(p.key, math.remainder(p.value, 2.0 * math.pi))
    turn = first + math.remainder(p.value - first, 2.0 * math.pi) - p.value
    ends = None if p.ci95 is None else (p.ci95[0] + turn, p.ci95[1] + turn)
    return replace(p, value=p.value + turn, ci95=ends)
