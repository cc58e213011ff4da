"""Whether the motion crossed the mode that tells K from the inertias, and what a result is worth where it did not."""

from __future__ import annotations

from dataclasses import replace

from flex_ident.estimation.thresholds import MODE_CLEAR, MODE_SEEN
from flex_ident.judgement.rules import not_determined
from flex_ident.notices import Code, Notice
from flex_ident.parameters import Identification

SPRING_KEYS = ("Jm", "K", "JL")


def with_mode_judged(result: Identification, confidence: float, band_hz: float) -> Identification:
    """The result, `doubtful` where the locked-motor mode lies so near the end of the band that the sweep shows little.

    `confidence` is that of the resonance, 0 to 1. Where the mode lies beyond the band, the motor alone determines
    neither K nor how the inertia is shared: of slow recordings of an adversary's joints K was 22 to 36 % low, up to 15
    standard deviations.
    """
    locked = result.derived.get("locked_motor_hz", 0.0)
    if confidence < MODE_SEEN and band_hz / MODE_CLEAR < locked <= band_hz:
        found = {"locked_motor_hz": locked, "band_hz": band_hz}
        notice = Notice(Code.MODE_OUTSIDE_BAND, numbers=found, texts={"case": "end"})
        verdict = "doubtful" if result.verdict == "trusted" else result.verdict
        result = replace(result, verdict=verdict, notices=(notice, *result.notices))
    outside = any(n.code is Code.MODE_OUTSIDE_BAND and n.texts.get("case") != "end" for n in result.notices)
    if not outside or result.sensors == "motor+link":
        return result
    open_keys = [p for p in result.parameters if p.key in SPRING_KEYS and p.identifiable]
    keys = {p.key for p in open_keys}
    parameters = tuple(replace(p, identifiable=False) if p.key in keys else p for p in result.parameters)
    return replace(result, parameters=parameters, notices=(*result.notices, *map(not_determined, open_keys)))
