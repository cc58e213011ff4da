"""A zero-phase low-pass with exact derivatives, in the frequency domain."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from flex_ident.errors import ExcitationError
from flex_ident.recording import Floats

Complexes = NDArray[np.complex128]
EXTENSION_S = 2.0
"""Time by which a signal is continued at both ends before it is filtered, s."""
ORDER = 6
"""Order m of the zero-phase low-pass of eq. 25 used throughout the simulation-based estimation."""
KEPT = 4
"""Delays, curvatures and lags of which the spectral shape is kept."""


def lowpass_response(frequency_hz: Floats, cutoff_hz: float, order: int = ORDER) -> Floats:
    """Magnitude (m,) of the forward and reverse Butterworth filter: eq. 25 of the paper."""
    response: Floats = 1.0 / (1.0 + (frequency_hz / cutoff_hz) ** (2 * order))
    return response


class SpectralFilter:
    """A zero-phase low-pass with derivatives and change of rate, for signals (n,) of one length and rate.

    The signal is continued at both ends by its point reflection, so that value and slope stay continuous; what is
    wrong is confined to about a period of the cutoff at each edge. `upsampling` gives that many output samples for
    each input sample: outputs have (n - 1) * upsampling + 1 samples. `decimation` gives every so many samples only,
    ceil(n / decimation) in all, and costs less than to filter and then drop them.
    """

    def __init__(
        self, n: int, sample_rate_hz: float, cutoff_hz: float, *, upsampling: int = 1, decimation: int = 1
    ) -> None:
        if n < 16:
            raise ExcitationError(f"{n} samples are too few to filter: record at least a few seconds.")
        if decimation > 1 and upsampling > 1:
            raise ValueError("either upsampling or decimation")
        self.n = n
        self.upsampling = upsampling
        self.decimation = d = decimation
        self._rate = sample_rate_hz
        # The first sample must be one of those that decimation keeps.
        self._extension = d * max(1, min(n - 1, max(8, round(EXTENSION_S * sample_rate_hz))) // d)
        self._length = d * fft.next_fast_len(-(-(n + 2 * self._extension) // d), real=True)
        frequency: Floats = fft.rfftfreq(self._length, 1.0 / sample_rate_hz)
        # Of what decimation folds back, the first image is kept: the second is under 1e-5 of it.
        self._frequency = frequency[: self._length // d + 1] if d > 1 else frequency
        self._response = lowpass_response(self._frequency, cutoff_hz)
        e = self._extension
        self._ramp: Floats = 0.5 - 0.5 * np.cos(np.pi * np.arange(e) / e)
        self._along: Floats = np.linspace(0.0, 1.0, n)
        self._shapes: dict[tuple[float, float, float], Floats | Complexes] = {(0.0, 0.0, 0.0): self._response}

    def through(self, signal: Floats, *transfers: Callable[[Floats], Complexes]) -> tuple[Floats, ...]:
        """The filtered signal behind each of several linear systems, whose `transfers` are asked at angular frequencies
        (k,), rad/s."""
        spectrum, slope, omega = self._spectrum(signal) * self._response, self._slope(signal), self._omega
        found: list[Floats] = []
        for transfer in (asked(omega) for asked in transfers):
            still = float(transfer[0].real)
            found += self._outputs(spectrum * transfer, (0,), float(signal[0]) * still, slope * still, 0.0)
        return tuple(found)

    def __call__(
        self, signal: Floats, derivatives: tuple[int, ...] = (0,), *, delay: float = 0.0, curvature: float = 0.0,
        lag: float = 0.0,
    ) -> tuple[Floats, ...]:  # fmt: skip
        """The filtered signal's `derivatives`, one array ((n - 1) * upsampling + 1,) each, in units per s^k.

        `delay`, s, shifts the output to later times; `curvature`, s^2, adds that much of the second derivative; `lag`,
        s, is the time constant of a first-order low-pass, negative to undo one.
        """
        spectrum = self._spectrum(signal) * self._shape(delay, curvature, lag)
        return self._outputs(spectrum, derivatives, float(signal[0]), self._slope(signal), delay + lag)

    @property
    def _omega(self) -> Floats:
        """Angular frequencies (k,), rad/s."""
        return 2.0 * np.pi * self._frequency

    def _slope(self, signal: Floats) -> float:
        """Of the straight line from the signal's first sample to its last, a sample."""
        return float((signal[-1] - signal[0]) / max(self.n - 1, 1))

    def _spectrum(self, signal: Floats) -> Complexes:
        """The spectrum (k,) of the signal less that line, mirrored at both ends."""
        e, n, length = self._extension, self.n, self._length
        extended = np.zeros(length)
        flat = extended[e : e + n]
        np.multiply(self._along, signal[-1] - signal[0], out=flat)
        flat += signal[0]
        np.subtract(signal, flat, out=flat)
        # Both ends come down to zero, which is where the padding up to the FFT's length lies.
        np.multiply(flat[e:0:-1], -self._ramp, out=extended[:e])
        np.multiply(flat[-2 : -e - 2 : -1], -self._ramp[::-1], out=extended[e + n : 2 * e + n])
        found: Complexes = fft.rfft(extended)[: self._response.size]
        return found

    def _outputs(
        self, spectrum: Complexes, derivatives: tuple[int, ...], first: float, slope: float, late: float
    ) -> tuple[Floats, ...]:
        """The signals of a spectrum (k,), with the line put back that starts at `first` and comes `late` s."""
        u, d, length = self.upsampling, self.decimation, self._length
        start = self._extension * u // d
        count = (self.n - 1) * u // d + 1
        outputs = []
        for order in derivatives:
            shaped = spectrum * (2j * np.pi * self._frequency) ** order if order else spectrum
            fine = fft.irfft(_folded(shaped), length // d) / d if d > 1 else fft.irfft(shaped, length * u) * u
            result: Floats = fine[start : start + count].copy()
            if order == 0:
                result += first + slope * d / u * np.arange(count) - slope * late * self._rate
            elif order == 1:
                result += slope * self._rate
            outputs.append(result)
        return tuple(outputs)

    def _shape(self, delay: float, curvature: float, lag: float) -> Floats | Complexes:
        """What the spectrum is multiplied by, (k,); the last are kept, as one point of a fit asks for the same."""
        key = (delay, curvature, lag)
        shape = self._shapes.get(key)
        if shape is not None:
            return shape
        shape = self._response
        if delay != 0.0:
            shape = shape * np.exp(-2j * np.pi * self._frequency * delay)
        if curvature != 0.0:
            shape = shape * (1.0 - curvature * (2.0 * np.pi * self._frequency) ** 2)
        if lag > 0.0:
            shape = shape / (1.0 + 2j * np.pi * self._frequency * lag)
        elif lag < 0.0:
            shape = shape * (1.0 - 2j * np.pi * self._frequency * lag)
        latest = list(self._shapes.items())[1 - KEPT :]
        self._shapes = {**dict(latest), key: shape}  # replaced as a whole: several threads ask
        return shape


def _folded(spectrum: Complexes) -> Complexes:
    """Bins 0 to m of a spectrum folded at m / 2: that of every so many samples, m in all."""
    m = spectrum.size - 1
    half = m // 2
    folded: Complexes = spectrum[: half + 1] + np.conj(spectrum[m : m - half - 1 : -1])
    return folded
