"""How far a linear regression may be trusted, each objection with a stable code."""

from __future__ import annotations

from collections.abc import Mapping

from flex_ident.parameters import FitQuality, Parameter, Verdict
from flex_ident.recording import Notice

ESSENTIAL = ("Jm", "K", "JL", "J")
SIGNALS = {"torque_delay": "torque", "link_skew": "link position"}


def judged(
    parameters: tuple[Parameter, ...],
    quality: FitQuality,
    derived: Mapping[str, float],
    measurement: tuple[Parameter, ...],
    *,
    possible: bool,
    sample_time: float,
    undetermined: tuple[tuple[str, ...], ...],
    required_rate_hz: float,
    sample_rate_hz: float,
) -> tuple[Verdict, tuple[Notice, ...]]:
    """The verdict, and a notice for each thing that speaks against trusting the numbers."""
    rejected: list[Notice] = []
    doubtful: list[Notice] = []
    said: list[Notice] = []
    if not possible:
        text = "the fit has a negative inertia or stiffness: the model does not hold for this recording."
        rejected.append(Notice("not_physical", text))
    for group in undetermined:
        text = f"only a combination of {', '.join(group)} is determined: record a wider sweep."
        (rejected if set(group) & set(ESSENTIAL) else said).append(Notice("undetermined", text))
    for p in parameters:
        if not p.identifiable:
            text = f"{p.key} is not determined by this recording (± {p.std:.2g} {p.unit})."
            (rejected if p.key in ESSENTIAL else said).append(Notice("not_identifiable", text))
        elif p.key in ESSENTIAL and p.relative_std_percent > 5.0:
            text = (
                f"{p.key} is known to {p.relative_std_percent:.0f} % only: sweep through the resonance with a payload."
            )
            doubtful.append(Notice("low_excitation", text))
    worst = max(quality.relative_error_percent, quality.validation_relative_error_percent)
    if not worst < 15.0:
        text = f"the model leaves {worst:.0f} % of the torque unexplained: run explain_gap to see what is missing."
        (doubtful if worst < 50.0 else rejected).append(Notice("model_mismatch", text))
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
    for p in measurement:
        if p.key in SIGNALS and abs(p.value) > sample_time + 2.0 * p.std:
            text = f"{SIGNALS[p.key]} lies {1e3 * p.value:.2f} ms after the motor position: corrected for."
            code = "encoder_skew" if p.key == "link_skew" else "torque_delay"
            doubtful.append(Notice(code, text))
    verdict: Verdict = "rejected" if rejected else ("doubtful" if doubtful else "trusted")
    return verdict, (*rejected, *doubtful, *said)
