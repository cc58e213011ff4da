"""Starts that owe nothing to the fit without an effect: where the effect is large, that fit may be lost.

An effect asks the estimation for its scans and least squares through `Scans`, and says what to make of them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from flex_ident.effects.probe import Scales
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term

FAR_OFF = 0.2
"""Residual over torque, rms, from which a fit is not where an effect of the measurement should start from."""
Shape = Callable[[float], Mapping[Term, float]]
"""Terms of a spring on a link of unit inertia, for the square of the locked-motor frequency, (rad/s)^2."""


@dataclass(frozen=True)
class Start:
    """Where a fit with the effect may start: `model`, what it leaves out at zero, and `effect` by name."""

    model: Values
    effect: Mapping[str, float]


class Scans(Protocol):
    """What an effect may ask of the estimation: the fit without it, and searches that need no start."""

    @property
    def values(self) -> Values:
        """The model's own keys, as fitted without the effect."""

    @property
    def scales(self) -> Scales:
        """What sizes of effects are measured against."""

    @property
    def rigid(self) -> bool:
        """Whether the model has no spring."""

    @property
    def residual(self) -> float:
        """What the fit without the effect leaves of the torque, standard deviation, N m, where it is compared."""

    @property
    def torque(self) -> float:
        """Standard deviation of the torque there, N m."""

    @property
    def recorded_torque(self) -> Floats:
        """The torque as recorded (n,), N m."""

    def reduced(self, signal: Floats, *, delay: float = 0.0, lag: float = 0.0) -> Floats:
        """A signal (n,), filtered and decimated, where it is compared (r,): `delay` s later, and behind a first-order
        low-pass of the time constant `lag`, s; before one where that is negative."""

    def scanned(self, torques: Floats) -> tuple[int, Values]:
        """Which of the torques (r, d) a joint with a linear spring explains best, and the model's keys with it.

        Raises ExcitationError where it explains none.
        """

    def scanned_springs(self, shapes: Sequence[Shape]) -> tuple[int, Values]:
        """Which of the springs explains the recorded torque best, likewise. Raises ExcitationError."""

    def measured_spring(self, law: Callable[[Floats, float], Floats], shares: Floats) -> tuple[float, Values] | None:
        """Size of what `law(deflection, size)` describes, rad, and the model's keys; from both positions as measured.

        `law` gives the spring's torque over its stiffness; `shares` are sizes tried first, over the range of
        deflection. None without a link encoder, or where no size gives positive inertias and a positive stiffness.
        """


def far_off(scans: Scans) -> bool:
    """Whether the fit without the effect explains so little that nothing should start from it."""
    return not scans.rigid and scans.residual >= FAR_OFF * scans.torque
