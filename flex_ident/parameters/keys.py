"""A parameter's key: what it belongs to, what physics allows it and how it is fitted; and how it is written.

Written out, in model.yaml, JSON, on the command line and in flat mappings of values, it is `K` or `backlash.gap`.
Nothing but this module takes that apart or puts it together.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Side = Literal["motor", "spring", "link", "both", "measurement"]
"""Where a term acts. What acts on the motor alone, or on what is recorded, leaves the link's motion as it is."""


@dataclass(frozen=True)
class Key:
    """One parameter of the model (`effect` None), of the measurement chain (likewise) or of an effect."""

    effect: str | None
    name: str
    unit: str
    lower: float
    upper: float
    logarithmic: bool
    """Fitted by its logarithm: positive by construction, and a factor is a factor."""
    is_force: bool
    """Scales with force: such keys, all together, leave the link's motion as it is."""
    side: Side

    def __str__(self) -> str:
        """The key as it is written."""
        return key_text(self.effect, self.name)


def key_parts(text: str) -> tuple[str | None, str]:
    """The effect of a written key, None for a base or measurement key, and the name."""
    effect, dot, name = text.partition(".")
    return (effect, name) if dot else (None, text)


def key_text(effect: str | None, name: str) -> str:
    """The key as it is written."""
    return name if effect is None else f"{effect}.{name}"


def effect_in(text: str) -> str | None:
    """The effect that a written key belongs to; None for a base or measurement key."""
    return key_parts(text)[0]


def flat_keys(effect: str | None, values: Mapping[str, float]) -> dict[str, float]:
    """Values by name, of one effect or of the model (None), under their written keys."""
    return {key_text(effect, name): value for name, value in values.items()}


def by_effect(values: Mapping[str, float]) -> tuple[dict[str, float], dict[str, dict[str, float]]]:
    """Values under written keys apart: those of no effect, and those of each effect by name."""
    base: dict[str, float] = {}
    effects: dict[str, dict[str, float]] = {}
    for text, value in values.items():
        effect, name = key_parts(text)
        own = base if effect is None else effects.setdefault(effect, {})
        own[name] = value
    return base, effects
