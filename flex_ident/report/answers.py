"""What a recording can answer: which model it shows, over which band and range, and which other joints moved."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from flex_ident.effects import told_key
from flex_ident.parameters import Identification
from flex_ident.recording import Recording
from flex_ident.report.units import words_of


def answer_content(result: Identification, recording: Recording) -> dict[str, Any]:
    """The same as data: `model` is `spring`, `rigid` or `none`, where the result is rejected."""
    model = "none" if result.verdict == "rejected" else "rigid" if result.model.rigid else "spring"
    band = None if result.filter is None else result.filter.bandwidth_rad_s / (2.0 * math.pi)
    return {
        "model": model, "band_hz": band, "range": float(np.ptp(recording.motor_position)),
        "locked_motor_hz": result.derived.get("locked_motor_hz"), "other_joints": list(recording.others),
    }  # fmt: skip


def answer_text(result: Identification, recording: Recording) -> str:
    """One line: what this recording can answer."""
    told = answer_content(result, recording)
    known = list(dict.fromkeys(told_key(p.key) for p in result.parameters if p.identifiable))
    band = "" if told["band_hz"] is None else f" up to {told['band_hz']:.3g} Hz"
    swing = words_of(result)(f"{told['range']:.3g} rad")
    others = ", ".join(told["other_joints"])
    moved = f"with {others} moving too" if others else "no other joint moved"
    if told["model"] == "none":
        what = "nothing that could be trusted"
    elif told["model"] == "rigid":
        what = f"a rigid joint ({', '.join(known) or 'friction as a curve'}); no spring shows"
    else:
        what = f"a joint with a spring ({', '.join(known)}), locked motor {told['locked_motor_hz'] or math.nan:.3g} Hz"
    return f"this recording answers: {what}{band}, over {swing}, {moved}"
