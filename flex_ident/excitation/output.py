"""The exciter's states, and what it says at each tick."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from flex_ident.excitation.holding import Hold

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
    hold: Hold | None = None
    """How the joints are to be held when nobody is there, where that takes feedback."""
    seen: float | None = None
    """Where the joint was seen for the command, rad; None: nowhere that is to be believed."""
    left: bool = False
    """Whether the guard holds the joints by now, and is to be left alone: the command is for the case that it died."""
