"""Bias, spread, ratio to the Cramér-Rao bound and coverage, on plants that are not the estimator's model.

    python bench/monte_carlo.py --draws 30 --joints paper,cobot,series_elastic --sensors motor,motor+link

Plant: flex_ident.virtual_joint (position Verlet, friction by impulse, its own drive) by default, or MuJoCo
(--plant mujoco). Every draw has its own noise, encoder phases, jitter and lost samples. The bound is that of the
linearised likelihood of the fit, priors included.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from flex_ident.errors import FlexIdentError
from flex_ident.estimation.estimate import estimated, fit_problem, started_values
from flex_ident.estimation.identification import better_start, identification_of
from flex_ident.parameters import FLEXIBLE_KEYS, JointModel
from flex_ident.parameters.values import Values
from flex_ident.recording import Recording
from flex_ident.report.table import text_table
from flex_ident.virtual_joint import JOINTS, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "test" / "plants"))
KEYS = ("Jm", "K", "JL")
NOISE = {
    "low": {"torque_noise": 0.002},
    "medium": {"torque_noise": 0.01},
    "high": {"torque_noise": 0.03, "torque_disturbance": 0.01},
}


def chain_of(noise: str, bits: int) -> MeasurementChain:
    """Encoders of `bits`, jitter of 5 % of a period, 0.2 % of the samples lost."""
    return MeasurementChain.with_bits(bits, bits, jitter=0.05, lost=0.002, **NOISE[noise])


def virtual(model: JointModel, experiment: Experiment, chain: MeasurementChain, seed: int) -> Recording:
    """A draw of the virtual joint."""
    return virtual_recording(model, experiment, chain, seed=seed)


def mujoco(model: JointModel, experiment: Experiment, chain: MeasurementChain, seed: int) -> Recording:
    """A draw of the MuJoCo joint."""
    from mujoco_joint import mujoco_recording

    made: Recording = mujoco_recording(model, experiment, chain, seed=seed)
    return made


def draw(
    recording: Recording, model: JointModel, sensors: str, guess: float, alone: bool
) -> dict[str, tuple[float, float, float]]:
    """Relative error, relative standard deviation stated, and relative bound of each key."""
    problem = fit_problem(recording, sensors=sensors)
    starts = [started_values(problem, FLEXIBLE_KEYS)] if not alone else []
    if guess != 1.0:
        off = {k: guess ** (1 if i % 2 else -1) for i, k in enumerate(KEYS)}
        starts.append(Values({k: model.value(k) * off.get(k, 1.0) for k in FLEXIBLE_KEYS}))
    start = better_start(problem, *(Values(dict.fromkeys(FLEXIBLE_KEYS, 0.0)) | s for s in starts))
    estimate = estimated(problem, FLEXIBLE_KEYS, start)
    result = identification_of(recording, estimate, sensors=sensors, method="auto")  # type: ignore[arg-type]
    fit = estimate.fit
    inside = [i for i, key in enumerate(fit.free) if key not in fit.at_bound]
    jacobian = fit.jacobian[:, inside]
    scale = np.linalg.norm(jacobian, axis=0)
    scale[scale == 0.0] = 1.0
    prior = fit.prior_information[np.ix_(inside, inside)] / np.outer(scale, scale)
    information = (jacobian / scale).T @ (jacobian / scale) + prior
    bound = np.sqrt(np.diag(np.linalg.inv(information))) / scale
    found = {}
    for key in KEYS:
        p, true = result.parameter(key), model.value(key)
        found[key] = (p.value / true - 1.0, p.std / true, bound[inside.index(fit.free.index(key))] / true)
    return found


def main() -> None:
    """Print one row for each joint, sensors, noise and parameter."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=30)
    parser.add_argument("--joints", default="paper,cobot,series_elastic")
    parser.add_argument("--sensors", default="motor,motor+link")
    parser.add_argument("--noise", default="medium")
    parser.add_argument("--bits", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--guess", type=float, default=1.0, help="also start this factor off, as `--model` does")
    parser.add_argument("--alone", action="store_true", help="start from the guess alone, without the linear start")
    parser.add_argument("--plant", choices=("virtual", "mujoco"), default="virtual")
    given = parser.parse_args()
    plant: Callable[..., Recording] = mujoco if given.plant == "mujoco" else virtual
    experiment = Experiment(duration_s=given.seconds)
    header = (
        "joint",
        "sensors",
        "noise",
        "",
        "bias %",
        "spread %",
        "worst %",
        "stated %",
        "spread/bound",
        "coverage",
        "",
    )
    rows = []
    for name in given.joints.split(","):
        model = JOINTS[name]
        for noise in given.noise.split(","):
            errors: dict[str, dict[str, list[tuple[float, float, float]]]] = {}
            failed: dict[str, int] = {}
            started = time.monotonic()
            for seed in range(given.draws):
                recording = plant(model, experiment, chain_of(noise, given.bits), seed)
                for sensors in given.sensors.split(","):
                    try:
                        one = draw(recording, model, sensors, given.guess, given.alone)
                    except FlexIdentError as error:
                        failed[sensors] = failed.get(sensors, 0) + 1
                        print(f"{name} {sensors} seed {seed}: {error}", file=sys.stderr)
                        continue
                    for key, values in one.items():
                        errors.setdefault(sensors, {}).setdefault(key, []).append(values)
            seconds = (time.monotonic() - started) / given.draws / len(given.sensors.split(","))
            for sensors, found in errors.items():
                for key in KEYS:
                    e, s, b = np.array(found[key]).T
                    rows.append((
                        name, sensors, noise, key, f"{100 * np.mean(e):+.3f}", f"{100 * np.std(e):.3f}",
                        f"{100 * np.abs(e).max():.3f}", f"{100 * np.mean(s):.3f}", f"{np.std(e) / np.mean(b):.2f}",
                        f"{100 * np.mean(np.abs(e) <= 1.96 * s):.0f} %",
                        f"{failed.get(sensors, 0)} failed, {seconds:.1f} s each" if key == "Jm" else "",
                    ))  # fmt: skip
            print(text_table(header, rows[-3 * len(errors) :], right=range(4, 10)), flush=True)
    print(f"\n{given.draws} draws of {given.seconds:.0f} s at 1 kHz, {given.bits} bits, plant {given.plant}")
    print(text_table(header, rows, right=range(4, 10)))


if __name__ == "__main__":
    main()
