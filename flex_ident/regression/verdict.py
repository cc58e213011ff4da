"""How far a linear regression may be trusted, each objection with a stable code."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping

from flex_ident.parameters import FitQuality, Parameter, Verdict
from flex_ident.recording import Notice

ESSENTIAL = ("Jm", "K", "JL", "J")
WEAK_PERCENT = 5.0
"""Relative standard deviation of an essential parameter from which the result is doubtful."""
POOR_PERCENT, HOPELESS_PERCENT = 15.0, 50.0
"""Torque left unexplained from which a result is doubtful, and rejected."""
SIGNALS = {"torque_delay": "torque", "link_skew": "link position"}
EXPERIMENTS: dict[str, str] = {
    "K": "sweep through the resonance with a larger amplitude, with a payload, or read a link encoder",
    "JL": "sweep through the resonance, with a payload",
    "Jm": "sweep to higher frequencies",
    "J": "move with larger accelerations",
    "FVm": "move at higher speed",
    "FV": "move at higher speed, or read a link encoder",
    "FSm": "add slow motion over a large range (chirp.profile: rich)",
    "FS": "add slow motion over a large range (chirp.profile: rich), or read a link encoder",
    "MX": "repeat at another start position, or move over a larger range (chirp.profile: rich)",
    "MY": "repeat at another start position, or move over a larger range (chirp.profile: rich)",
    "offset": "move over a larger range (chirp.profile: rich), so that gravity and offset differ",
}
"""What determines a parameter that the data leave open."""
REVERSED = (
    "effort seems reversed: with the opposite sign the inertias come out positive: --effort-scale -1, or the opposite "
    "of yours."
)


def judged(
    parameters: tuple[Parameter, ...],
    quality: FitQuality,
    derived: Mapping[str, float],
    measurement: tuple[Parameter, ...],
    *,
    possible: bool,
    opposed: bool,
    sample_time: float,
    undetermined: tuple[tuple[str, ...], ...],
    required_rate_hz: float,
    sample_rate_hz: float,
) -> tuple[Verdict, tuple[Notice, ...]]:
    """The verdict, and a notice for each thing that speaks against trusting the numbers.

    `possible`: inertias and stiffness are positive; `opposed`: they are negative, all of them.
    """
    rejected: list[Notice] = []
    doubtful: list[Notice] = []
    said: list[Notice] = []
    if opposed:
        rejected.append(Notice("effort_reversed", REVERSED))
    elif not possible:
        text = "the fit has a negative inertia or stiffness: the model does not hold for this recording."
        rejected.append(Notice("not_physical", text))
    for group in undetermined:
        text = f"only a combination of {', '.join(group)} is determined: record a wider sweep."
        (rejected if set(group) & set(ESSENTIAL) else said).append(Notice("undetermined", text))
    for p in parameters:
        if not p.identifiable:
            text = not_determined(p)
            (rejected if p.key in ESSENTIAL else said).append(Notice("not_identifiable", text))
        elif p.key in ESSENTIAL and p.relative_std_percent > WEAK_PERCENT:
            doubtful.append(Notice("low_excitation", known_only(p)))
    worst = max(quality.relative_error_percent, quality.validation_relative_error_percent)
    (doubtful if worst <= HOPELESS_PERCENT else rejected).extend(mismatches(worst))
    sigmas = derived.get("x5_sigmas", 0.0)
    if sigmas > 2.0:
        text = (
            f"X5 contradicts the other six X by {sigmas:.1f} standard deviations: gravity and the link's Coulomb "
            "friction, which eq. 18 leaves out, or noise bias K and JL. Use --method auto."
        )
        (doubtful if sigmas < 10.0 else rejected).append(Notice("x5_inconsistent", text))
    elif "x5_sigmas" in derived:
        text = "eq. 18 leaves out gravity and the link's Coulomb friction; K and JL may be far off. Use --method auto."
        doubtful.append(Notice("simplified_model", text))
    if required_rate_hz > sample_rate_hz:
        text = f"{sample_rate_hz:.4g} Hz is below the {required_rate_hz:.0f} Hz of eq. 29: derivatives are distorted."
        doubtful.append(Notice("low_sampling_rate", text))
    doubtful.extend(late_signals(measurement, sample_time))
    verdict: Verdict = "rejected" if rejected else ("doubtful" if doubtful else "trusted")
    return verdict, (*rejected, *doubtful, *said)


def not_determined(p: Parameter) -> str:
    """That the data do not determine a parameter, how far they do (2 sigma, as in the table), and what would."""
    how = EXPERIMENTS.get(p.key, "a wider sweep, a larger amplitude or a payload")
    known = f"± {2.0 * p.std:.2g} {p.unit}, 2σ" if math.isfinite(p.std) else "not at all"
    return f"{p.key} is not determined by this recording ({known}): {how}."


def known_only(p: Parameter) -> str:
    """That a parameter is known poorly (2 sigma, as in the table), and what would help."""
    return f"{p.key} is known to ± {2.0 * p.relative_std_percent:.0f} % (2σ) only: {EXPERIMENTS[p.key]}."


def mismatches(left: float) -> Iterator[Notice]:
    """That a model leaves too much of the torque, in percent, unexplained."""
    if not left <= POOR_PERCENT:
        text = f"the model leaves {left:.0f} % of the torque unexplained: run explain_gap to see what is missing."
        yield Notice("model_mismatch", text)


def late_signals(measurement: Iterable[Parameter], sample_time: float) -> Iterator[Notice]:
    """One notice a signal that is recorded more than a sample, s, late or early."""
    for p in measurement:
        if p.key in SIGNALS and abs(p.value) > sample_time + 2.0 * p.std:
            how = f"{1e3 * abs(p.value):.2f} ms {'late' if p.value > 0.0 else 'early'}"
            text = (
                f"{SIGNALS[p.key]} is recorded {how} against the motor position, more than a sample "
                f"({1e3 * sample_time:.2f} ms): corrected for, but look at the drive's time stamps."
            )
            yield Notice(p.key, text)
