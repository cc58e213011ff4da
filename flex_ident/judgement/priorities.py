"""What to look at first where several things speak against a result, and the experiment that would help."""

from __future__ import annotations

from flex_ident.notices import Code

SIGNALS_FIRST = (
    Code.EFFORT_REVERSED, Code.EFFORT_NOT_SI, Code.POSITION_NOT_SI,
)  # fmt: skip
"""Codes that say that a signal is not what it was taken for: all else follows from it."""
DOUBTS = (
    Code.OTHER_JOINTS_EXPLAIN, Code.MODE_OUTSIDE_BAND, Code.SINGLE_TONE, Code.CONSTANT_SPEED,
    Code.EFFORT_KIND_UNCLEAR, Code.URDF_GRAVITY, Code.LOW_EXCITATION, Code.LOW_SAMPLING_RATE, Code.SAMPLED_SLOWLY,
    Code.SIMPLIFIED_MODEL, Code.X5_INCONSISTENT, Code.STARTS_DISAGREE,
    Code.EFFORT_FROZEN, Code.HELD_SAMPLES, Code.POSITION_REZEROED, Code.TORQUE_DELAY, Code.LINK_SKEW,
    Code.VALIDATION_GAP, Code.MODEL_MISMATCH, Code.CAUSE_SUSPECTED, Code.STRUCTURED_RESIDUAL, Code.STRUCTURED_LINK,
    Code.CHAIN_AT_ITS_END, Code.MOTOR_CURRENT,
    Code.NOISE_UNKNOWN, Code.TORQUE_SCALES_DIFFER, Code.TORQUE_SCALE_OFF, Code.RECORDING_DISAGREES,
    Code.RECORDING_LEFT_OUT, Code.RECORDINGS_DOUBTFUL,
)  # fmt: skip
"""Codes for which a result is doubtful, the most telling first."""

REFUSALS = (
    Code.RIGID_AS_WELL, Code.BASE_NOT_DETERMINED, Code.NOT_PHYSICAL, Code.SCATTER_TOO_LARGE,
)  # fmt: skip
"""Codes for which a result is rejected, where nothing else stands out."""
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
LOADED = (
    "effort and acceleration do not belong together: other joints that move load this one, it hardly accelerates, or "
    "its link sticks for most of the motion. Move it alone, faster, and with a larger amplitude."
)


def apart_in_time(late_s: float) -> str:
    """What to say of an effort that is recorded `late_s` late against the position."""
    how = "late" if late_s > 0.0 else "early"
    return (
        f"the effort is recorded about {1e3 * abs(late_s):.3g} ms {how} against the position, and with that taken back "
        "it is positive. Stamp both by one clock when they are measured, or shift one before you import them."
    )
