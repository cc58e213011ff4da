"""Three ways to simulate a joint against a recording, motor encoder only: python bench/simulation_ways.py --draws 3

a  position drives the spring (flex_ident's own): the link is simulated, eq. 6 gives the torque that is compared.
b  torque as input with feedback: the recorded torque drives both masses, a PD keeps the motor on its recorded position;
   what the PD must add is the residual.
c  reference with identified controller: the recorded reference drives a closed loop; torque and motor position are
   compared. Gains come from a regression of the recorded torque on position error, velocity error and the integral of
   the position error ('P, PI'). The virtual joint's drive is more than that: it smooths and delays the reference, feeds
   its acceleration forward, and holds its torque over a cycle. 'nearest' has all of it: an acceleration feedforward,
   two equal lags and a delay of the reference, and a delay in the loop, the last three scanned.

All fit the same nine parameters, without offset, from the same start, with the same optimiser (scipy's least_squares in
`SimulationFit`), low-pass, usable samples and rounds of whitening. a and b also fit the torque's delay and averaging, a
the link's first deflection. c is told the averaging and that there is no delay: its regression cannot tell a torque
logged late (--torque-delay-ms) from a slow loop. b and c step as the virtual joint does (position Verlet, friction an
impulse that cannot reverse motion), which a does not: in their favour.
Times are CPU time without compiling and start, with c's regression. A step is Runge-Kutta 4 (a), or one kick (b, c).
"""

from __future__ import annotations

import argparse
import math
import sys
import time
import timeit
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numba import njit
from scipy import optimize, signal

from flex_ident.errors import FlexIdentError
from flex_ident.estimation.base_fit import refined
from flex_ident.estimation.estimate import fit_problem, started_values
from flex_ident.filtering.band import excited_band_hz
from flex_ident.filtering.spectral import SpectralFilter
from flex_ident.likelihood.fit import SimulationFit
from flex_ident.likelihood.nuisances import measurement_priors
from flex_ident.likelihood.problem import DRIVE_MARGIN, FitProblem, terms_of
from flex_ident.parameters import JointModel
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats, Recording
from flex_ident.simulation.batch import LANES, simulated_links
from flex_ident.simulation.kernel import simulated_link
from flex_ident.simulation.motion import motor_motion
from flex_ident.simulation.response import link_motion, motor_torque
from flex_ident.virtual_joint import JOINTS, Experiment, MeasurementChain
from flex_ident.virtual_joint.run import virtual_recording

PARAMETERS = ("Jm", "K", "JL", "FVm", "FSm", "FV", "FS", "MX", "MY")
GRAVITY = 9.81
SUBSTEPS = 4
"""Steps of b and c in a sample; even, so that a sample's middle lies between two of them."""
FAILED = 10.0
"""Error of Jm, K or JL, percent, from which a fit counts as failed; its error is shown all the same."""
REPEATS = 15


@njit(cache=True, nogil=True, error_model="numpy")
def two_masses(p, gains, late, feed, wanted, wanted_rate, a, va, step, position, torque):
    """Fill motor position and torque, the mean over a sample around its instant (n,).

    The torque is `feed` plus `gains` (P, D, I) on `wanted` less motor position, `late` steps ago; not late, the D part
    is implicit. All inputs are at the middles of the steps.
    Soft thresholds keep the result continuous in `p` (9,): a mass at rest sticks until pushed harder than its friction.
    """
    jm, k, jl, fvm, fsm, fv, fs, gx, gy = p
    kp, kd, ki = gains
    b, vb = a, va
    for _ in range(8):
        b = a - (gx * math.cos(b) + gy * math.sin(b)) / k
    inside = kd if late == 0 else 0.0
    waiting = np.full(max(late, 1), feed[0])
    motor_damping, link_damping = 0.5 * step * (fvm + inside), 0.5 * step * fv
    motor_loss, link_loss = step * fsm / (jm + motor_damping), step * fs / (jl + link_damping)
    integral = 0.0
    torque[:] = 0.0
    for i in range(feed.size):
        if i % SUBSTEPS == 0:
            position[i // SUBSTEPS] = a
        a += 0.5 * step * va
        b += 0.5 * step * vb
        error = wanted[i] - a
        integral += step * error
        asked = feed[i] + kp * error + kd * wanted_rate[i] + ki * (integral - 0.5 * step * error)
        given = waiting[i % late] if late > 0 else asked
        spring = k * (a - b)
        free = (va * (jm - motor_damping) + step * (given - spring)) / (jm + motor_damping)
        after = 0.0 if abs(free) <= motor_loss else free - math.copysign(motor_loss, free)
        torque[(i + SUBSTEPS // 2) // SUBSTEPS] += (given - 0.5 * inside * (va + after)) / SUBSTEPS
        if late > 0:
            waiting[i % late] = asked - 0.5 * kd * (va + after)
        va = after
        push = spring - gx * math.cos(b) - gy * math.sin(b)
        free = (vb * (jl - link_damping) + step * push) / (jl + link_damping)
        vb = 0.0 if abs(free) <= link_loss else free - math.copysign(link_loss, free)
        a += 0.5 * step * va
        b += 0.5 * step * vb
    position[-1] = a
    torque[0] *= 2.0  # half a sample lies within the recording
    torque[-1] *= 2.0


class ForwardProblem(FitProblem):
    """A recording compared with both masses simulated forward; `residuals` is what the two ways differ in."""

    def __init__(self, recording: Recording) -> None:
        super().__init__(recording, sensors="motor", band_hz=excited_band_hz(recording))
        rate = recording.sample_rate_hz
        self.drive_hz = min(DRIVE_MARGIN * self.band_hz, 0.45 * rate)
        self.step = recording.sample_time / SUBSTEPS
        self.fine = motor_motion(recording.motor_position, rate, cutoff_hz=self.drive_hz, substeps=SUBSTEPS)
        self._spectral = SpectralFilter(recording.time.size, rate, self.drive_hz, upsampling=2 * SUBSTEPS)
        self.drive: tuple[object, ...] = ()
        self.chain: tuple[str, ...] = ()

    def simulated(self, values: Values) -> tuple[Floats, Floats]:
        """Motor position, rad, and torque, N m (n,)."""
        p = np.array([values[k] * (GRAVITY if k in ("MX", "MY") else 1.0) for k in PARAMETERS])
        position, torque = np.empty((2, self.recording.time.size))
        first, rate = self.fine.fine_position[0], self.fine.fine_velocity[0]
        two_masses(p, *self.drive, first, rate, self.step, position, torque)
        return position, torque

    def sensitivities(self, values: Values, keys: Sequence[str], steps: Mapping[str, float]) -> tuple[Floats, ...]:
        """Forward differences, (m, len(keys)) a channel."""
        rest = self.residuals(values)
        moved = [self.residuals(values | {k: values[k] + steps[k]}) for k in keys]
        size = np.array([steps[k] for k in keys])
        return tuple(np.column_stack([t[i] - here for t in moved]) / size for i, here in enumerate(rest))


class TorqueDriven(ForwardProblem):
    """b: the residual is the torque that a PD at `feedback_hz` must add; critically damped for the start's inertia."""

    def __init__(self, recording: Recording, inertia: float, feedback_hz: float) -> None:
        super().__init__(recording)
        omega = 2.0 * math.pi * feedback_hz
        self._gains = np.array([inertia * omega**2, 2.0 * inertia * omega, 0.0])
        self._wanted = self.fine.fine_position[1::2].copy(), self.fine.fine_velocity[1::2].copy()
        self.chain = ("torque_delay", "torque_averaging")
        self._fed: list[float] = []

    def simulated(self, values: Values) -> tuple[Floats, Floats]:
        """Motor position, rad, and torque, N m (n,), fed the recorded torque with delay and averaging undone."""
        delay, averaging = fed = [values.get(k, 0.0) for k in self.chain]
        if fed != self._fed:
            ts = self.recording.sample_time
            (fine,) = self._spectral(self.recording.motor_torque, delay=-delay, curvature=-averaging * ts * ts)
            feed = fine[1::2].copy()
            self._fed, self.drive = fed, (self._gains, 0, feed, *self._wanted)
            self.given = np.pad(feed, SUBSTEPS // 2, mode="edge").reshape(-1, SUBSTEPS).mean(axis=1)
        return super().simulated(values)

    def residuals(self, values: Values) -> tuple[Floats, ...]:
        """Torque that the feedback adds (m,), N m."""
        return (self.reduced(self.simulated(values)[1] - self.given),)


class ReferenceDriven(ForwardProblem):
    """c: the residuals are torque and motor position of a closed loop along the recorded reference."""

    def __init__(self, recording: Recording, *, nearest: bool) -> None:
        super().__init__(recording)
        assert recording.reference is not None
        self._nearest, self._reference = nearest, recording.reference
        self.position = self.reduced(recording.motor_position)
        self.delays_ms, late = np.zeros(3), 0
        if nearest:
            options = {"maxfev": 100}
            free = optimize.minimize(
                lambda x: self._left(x)[0], [1.0, 1.0, 0.5], method="Nelder-Mead", options=options
            ).x
            late = max(0, round(1e-3 * free[2] / self.step))
            whole = [1e3 * late * self.step]
            free = optimize.minimize(lambda x: self._left([*x, *whole])[0], free[:2], method="Nelder-Mead").x
            self.delays_ms = np.array([*free, *whole])
        self.misfit, gains = self._left(self.delays_ms)
        position, velocity, acceleration = (x[1::2].copy() for x in self._smoothed(self.delays_ms))
        self.drive = (gains[1:4], late, gains[0] + gains[4] * acceleration, position, velocity)

    def _smoothed(self, delays_ms: Sequence[float] | Floats) -> list[Floats]:
        """The reference at half steps behind a delay and two equal lags: position, velocity and acceleration."""
        signals = list(self._spectral(self._reference, (0, 1, 2), delay=1e-3 * float(delays_ms[0])))
        lag = 1e-3 * abs(float(delays_ms[1]))
        if lag > 0.0:
            fall = math.exp(-0.5 * self.step / lag)
            b, a = [0.0, (1.0 - fall) ** 2], [1.0, -2.0 * fall, fall**2]
            signals = [signal.lfilter(b, a, x - x[0]) + x[0] for x in signals]
        return signals

    def _left(self, delays_ms: Sequence[float] | Floats) -> tuple[float, Floats]:
        """Rms of what is left of the torque, and constant, P, D, I, acceleration feedforward (5,).

        `delays_ms` (3,): delay and lag of the reference, delay of the torque behind all that it is regressed on.
        """
        position, velocity, acceleration = (x[:: 2 * SUBSTEPS] for x in self._smoothed(delays_ms))
        error, rate = position - self.fine.position, velocity - self.fine.velocity
        integral = (np.cumsum(error) - 0.5 * (error + error[0])) * self.recording.sample_time
        columns = [np.ones_like(error), error, rate, integral, *([acceleration] if self._nearest else [])]
        matrix = np.column_stack([self.reduced(c)[self.usable] for c in columns])
        target = self.reduced(self.recording.motor_torque, delay=-1e-3 * float(delays_ms[2]))[self.usable]
        scale = np.linalg.norm(matrix, axis=0)
        solution = np.linalg.lstsq(matrix / scale, target, rcond=1e-12)[0] / scale
        return float(np.std(target - matrix @ solution)), np.pad(solution, (0, 5 - solution.size))

    def residuals(self, values: Values) -> tuple[Floats, ...]:
        """Torque (m,), N m, and motor position (m,), rad."""
        position, torque = self.simulated(values)
        return self.torque - self.reduced(torque), self.position - self.reduced(position)


def cpu_time(function: Callable[[], object]) -> float:
    """The least CPU time of several runs, s; the first, which may compile, is not counted."""
    function()
    return min(timeit.repeat(function, timer=time.process_time, number=1, repeat=REPEATS))


def drawn(make: Callable[[], FitProblem], start: Values, model: JointModel, label: str) -> list[float] | None:
    """Of one fit: errors of Jm, K and JL in percent, s a simulation, steps of one, s a fit. None: it failed."""
    try:
        problem = make()
        motion, terms, substeps = problem.motion, terms_of(start, rigid=False), problem.substeps
        if isinstance(problem, ForwardProblem):
            simulation_s, substeps = cpu_time(lambda: problem.simulated(start)), SUBSTEPS
        else:
            simulation_s = cpu_time(lambda: motor_torque(terms, motion, link_motion(terms, motion), problem.sign))
        started = time.process_time()
        problem = make()
        priors = measurement_priors(problem)
        if isinstance(problem, ForwardProblem):
            priors = {k: priors[k] for k in problem.chain}
        fit = refined(SimulationFit(problem, priors=priors), (*PARAMETERS, *priors), start)
        fit_s = time.process_time() - started
    except (FlexIdentError, np.linalg.LinAlgError, ValueError) as error:
        print(f"{label}: {error}", file=sys.stderr)
        return None
    errors = [100.0 * (fit.values[k] / model.value(k) - 1.0) for k in PARAMETERS[:3]]
    note = " ".join(f"{k} {e:+.3f} %" for k, e in zip(PARAMETERS, errors, strict=False))
    if isinstance(problem, ReferenceDriven):
        note += f"; controller: delays {problem.delays_ms.round(3)} ms, {problem.misfit:.3g} N m left"
    print(label, note, file=sys.stderr)
    return [*errors, simulation_s, (problem.recording.time.size - 1.0) * substeps, fit_s]


def speeds(problem: FitProblem, values: Values) -> tuple[float, float]:
    """Plant steps a second of one link alone, and of a batch."""
    terms, motion = terms_of(values, rigid=False), problem.motion
    base, rate, step, n = motion.fine_position, motion.fine_velocity, motion.step, motion.fine_position.size // 2 + 1
    many, lanes = np.empty((3, LANES, n)), np.array([terms * (1.0 + 1e-6 * j) for j in range(LANES)])
    alone = cpu_time(lambda: simulated_link(terms, base, rate, step, *many[:, 0]))
    return (n - 1) / alone, LANES * (n - 1) / cpu_time(lambda: simulated_links(lanes, base, rate, step, *many))


def main() -> None:
    """Print one row for each joint and way, and the speed of the link's simulation."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=3)
    parser.add_argument("--joints", default="paper,cobot,series_elastic")
    parser.add_argument("--seconds", type=float, default=25.0)
    parser.add_argument("--feedback-hz", type=float, default=60.0)
    parser.add_argument("--torque-delay-ms", type=float, default=0.0)
    given = parser.parse_args()
    chain = MeasurementChain.with_bits(20, 20, torque_noise=0.01, jitter=0.05, lost=0.002)
    print("| joint | way | Jm % | K % | JL % | ms a simulation | million plant steps a second | s a fit | failed |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    fast = []
    for name in given.joints.split(","):
        model = JointModel(JOINTS[name].parameters, {"time_delay": {"delay": 1e-3 * given.torque_delay_ms}}, name)
        seen: dict[str, list[list[float] | None]] = {}
        for seed in range(given.draws):
            recording = virtual_recording(model, Experiment(duration_s=given.seconds), chain, seed=seed, link=False)
            problem = fit_problem(recording, sensors="motor")
            start = started_values(problem, PARAMETERS)
            ways: dict[str, Callable[[], FitProblem]] = {
                "a position drives the spring": lambda r=recording: fit_problem(r, sensors="motor"),
                "b torque with feedback": lambda r=recording, s=start: TorqueDriven(r, s["Jm"], given.feedback_hz),
            }
            for kind in ("P, PI", "nearest"):
                ways[f"c reference, {kind}"] = lambda r=recording, k=kind: ReferenceDriven(r, nearest=k == "nearest")
            for way, make in ways.items():
                seen.setdefault(way, []).append(drawn(make, start, model, f"{name} {way} {seed}"))
            if seed == 0:
                fast.append((name, problem.substeps, *speeds(problem, model.parameters)))
        for way, draws in seen.items():
            found = np.array([d for d in draws if d is not None] or [[np.nan] * 6])
            cells = [f"{e.mean():+.3f} ± {e.std():.3f}" for e in found.T[:3]]
            seconds = found[:, 3].min()
            failed = len(draws) - int(np.sum(np.abs(found[:, :3]).max(axis=1) <= FAILED))
            cells += [f"{1e3 * seconds:.2f}", f"{1e-6 * found[0, 4] / seconds:.1f}", f"{found[:, 5].mean():.2f}"]
            print(f"| {name} | {way} | " + " | ".join(cells) + f" | {failed} of {given.draws} |", flush=True)
    print("\n| joint | steps a sample | `simulated_link`, million steps a second | `simulated_links`, a batch of 8 |")
    print("| --- | --- | --- | --- |")
    for name, substeps, alone, together in fast:
        print(f"| {name} | {substeps} | {1e-6 * alone:.1f} | {1e-6 * together:.1f} |")


if __name__ == "__main__":
    main()
