"""How far a linear regression may be trusted, each objection with a stable code."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from flex_ident.notices import Code, Notice
from flex_ident.parameters import FitQuality, Parameter, Verdict

ESSENTIAL = ("Jm", "K", "JL", "J")
WEAK_PERCENT = 5.0
"""Relative standard deviation of an essential parameter from which the result is doubtful."""
POOR_PERCENT, HOPELESS_PERCENT = 15.0, 50.0
"""Torque left unexplained from which a result is doubtful, and rejected."""
SIGNALS = {"torque_delay": Code.TORQUE_DELAY, "link_skew": Code.LINK_SKEW}
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
        rejected.append(Notice(Code.EFFORT_REVERSED, "motor_torque"))
    elif not possible:
        rejected.append(Notice(Code.NOT_PHYSICAL))
    for group in undetermined:
        notice = Notice(Code.UNDETERMINED, ", ".join(group), texts={"case": "linear"})
        (rejected if set(group) & set(ESSENTIAL) else said).append(notice)
    for p in parameters:
        if not p.identifiable:
            (rejected if p.key in ESSENTIAL else said).append(not_determined(p))
        elif p.key in ESSENTIAL and p.relative_std_percent > WEAK_PERCENT:
            doubtful.append(known_only(p))
    worst = max(quality.relative_error_percent, quality.validation_relative_error_percent)
    (doubtful if worst <= HOPELESS_PERCENT else rejected).extend(mismatches(worst))
    sigmas = derived.get("x5_sigmas", 0.0)
    if sigmas > 2.0:
        (doubtful if sigmas < 10.0 else rejected).append(Notice(Code.X5_INCONSISTENT, "X5", {"sigmas": sigmas}))
    elif "x5_sigmas" in derived:
        doubtful.append(Notice(Code.SIMPLIFIED_MODEL))
    if required_rate_hz > sample_rate_hz:
        rates = {"rate_hz": sample_rate_hz, "required_hz": required_rate_hz}
        doubtful.append(Notice(Code.LOW_SAMPLING_RATE, numbers=rates))
    doubtful.extend(late_signals(measurement, sample_time))
    verdict: Verdict = "rejected" if rejected else ("doubtful" if doubtful else "trusted")
    return verdict, (*rejected, *doubtful, *said)


def not_determined(p: Parameter) -> Notice:
    """That the data do not determine a parameter, and how far they do."""
    return Notice(Code.NOT_IDENTIFIABLE, p.key, {"value": p.value, "std": p.std}, {"unit": p.unit})


def known_only(p: Parameter) -> Notice:
    """That a parameter is known poorly."""
    return Notice(Code.LOW_EXCITATION, p.key, {"relative_std_percent": p.relative_std_percent})


def mismatches(left: float) -> Iterator[Notice]:
    """That a model leaves too much of the torque, in percent, unexplained."""
    if not left <= POOR_PERCENT:
        yield Notice(Code.MODEL_MISMATCH, numbers={"left_percent": left})


def late_signals(measurement: Iterable[Parameter], sample_time: float) -> Iterator[Notice]:
    """One notice a signal that is recorded more than a sample, s, late or early."""
    for p in measurement:
        if p.key in SIGNALS and abs(p.value) > sample_time + 2.0 * p.std:
            yield Notice(SIGNALS[p.key], p.key, {"delay_s": p.value, "std": p.std, "sample_s": sample_time})
