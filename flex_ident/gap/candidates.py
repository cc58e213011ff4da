"""What could be missing: each effect of the catalogue with the sizes and shapes at which it is tried."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from flex_ident.effects import CATALOGUE
from flex_ident.errors import ExcitationError
from flex_ident.estimation.problem import FitProblem
from flex_ident.estimation.start import delay_scanned_start, limit_scanned_start, spring_scanned_start
from flex_ident.filtering import first_mode
from flex_ident.gap.options import GapOptions
from flex_ident.gap.spring_start import dead_band_start
from flex_ident.parameters import GRAVITY_KEYS
from flex_ident.recording import Floats
from flex_ident.simulation.terms import Term

REPLACES = {"time_delay": "torque_delay", "encoder_skew": "link_skew"}
"""Effects that take over from a measurement key, which is confined to one sample."""
FAR_OFF = 0.2
"""Residual over torque, rms, from which the base fit is not where a delay or a saturation should start from."""
BENT = 0.02
"""Likewise for a spring whose law is scanned."""
HARDENINGS = (-0.1, -0.03, 0.01, 0.03, 0.1, 0.3)
"""Cubic over linear part of the spring's torque at the rms deflection of the best linear spring."""
LEAST_FRICTION = 0.05
"""Share of the link's viscous friction that is left when damping takes its part over."""
SMOOTH_PROBE = 1e-3
"""Size of the probe of an effect that enters smoothly: what resonates is linear in small changes only."""
PLAUSIBLE = 0.05
"""Largest size worth testing for, in the units of the smooth probes."""
LIMIT_SHARES = np.array((0.2, 0.4, 0.55, 0.7, 0.8, 0.88, 0.94))
LIMIT_QUANTILES = (0.6, 0.75, 0.9, 0.95, 0.98, 0.99, 0.995)
MOST_CYCLES = 90
"""Largest number of spatial frequencies tried for a periodic effect."""


@dataclass(frozen=True)
class Candidate:
    """One effect at one size and shape: `probes` are alternatives of its flat keys, added to the base one at a time.

    `scaled` are the keys that grow with the effect's size; `one_sided` says that only positive sizes exist.
    """

    effect: str
    probes: tuple[Mapping[str, float], ...]
    scaled: tuple[str, ...]
    one_sided: bool
    smooth: bool = False
    """The prediction changes in proportion to the size: the probe is small and says by how much it must grow."""
    base: Mapping[str, float] = field(default_factory=dict)
    """Values of the model's own keys from which a fit with this candidate had better start."""
    anew: Mapping[str, float] = field(default_factory=dict)
    """Values of all keys from which a fit may start as well, found without the base fit where this is far off."""

    @property
    def plausible(self) -> float:
        """By how much the probe is smaller than the largest effect that nobody would have overlooked."""
        return PLAUSIBLE / SMOOTH_PROBE if self.smooth else 1.0

    @property
    def keys(self) -> tuple[str, ...]:
        """All flat keys of the effect."""
        return tuple(self.probes[0])

    @property
    def side(self) -> str:
        """`link` for the variant on the link's side, else empty."""
        return "link" if any(k.endswith("_link") for k in self.keys) else ""

    def start(self, sizes: tuple[float, ...]) -> dict[str, float]:
        """Values of the keys from which a fit starts, `sizes` being the linear estimates for each probe."""
        values = dict(self.probes[0])
        if f"{self.effect}.phase" in values:
            amplitude = f"{self.effect}.amplitude"
            values[amplitude] *= math.hypot(*sizes)
            values[f"{self.effect}.phase"] = math.atan2(sizes[1], sizes[0])
            return values
        if len(self.probes) > 1:
            return {k: sum(a * p[k] for a, p in zip(sizes, self.probes, strict=True)) for k in values}
        size = sizes[0] if self.smooth else float(np.clip(sizes[0], 0.2, 3.0))
        return {k: v * size if k in self.scaled else v for k, v in values.items()}


def candidates(problem: FitProblem, values: Mapping[str, float], options: GapOptions) -> Iterator[Candidate]:
    """Every candidate that makes sense for this problem and is not part of the model yet."""
    present = {k.split(".")[0] for k in values if "." in k}
    for name, effect in CATALOGUE.items():
        if name in present or (options.effects and name not in options.effects):
            continue
        if (effect.needs_spring and problem.rigid) or (effect.needs_link and problem.link is None):
            continue
        yield from _of_effect(name, problem, values, options)


def _of_effect(name: str, problem: FitProblem, values: Mapping[str, float], options: GapOptions) -> Iterator[Candidate]:
    torque = float(np.std(problem.torque))
    speed = float(np.sqrt(np.mean(problem.motion.velocity**2)))
    ts = problem.recording.sample_time
    spring = problem.link_response_of(values)
    load = float(np.std(spring.spring_torque)) if spring is not None else torque
    bend = load / values["K"] if spring is not None else 1.0

    def one(keys: Mapping[str, float], *, scaled: tuple[str, ...] = (), one_sided: bool = False) -> Candidate:
        full = {f"{name}.{k}": v for k, v in keys.items()}
        return Candidate(name, (full,), tuple(f"{name}.{k}" for k in (scaled or tuple(keys))), one_sided)

    def slope(key: str, value: float, *, one_sided: bool = False) -> Candidate:
        flat = f"{name}.{key}"
        return Candidate(name, ({flat: SMOOTH_PROBE * value},), (flat,), one_sided, smooth=True)

    sides = ("",) if problem.rigid else ("", "_link")
    match name:
        case "stribeck_friction":
            for side in sides:
                for share in (0.03, 0.08, 0.2, 0.5):
                    yield one({f"amplitude{side}": 0.02 * torque, f"velocity{side}": share * speed},
                              scaled=(f"amplitude{side}",), one_sided=True)  # fmt: skip
        case "torque_offset":
            if "offset" not in values:
                yield slope("offset", torque)
        case "viscous_asymmetry":
            for side in sides:
                yield slope(f"coefficient{side}", torque / speed)
        case "viscous_nonlinearity":
            for side in sides:
                yield slope(f"coefficient{side}", torque / speed**2)
        case "load_dependent_friction":
            for side in sides:
                yield slope(f"coefficient{side}", 1.0, one_sided=True)
        case "friction_drift":
            yield slope("rate", 1.0 / max(float(problem.time[-1]), 1.0))
        case "gravity":
            missing = [k for k in GRAVITY_KEYS if k not in values and not options.prismatic]
            if missing:
                each = tuple(
                    {f"gravity.{k}": SMOOTH_PROBE * torque / 9.81 * (k == m) for k in missing} for m in missing
                )
                yield Candidate(name, each, tuple(f"gravity.{k}" for k in missing), False, smooth=True)
        case "nonlinear_stiffness":
            yield replace(slope("cubic", load / bend**3), anew=_bent(problem, values, bend))
        case "backlash":
            found = _anew(values, dead_band_start(problem))
            for share in (0.01, 0.03, 0.1, 0.3, 1.0):
                yield replace(one({"gap": share * bend}, one_sided=True), anew=found)
        case "hysteresis":
            for share in (0.03, 0.1, 0.3, 1.0):
                yield one({"torque": 0.02 * load, "deflection": share * bend}, scaled=("torque",), one_sided=True)
        case "joint_damping":
            omega = math.sqrt(values["K"] / values["JL"])
            yield replace(slope("damping", values["K"] / omega, one_sided=True), anew=_unskewed(values))
        case "torque_ripple":
            yield from _periodic(name, problem, SMOOTH_PROBE * torque)
        case "kinematic_error":
            yield from _periodic(name, problem, SMOOTH_PROBE * bend)
        case "time_delay":
            yield replace(slope("delay", 30.0 * ts), anew=_delayed(problem, values))
        case "encoder_skew":
            yield slope("skew", 30.0 * ts)
        case "saturation":
            recorded, found = np.abs(problem.recording.motor_torque), _clipped(problem, values)
            for limit in (*(np.max(recorded) * LIMIT_SHARES), *np.quantile(recorded, LIMIT_QUANTILES)):
                yield replace(one({"limit": float(limit)}, one_sided=True), anew=found)
        case "second_mode":
            yield from _second_modes(problem, values)


def _torque_residual(problem: FitProblem, values: Mapping[str, float]) -> Floats:
    return problem.residuals(values)[0][problem.usable]


def _far_off(problem: FitProblem, values: Mapping[str, float]) -> bool:
    left = float(np.std(_torque_residual(problem, values)))
    return not problem.rigid and left >= FAR_OFF * float(np.std(problem.torque[problem.usable]))


def _delayed(problem: FitProblem, values: Mapping[str, float]) -> dict[str, float]:
    """A start that knows the torque's delay: a fit that had to do without one may be lost."""
    if not _far_off(problem, values):
        return {}
    try:
        delay, found = delay_scanned_start(problem)
    except ExcitationError:
        return {}
    return _anew(values, {**found, "time_delay.delay": delay})


def _clipped(problem: FitProblem, values: Mapping[str, float]) -> dict[str, float]:
    """A start that knows where the drive saturates, likewise."""
    if not _far_off(problem, values):
        return {}
    try:
        limit, found = limit_scanned_start(problem)
    except ExcitationError:
        return {}
    return _anew(values, {**found, "saturation.limit": limit})


def _unskewed(values: Mapping[str, float]) -> dict[str, float]:
    """A start with the damping that a skew of the encoders and the link's friction stood in for."""
    damping = -values.get("link_skew", 0.0) * values["K"]
    if damping <= 0.0:
        return {}
    friction = {k: max(v - damping, LEAST_FRICTION * v) for k, v in values.items() if k == "FV"}
    return {**values, **friction, "link_skew": 0.0, "joint_damping.damping": damping}


def _bent(problem: FitProblem, values: Mapping[str, float], bend: float) -> dict[str, float]:
    """A start that knows how the spring hardens or softens: the best linear spring has its resonance elsewhere."""
    if problem.rigid or float(np.std(_torque_residual(problem, values))) < BENT * float(np.std(problem.torque)):
        return {}

    def hardening(share: float) -> Callable[[float], Mapping[Term, float]]:
        return lambda square: {Term.CUBIC_STIFFNESS: share * square / bend**2}

    try:
        which, inertia, found = spring_scanned_start(problem, [hardening(share) for share in HARDENINGS])
    except ExcitationError:
        return {}
    square = found["K"] / inertia
    return _anew(values, {**found, "nonlinear_stiffness.cubic": HARDENINGS[which] * square / bend**2 * inertia})


def _anew(values: Mapping[str, float], found: Mapping[str, float]) -> dict[str, float]:
    """The keys of a model as found without it, measurement keys at zero, and those of the effect."""
    if not found:
        return {}
    own = {k: v for k, v in found.items() if "." in k}
    return {**{k: found.get(k, v if "." in k else 0.0) for k, v in values.items()}, **own}


def _second_modes(problem: FitProblem, values: Mapping[str, float]) -> Iterator[Candidate]:
    """Further masses over a grid of frequencies; with a link encoder first the one that the link's own motion shows."""
    name = "second_mode"

    def mass(frequency_hz: float, inertia: float, ratio: float, **base: float) -> Candidate:
        omega = 2.0 * math.pi * frequency_hz
        keys = {f"{name}.inertia": inertia, f"{name}.stiffness": inertia * omega**2,
                f"{name}.damping": 2.0 * ratio * inertia * omega}  # fmt: skip
        return Candidate(name, (keys,), tuple(keys), True, base=base)

    seen = _link_mode(problem, values)
    if seen is not None:
        frequency_hz, share = seen
        inertia = values["JL"] * share / (1.0 + share)
        yield mass(frequency_hz, inertia, 0.02, JL=values["JL"] - inertia)
    locked = math.sqrt(values["K"] / values["JL"]) / (2.0 * math.pi)
    highest = max(0.6 * locked, min(5.0 * locked, problem.band_hz))
    for frequency, share in product(np.geomspace(0.6 * locked, highest, 10), (0.06, 0.2)):
        inertia = share * values["JL"]
        yield mass(float(frequency), inertia, 0.03, JL=values["JL"] - inertia)


def _link_mode(problem: FitProblem, values: Mapping[str, float]) -> tuple[float, float] | None:
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


def _periodic(name: str, problem: FitProblem, amplitude: float) -> Iterator[Candidate]:
    """Spatial frequencies from one period over the range of motion to what the band carries at moderate speed."""
    reach = float(np.ptp(problem.motion.position))
    speed = float(np.sqrt(np.mean(problem.motion.velocity**2)))
    low = 2.0 * math.pi / reach
    high = max(4.0 * low, min(2.0 * math.pi * problem.cutoff_hz / speed, 2000.0))
    count = int(min(MOST_CYCLES, max(12, (high - low) / (0.35 * low))))
    for cycles in np.geomspace(low, high, count):
        keys = {f"{name}.amplitude": amplitude, f"{name}.cycles_per_turn": float(cycles), f"{name}.phase": 0.0}
        quarter = {**keys, f"{name}.phase": 0.5 * math.pi}
        yield Candidate(name, (keys, quarter), (f"{name}.amplitude",), False, smooth=True)


def refined_candidates(candidate: Candidate) -> Iterator[Candidate]:
    """Neighbours of a candidate in its shape, finer than the grid."""
    shape = {
        "torque_ripple": "cycles_per_turn", "kinematic_error": "cycles_per_turn", "saturation": "limit",
        "second_mode": "stiffness",
    }.get(candidate.effect)  # fmt: skip
    if shape is None:
        return
    key = f"{candidate.effect}.{shape}"
    steps = np.linspace(-0.06, 0.06, 13) if shape != "stiffness" else np.linspace(-0.3, 0.3, 5)
    for step in steps:
        factor = 1.0 + float(step)
        yield Candidate(
            candidate.effect,
            tuple({**p, key: p[key] * factor} for p in candidate.probes),
            candidate.scaled,
            candidate.one_sided,
            candidate.smooth,
        )
