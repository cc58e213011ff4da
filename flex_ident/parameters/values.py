"""A model's parameter values under their written keys: what fits start from, move and end with."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from flex_ident.parameters.keys import key_parts, key_text
from flex_ident.recording.recording import Floats

_Parts = tuple["Values", Mapping[str, Mapping[str, float]]]


class Values(Mapping[str, float]):
    """Values of base (`K`), measurement (`torque_delay`) and effect (`backlash.gap`) keys, in the units of the keys.

    They keep the order in which they were given and never change; equal ones have equal hashes, in whatever order.
    A key that is not there is one that the model does not have: where it would add to something it counts as zero.
    """

    __slots__ = ("_hash", "_own", "_parts")

    def __init__(self, values: Mapping[str, float] | None = None) -> None:
        self._own: dict[str, float] = {} if values is None else dict(values)
        self._hash: int | None = None
        self._parts: _Parts | None = None

    @classmethod
    def of_effect(cls, effect: str, parameters: Mapping[str, float]) -> Values:
        """An effect's parameters, given by name, under their written keys."""
        return cls({key_text(effect, name): value for name, value in parameters.items()})

    def __getitem__(self, key: str) -> float:
        return self._own[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._own)

    def __len__(self) -> int:
        return len(self._own)

    def __contains__(self, key: object) -> bool:
        return key in self._own

    def __eq__(self, other: object) -> bool:
        if isinstance(other, Values):
            return self._own == other._own
        return self._own == dict(other) if isinstance(other, Mapping) else NotImplemented

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash(frozenset(self._own.items()))
        return self._hash

    def __reduce__(self) -> tuple[type[Values], tuple[dict[str, float]]]:
        # Without the hash: that of a string differs from process to process.
        return Values, (self._own,)

    def __repr__(self) -> str:
        return f"Values({self._own})"

    def __or__(self, other: Mapping[str, float]) -> Values:
        """These values with those of `other` in their place, or behind them where they are new."""
        return Values({**self._own, **other})

    def without(self, keys: Container[str]) -> Values:
        """The values of all other keys."""
        return Values({key: value for key, value in self._own.items() if key not in keys})

    def only(self, keys: Container[str]) -> Values:
        """The values of those of the keys that are there, in the order of the values."""
        return Values({key: value for key, value in self._own.items() if key in keys})

    def vector(self, keys: Sequence[str]) -> Floats:
        """The values of the keys (p,), zero for a key that is not there."""
        return np.array([self._own.get(key, 0.0) for key in keys], float)

    def with_vector(self, keys: Sequence[str], numbers: Floats) -> Values:
        """These values with the numbers (p,) for the keys. Raises ValueError where there are not as many."""
        return self | dict(zip(keys, map(float, numbers), strict=True))

    @property
    def base(self) -> Values:
        """The values of base and measurement keys."""
        return self._apart[0]

    @property
    def effects(self) -> Mapping[str, Mapping[str, float]]:
        """The parameters of each effect by name, read-only, under the effect's name."""
        return self._apart[1]

    @property
    def _apart(self) -> _Parts:
        """Base values and effects, taken apart the first time that they are asked for."""
        if self._parts is None:
            base: dict[str, float] = {}
            effects: dict[str, dict[str, float]] = {}
            for text, value in self._own.items():
                effect, name = key_parts(text)
                own = base if effect is None else effects.setdefault(effect, {})
                own[name] = value
            frozen = {effect: MappingProxyType(own) for effect, own in effects.items()}
            self._parts = Values(base), MappingProxyType(frozen)
        return self._parts
