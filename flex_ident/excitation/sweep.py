"""One sweep: a sine whose frequency and amplitude change, with its exact derivatives."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Sweep:
    """A sine from `low_hz` to `high_hz` in `duration` s, of `amplitude` rad where it starts, faded over `fade` s.

    The amplitude goes with the frequency to the power of minus `power` (0, 1, 2: constant position, velocity,
    acceleration), and by one power more above each of `corners_hz`.

        q = A g(f) e(t) sin(phi),  phi' = w = 2 pi f(t),  g: profile, e: raised cosine at both ends
    """

    duration: float
    low_hz: float
    high_hz: float
    amplitude: float
    fade: float = 0.0
    linear: bool = False
    power: int = 0
    corners_hz: tuple[float, ...] = ()

    @property
    def _growth(self) -> float:
        """1/s of the logarithm of the frequency; Hz/s of the frequency when linear."""
        if self.linear:
            return (self.high_hz - self.low_hz) / self.duration
        return math.log(self.high_hz / self.low_hz) / self.duration

    @property
    def _steady(self) -> bool:
        return abs(self.high_hz / self.low_hz - 1.0) < 1e-9

    @property
    def periods(self) -> float:
        """Periods of the sine in all."""
        if self.linear or self._steady:
            return 0.5 * (self.low_hz + self.high_hz) * self.duration
        return (self.high_hz - self.low_hz) / self._growth

    def instants(self, periods: Floats) -> Floats:
        """Instants, s, at which a number of periods has passed; never after the end."""
        low, growth = self.low_hz, self._growth
        if self._steady:
            t = periods / low
        elif self.linear:
            t = (np.sqrt(np.maximum(low**2 + 2.0 * growth * periods, 0.0)) - low) / growth
        else:
            t = np.log(np.maximum(1.0 + growth * periods / low, 1e-300)) / growth
        clipped: Floats = np.clip(t, 0.0, self.duration)
        return clipped

    def at(self, t: float) -> tuple[float, float, float]:
        """Position, velocity and acceleration at `t` s after the sweep's start."""
        position, velocity, acceleration = self.motion(np.array([t]))
        return float(position[0]), float(velocity[0]), float(acceleration[0])

    def motion(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Position, velocity and acceleration (n,) at instants `t` (n,), s, between 0 and `duration`."""
        low, growth = self.low_hz, self._growth
        if self.linear or self._steady:
            f = low + growth * t if self.linear else np.full_like(t, low)
            turns = low * t + 0.5 * growth * t * t if self.linear else low * t
            rate = growth / f if self.linear else np.zeros_like(t)
            drate = -(rate**2)
        else:
            f = low * np.exp(growth * t)
            turns = (f - low) / growth
            rate, drate = np.full_like(t, growth), np.zeros_like(t)
        gain, dgain, ddgain = self._gain(f, rate, drate)
        edge, dedge, ddedge = self._edge(t)
        a = self.amplitude * gain * edge
        da = self.amplitude * (dgain * edge + gain * dedge)
        dda = self.amplitude * (ddgain * edge + 2.0 * dgain * dedge + gain * ddedge)
        w = 2.0 * math.pi * f
        dw = w * rate
        sine, cosine = np.sin(2.0 * math.pi * turns), np.cos(2.0 * math.pi * turns)
        return (
            a * sine,
            da * sine + a * w * cosine,
            (dda - a * w * w) * sine + (2.0 * da * w + a * dw) * cosine,
        )

    def _gain(self, f: Floats, rate: Floats, drate: Floats) -> tuple[Floats, Floats, Floats]:
        """Profile of the amplitude and its derivatives in time; `rate` is f'/f.

        With power p: g' = -p g f'/f, g'' = p g (p (f'/f)^2 - (f'/f)').
        """
        gain = (self.low_hz / f) ** self.power
        power = np.full_like(f, self.power)
        for corner in self.corners_hz:
            gain = gain * np.minimum(1.0, corner / f)
            power += f > corner
        return gain, -power * gain * rate, power * gain * (power * rate**2 - drate)

    def _edge(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Raised cosine at both ends and its derivatives in time."""
        if self.fade <= 0.0:
            return np.ones_like(t), np.zeros_like(t), np.zeros_like(t)
        inside = np.minimum(t, self.duration - t) / self.fade
        x = math.pi * np.clip(inside, 0.0, 1.0)
        within = inside < 1.0
        speed = math.pi / self.fade
        sign = np.where(t < 0.5 * self.duration, 1.0, -1.0)
        return (
            0.5 - 0.5 * np.cos(x),
            np.where(within, sign * 0.5 * speed * np.sin(x), 0.0),
            np.where(within, 0.5 * speed**2 * np.cos(x), 0.0),
        )
