"""Five excitations of unit amplitude, and how they fall off towards high frequencies."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

Floats = NDArray[np.float64]
EXCITATIONS = ("log_chirp", "linear_chirp", "multisine", "prbs", "rich")
FADE_S = 1.0


def faded(t: Floats, duration_s: float) -> Floats:
    """A window, (n,), that rises and falls smoothly within `FADE_S`."""
    x = np.clip(np.minimum(t, duration_s - t) / FADE_S, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


def chirp(t: Floats, duration_s: float, low: float, high: float, corner: float, linear: bool = False) -> Floats:
    """A sweep from `low` to `high`, Hz, of unit amplitude up to `corner`, Hz, and of constant speed above it."""
    if linear:
        f = low + (high - low) * t / duration_s
        phase = 2.0 * np.pi * (low * t + 0.5 * (high - low) * t * t / duration_s)
    else:
        rate = duration_s / np.log(high / low)
        f = low * np.exp(t / rate)
        phase = 2.0 * np.pi * low * rate * (np.exp(t / rate) - 1.0)
    return np.minimum(1.0, corner / f) * np.sin(phase)


def multisine(
    t: Floats, duration_s: float, low: float, high: float, corner: float, rng: np.random.Generator
) -> Floats:  # fmt: skip
    """Forty lines between `low` and `high`, Hz, logarithmically spaced, of random phase, scaled to a peak of one."""
    lines = np.unique(np.round(np.geomspace(low, high, 40) * duration_s)) / duration_s
    size = np.minimum(1.0, corner / lines)
    phase = rng.uniform(0.0, 2.0 * np.pi, lines.size)
    wave = np.zeros(t.size)
    for f, a, angle in zip(lines, size, phase, strict=True):
        wave += a * np.sin(2.0 * np.pi * f * t + angle)
    return wave / np.max(np.abs(wave))


def prbs(t: Floats, low: float, high: float, corner: float, rng: np.random.Generator) -> Floats:
    """Random levels of a sign each, followed by their opposite, smoothed: peak one.

    The levels last from half a period of `high` to one of 4 `low`, Hz; the smoothing is two lags at `corner`, Hz.
    """
    rate = 1.0 / (t[1] - t[0])
    levels: list[float] = []
    while len(levels) < t.size:
        half = max(1, int(rate * 0.5 / np.exp(rng.uniform(np.log(4.0 * low), np.log(high)))))
        sign = 1.0 if rng.uniform() < 0.5 else -1.0
        levels += [sign] * half + [-sign] * half
    wave = np.array(levels[: t.size])
    share = 1.0 - np.exp(-2.0 * np.pi * corner / rate)
    for _ in range(2):
        wave = np.asarray(lfilter([share], [1.0, share - 1.0], wave))
    return wave / np.max(np.abs(wave))


def excitation(
    kind: str, t: Floats, duration_s: float, low: float, high: float, corner: float, rng: np.random.Generator
) -> Floats:  # fmt: skip
    """The excitation of unit amplitude, (n,), with its fades."""
    if kind in ("log_chirp", "linear_chirp"):
        wave = chirp(t, duration_s, low, high, corner, kind == "linear_chirp")
    elif kind == "multisine":
        wave = multisine(t, duration_s, low, high, corner, rng)
    elif kind == "prbs":
        wave = prbs(t, low, high, corner, rng)
    else:  # rich: a slow sine over a third, a chirp, and a smaller chirp
        a, b = duration_s / 3.0, 0.7 * duration_s
        wave = np.zeros(t.size)
        for start, end, size in ((0.0, a, 2.0), (a, b, 1.0), (b, duration_s, 0.3)):
            part = (t >= start) & (t < end)
            own, length = t[part] - start, end - start
            if size == 2.0:
                wave[part] = size * np.sin(2.0 * np.pi * max(0.5 * low, 2.0 / length) * own)
            else:
                wave[part] = size * chirp(own, length, 2.0 * low, high, corner)
            wave[part] *= faded(own, length)
        return wave
    return wave * faded(t, duration_s)
