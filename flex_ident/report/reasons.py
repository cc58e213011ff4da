"""The sentence of each reason: why an effect is not accepted, and what is left at the end of a search."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from flex_ident.notices import Reason, Why

Template = str | Callable[[Reason], str] | Mapping[str, str]
"""A format string over the reason's numbers, `subject` and `because`, one for each case, or a function."""


def reason_text(reason: Reason) -> str:
    """What a reason says, forces in N m and positions in rad; it begins with a small letter and has no full stop."""
    template = SENTENCES[reason.why]
    if isinstance(template, Mapping):
        template = template[reason.case]
    if callable(template):
        return template(reason)
    because = "" if reason.because is None else reason_text(reason.because)
    return template.format(subject=reason.subject, because=because, **reason.numbers)


def _within_own_error(reason: Reason) -> str:
    n = reason.numbers
    return "; ".join(
        f"it changes the {name} by {n[f'{name}_percent']:.2f} % only, where the model without it may be wrong by "
        f"{n[f'{name}_wrong_percent']:.2f} %"
        for name in ("torque", "deflection")
        if f"{name}_percent" in n
    )


def _gap_does_not_fall(reason: Reason) -> str:
    n = reason.numbers

    def size(name: str) -> str:
        link = n.get(f"{name}_link_mrad")
        return f"{n[name]:.3g} N m" + ("" if link is None else f", {link:.3g} mrad")

    return f"in the final model the gap on data not fitted does not fall ({size('before')} to {size('after')})"


SENTENCES: dict[Why, Template] = {
    Why.LITTLE_LIKELIHOOD: (
        "the likelihood gains too little for its parameters (BIC falls by {fall:.0f}, {needed:.0f} needed)"
    ),
    Why.WITHIN_NOISE: "what was left without it is no more than the noise",
    Why.NOT_CONFIRMED: "data left out of the fit do not confirm it (t = {t:.1f} over blocks, {needed:.2g} needed)",
    Why.WITHIN_OWN_ERROR: _within_own_error,
    Why.WITHIN_ROUNDING: "{amplitude:.2g} rad is no more than the encoder's rounding and noise ({noise:.2g} rad rms)",
    Why.WITHIN_FILTER: (
        "{way:.2g} rad is within what the low-pass changes of the position at reversals ({error:.2g} rad rms)"
    ),
    Why.WITHIN_TORQUE_NOISE: (
        "the torque exceeds the limit by {over:.2g} N m rms, hardly more than its noise ({noise:.2g} N m)"
    ),
    Why.TORQUE_GAP_GROWS: "the torque's gap grows by {percent:.1f} % with it",
    Why.AT_BOUND: "{subject} ends at the limit of what is physical ({value:.3g})",
    Why.PART_OF_A_PERIOD: "it shows a part of one period only within the range of motion",
    Why.NOT_SIGNIFICANT: "{subject} is known to {stds:.1f} standard deviations only, {needed:.0f} needed",
    Why.OTHER_WITHOUT: "without {subject}, known to {stds:.1f} standard deviations only, it is another effect",
    Why.SHAPE_OPEN: "its shape is not determined: {subject} is known to {stds:.1f} standard deviations",
    Why.BELOW_A_SAMPLE: {
        "measurement": "{time_ms:.2f} ms is less than one sample: measurement, corrected for",
        "between": "{time_ms:.2f} ms is less than one sample: the recording does not show what is in between",
    },
    Why.CLOSES_LITTLE: {
        "cause": "it closes {percent:.0f} % of the gap only, {needed_percent:.0f} % needed for a cause",
        "curve": "it closes {percent:.0f} % of the gap only, {needed_percent:.0f} % needed for a curve",
    },
    Why.PART_OF_OWN_ERROR: "it closes {percent:.0f} % only of what may be the method's own error",
    Why.EXPLAINS_NOTHING: "it would explain nothing of what is left",
    Why.OTHERS_EXPLAIN_MORE: "other effects explain more",
    Why.RUNS_AWAY: "its simulation runs away, whatever shape it starts from",
    Why.NOTHING_LEFT: "what is left is no more than noise",
    Why.BESIDE_ANOTHER: "with {subject} in the model, {because}",
    Why.ALREADY_EXPLAINED: "what is in the model already explains as much, fitted again from there: {because}",
    Why.RESEMBLES: "{subject} would close {percent:.0f} % of the gap: what is missing resembles it, and is not it",
    Why.MEASURED_INSTEAD: "a law of its kind leaves more than noise: {subject} was measured instead",
    Why.GAP_DOES_NOT_FALL: _gap_does_not_fall,
    Why.LINK_ALONE: (
        "it closes little of the torque's gap, and of the link's position no more was left than the method's own "
        "error ({link_mrad:.3g} mrad)"
    ),
    Why.NOISE_UNKNOWN: (
        "nothing tells how much of the gap is noise, and it closes {percent:.0f} % of all of it, by energy: "
        "{needed_percent:.0f} % needed for a cause"
    ),
    Why.OPEN_IN_FINAL: "in the final model {subject} is known to {stds:.1f} standard deviations only",
    Why.OPEN_WITH_ALL: "with all that may be missing {subject} is known to {stds:.1f} standard deviations only",
    Why.VARIES_BEYOND_FRICTION: "it varies by {varies:.3g} N m, more than there is of dry friction ({dry:.3g} N m)",
    Why.PEAK_WITHOUT_FRICTION: "a peak of {peak:.3g} N m does not go with a dry friction of {dry:.3g} N m",
    Why.MORE_THAN_NOISE: {
        "catalogue": (
            "{left:.3g} N m rms remain, the noise is {noise:.3g} N m: no effect of the catalogue that accounts for it "
            "is borne out"
        ),
        "tried": "{left:.3g} N m rms remain, the noise is {noise:.3g} N m: no effect that was tried accounts for it",
        "others": (
            "{left:.3g} N m rms remain, the noise is {noise:.3g} N m: no effect that the other recordings bear out "
            "accounts for it"
        ),
    },
    Why.OTHER_JOINTS: (
        "the motion of other joints ({subject}) accounts for {percent:.0f} % of what is left, by energy"
    ),
    Why.ONE_OF_MANY: "the motion holds one frequency or one speed: what is missing may pass for what is there",
    Why.NOISE_UNTOLD: "{left:.3g} N m rms remain, and nothing tells how much of it is noise: repeat the motion",
    Why.LINK_LEFT: "{left:.3g} rad rms remain of the link's position, its noise is {noise:.3g} rad",
    Why.SCALE_SUSPECTED: (
        "{subject} is suspected: it would move the parameters by {stds:.0f} standard deviations, and hardly leaves a "
        "gap"
    ),
    Why.CAUSE_SUSPECTED: (
        "{subject} is suspected: it would move the parameters by {stds:.0f} standard deviations, and what is left is "
        "too little to tell whether it is there"
    ),
    Why.CHAIN_AT_ITS_END: (
        "{subject} is at the end of what a measurement chain can be: it stands in for something else"
    ),
}
