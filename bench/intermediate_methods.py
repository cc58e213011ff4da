"""Bias and spread of each method against the bound, motor only and both: python bench/intermediate_methods.py

The paper's inversion, the weighted inversion of all seven X, instrumental variables on eq. 18 with the instruments
simulated from the weighted estimate, and maximum likelihood, on the paper's joint and the same draws.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

import numpy as np
from monte_carlo import draw

from flex_ident.errors import FlexIdentError
from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.filtering.band import excited_band_hz
from flex_ident.parameters import Identification
from flex_ident.recording import Floats, Recording
from flex_ident.regression import LinearFit, identify_linear, least_squares
from flex_ident.regression.inversion import weighted_inversion
from flex_ident.regression.models import motor_only
from flex_ident.regression.observation import clean_observation
from flex_ident.report.table import text_table
from flex_ident.virtual_joint import PAPER_JOINT, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

KEYS = ("Jm", "K", "JL")
FIRST_MODE_HZ = 3.9
BAND_HZ = 12.0


def by_likelihood(recording: Recording, sensors: str) -> dict[str, float]:
    """Maximum likelihood by simulation."""
    return values_of(identify(recording, IdentifyOptions(sensors=sensors)))


def by_regression(method: str) -> Callable[[Recording, str], dict[str, float]]:
    """The paper's route, or the weighted one."""

    def found(recording: Recording, sensors: str) -> dict[str, float]:
        return values_of(
            identify_linear(recording, sensors=sensors, method=method, first_mode_hz=FIRST_MODE_HZ)  # type: ignore[arg-type]
        )

    return found


def by_instruments(recording: Recording, sensors: str) -> dict[str, float]:
    """Instrumental variables on eq. 18: the instruments are the same columns, free of the recording's noise.

    They are computed from the commanded position and from the torque that a first least-squares fit predicts for it.
    """
    assert recording.reference is not None
    at = clean_observation(recording, band_hz=min(BAND_HZ, excited_band_hz(recording)))
    matrix, target, names = motor_only(recording, at)
    matrix, target = at.reduced(matrix), at.reduced(target[:, None])[:, 0]
    first = least_squares(matrix, target, names)
    clean = Recording(
        recording.joint,
        recording.sample_rate_hz,
        recording.reference,
        at_full(recording, at, first),
        path="",
        sha256="",
    )
    instruments = at.reduced(motor_only(clean, at)[0])
    scale = np.linalg.norm(instruments, axis=0)
    projected = (instruments / scale).T
    solution = np.linalg.lstsq(projected @ matrix, projected @ target, rcond=1e-12)[0]
    residual = target - matrix @ solution
    inverse = np.linalg.pinv(projected @ matrix)
    covariance = inverse @ (projected @ projected.T) @ inverse.T * float(np.var(residual))
    fit = LinearFit(names, solution, covariance, first.condition_number, first.rank, (), residual)
    values = weighted_inversion(fit).values
    return dict(zip(("Jm", "K", "JL"), map(float, values[:3]), strict=True))


def at_full(recording: Recording, at: object, fit: LinearFit) -> Floats:
    """Torque that the first fit predicts from the reference, at the recording's rate."""
    assert recording.reference is not None
    position = recording.reference
    q1, q2, q3, q4 = (at.derivative(position, k) for k in (1, 2, 3, 4))  # type: ignore[attr-defined]
    forced = fit.value("X3") * q4 + fit.value("X4") * q3 + fit.value("X5") * q2 + fit.value("X6") * q1
    forced = forced + fit.value("X7") * np.sign(q1)
    n, rate = position.size, recording.sample_rate_hz
    s = 2j * np.pi * np.fft.rfftfreq(n, 1.0 / rate)
    response = 1.0 / (1.0 + fit.value("X2") * s + fit.value("X1") * s**2)
    torque: Floats = np.fft.irfft(np.fft.rfft(forced) * response, n)
    return torque


def values_of(result: Identification) -> dict[str, float]:
    """Jm, K and JL of a result."""
    return {k: result.parameter(k).value for k in KEYS}


METHODS: dict[str, tuple[str, Callable[[Recording, str], dict[str, float]]]] = {
    "paper, eq. 13": ("motor+link", by_regression("paper")),
    "weighted, eq. 13": ("motor+link", by_regression("weighted")),
    "maximum likelihood, both": ("motor+link", by_likelihood),
    "paper, Table 3": ("motor", by_regression("paper")),
    "weighted inversion of seven X": ("motor", by_regression("weighted")),
    "instrumental variables": ("motor", by_instruments),
    "maximum likelihood, motor only": ("motor", by_likelihood),
}


def main() -> None:
    """Print bias ± spread of Jm, K and JL in percent, and the spread over the Cramér-Rao bound of the same sensors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=10)
    given = parser.parse_args()
    chain = MeasurementChain(1e-5, 2.4e-5, torque_noise=0.01, torque_disturbance=0.005)
    errors: dict[str, list[list[float]]] = {name: [] for name in METHODS}
    bounds: dict[str, list[list[float]]] = {"motor": [], "motor+link": []}
    for seed in range(given.draws):
        recording = virtual_recording(PAPER_JOINT, Experiment(duration_s=40.0), chain, seed=seed)
        for sensors, known in bounds.items():
            one = draw(recording, PAPER_JOINT, sensors, 1.0, False)
            known.append([100.0 * one[k][2] for k in KEYS])
        for name, (sensors, method) in METHODS.items():
            try:
                found = method(recording, sensors)
            except FlexIdentError:
                continue
            errors[name].append([100.0 * (found[k] / PAPER_JOINT.value(k) - 1.0) for k in KEYS])
    rows = []
    for name, found_errors in errors.items():
        e = np.array(found_errors) if found_errors else np.full((1, 3), np.nan)
        bound = np.mean(bounds[METHODS[name][0]], axis=0)
        cells = zip(e.mean(axis=0), e.std(axis=0), e.std(axis=0) / bound, strict=True)
        rows.append((name, *(f"{m:+.2f} ± {s:.3f} ({r:.1f})" for m, s, r in cells),
                     f"{given.draws - len(found_errors)} failed"))  # fmt: skip
    print(text_table(("method", "Jm %", "K %", "JL %", ""), rows, right=(1, 2, 3)))


if __name__ == "__main__":
    main()
