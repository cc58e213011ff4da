"""What the joint did, cycle by cycle of its drive, and how encoders and a torque reading see it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from flex_ident.recording import Floats
from flex_ident.virtual_joint.compiled import compiled


@compiled
def position_at(rows: Floats, column: int, where: float, cycle: float) -> float:
    """Position at the fractional cycle `where`: the cubic through the positions and velocities on either side.

    `rows` (m, 5) as in `plant.ROW`, `cycle` s apart; `column` is that of the position, its velocity the next.
    """
    last = rows.shape[0] - 1
    k = min(max(int(where), 0), last - 1)
    s = min(max(where - k, 0.0), 1.0)
    left, right = rows[k, column], rows[k + 1, column]
    slope_left, slope_right = cycle * rows[k, column + 1], cycle * rows[k + 1, column + 1]
    step = right - left
    bend = slope_left + slope_right - 2.0 * step
    return float(left + s * (slope_left + s * (3.0 * step - 2.0 * slope_left - slope_right + s * bend)))


@compiled
def mean_torque(rows: Floats, start: float, stop: float) -> float:
    """Mean of the torque, held over each cycle, between the fractional cycles `start` and `stop`."""
    count = rows.shape[0]
    low, high = min(max(start, 0.0), count - 1.0), min(max(stop, 1.0), float(count))
    total = 0.0
    for k in range(int(low), min(int(high) + 1, count)):
        total += rows[k, 4] * max(min(high, k + 1.0) - max(low, float(k)), 0.0)
    return float(total / (high - low))


@compiled
def readings(rows: Floats, where: Floats, cycle: float, window: float, torque_delay: float, link_skew: float) -> Floats:
    """Motor position, link position, mean torque (n, 3) at the fractional cycles `where` (n,).

    The torque is the mean over `window` cycles around the instant; delay and skew in cycles, positive: recorded late.
    """
    read = np.empty((where.size, 3))
    for k in range(where.size):
        middle = where[k] - torque_delay
        read[k, 0] = position_at(rows, 0, where[k], cycle)
        read[k, 1] = position_at(rows, 2, where[k] - link_skew, cycle)
        read[k, 2] = mean_torque(rows, middle - 0.5 * window, middle + 0.5 * window)
    return read


@dataclass(frozen=True)
class TrueMotion:
    """A whole run: `rows` (m, 5) as in `plant.ROW` at `cycle_rate_hz`, under `reference` (n,) at `sample_rate_hz`."""

    sample_rate_hz: float
    cycle_rate_hz: float
    rows: Floats
    reference: Floats

    @property
    def cycles(self) -> int:
        """Cycles of the drive in one sample."""
        return round(self.cycle_rate_hz / self.sample_rate_hz)

    @property
    def time(self) -> Floats:
        """Instants of the samples (n,), s."""
        instants: Floats = np.arange(self.reference.size) / self.sample_rate_hz
        return instants

    @property
    def motor_position(self) -> Floats:
        """(n,), rad, at the samples."""
        return self.rows[:: self.cycles, 0]

    @property
    def motor_velocity(self) -> Floats:
        """(n,), rad/s, at the samples."""
        return self.rows[:: self.cycles, 1]

    @property
    def link_position(self) -> Floats:
        """(n,), rad, at the samples."""
        return self.rows[:: self.cycles, 2]

    @property
    def torque(self) -> Floats:
        """(n,), N m: the mean over a sample around each sample's instant."""
        return self.at(self.time)[:, 2]

    def at(self, instants: Floats, *, torque_delay: float = 0.0, link_skew: float = 0.0) -> Floats:
        """Motor position, link position, mean torque (n, 3) at `instants` (n,), s; delay and skew in s."""
        rate = self.cycle_rate_hz
        read: Floats = readings(
            self.rows, instants * rate, 1.0 / rate, float(self.cycles), torque_delay * rate, link_skew * rate
        )
        return read
