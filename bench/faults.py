"""Faults of what robots publish, put into a clean recording: messages with stamps, times of reception and numbers.

Knows nothing of flex_ident. `FAULTS` says which there are, in which strengths, and by which codes they are named.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LATENCY_S, LATENCY_SCATTER_S = 4e-4, 1.5e-4
"""Time from stamp to reception: its least, and the mean of what is added to it."""


@dataclass(frozen=True)
class Told:
    """Messages of one topic of joint states: `stamp` and `received` (n,), s, `position` (n,) and `effort` (n,).

    `name` (n,): 0 for the joint itself, 1 for another one.
    """

    stamp: Floats
    received: Floats
    position: Floats
    effort: Floats
    name: NDArray[np.int64]

    def taken(self, which: NDArray[np.bool_] | slice) -> Told:
        """Some of the messages."""
        return Told(*(getattr(self, k)[which] for k in ("stamp", "received", "position", "effort", "name")))

    def joined(self, other: Told) -> Told:
        """The messages of both, in the order of their reception."""
        both = Told(
            *(np.concatenate((getattr(self, k), getattr(other, k)))
              for k in ("stamp", "received", "position", "effort", "name"))
        )  # fmt: skip
        return both.taken(np.argsort(both.received, kind="stable"))  # type: ignore[arg-type]


@dataclass(frozen=True)
class Played:
    """A recording as messages: those of the joint, those of its link encoder if there is one, and what it was made of.

    `frequency_hz` (n,) is the chirp's at each message, `locked_hz` the first mode, `gear` turns of the motor.
    """

    joint: Told
    link: Told | None
    rate_hz: float
    frequency_hz: Floats
    locked_hz: float
    gear: float


def told(time: Floats, position: Floats, effort: Floats, rng: np.random.Generator) -> Told:
    """Clean messages, received in their order a little after their stamps."""
    received = time + LATENCY_S + LATENCY_SCATTER_S * rng.exponential(size=time.size)
    return Told(time, np.maximum.accumulate(received), position, effort, np.zeros(time.size, np.int64))


Fault = Callable[[Played, float, np.random.Generator], Played]


def _with(played: Played, **changed: Floats) -> Played:
    return replace(played, joint=replace(played.joint, **changed))


def _publisher(played: Played, share: float, rng: np.random.Generator, name: int) -> Told:
    """Another publisher's messages at `share` of the rate: zeros."""
    count = max(2, round(share * played.joint.stamp.size))
    time = np.linspace(played.joint.stamp[0] + 3e-4, played.joint.stamp[-1], count)
    zeros = np.zeros(count)
    return replace(told(time, zeros, zeros, rng), name=np.full(count, name))


def second_zeros(played: Played, share: float, rng: np.random.Generator) -> Played:
    """A second publisher says that joint and effort are zero, at `share` of the rate."""
    return replace(played, joint=played.joint.joined(_publisher(played, share, rng, 0)))


def second_others(played: Played, share: float, rng: np.random.Generator) -> Played:
    """A second publisher says where another joint is, at `share` of the rate."""
    return replace(played, joint=played.joint.joined(_publisher(played, share, rng, 1)))


def _hit(played: Played, share: float, rng: np.random.Generator) -> NDArray[np.bool_]:
    return np.asarray(rng.random(played.joint.stamp.size) < share)


def zeros_in_effort(played: Played, share: float, rng: np.random.Generator) -> Played:
    return _with(played, effort=np.where(_hit(played, share, rng), 0.0, played.joint.effort))


def zeros_in_position(played: Played, share: float, rng: np.random.Generator) -> Played:
    return _with(played, position=np.where(_hit(played, share, rng), 0.0, played.joint.position))


def _spiked(values: Floats, size: float, hit: NDArray[np.bool_], rng: np.random.Generator) -> Floats:
    sizes = size * np.ptp(values) * rng.choice((-1.0, 1.0), values.size) * rng.uniform(0.7, 1.3, values.size)
    return np.where(hit, values + sizes, values)


def spikes_in_effort(played: Played, size: float, rng: np.random.Generator) -> Played:
    """One in a hundred efforts is off by `size` of the range."""
    return _with(played, effort=_spiked(played.joint.effort, size, _hit(played, 0.01, rng), rng))


def spikes_in_position(played: Played, size: float, rng: np.random.Generator) -> Played:
    """One in a hundred positions is off by `size` of the range."""
    return _with(played, position=_spiked(played.joint.position, size, _hit(played, 0.01, rng), rng))


def wrapped(played: Played, seam: float, rng: np.random.Generator) -> Played:
    """The motor's position wraps at a seam that the motion crosses; `seam` in ranges of the motion, 0 for 2 pi."""
    position = played.joint.position
    turn = seam * float(np.ptp(position)) if seam else 2.0 * np.pi
    zero = float(np.quantile(position, 0.3))
    return _with(played, position=np.mod(position - zero, turn) + zero)


def rezeroed(played: Played, step: float, rng: np.random.Generator) -> Played:
    """From one sample on, the motor's position is off by `step`, rad."""
    at = round(rng.uniform(0.3, 0.7) * played.joint.stamp.size)
    position = played.joint.position.copy()
    position[at:] += step
    return _with(played, position=position)


def _held(values: Floats, ratio: float) -> Floats:
    """Each value is the last that was measured, every `ratio` samples."""
    at = np.arange(values.size, dtype=np.float64)
    return np.interp(np.floor(at / ratio + 1e-9) * ratio, at, values)


def held_effort(played: Played, ratio: float, rng: np.random.Generator) -> Played:
    """The effort is measured at the rate over `ratio` only, and repeated in between."""
    return _with(played, effort=_held(played.joint.effort, ratio))


def held_all(played: Played, ratio: float, rng: np.random.Generator) -> Played:
    """All that the driver says is measured at the rate over `ratio`."""
    link = played.link
    if link is not None:
        link = replace(link, position=_held(link.position, ratio))
    held = _with(played, effort=_held(played.joint.effort, ratio), position=_held(played.joint.position, ratio))
    return replace(held, link=link)


def coarse_stamps(played: Played, tick_ms: float, rng: np.random.Generator) -> Played:
    """All stamps are of a clock that ticks every so many ms."""

    def ticked(t: Told | None) -> Told | None:
        return None if t is None else replace(t, stamp=np.floor(t.stamp * 1e3 / tick_ms + 1e-9) * tick_ms * 1e-3)

    joint = ticked(played.joint)
    assert joint is not None
    return replace(played, joint=joint, link=ticked(played.link))


def _stepped(played: Played, step_ms: float, at: float, *, recorder: bool) -> Played:
    def one(t: Told | None) -> Told | None:
        if t is None:
            return None
        late = np.where(t.stamp > at, 1e-3 * step_ms, 0.0)
        return replace(t, stamp=t.stamp + late, received=t.received + (late if recorder else 0.0))

    joint = one(played.joint)
    assert joint is not None
    return replace(played, joint=joint, link=one(played.link))


def clock_set(played: Played, step_ms: float, rng: np.random.Generator) -> Played:
    """The robot's clock is set by so many ms in the middle; the recorder has another."""
    return _stepped(played, step_ms, float(played.joint.stamp[-1]) * rng.uniform(0.4, 0.6), recorder=False)


def both_clocks_set(played: Played, step_ms: float, rng: np.random.Generator) -> Played:
    """The one clock of robot and recorder is set by so many ms in the middle."""
    return _stepped(played, step_ms, float(played.joint.stamp[-1]) * rng.uniform(0.4, 0.6), recorder=True)


def link_drift(played: Played, ppm: float, rng: np.random.Generator) -> Played:
    """The link encoder's clock is fast by so many parts in a million; the recorder's is not."""
    assert played.link is not None
    return replace(played, link=replace(played.link, stamp=played.link.stamp * (1.0 + 1e-6 * ppm)))


def link_drift_unseen(played: Played, ppm: float, rng: np.random.Generator) -> Played:
    """The same where the time of reception drifts as well: a bag written from another one, or by the encoder's host."""
    assert played.link is not None
    factor = 1.0 + 1e-6 * ppm
    return replace(played, link=replace(played.link, stamp=played.link.stamp * factor,
                                        received=played.link.received * factor))  # fmt: skip


def frozen_effort(played: Played, seconds: float, rng: np.random.Generator) -> Played:
    """The effort stands still for so long while the joint moves on."""
    effort = played.joint.effort.copy()
    start = round(0.6 * effort.size)
    effort[start : start + round(seconds * played.rate_hz)] = effort[start]
    return _with(played, effort=effort)


def protective_stop(played: Played, share: float, rng: np.random.Generator) -> Played:
    """From this share of the recording on brakes hold the joint, and the effort is what it was last."""
    n, stop = played.joint.stamp.size, round(share * played.joint.stamp.size)
    brake = max(2, round(0.05 * played.rate_hz))
    way = np.minimum(np.arange(n - stop), brake)
    eased = (way - way**2 / (2.0 * brake)).astype(np.int64)

    def stopped(values: Floats) -> Floats:
        held = values.copy()
        held[stop:] = values[np.minimum(stop + eased, n - 1)]
        return held

    effort = played.joint.effort.copy()
    effort[stop:] = effort[stop]
    link = played.link
    if link is not None:
        link = replace(link, position=stopped(link.position))
    return replace(_with(played, position=stopped(played.joint.position), effort=effort), link=link)


def cut_chirp(played: Played, share: float, rng: np.random.Generator) -> Played:
    """The recording ends where the chirp has come to this share of the locked-motor frequency."""
    end = int(np.argmax(played.frequency_hz > share * played.locked_hz))
    link = None if played.link is None else played.link.taken(slice(0, end))
    return replace(played, joint=played.joint.taken(slice(0, end)), link=link)


def late_effort(played: Played, samples: float, rng: np.random.Generator) -> Played:
    """The effort is recorded so many samples late."""
    at = np.arange(played.joint.effort.size, dtype=np.float64)
    return _with(played, effort=np.interp(at - samples, at, played.joint.effort))


@dataclass(frozen=True)
class Kind:
    """A fault, its strengths, and codes that name it; `link`: it needs a link encoder."""

    fault: Fault
    strengths: tuple[float, ...]
    names: tuple[str, ...]
    link: bool = False


SHARES = (0.001, 0.003, 0.01, 0.03, 0.1)
STEPS_MS = (3.0, 20.0, -20.0, 300.0, -2000.0)
FAULTS = {
    "second_zeros": Kind(second_zeros, (0.01, 0.1, 0.5, 1.0, 2.0), ("isolated_values",)),
    "second_others": Kind(second_others, (0.1, 0.5, 1.0, 2.0, 5.0), ()),
    "zeros_in_effort": Kind(zeros_in_effort, SHARES, ("isolated_values",)),
    "zeros_in_position": Kind(zeros_in_position, SHARES, ("isolated_values",)),
    "spikes_in_effort": Kind(spikes_in_effort, (0.1, 0.3, 1.0, 3.0, 100.0), ("spikes", "isolated_values")),
    "spikes_in_position": Kind(spikes_in_position, (0.1, 0.3, 1.0, 3.0, 100.0), ("spikes", "isolated_values")),
    "wrapped": Kind(wrapped, (0.0, 1.0, 0.8, 0.4, 0.15), ("position_unwrapped", "position_rezeroed")),
    "rezeroed": Kind(rezeroed, (0.02, 0.05, 0.2, 1.0, 5.0), ("position_rezeroed", "position_unwrapped")),
    "held_effort": Kind(held_effort, (1.25, 4.0 / 3.0, 2.0, 3.0, 5.0), ("held_samples",)),
    "held_all": Kind(held_all, (1.25, 4.0 / 3.0, 2.0, 3.0, 5.0), ("held_samples",)),
    "coarse_stamps": Kind(coarse_stamps, (0.1, 1.0, 1.5, 4.0, 10.0), ("coarse_stamps", "receive_times")),
    "clock_set": Kind(clock_set, STEPS_MS, ("clock_stepped", "time_jumped_back", "paused", "gaps")),
    "both_clocks_set": Kind(both_clocks_set, STEPS_MS, ("clock_stepped", "time_jumped_back", "paused", "gaps")),
    "link_drift": Kind(link_drift, (10.0, 50.0, -50.0, 200.0, 1000.0), ("clock_drift",), link=True),
    "link_drift_unseen": Kind(link_drift_unseen, (10.0, 50.0, -50.0, 200.0, 1000.0), ("clock_drift",), link=True),
    "frozen_effort": Kind(frozen_effort, (0.05, 0.2, 1.0, 5.0, 10.0), ("effort_frozen",)),
    "protective_stop": Kind(protective_stop, (0.95, 0.9, 0.8, 0.6, 0.4), ("effort_frozen",)),
    "cut_chirp": Kind(
        cut_chirp, (0.9, 0.75, 0.6, 0.4, 0.2),
        ("mode_outside_band", "taken_as_rigid", "not_identifiable", "low_excitation", "no_mode_in_band"),
    ),
    "late_effort": Kind(late_effort, (1.0, 4.0, 8.0, 14.0, 20.0), ("torque_delay", "chain_at_its_end")),
}  # fmt: skip
