"""How to excite a joint."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from flex_ident.errors import ConfigurationError
from flex_ident.excitation.commands import INTERFACES, Gains, Interface


@dataclass(frozen=True)
class ExciterSettings:
    """How to excite: `start_position`, rad, None: where the joint is; `approach_velocity`, rad/s, on the way there.

    `inertia`, kg m^2, when known, lets the effort be checked before anything moves. `carry_effort`: what the drive
    exerts at rest goes on under effort commands; false for robots that bear gravity on their own. Raises
    ConfigurationError.
    """

    joint: str
    interface: Interface = "position"
    rate_hz: float = 500.0
    start_position: float | None = None
    state_timeout_s: float = 0.1
    approach_velocity: float = 0.2
    gains: Gains = field(default_factory=Gains)
    inertia: float = 0.0
    carry_effort: bool = True
    held: tuple[str, ...] = ()
    """Names of the other joints that are commanded, in the order of `JointSample.others`."""
    held_effort: tuple[float, ...] = ()
    """Their effort limits, N m."""
    continuous: tuple[bool, ...] = ()
    """Which of the joints turn without end: the one that moves, then those held."""

    def __post_init__(self) -> None:
        if not self.joint:
            raise ConfigurationError("joint is empty: name the joint that shall move.")
        if self.interface not in INTERFACES:
            raise ConfigurationError(
                f"command.interface is '{self.interface}': expected one of {', '.join(INTERFACES)}."
            )
        for name in ("rate_hz", "state_timeout_s", "approach_velocity"):
            if not getattr(self, name) > 0.0:
                raise ConfigurationError(f"{name} is {getattr(self, name)}: it must be positive.")
        if self.start_position is not None and not math.isfinite(self.start_position):
            raise ConfigurationError(f"start_position is {self.start_position}: expected a number.")
