"""Measured and simulated signals side by side, filtered alike: what every simulation-based fit minimises."""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from flex_ident.effects import effect_named, key_named
from flex_ident.errors import ConfigurationError, ExcitationError
from flex_ident.filtering.direction import sharp_velocity, velocity_noise
from flex_ident.filtering.spectral import Complexes, SpectralFilter
from flex_ident.likelihood.cores import mapped
from flex_ident.likelihood.links import LinkResponses
from flex_ident.likelihood.thresholds import FAR_BANDS, FAR_DAMPING, FEWEST, HARDLY, MOST_SETTLING, UNSEEN_WAY
from flex_ident.parameters import FLEXIBLE_KEYS, RIGID_KEYS, JointModel
from flex_ident.parameters.parameter import FAR_MODE
from flex_ident.parameters.values import Values
from flex_ident.recording import Floats, Recording, extent_text, more_needed
from flex_ident.simulation.drive import delivered_torque, recorded_torque
from flex_ident.simulation.encoder_error import link_reading_error
from flex_ident.simulation.motion import MotorMotion, motor_motion
from flex_ident.simulation.response import LinkMotion, motor_torque, standstill_friction
from flex_ident.simulation.terms import BASE_TERMS, MEASUREMENT_TERMS, RIGID_TERMS, Term, no_terms
from flex_ident.simulation.turnover import as_sampled, friction_share

Bools = NDArray[np.bool_]

COMPARISON_MARGIN = 1.2
"""Cutoff of the comparison's low-pass over the excited band."""
DRIVE_MARGIN = 3.0
"""Cutoff of the low-pass on the recorded motor position over the excited band."""
REMEMBERED = 12
"""Ways of friction to turn over that are kept."""
SLOPES = 2
"""Points at which sensitivities are kept."""
MAX_SUBSTEPS = 8
SETTLING_S = 1.5
"""Time after a gap in which the simulated link is not compared, s."""


@dataclass(frozen=True)
class Prediction:
    """Motor torque (m,), N m, and link position (m,), rad, or None: filtered and decimated like the measurement."""

    torque: Floats
    link: Floats | None


def terms_of(values: Values, *, rigid: bool) -> Floats:
    """The simulation's terms for base (`K`), measurement (`torque_delay`) and effect (`backlash.gap`) keys.

    Raises ConfigurationError on a key that is none of them.
    """
    base = RIGID_TERMS if rigid else BASE_TERMS
    terms = no_terms()
    for key, value in values.base.items():
        if key in base:
            terms[base[key][0]] += value * base[key][1]
        elif key in MEASUREMENT_TERMS:
            terms[MEASUREMENT_TERMS[key][0]] += value * MEASUREMENT_TERMS[key][1]
        elif key != FAR_MODE:
            raise ConfigurationError(f"unknown parameter {key}.")
    for effect, parameters in values.effects.items():
        effect_named(effect).contribute(terms, parameters)
    return terms


def values_of(model: JointModel) -> Values:
    """The values of a model, effects included."""
    values = Values(model.parameters)
    for effect, parameters in model.effects.items():
        values |= Values.of_effect(effect, parameters)
    return values


def model_of(values: Values, *, rigid: bool, joint: str = "") -> JointModel:
    """The model with these values; measurement keys are left out."""
    base = RIGID_KEYS if rigid else FLEXIBLE_KEYS
    return JointModel({k: values[k] for k in base if k in values}, values.effects, joint)


def _held_after(marks: Bools, count: int) -> Bools:
    """`marks` (n,), and the `count` samples after each."""
    total = np.cumsum(np.concatenate(([0], marks)))
    before = np.maximum(np.arange(marks.size) - count, 0)
    held: Bools = total[1:] > total[before]
    return held


class FitProblem:
    """One recording prepared for fitting: the motor's motion, and the measured signals filtered and decimated.

    `time`, `torque`, `link` (m,) are the measured signals at `rate_hz`; `usable` (m,) is False at the edges, across
    gaps and where the motor stands still (there Coulomb friction takes any value). Raises ExcitationError when too
    little is left.
    """

    def __init__(
        self,
        recording: Recording,
        *,
        sensors: str = "motor",
        rigid: bool = False,
        band_hz: float,
        stiffest_hz: float | None = None,
        trim_s: float = 1.0,
    ) -> None:
        rate = recording.sample_rate_hz
        self.recording = recording
        self.rigid = rigid
        self.sensors = sensors
        self.band_hz = band_hz
        self.cutoff_hz = min(COMPARISON_MARGIN * band_hz, 0.45 * rate)
        self.drive_hz = drive_hz = min(DRIVE_MARGIN * band_hz, 0.45 * rate)
        # Runge-Kutta 4 wants about a quarter of a radian a step at the fastest mode of the link.
        fastest = 2.0 * math.pi * (stiffest_hz if stiffest_hz is not None else 2.0 * band_hz)
        self.substeps = 1 if rigid else int(np.clip(math.ceil(fastest / rate / 0.35), 1, MAX_SUBSTEPS))
        self.motion: MotorMotion = motor_motion(
            recording.motor_position, rate, cutoff_hz=drive_hz, substeps=self.substeps
        )
        n = recording.motor_position.size
        self.decimation = max(1, int(rate / (2.5 * self.cutoff_hz)))
        self._filter = SpectralFilter(n, rate, self.cutoff_hz, decimation=self.decimation)
        self.rate_hz = rate / self.decimation
        self.time: Floats = recording.time[:: self.decimation]
        self._noise = float(np.std((recording.motor_position - self.motion.position)[10:-10]))
        self.resolution = 2.0 * velocity_noise(self._noise, drive_hz, rate)
        self.resting_speed = self.resolution
        """Speed, rad/s, up to which the motor is taken to stand still."""
        self.sharp = sharp_velocity(recording.motor_position, rate, lowest_hz=drive_hz)
        self._shares: dict[tuple[float, ...], Floats] = {}
        self._slopes: dict[Hashable, tuple[Floats, ...]] = {}
        self._lock = threading.Lock()
        self._raw_torque = recording.motor_torque
        self.torque = self.reduced(recording.motor_torque)
        signals = (self.torque, self.motion.position, self.motion.velocity, self.motion.acceleration)
        self.spread = tuple(float(np.std(s)) or 1.0 for s in signals)
        """Standard deviations of torque, N m, and of the motor's position, velocity and acceleration; 1 for none."""
        has_link = sensors == "motor+link" and recording.link_position is not None and not rigid
        self.link: Floats | None = None
        if has_link and recording.link_position is not None:
            self.link = self.reduced(recording.link_position)
        self.usable: Bools = self._usable(recording, trim_s)
        if int(self.usable.sum()) < FEWEST:
            moving = np.abs(self.motion.velocity[:: self.decimation]) > self.resolution
            if self.usable.size >= 2 * FEWEST and float(np.mean(moving)) < HARDLY:
                raise ExcitationError(
                    f"joint {recording.joint} hardly moves: it is faster than its encoder resolves in "
                    f"{100.0 * float(np.mean(moving)):.0f} % of the recording only. Record it while it follows a chirp."
                )
            raise ExcitationError(
                f"{int(self.usable.sum())} usable samples are left of {extent_text(n, rate)} after filtering, edges, "
                f"gaps and standstill: {more_needed(n, rate)}"
            )
        self._links = LinkResponses(self.motion, lambda position, skew: self.reduced(position, delay=skew))
        self._shaken: FitProblem | None = None
        self._middle = float(np.mean(recording.motor_position))

    def reduced(self, signal: Floats, *, delay: float = 0.0, curvature: float = 0.0, lag: float = 0.0) -> Floats:
        """A signal (n,) at the recording's rate, filtered and decimated (m,) as the measurement is.

        `delay`, s; `curvature`, s^2 (see `SpectralFilter`); `lag`, s, the time constant of a first-order low-pass.
        """
        (filtered,) = self._filter(signal, delay=delay, curvature=curvature, lag=lag)
        return filtered

    def friction_share(self, terms: Floats) -> Floats:
        """The motor's dry friction over its size (n,), -1 to 1, as it turns over at reversals; the last are kept.

        Of the direction alone where bristles or a soft constraint say how it turns over.
        """
        jump = standstill_friction(terms) / max(float(terms[Term.MOTOR_INERTIA]), 1e-12)
        key = (float(terms[Term.REVERSAL_SPEED]), float(terms[Term.PRESLIDING]), float(terms[Term.REVERSAL_LEAD]), jump)
        if terms[Term.BRISTLE_DEFLECTION] > 0.0 or terms[Term.SOFT_FRICTION] > 0.0:
            key = (0.0, 0.0, 0.0, 0.0)
        known = self._shares.get(key)
        if known is None:
            speed, way, lead, jump = key
            speed, way = max(speed, 0.0), max(way, 0.0)
            mean = friction_share(
                self.sharp.velocity, self.sharp.half_width, self.motion.position, speed=speed, way=way,
                lead=lead / self.recording.sample_time, resolution=UNSEEN_WAY * self._noise,
                kink=self.sharp.kink(jump, speed=speed, way=way),
            )  # fmt: skip
            known = as_sampled(mean)
            with self._lock:
                self._shares[key] = known
                while len(self._shares) > REMEMBERED:
                    self._shares.pop(next(iter(self._shares)))
        return known

    def reduced_through(self, signal: Floats, transfer: Callable[[Floats], Complexes]) -> Floats:
        """The same of a signal behind a linear system, whose `transfer` is asked at angular frequencies, rad/s."""
        return self._filter.through(signal, transfer)[0]

    def reduced_through_each(
        self, signal: Floats, torque: Callable[[Floats], Complexes], position: Callable[[Floats], Complexes]
    ) -> list[Floats]:
        """The same behind the system that leads to the torque, and behind that to the link's position where there is
        one."""
        transfers = (torque, position) if self.link is not None else (torque,)
        return list(self._filter.through(signal, *transfers))

    def _usable(self, recording: Recording, trim_s: float) -> Bools:
        n, rate = recording.motor_position.size, recording.sample_rate_hz
        trim = int(min(trim_s * rate, n / 10))
        bad = np.zeros(n, bool)
        bad[:trim] = True
        bad[n - trim :] = True
        assert recording.measured is not None
        if not recording.measured.all():
            margin = max(1, int(rate / self.cutoff_hz))
            missing = ndimage.binary_dilation(~recording.measured, iterations=margin)
            # Over a gap the simulated link was driven by a guess: it takes a while to forget that.
            settling = _held_after(missing, 0 if self.rigid else round(SETTLING_S * rate))
            bad |= settling if float(np.mean(settling)) < MOST_SETTLING else missing
        window = max(3, int(0.1 * rate))
        moving = ndimage.uniform_filter1d((np.abs(self.motion.velocity) > self.resting_speed).astype(float), window)
        bad |= moving < 0.5
        usable: Bools = ~bad[:: self.decimation]
        return usable

    def terms(self, values: Values) -> Floats:
        """The simulation's terms (len(Term),) for the values.

        A mode above the band is a second mass on the link, where the model has none of its own. JL is the inertia of
        both. Raises ConfigurationError.
        """
        terms, share = terms_of(values, rigid=self.rigid), values.get(FAR_MODE, 0.0)
        if share != 0.0 and terms[Term.SECOND_INERTIA] == 0.0:
            natural, inertia = 2.0 * math.pi * FAR_BANDS * self.band_hz, share * terms[Term.LINK_INERTIA]
            terms[Term.SECOND_INERTIA] = inertia
            terms[Term.SECOND_STIFFNESS] = inertia * natural**2
            terms[Term.SECOND_DAMPING] = 2.0 * FAR_DAMPING * inertia * natural
            terms[Term.LINK_INERTIA] -= inertia
        return terms

    def link_response(self, terms: Floats) -> LinkMotion | None:
        """The link's motion under `terms` at the recording's rate; None for a rigid joint."""
        if self.rigid:
            return None
        return self._links.of(terms)

    def link_response_of(self, values: Values) -> LinkMotion | None:
        """The link's motion (n,) under the values; None for a rigid joint."""
        return self.link_response(self.terms(values))

    def prediction(self, values: Values) -> Prediction:
        """What the model with these values says the measurement is; NaN when its simulation runs away."""
        return self._prediction(self.terms(values))

    def _prediction(self, terms: Floats, link: LinkMotion | None = None) -> Prediction:
        if link is None:
            link = self.link_response(terms)
        torque = motor_torque(terms, self.motion, link, self.friction_share(terms))
        torque = recorded_torque(terms, torque, self.motion.velocity)
        ts, lag = self.recording.sample_time, float(terms[Term.EFFORT_LAG])
        torque_out = self.reduced(
            torque, delay=float(terms[Term.TORQUE_DELAY]), curvature=float(terms[Term.TORQUE_AVERAGING]) * ts * ts,
            lag=lag,
        )  # fmt: skip
        if terms[Term.GAIN_RATE] != 0.0:  # as in `recorded_torque`
            torque_out = torque_out * (1.0 + terms[Term.GAIN_RATE] * (self.time - self.time[0]))
        if terms[Term.OFFSET_RATE] != 0.0:
            torque_out = torque_out + terms[Term.OFFSET_RATE] * (self.time - self.time[0])
        link_out = None
        if self.link is not None and link is not None:
            position = self._links.filtered_position(link, float(terms[Term.LINK_SKEW]))
            drift = float(terms[Term.LINK_DRIFT])
            if drift != 0.0:
                position = position + self._drifted(link, float(terms[Term.LINK_SKEW]), drift)
            misread = link_reading_error(terms, link.position)
            if misread is not None:
                position = position + self.reduced(misread, delay=float(terms[Term.LINK_SKEW]))
            moved = position - self._middle
            link_out = position + terms[Term.LINK_SCALE] * moved + terms[Term.LINK_ZERO]
        return Prediction(torque_out, link_out)

    def _drifted(self, link: LinkMotion, skew: float, drift: float) -> Floats:
        """What the link's position (m,) differs by where its clock gains `drift` on the motor's, s/s: to second order
        in the time that it is off, which is none in the middle."""
        late = drift * (self.time - 0.5 * self.time[-1])
        velocity, acceleration = self._filter(link.velocity, (0, 1), delay=skew)
        off: Floats = -late * velocity + 0.5 * late**2 * acceleration
        return off

    def measured_torque(self, values: Values) -> Floats:
        """The recorded torque (m,), or as much of it as the model says that the drive delivered."""
        delivered = delivered_torque(self.terms(values), self._raw_torque)
        return self.torque if delivered is self._raw_torque else self.reduced(delivered)

    def _limited(self, values: Values) -> bool:
        """Whether a force bears on what was measured, or the reading is not in proportion: then scaling all forces
        does not scale the residual."""
        terms = self.terms(values)
        return bool(terms[Term.IRON_LOSS] != 0.0 or terms[Term.TORQUE_LIMIT] != 0.0)

    def residuals(self, values: Values) -> tuple[Floats, ...]:
        """Measured minus predicted, (m,) each: torque, and link position where there is one."""
        return self._compared(values, self._prediction(self.terms(values)))

    def residuals_of_many(self, many: Sequence[Values]) -> list[tuple[Floats, ...]]:
        """The same under each of several sets of values, in one pass on all cores."""
        terms = [self.terms(values) for values in many]
        links = [None] * len(terms) if self.rigid else self._links.of_many(terms)
        samples = self.motion.position.size
        return mapped(lambda v, t, k: self._compared(v, self._prediction(t, k)), many, terms, links, samples=samples)

    def _compared(self, values: Values, predicted: Prediction) -> tuple[Floats, ...]:
        residual = [self.measured_torque(values) - predicted.torque]
        if self.link is not None and predicted.link is not None:
            residual.append(self.link - predicted.link)
        return tuple(residual)

    def sensitivities(self, values: Values, keys: Sequence[str], steps: Mapping[str, float]) -> tuple[Floats, ...]:
        """Derivative of each residual with respect to `keys`, (m, len(keys)) a channel; forward differences.

        `steps` gives the size of each difference. All keys that move the link are simulated in one pass. All forces
        scaled together leave the link's motion as it is and scale the torque (Euler's theorem on homogeneous
        functions), which gives the column of JL from the others; differences must honour that to the last digit, or a
        precise link encoder would seem to know the scale. The last are remembered: the end of one fit is the start of
        the next.
        """
        asked = (values, tuple(keys), tuple(steps[key] for key in keys))
        known = self._slopes.get(asked)
        if known is None:
            known = self._differences(values, keys, steps)
            with self._lock:
                self._slopes[asked] = known
                while len(self._slopes) > SLOPES:
                    self._slopes.pop(next(iter(self._slopes)))
        return known

    def _differences(self, values: Values, keys: Sequence[str], steps: Mapping[str, float]) -> tuple[Floats, ...]:
        base = self.prediction(values)
        rest = self._compared(values, base)
        columns = [np.zeros((r.size, len(keys))) for r in rest]
        scaling = [key for key, value in values.items() if value != 0.0 and key_named(key).is_force]
        homogeneous = "JL" in keys and set(scaling) <= set(keys) and not self._limited(values)
        varied = [key for key in keys if not (homogeneous and key == "JL")]
        moved = [values | {key: values.get(key, 0.0) + steps[key]} for key in varied]
        for key, there in zip(varied, self.residuals_of_many(moved), strict=True):
            for column, r0, r1 in zip(columns, rest, there, strict=True):
                column[:, keys.index(key)] = (r1 - r0) / steps[key]
        if homogeneous:
            weights = np.array([values[key] if key in scaling and key != "JL" else 0.0 for key in keys])
            for column, scaled in zip(columns, (base.torque, 0.0), strict=False):
                column[:, keys.index("JL")] = -(scaled + column @ weights) / values["JL"]
        for column in columns:
            column.setflags(write=False)
        return tuple(columns)

    def shaken(self, size: Callable[[FitProblem], float]) -> FitProblem:
        """The same problem with as much white noise more on the recorded motor position as there is: `size`, rad.

        Made once. What its prediction differs by is what an encoder's rounding does to it.
        """
        if self._shaken is None:
            noise = np.random.default_rng(0).standard_normal(self.recording.motor_position.size)
            self._shaken = self.shifted(size(self) * noise)
        return self._shaken

    def shifted(self, by: Floats, *, direction: bool = False) -> FitProblem:
        """The same problem with the recorded motor position moved `by` (n,), rad; its `direction` of motion as well."""
        rate, position = self.recording.sample_rate_hz, self.recording.motor_position + by
        other = self.restricted(self.usable)
        other.motion = motor_motion(position, rate, cutoff_hz=self.drive_hz, substeps=self.substeps)
        other._slopes = {}
        other._links = LinkResponses(other.motion, lambda position, skew: self.reduced(position, delay=skew))
        if direction:
            other.sharp, other._shares = sharp_velocity(position, rate, lowest_hz=self.drive_hz), {}
        return other

    def resting_below(self, speed: float) -> FitProblem:
        """The same problem in which a motor slower than `speed`, rad/s, stands still as well."""
        other = self.restricted(self.usable)
        other.resting_speed = max(speed, self.resolution)
        other.usable = self.usable & other._usable(self.recording, 0.0)
        return other

    def restricted(self, usable: Bools) -> FitProblem:
        """The same problem with other usable samples (shares everything else)."""
        copy = object.__new__(FitProblem)
        copy.__dict__.update(self.__dict__)
        copy.usable = usable
        return copy
