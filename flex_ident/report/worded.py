"""Sentences that a format string cannot make: their words depend on the notice's numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from flex_ident.judgement.priorities import EXPERIMENTS
from flex_ident.notices import Notice

Template = str | Callable[[Notice], str]
"""A format string over the notice's numbers, texts and `subject`, or a function where the words depend on them."""
WIDER = "a wider sweep, a larger amplitude or a payload"
"""The experiment for a parameter of which no better is known."""

LEAST_MOVED = 0.1
"""Standard deviations under which it is not said how far an effect would move a parameter."""
TAKEN = "Positions are taken as rad or m on the link side."


def experiment_for(key: str) -> str:
    """What to record for a parameter that is not determined."""
    return EXPERIMENTS.get(key, WIDER)


def not_identifiable(n: Notice) -> str:
    std = n.numbers["std"]
    known = f"± {2.0 * std:.2g} {n.texts['unit']}".rstrip() + ", 2σ" if math.isfinite(std) else "not at all"
    return f"{n.subject} is not determined by this recording ({known}): {experiment_for(n.subject)}."


def low_excitation(n: Notice) -> str:
    percent = n.numbers["relative_std_percent"]
    return f"{n.subject} is known to ± {2.0 * percent:.0f} % (2σ) only: {experiment_for(n.subject)}."


CHAIN = {
    "torque_delay": "the delay of the torque", "torque_averaging": "the averaging of the torque within a sample",
    "effort_lag": "the low-pass in the effort", "reversal_lead": "the time by which friction turns over early",
    "link_skew": "the skew of the link encoder", "link_scale": "the scale error of the link encoder",
    "link_drift": "the drift of the link encoder's clock",
}  # fmt: skip


def chain_at_its_end(n: Notice) -> str:
    if n.subject == "reversal_lead":
        return (
            f"friction turns over {1e3 * n.numbers['value']:.3g} ms before the motion does (reversal_lead), more than "
            "any drive shows: the motor sticks between its moves, and its friction is not told from its inertia. Move "
            "with a larger amplitude, or with a chirp rather than steps."
        )
    return (
        f"{CHAIN.get(n.subject, n.subject)} ({n.subject}) is estimated at {n.numbers['value']:.3g}, the end of what it "
        "can be: it stands in for something else. Torque from above half the sampling rate that folds back: record at "
        "a higher rate, or with a chirp rather than steps. Or what the model lacks in the transmission, as damping "
        "across the spring: run explain_gap."
    )


def late(what: str) -> Template:
    def words(n: Notice) -> str:
        delay, sample = n.numbers["delay_s"], n.numbers["sample_s"]
        side = "late" if delay > 0.0 else "early"
        return (
            f"{what} is recorded {1e3 * abs(delay):.2f} ms {side} against the motor position, more than a sample "
            f"({1e3 * sample:.2f} ms): corrected for, but look at the drive's time stamps."
        )

    return words


def below_a_sample(what: str) -> Mapping[str, Template]:
    start = f"{what} fits best when recorded {{delay_ms:+.3f}} ms against the motor position, "
    return {
        "within": start + "less than a sample: measurement, corrected for, not a finding.",
        "at_limit": start + "the most that counts as measurement: it may be larger, or stand in for something else.",
    }


def clock_drift(n: Notice) -> str:
    ppm, std, total = (n.numbers[k] for k in ("ppm", "std_ppm", "total_ms"))
    how = "by what fits best" if n.case == "fitted" else "by the times of reception"
    return (
        f"the clock of {n.subject} runs {abs(ppm):.3g} ± {2.0 * std:.2g} ppm {'fast' if ppm > 0.0 else 'slow'} against "
        f"the motor position's, {abs(total):.2g} ms over the recording: taken out {how}."
    )


def jumped_back(n: Notice) -> str:
    jumps, kept, dropped = (int(n.numbers[k]) for k in ("jumps", "kept", "dropped"))
    return (
        f"the clock of {n.subject} jumped back {often(jumps)}, by {n.numbers['largest_s']:.3g} s at most, "
        f"{n.numbers['at_s']:.3g} s after the first message: "
        f"the longest stretch of {kept} samples was kept, {dropped} were dropped."
    )


def often(count: float) -> str:
    return "once" if count == 1 else f"{count:.0f} times"


def clock_stepped(n: Notice) -> str:
    steps, largest = n.numbers["steps"], n.numbers["largest_ms"]
    return (
        f"the clock that stamps {n.subject} was set {often(steps)}, by {largest:+.4g} ms at most, while messages went "
        "on: its steps were taken back."
    )


def isolated(more: str = "") -> Template:
    def words(n: Notice) -> str:
        count, total, constant = (n.numbers[k] for k in ("count", "total", "constant"))
        zero = "zero" if constant == 0.0 else f"{constant:.6g}"
        return (
            f"{count:.0f} of {total:.0f} values of {n.subject} are {zero} between others that are not: left out.{more}"
        )

    return words


def effort_frozen(n: Notice) -> str:
    stretches, seconds, count, total = (n.numbers[k] for k in ("stretches", "seconds", "count", "total"))
    return (
        f"{n.subject} stands still {often(stretches)}, for {seconds:.3g} s in all ({count:.0f} of {total:.0f} "
        "samples), where it cannot: left out."
    )


def seam(n: Notice) -> str:
    jumps, size = n.numbers["jumps"], n.numbers["size"]
    return f"{n.subject} jumps {often(jumps)} by {size:.6g}, the seam of its encoder: made continuous."


def rezeroed(n: Notice) -> str:
    jumps, largest = n.numbers["jumps"], n.numbers["largest"]
    return (
        f"{n.subject} jumps {often(jumps)}, by {largest:.4g} at most, and goes on from there, as after a new zero, or "
        "where recordings were put one behind another: made continuous with its first part."
    )


def motor_over_link(n: Notice) -> str:
    ratio = n.numbers["ratio"]
    units = (
        (180.0 / math.pi, "motor in degrees, link in radians"),
        (math.pi / 180.0, "motor in radians, link in degrees"),
        (1000.0, "motor in millimetres, link in metres"),
    )
    known = (words for factor, words in units if abs(ratio / factor - 1.0) < 0.05)
    why = next(known, "is one in other units, or on the motor shaft (--gear-ratio)?")
    return f"the motor position moves {ratio:.4g} times as far as the link's where both move together: {why}. {TAKEN}"


def motor_equation(n: Notice) -> str:
    k, std, left, skew = (n.numbers[key] for key in ("K", "std", "left_percent", "least_skew_s"))
    text = (
        "the motor's equation alone (eq. 6), which holds whatever moves the link, gives "
        f"K = {k:.3g} ± {2 * std:.1g} {n.texts['unit']} (2σ) with {left:.0f} % of the torque left"
    )
    if skew > 0.0:
        text += (
            "; its velocity term is negative, which means that the link encoder is read at least "
            f"{1e3 * skew:.1f} ms after the motor's"
        )
    return text + "."


def motor_equation_undetermined(n: Notice) -> str:
    k, std, left = (n.numbers[key] for key in ("K", "std", "left_percent"))
    return (
        f"not even the motor's equation alone (eq. 6) determines K: {k:.2g} ± {2 * std:.1g} {n.texts['unit']} (2σ), "
        f"{left:.0f} % of the torque left. The measured deflection does not follow the torque: "
        "check that both encoders belong to this joint and share one clock, and move this joint alone."
    )


def base_not_determined(n: Notice) -> str:
    text = "the recording does not determine the base model, so nothing is named"
    if n.texts["effects"]:
        text += f" ({n.texts['effects']} would close some of the gap, by chance for all we know)"
    return text + "."


def other_joints(n: Notice) -> str:
    count = int(n.numbers["count"])
    return f"{count} other joint{'s' if count > 1 else ''} moved: {n.texts['joints']}."


def cause_suspected(n: Notice) -> str:
    """Which effect is suspected, and how far it would move a parameter where that is far enough to be said."""
    moved = n.numbers["moved_stds"]
    how = f", and would move a parameter by up to {moved:.1f} standard deviations" if moved >= LEAST_MOVED else ""
    then = (
        f"see what --add {n.subject} does"
        if n.case == "searched"
        else "run explain_gap, which tells whether it is there"
    )
    return f"{n.subject} accounts best for what is left{how}: {then}."
