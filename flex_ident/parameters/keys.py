"""A parameter's key: what it belongs to, what physics allows it and how it is fitted; and how it is written.

Written out, in model.yaml, JSON, on the command line and in `Values`, it is `K` or `backlash.gap`.
Nothing but this module takes that apart or puts it together.
"""

from __future__ import annotations

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
