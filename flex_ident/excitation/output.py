"""The exciter's states, and what it says at each tick."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

State = Literal["idle", "moving_to_start", "exciting", "ramping_down", "done", "aborted"]
MOVING: tuple[State, ...] = ("moving_to_start", "exciting", "ramping_down")


@dataclass(frozen=True)
class Output:
    """What to do now: `command` and those of the `others` in the interface's unit, None: command nothing.

    `position`, rad, and `velocity`, rad/s, are the reference's; `progress` of the chirp is 0 to 1.
    """

    state: State
    command: float | None
    others: tuple[float, ...]
    position: float
    velocity: float
    progress: float
    reason: str
    safe: tuple[float, tuple[float, ...]] = (0.0, ())
    """What may be commanded for any length of time: of the joint and of the others."""
    lease_s: float = math.inf
    """How long the command may stand with nobody there to change it, s."""
