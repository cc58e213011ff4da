"""An effect with the values that the other recordings of a set found, to be tried on one of them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from flex_ident.effects import effect_named
from flex_ident.gap.carried import Carried
from flex_ident.gap.shared import Proposal
from flex_ident.parameters import Identification, Parameter
from flex_ident.parameters.keys import key_parts
from flex_ident.parameters.values import Values
from flex_ident.pooling.combining import pooled


def carried_from_others(proposal: Proposal, results: Sequence[Identification], here: int) -> Carried | None:
    """The effect with the values that recordings other than `here` found; None where no other found it.

    Each value is the mean over them, their scatter in the weights; angles are the recording's own.
    """
    others = [i for i in proposal.finders if i != here]
    if not others:
        return None
    known: dict[str, list[Parameter]] = {}
    for i in others:
        for p in proposal.own(results[i]):
            known.setdefault(p.key, []).append(p)
    if not known:
        return None
    values = Values({key: _mean(own) for key, own in known.items()})
    angles = tuple(k for k in values if effect_named(proposal.effect).parameter(key_parts(k)[1]).angle)
    return Carried(proposal.effect, values, angles)


def its_own(proposal: Proposal, result: Identification) -> Carried:
    """The effect as the recording itself has it, all values to be fitted."""
    values = Values({p.key: p.value for p in proposal.own(result)})
    return Carried(proposal.effect, values, tuple(values))


def _mean(parameters: Sequence[Parameter]) -> float:
    sure = [p for p in parameters if math.isfinite(p.std) and p.std > 0.0]
    if not sure:
        return float(np.mean([p.value for p in parameters]))
    return pooled(np.array([p.value for p in sure]), np.array([p.std for p in sure])).value


def base_values(result: Identification) -> Values:
    """The joint's own parameters in a result, from which a fit may start."""
    return Values({p.key: p.value for p in result.parameters if math.isfinite(p.value)}).base
