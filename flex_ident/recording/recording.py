"""Signals as they were recorded, and the same on one uniform clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flex_ident.errors import SignalError
from flex_ident.notices import Notice
from flex_ident.recording.weight import Weight

SHORT_S, SLOW_HZ = 10.0, 100.0
"""Duration and rate below which a recording is said to be short, or slow."""
FASTEST_HZ = 1e5
"""Rate above which times are no clock: nothing that samples a joint is that fast."""
Floats = NDArray[np.float64]
Role = Literal["motor_position", "link_position", "motor_torque", "reference", "motor_current"]


def read_only(values: object, *, name: str, length: int | None = None) -> Floats:
    """A read-only float64 copy, shape (n,), of finite `values`; itself, when it is that already. Raises SignalError."""
    shared = isinstance(values, np.ndarray) and values.flags.owndata and not values.flags.writeable
    array: Floats = np.asarray(values, dtype=np.float64) if shared else np.array(values, dtype=np.float64)
    if array.ndim != 1:
        raise SignalError(f"{name} has {array.ndim} dimensions: expected one.")
    if length is not None and array.size != length:
        raise SignalError(f"{name} has {array.size} samples, the clock has {length}.")
    bad = int(np.count_nonzero(~np.isfinite(array)))
    if bad:
        raise SignalError(f"{name} has {bad} of {array.size} samples that are not finite numbers.")
    array.flags.writeable = False
    return array


@dataclass(frozen=True)
class Signal:
    """One channel as recorded: uneven, increasing `time` (n,), s since the start of the bag, and `values` (n,), SI.

    `source` says where it was found (`/joint_states:joint_2.position`); `clock` whether `time` is the header's stamp
    or the time of reception.
    """

    role: Role
    source: str
    clock: Literal["header", "receive"]
    time: Floats
    values: Floats
    dropped_nonfinite: int = 0
    dropped_duplicates: int = 0
    dropped_backwards: int = 0
    untold_step: float = 0.0
    """The step of an effort of which it does not show whether it was rounded or cut toward zero; 0 where it does, or
    where it has none (`recording.truncation`)."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", read_only(self.time, name=f"time of {self.source}"))
        object.__setattr__(self, "values", read_only(self.values, name=self.source, length=self.time.size))
        if self.time.size > 1 and not bool(np.all(np.diff(self.time) > 0)):
            raise SignalError(f"time of {self.source} does not increase.")


@dataclass(frozen=True)
class Sampling:
    """How one channel was sampled, and what was done to bring it to the uniform clock."""

    role: Role
    source: str
    clock: Literal["header", "receive"]
    samples: int
    rate_hz: float
    jitter_percent: float
    """Standard deviation of the time steps, lost samples left out, in percent of the period."""
    lost_percent: float
    longest_gap_s: float
    skew_s: float
    """Mean time by which this channel's samples lie after the motor position's, s, before alignment."""
    dropped_nonfinite: int = 0
    dropped_duplicates: int = 0
    dropped_backwards: int = 0
    step: float = 0.0
    """The step of the values as they were recorded, in their unit: an encoder's count, or next to nothing. Splines
    through stamps that jitter leave no steps."""
    untold_step: float = 0.0
    """As of the `Signal`."""


@dataclass(frozen=True)
class Recording:
    """One joint's experiment on one uniform clock; all arrays (n,), read-only, finite, SI, link side of the gear.

    `measured` (n,) is False where a gap longer than a few periods had to be bridged: such samples carry no
    information and are left out of every fit. `time` starts at 0 and steps by 1 / `sample_rate_hz`.
    """

    joint: str
    sample_rate_hz: float
    motor_position: Floats
    motor_torque: Floats
    link_position: Floats | None = None
    reference: Floats | None = None
    motor_current: Floats | None = None
    """The motor's current, A, where the effort is a torque sensor's."""
    measured: NDArray[np.bool_] | None = None
    sampling: tuple[Sampling, ...] = ()
    notices: tuple[Notice, ...] = ()
    path: str = ""
    sha256: str = ""
    start_time_s: float = 0.0
    others: Mapping[str, Floats] = field(default_factory=dict)
    """Positions (n,), rad or m, of the other joints that moved, by name."""
    poses: Mapping[str, float] = field(default_factory=dict)
    """Where the other joints were on average, rad or m, moved or held, by name."""
    weight: Weight | None = None
    """What hangs on the joint by the robot's description; None without one."""
    time: Floats = field(init=False)

    def __post_init__(self) -> None:
        if not (np.isfinite(self.sample_rate_hz) and self.sample_rate_hz > 0):
            raise SignalError(f"sampling rate is {self.sample_rate_hz} Hz: it must be positive.")
        n = np.asarray(self.motor_position).size
        for name in ("motor_position", "motor_torque", "link_position", "reference", "motor_current"):
            values = getattr(self, name)
            if values is not None:
                object.__setattr__(self, name, read_only(values, name=name, length=n))
        others = {k: read_only(v, name=f"position of {k}", length=n) for k, v in self.others.items()}
        object.__setattr__(self, "others", MappingProxyType(others))
        object.__setattr__(self, "poses", MappingProxyType(dict(self.poses)))
        mask = np.ones(n, bool) if self.measured is None else np.array(self.measured, bool)
        if mask.shape != (n,):
            raise SignalError(f"mask of measured samples has shape {mask.shape}, expected ({n},).")
        mask.flags.writeable = False
        object.__setattr__(self, "measured", mask)
        object.__setattr__(self, "time", read_only(np.arange(n) / self.sample_rate_hz, name="time"))

    @property
    def sample_time(self) -> float:
        """Sampling period, s."""
        return 1.0 / self.sample_rate_hz


def spacing_text(period: float) -> str:
    """How close samples lie, as in 'lie 1 ns apart (1e+09 Hz)'; `period` in s."""
    return f"lie {1e9 * period:.3g} ns apart ({1.0 / period:.3g} Hz)"


def extent_text(samples: int, rate_hz: float) -> str:
    """Samples with their duration and rate, as in '100 samples (20 s at 5 Hz)'."""
    return f"{samples} samples ({samples / rate_hz:.3g} s at {rate_hz:.4g} Hz)"


def more_needed(samples: int, rate_hz: float) -> str:
    """What to record where so many samples at such a rate were too few."""
    slow, short = rate_hz < SLOW_HZ, samples / rate_hz < SHORT_S
    if slow:
        return f"record at {SLOW_HZ:.0f} Hz or more{', ten seconds at least' if short else ''}."
    return "record at least ten seconds of motion." if short else "record a longer motion, without gaps or standstill."
