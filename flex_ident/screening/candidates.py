"""What could be missing: each effect of the catalogue as it is tried on one recording."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np

from flex_ident.effects import CATALOGUE, Effect, Probe, Scales, effect_named
from flex_ident.effects.probe import PLAUSIBLE, SMOOTH_PROBE
from flex_ident.filtering.frequency_response import first_mode
from flex_ident.likelihood.problem import FitProblem
from flex_ident.parameters import GRAVITY_KEYS
from flex_ident.parameters.keys import key_text
from flex_ident.parameters.values import Values
from flex_ident.screening.anew import start_anew


@dataclass(frozen=True)
class Candidate:
    """One effect at one size and shape, its parameters under their written keys."""

    effect: str
    probe: Probe
    anew: Callable[[], Values] = field(default=Values, compare=False)
    """Values of all keys from which a fit may start as well, found without the base fit where this is far off; or none.
    They take a scan, which is made when they are first asked for."""
    suffix: str = ""
    """Of its parameters, where the effect is in the model already and may be there again."""

    @property
    def probes(self) -> tuple[Values, ...]:
        """Alternatives of its values, added to the base one at a time: each makes a column."""
        return tuple(self._written(column) for column in self.probe.columns)

    @property
    def scaled(self) -> tuple[str, ...]:
        """The keys that grow with the effect's size."""
        return tuple(map(self._key, self.probe.scaled))

    @property
    def replaces(self) -> str:
        """The measurement key that the effect takes over from; empty for most."""
        return effect_named(self.effect).replaces

    @property
    def plausible(self) -> float:
        """By how much the probe is smaller than the largest effect that nobody would have overlooked."""
        return PLAUSIBLE / SMOOTH_PROBE if self.probe.smooth else 1.0

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of the effect that are fitted."""
        effect = effect_named(self.effect)
        return tuple(self._key(k) for k in self.probe.columns[0] if not effect.parameter(k + self.suffix).fixed)

    @property
    def cycles(self) -> str:
        """The key of its periods in a turn of the motor; empty for what is not periodic."""
        name = effect_named(self.effect).cycles
        return self._key(name) if name else ""

    @property
    def side(self) -> str:
        """`link` for the variant on the link's side, else empty."""
        effect = effect_named(self.effect)
        return "link" if any(effect.parameter(name).on_link for name in self.probe.columns[0]) else ""

    def start(self, sizes: tuple[float, ...]) -> Values:
        """Values of the keys from which a fit starts, `sizes` being the linear estimates for each probe."""
        return self._written(self.probe.start(sizes))

    def _key(self, name: str) -> str:
        return key_text(self.effect, name + self.suffix)

    def _written(self, parameters: Mapping[str, float]) -> Values:
        return Values.of_effect(self.effect, {name + self.suffix: value for name, value in parameters.items()})


def candidates(
    problem: FitProblem, values: Values, *, effects: tuple[str, ...] = (), prismatic: bool = False
) -> Iterator[Candidate]:
    """Every law that makes sense for this problem and is not part of the model yet, as often as it may be, nor of a
    curve that is.

    `effects` restricts the catalogue where it is not empty; what slides (`prismatic`) has no first moments.
    """
    scales = scales_of(problem, values, prismatic=prismatic)
    curves = (effect_named(name).curve for name in values.effects)
    held = {name for curve in curves if curve is not None for name in curve.contains}
    for name, effect in CATALOGUE.items():
        suffix = _unused(effect, values)
        if suffix is None or (effects and name not in effects) or effect.curve is not None or name in held:
            continue
        if (effect.needs_spring and problem.rigid) or (effect.needs_link and problem.link is None):
            continue
        anew = cache(partial(start_anew, effect, problem, values, scales))
        for probe in effect.probes(scales):
            yield Candidate(name, probe, anew, suffix)


def _unused(effect: Effect, values: Values) -> str | None:
    """The first suffix under which the effect is not in the model; None where it is there as often as it may be."""
    if len(effect.again) == 1:
        return None if effect.name in values.effects else ""
    first = effect.parameters[0].name
    return next((s for s in effect.again if key_text(effect.name, first + s) not in values), None)


def scales_of(problem: FitProblem, values: Values, *, prismatic: bool = False) -> Scales:
    """What sizes of effects are measured against, for one problem under the model as it stands."""
    torque = float(np.std(problem.torque))
    speed = float(np.sqrt(np.mean(problem.motion.velocity**2)))
    spring = problem.link_response_of(values)
    load = torque if spring is None else float(np.std(spring.spring_torque))
    return Scales(
        torque=torque,
        speed=speed,
        load=load,
        deflection=1.0 if spring is None else load / values["K"],
        travel=float(np.ptp(problem.motion.position)),
        duration_s=float(problem.time[-1]),
        sample_time_s=problem.recording.sample_time,
        band_hz=problem.band_hz,
        most_cycles=2.0 * math.pi * problem.cutoff_hz / speed,
        recorded_torque=np.abs(problem.recording.motor_torque),
        sides=("",) if problem.rigid else ("", "_link"),
        model=values,
        missing_moments=() if prismatic else tuple(k for k in GRAVITY_KEYS if k not in values),
        link_mode=partial(_link_mode, problem, values),
    )


def _link_mode(problem: FitProblem, values: Values) -> tuple[float, float] | None:
    """Frequency, Hz, and inertia over the link's, of a mass that the link drags along; None without a link encoder.

    Spring torque over link acceleration is an apparent inertia, as motor torque over motor acceleration is.
    """
    recording = problem.recording
    if problem.link is None or recording.link_position is None:
        return None
    torque = values["K"] * (recording.motor_position - recording.link_position)
    own = replace(recording, motor_position=recording.link_position, motor_torque=torque, link_position=None)
    mode = first_mode(own)
    if not mode.confidence > 0.1:
        return None
    return mode.frequency_hz, (mode.free_resonance_hz / mode.frequency_hz) ** 2 - 1.0


def refined_candidates(candidate: Candidate) -> Iterator[Candidate]:
    """Neighbours of a candidate in its shape, finer than the grid."""
    name, steps = effect_named(candidate.effect).refined
    probe = candidate.probe
    for step in steps:
        columns = tuple({**column, name: column[name] * (1.0 + step)} for column in probe.columns)
        yield replace(candidate, probe=replace(probe, columns=columns))
