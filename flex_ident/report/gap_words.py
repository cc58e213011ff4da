"""What an explanation says in words: where the gap lies, what speaks for an effect and against one, what is left."""

from __future__ import annotations

from flex_ident.effects import effect_named
from flex_ident.gap.explanation import Finding, GapExplanation, Proof, Region, Rejected
from flex_ident.notices import Why
from flex_ident.report.curve_words import curve_words
from flex_ident.report.reasons import reason_text
from flex_ident.report.units import Words, words_of

VARIABLES = {
    "time": "time", "frequency": "frequency", "motor_position": "motor angle", "motor_velocity": "motor velocity",
    "recorded_torque": "recorded torque", "spring_deflection": "spring deflection",
    "deflection_rate": "rate of deflection", "transmitted_torque": "transmitted torque",
}  # fmt: skip
"""What the gap is looked at against, in words."""


def region_text(region: Region) -> str:
    """Where a part of the gap lies."""
    of_what = "spectrum" if region.variable == "frequency" else "time"
    return (
        f"{100 * region.share:.0f} % of the gap above the noise lies where the {VARIABLES[region.variable]} is "
        f"{region.low:.3g} to {region.high:.3g} {region.unit}, {100 * region.time_share:.0f} % of the {of_what}"
    )


def evidence_text(finding: Finding, words: Words) -> str:
    """What speaks for an effect, in `words` of the joint's units."""
    proof = finding.proof
    text = (
        f"{effect_named(finding.effect).summary}: on data not fitted {_fall(proof)} N m; blocks of 0.25 s "
        f"left out of the fit are predicted better by {100 * proof.held_out_share:.0f} % (t = {proof.held_out_t:.1f}), "
        f"the BIC falls by {proof.bic:.0f}; {100 * max(0.0, min(1.0, proof.share)):.0f} % of the closable gap"
    )
    if proof.against is not None:
        text += f"; against it: {reason_text(proof.against)}"
    text += "."
    if proof.periods is not None:
        text += (
            f" Only {proof.periods:.1f} periods lie within the range of motion: it may be any torque that depends on "
            "the angle; a larger range would tell."
        )
    return words(text)


def _fall(proof: Proof) -> str:
    """Which gap falls, from what to what: the link's where it falls by more, relative to what it was."""
    before, after = proof.before, proof.after
    torque = f"from {before.torque:.3g} to {after.torque:.3g}"
    if before.link is None or after.link is None or after.link * before.torque >= after.torque * before.link:
        return f"the gap falls {torque}"
    link = f"from {1e3 * before.link:.3g} to {1e3 * after.link:.3g} mrad"
    return f"the gap of the link's position falls {link}, that of the torque goes {torque}"


def reading_text(finding: Finding, words: Words) -> str:
    """The measured law of an effect that is a curve; empty for one that is none."""
    if finding.curve is None or finding.reading is None:
        return ""
    return words(curve_words(finding.curve, finding.reading))


def rejected_text(rejected: Rejected, words: Words) -> str:
    """Why an effect is not accepted."""
    return words(reason_text(rejected.reason))


def unexplained_text(explanation: GapExplanation) -> str:
    """What is left and may be more than noise, and where it lies; empty where nothing is."""
    words, said = words_of(explanation.final), []
    for reason in explanation.unexplained:
        text = words(reason_text(reason))
        if reason.why is Why.MORE_THAN_NOISE:
            left = explanation.where_left
            text += f"; {region_text(left[0]) if left else 'it is spread evenly'}"
        said.append(text + ".")
    return " ".join(said)
