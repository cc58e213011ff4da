"""Starts that owe nothing to the base fit: what an effect may ask of the estimation, and the values that come of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from flex_ident.effects import Effect, Scales
from flex_ident.effects.starting import Shape
from flex_ident.errors import ExcitationError
from flex_ident.likelihood.problem import FitProblem
from flex_ident.likelihood.start import spring_scanned_start, torque_scanned_start
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats
from flex_ident.screening.spring_start import measured_spring_start


@dataclass(frozen=True)
class FitScans:
    """`effects.starting.Scans` of one problem and the values fitted to it."""

    problem: FitProblem
    values: Values
    scales: Scales

    @property
    def rigid(self) -> bool:
        """Whether the model has no spring."""
        return self.problem.rigid

    @property
    def residual(self) -> float:
        """What the values leave of the torque, standard deviation over the usable samples, N m."""
        return float(np.std(self.problem.residuals(self.values)[0][self.problem.usable]))

    @property
    def torque(self) -> float:
        """Standard deviation of the torque there, N m."""
        return float(np.std(self.problem.torque[self.problem.usable]))

    @property
    def recorded_torque(self) -> Floats:
        """The torque as recorded (n,), N m."""
        return self.problem.recording.motor_torque

    def reduced(self, signal: Floats, *, delay: float = 0.0, lag: float = 0.0) -> Floats:
        """A signal (n,), `delay` s later and behind a low-pass of `lag` s, filtered and decimated, at the usable
        samples."""
        return self.problem.reduced(signal, delay=delay, lag=lag)[self.problem.usable]

    def scanned(self, torques: Floats) -> tuple[int, Values]:
        """Which of the torques (r, d) fits best, and the base keys. Raises ExcitationError."""
        return torque_scanned_start(self.problem, torques)

    def scanned_springs(self, shapes: Sequence[Shape]) -> tuple[int, Values]:
        """Which of the springs fits best, and the base keys. Raises ExcitationError."""
        return spring_scanned_start(self.problem, shapes)

    def measured_spring(self, law: Callable[[Floats, float], Floats], shares: Floats) -> tuple[float, Values] | None:
        """Size of the spring's law, rad, and the base keys, from both positions as measured; or None."""
        return measured_spring_start(self.problem, law, shares)


def start_anew(effect: Effect, problem: FitProblem, values: Values, scales: Scales) -> Values:
    """Values of all keys, the effect's among them, from which a fit with the effect may start as well; or none."""
    if effect.start is None:
        return Values()
    try:
        found = effect.start(FitScans(problem, values, scales))
    except ExcitationError:
        return Values()
    if found is None:
        return Values()
    model = values | dict.fromkeys(values.base, 0.0) | found.model.only(values)
    return model | Values.of_effect(effect.name, found.effect)
