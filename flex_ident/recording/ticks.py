"""Stamps of a coarse clock, and of one that was set during the recording."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from flex_ident.recording.cleaning import measurable
from flex_ident.recording.instants import evened
from flex_ident.recording.recording import Floats

FEWEST = 64
COARSE = 0.05
"""Tick of a clock, in sampling periods, from which it is coarse."""
FEWEST_UNEVEN = 3
"""Steps that must not be whole periods."""
FEWEST_BETWEEN, REGULAR = 10, 0.75
"""Intervals between such steps, and the share of them that must be alike."""
CERTAIN = 0.4
"""Tick, in periods, up to which the step between two samples says how many periods there are."""
SPAN, WITHOUT_LOSS = 64, 0.25
"""Samples over which ticks average out, and the quantile of their durations at which none of them is lost."""
SMOOTHER = 0.8
"""Roughness of a motion at its stamps, in that at even times, up to which samples were taken when stamped."""
MOST_AROUND = 2.0
"""Time from the first to the last of five samples, in usual ones, up to which a cubic joins them."""
REPEATED = 0.01
"""Share of the messages that must repeat the stamp before them to be of one tick."""
SETTLED = 32
"""Messages before and behind a step of the clock over which the time to reception must be the same."""
LEAST_PERIODS, LEAST_NS = 2.5, 2_000_000
"""Size of a step of the clock, in periods and ns, from which it is told from lateness."""
CLEARLY = 4.0
"""How much larger than the scatter of the time to reception it must be."""


def tick_ns(stamps: NDArray[np.int64]) -> int:
    """The tick, ns, that all stamps (k,) are whole multiples of, where it is coarse for their rate; else 0."""
    steps = np.diff(stamps)
    if steps.size < FEWEST:
        return 0
    tick = int(np.gcd.reduce(np.abs(steps)))
    period = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    if period <= 0.0 or tick < COARSE * period:
        return 0
    uneven = np.abs(steps - np.rint(steps / period) * period) > 0.5 * tick
    if np.count_nonzero(uneven) >= FEWEST_UNEVEN:
        return tick
    # A tick as long as the usual step: then others come at regular intervals, which lost messages do not.
    between = np.diff(np.flatnonzero(np.abs(steps - period) > 0.5 * tick))
    regular = np.abs(between - np.median(between)) <= 1 if between.size >= FEWEST_BETWEEN else np.zeros(1, bool)
    return tick if float(np.mean(regular)) > REGULAR else 0


def evened_ticks(time: Floats, tick: float) -> Floats:
    """The even times (n,) behind increasing ones in ticks of `tick`, s, lost samples counted."""
    period = period_in_ticks(time)
    if tick > CERTAIN * period:
        return evened(time, period)
    index = np.concatenate(([0.0], np.cumsum(np.maximum(1.0, np.rint(np.diff(time) / period)))))
    slope, offset = np.polyfit(index, time, 1)
    even: Floats = float(slope) * index + float(offset)
    return even


def taken_when_stamped(time: Floats, values: Floats, tick: float) -> bool:
    """Whether samples were taken at the ticks they are stamped with, as of a controller's cycle, and not between them.

    `time` (n,), s, in ticks of `tick`, s; `values` (n,) as recorded. A motion is smooth at the times it was sampled at:
    at others, it is as rough as they are wrong times its speed.
    """
    usable = measurable(time) & measurable(values)
    time, values = time[usable], values[usable]
    if time.size < FEWEST or (np.diff(time) <= 0.0).any():
        return False
    return _roughness(time, values) < SMOOTHER * _roughness(evened_ticks(time, tick), values)


def _roughness(time: Floats, values: Floats) -> float:
    """Root mean square distance of values (n,) from the cubic through the two before and the two behind each."""
    n = time.size - 4
    t, around = time[2:-2], (0, 1, 3, 4)
    own = [time[k : k + n] for k in around]
    predicted = np.zeros(n)
    for i, k in enumerate(around):
        weight = np.ones(n)
        for j in range(len(around)):
            if j != i:
                weight *= (t - own[j]) / (own[i] - own[j])
        predicted += weight * values[k : k + n]
    near = own[-1] - own[0] < MOST_AROUND * float(np.median(own[-1] - own[0]))
    return float(np.sqrt(np.mean((values[2:-2] - predicted)[near] ** 2)))


def period_in_ticks(time: Floats) -> float:
    """The sampling period, s, of times (n,) in ticks that may be as long: over many samples, of which few are lost."""
    span = min(SPAN, time.size - 1)
    return float(np.quantile(time[span:] - time[:-span], WITHOUT_LOSS)) / span


def within_ticks(stamps: NDArray[np.int64], values: Floats) -> Floats:
    """Stamps (k,), ns, with those that share a tick spread over it; unchanged where the messages were sent twice."""
    spread = stamps.astype(np.float64)
    again = np.diff(stamps) == 0
    if float(np.mean(again)) < REPEATED or float(np.mean(np.diff(values)[again] != 0.0)) < 0.5:
        return spread
    starts = np.flatnonzero(np.concatenate(([True], ~again)))
    lengths = np.diff(np.append(starts, stamps.size))
    place = np.arange(stamps.size) - np.repeat(starts, lengths)
    ticks = np.append(np.diff(stamps[starts]), np.median(np.diff(stamps[starts])))
    spread += place * np.repeat(ticks / lengths, lengths)
    return spread


def steps_taken_back(stamps: NDArray[np.int64], received: NDArray[np.int64]) -> tuple[NDArray[np.int64], list[int]]:
    """Stamps (k,), ns, without the steps of a clock that was set meanwhile, and those steps, ns.

    The clock was set where the time from stamp to reception changes for good, and it is the stamps that step while
    messages go on arriving as before.
    """
    if stamps.size < 2 * SETTLED + 2 or (stamps == 0).any():
        return stamps, []
    latency = received - stamps
    stepped, arrived = np.diff(stamps), np.diff(received)
    period = float(np.median(arrived))
    scatter = float(np.median(np.abs(np.diff(latency))))
    least = max(LEAST_PERIODS * period, LEAST_NS, CLEARLY * scatter)
    suspects = np.flatnonzero(
        (np.abs(np.diff(latency)) > least) & (np.abs(stepped - period) > 2.0 * np.abs(arrived - period))
    )
    corrected, found = stamps.copy(), []
    for i in suspects.tolist():
        before, behind = latency[max(0, i + 1 - SETTLED) : i + 1], latency[i + 1 : i + 1 + SETTLED]
        if min(before.size, behind.size) < SETTLED:
            continue
        change = int(np.median(behind) - np.median(before))
        spread = max(float(np.ptp(np.quantile(part, (0.1, 0.9)))) for part in (before, behind))
        if abs(change) > max(least, CLEARLY * spread):
            corrected[i + 1 :] += change
            found.append(-change)
    return corrected, found
