"""The sentences of notices about several recordings of one joint."""

from __future__ import annotations

import math
from collections.abc import Mapping

from flex_ident.notices import Code, Notice
from flex_ident.report.worded import Template

QUARTER_DEG, HALF_DEG, NEAR_DEG = 90.0, 180.0, 10.0
"""Turns by which X and Y are exchanged, and the mass pulls the other way, and how near to them that is asked."""


def few_recordings(n: Notice) -> str:
    """Why the intervals of two or three recordings are wide."""
    count = {2: "two", 3: "three"}.get(int(n.numbers["count"]), f"{n.numbers['count']:.0f}")
    return (
        f"{count} recordings say little of how far others would scatter: where they differ beyond chance, the interval "
        "is wide for that. Record five or more."
    )


def few_sessions(n: Notice) -> str:
    """What recordings of one session, or of a few, do not tell."""
    recordings, count = n.numbers["recordings"], int(n.numbers["count"])
    if count == 1:
        return (
            f"the {recordings:.0f} recordings are of one session (they began within 12 hours): the result is for that "
            "day, and how far other days lie from it is not in the interval. Record on other days."
        )
    return (
        f"the {recordings:.0f} recordings are of {count} sessions, and each of these counts once: recordings of one "
        "day share what it does. Record on five days or more."
    )


def turned(n: Notice) -> str:
    """The scale that a known mass gives, and where its gravity pulls."""
    known = (("inertia", "inertia"), ("weight", "its weight"))
    means = [words for key, words in known if math.isfinite(n.numbers[key])]
    scale, two_std = n.numbers["scale"], n.numbers["two_std"]
    text = (
        f"the known mass says that the effort is to be multiplied by {scale:.5g} ± {two_std:.2g} (2σ), by "
        f"{' and '.join(means)}"
    )
    angle = n.numbers["angle_deg"]
    if math.isfinite(angle) and abs(angle) > n.numbers["least_deg"]:
        text += f"; its gravity acts as if X and Y were turned by {angle:.3g} degrees from the frame of MX and MY"
        if abs(abs(angle) - QUARTER_DEG) < NEAR_DEG:
            text += " (a quarter: are X and Y of --payload exchanged, or one with the wrong sign?)"
        elif abs(abs(angle) - HALF_DEG) < NEAR_DEG:
            text += " (a half: was the mass in the other recordings, or on the other side of the axis?)"
    return text + "."


OF_SEVERAL: Mapping[Code, Template | Mapping[str, Template]] = {
    Code.RECORDING_LEFT_OUT: {
        "asked": "{subject} was left out, as you say.",
        "failed": "{subject} was left out, it cannot be identified: {why}",
        "copy": "{subject} was left out: it is a copy of {of}, and each recording counts once.",
        "rejected": "{subject} was left out: by itself it is rejected.",
        "other_model": "{subject} was left out: it was identified as a {model} joint, and most others were not.",
    },
    Code.RECORDINGS_DOUBTFUL: "{count:.0f} of {total:.0f} recordings are doubtful by themselves: {names}.",
    Code.RECORDING_DISAGREES: (
        "{subject} disagrees with the other {others:.0f} recordings: its {key} lies {stds:.1f} standard deviations "
        "from what they predict, scatter included (chance {chance:.1g}). It is in the result: --leave-out {subject} "
        "takes it out."
    ),
    Code.RECORDINGS_SCATTER: {
        "": (
            "{subject} scatters by {scatter:.3g} {unit} between recordings (one standard deviation; chance "
            "{chance:.1g}), most in {farthest}: the interval holds that."
        ),
        "two": (
            "{subject} differs by {apart:.3g} {unit} between the two recordings, beyond chance ({chance:.1g}): the "
            "interval holds that."
        ),
        "condition": (
            "{subject} scatters by {scatter:.3g} {unit} between recordings, and follows the {condition}, which "
            "accounts for {share_percent:.0f} % of it (chance {cause_chance:.2g} over all conditions tried)."
        ),
        "alike": (
            "{subject} scatters by {scatter:.3g} {unit} between recordings, and follows the {condition}, which "
            "accounts for {share_percent:.0f} % of it (chance {cause_chance:.2g} over all conditions tried), or what "
            "changes with it here: {alike}."
        ),
    },
    Code.SCATTER_TOO_LARGE: (
        "{subject} differs so much between the recordings that together they do not determine it: {value:.3g} ± "
        "{two_std:.2g} {unit} (2σ). Look at each by itself, and leave out what does not belong (--leave-out BAG)."
    ),
    Code.FEW_RECORDINGS: few_recordings,
    Code.FEW_SESSIONS: few_sessions,
    Code.EFFECT_NOT_SHARED: {
        "contradicted": "{effect} was found in {found} alone, and is contradicted by {against}: it is not accepted.",
        "unconfirmed": "{effect} was found in {found} alone, and no other recording can tell: it is not accepted.",
        "values_differ": (
            "{effect} was found in {found}, each time of another size: with the values of the others the gap does not "
            "fall in {against}. It is not accepted as one of the joint."
        ),
    },
    Code.EFFECT_CONTRADICTED: (
        "{subject} is predicted worse with {effect} as the others have it; they confirm it, and it is accepted."
    ),
    Code.JOINT_NAMES_DIFFER: "the joint has different names in the recordings: {joints}.",
    Code.TORQUE_SCALE: turned,
    Code.TORQUE_SCALE_UNKNOWN: {
        "on_axis": "the known mass does not tell the effort's scale: it sits on the axis.",
        "same_loads": (
            "the known mass does not tell the effort's scale: it is the same in all recordings. Record with and "
            "without it."
        ),
        "weak": (
            "the known mass does not tell the effort's scale: it adds too little, for how well inertia and gravity are "
            "known. Take a larger one, further from the axis."
        ),
    },
    Code.TORQUE_SCALE_OFF: (
        "the effort has another scale than it was taken with: multiply --effort-scale by {scale:.5g} ± {two_std:.2g} "
        "(2σ), and all parameters with it."
    ),
    Code.TORQUE_SCALES_DIFFER: (
        "the known mass gives one scale of the effort by inertia, {inertia:.4g}, and another by gravity, {weight:.4g} "
        "(chance {chance:.1g})."
    ),
}
