"""The recorded motor position as a smooth function of time: what drives the spring."""

from __future__ import annotations

from dataclasses import dataclass

from flex_ident.filtering.spectral import SpectralFilter
from flex_ident.recording import Floats


@dataclass(frozen=True)
class MotorMotion:
    """Motor position, velocity and acceleration, low-passed. Samples at the recording's clock (n,): `position`, …

    `fine_position`, `fine_velocity` (2 (n - 1) substeps + 1,) stand at every half step of the integration, `step` s.
    """

    sample_time: float
    substeps: int
    position: Floats
    velocity: Floats
    acceleration: Floats
    fine_position: Floats
    fine_velocity: Floats

    @property
    def step(self) -> float:
        """Step of the integration, s."""
        return self.sample_time / self.substeps


def motor_motion(position: Floats, sample_rate_hz: float, *, cutoff_hz: float, substeps: int = 1) -> MotorMotion:
    """The motion behind a recorded motor position (n,), rad, low-passed at `cutoff_hz`. Raises ExcitationError."""
    upsampling = 2 * substeps
    spectral = SpectralFilter(position.size, sample_rate_hz, cutoff_hz, upsampling=upsampling)
    fine_position, fine_velocity = spectral(position, (0, 1))
    (acceleration,) = SpectralFilter(position.size, sample_rate_hz, cutoff_hz)(position, (2,))
    return MotorMotion(
        sample_time=1.0 / sample_rate_hz,
        substeps=substeps,
        position=fine_position[::upsampling].copy(),
        velocity=fine_velocity[::upsampling].copy(),
        acceleration=acceleration,
        fine_position=fine_position,
        fine_velocity=fine_velocity,
    )
