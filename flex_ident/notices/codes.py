"""Every code that a result may carry: what it does to the verdict, what it means, what to do about it.

Codes are what users script against (`flex_ident codes`, docs/codes.md): they stay; sentences may change.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from typing import Literal

Severity = Literal["info", "doubt", "reject"]
"""What a code does to the verdict: nothing, at best doubtful, rejected; its meaning says when it does more."""


class Code(StrEnum):
    """One member a code: its name in `result.json`, its severity, its meaning in one sentence, and what to do."""

    severity: Severity
    meaning: str
    advice: str

    def __new__(cls, value: str, severity: Severity = "info", meaning: str = "", advice: str = "") -> Code:
        """The member, which is the code's text and carries the rest."""
        member = str.__new__(cls, value)
        member._value_ = value
        member.severity, member.meaning, member.advice = severity, meaning, advice
        return member

    # The bag.
    BAG_DAMAGED = (
        "bag_damaged", "info",
        "Part of the bag could not be read; what is whole was used.",
        "Copy the bag again from where it was recorded; if it is damaged there too, record again where much is lost.",
    )  # fmt: skip
    BAG_UNFINISHED = (
        "bag_unfinished", "info",
        "The recorder did not close the file; it was read to its end.",
        "Stop the recorder with Ctrl-C, and let it finish.",
    )  # fmt: skip

    COLUMNS_GUESSED = (
        "columns_guessed", "info",
        "The columns of a table were taken for time, position and effort by their names.",
        "Name them in a mapping where one is taken for another.",
    )  # fmt: skip

    # Stamps and samples.
    NONFINITE_VALUES = (
        "nonfinite_values", "info",
        "Messages without a finite number, or without a stamp, were dropped.",
        "Look at what publishes them.",
    )  # fmt: skip
    TIME_JUMPED_BACK = (
        "time_jumped_back", "info",
        "The clock was set back while it was recorded; the longest stretch in between was kept.",
        "Let the clocks settle (chrony, PTP) before recording.",
    )  # fmt: skip
    STAMPS_OUT_OF_ORDER = (
        "stamps_out_of_order", "info",
        "Single messages are out of order in time, or have a stamp far from their neighbours', and were dropped.",
        "Nothing, while they are few; else publish from one thread, and record on the robot's own computer.",
    )  # fmt: skip
    CLOCK_STEPPED = (
        "clock_stepped", "info",
        "The clock that stamps messages was set while they went on; its steps were taken back by the times of "
        "reception.",
        "Let the clocks settle (chrony, PTP) before recording.",
    )  # fmt: skip
    COARSE_STAMPS = (
        "coarse_stamps", "info",
        "Stamps come in ticks that are coarse for the rate; samples were taken as evenly spaced.",
        "Stamp with a clock of nanoseconds, not of milliseconds.",
    )  # fmt: skip
    DUPLICATE_STAMPS = (
        "duplicate_stamps", "info",
        "Messages repeat the stamp before them, so that the rate is lower than it looks.",
        "Stamp each message when it is measured.",
    )  # fmt: skip
    DIFFERENT_CLOCKS = (
        "different_clocks", "info",
        "Two signals are stamped by clocks that are far apart; they were brought together by their times of reception.",
        "Stamp position and effort by one clock: a skew between them biases viscous friction.",
    )  # fmt: skip
    CLOCK_DRIFT = (
        "clock_drift", "info",
        "The clock that stamps one signal runs faster or slower than that of the motor position: its drift, by the "
        "times of reception or by what fits best, was taken out.",
        "Discipline all clocks by one (PTP, chrony), or stamp all signals on one computer.",
    )  # fmt: skip
    RECEIVE_TIMES = (
        "receive_times", "info",
        "The headers carry no usable stamps: times of reception were used, taken as evenly spaced.",
        "Stamp the messages where they are measured.",
    )  # fmt: skip
    MIXED_CLOCKS = (
        "mixed_clocks", "info",
        "Some signals carry no usable stamps: their times of reception were used, shifted by the usual latency.",
        "Stamp all signals where they are measured: a skew between torque and position biases viscous friction.",
    )  # fmt: skip
    PAUSED = (
        "paused", "info",
        "The recording pauses; only its longest part was used.",
        "Record without a pause, or one bag a part.",
    )  # fmt: skip
    GAPS = (
        "gaps", "info",
        "Samples are missing over longer stretches, which were left out.",
        "Record on the robot's own computer, or with a larger queue, where much is lost.",
    )  # fmt: skip
    ISOLATED_VALUES = (
        "isolated_values", "info",
        "Values of one constant, zero as a rule, stand between others that are not, and were left out.",
        "Look at what publishes them: a second node on the topic, or a driver that sends zeros where it has no value.",
    )  # fmt: skip
    SPIKES = (
        "spikes", "info",
        "Values of a single sample lie far off their neighbours, and were left out.",
        "Look at cables and driver where there are many.",
    )  # fmt: skip
    HELD_SAMPLES = (
        "held_samples", "info",
        "A signal is stamped more often than it is measured: samples that repeat others were left out; doubts where "
        "it is measured at less than 100 Hz.",
        "Record it at the rate at which it is measured, and measure it as often as the position.",
    )  # fmt: skip
    EFFORT_TRUNCATED = (
        "effort_truncated", "info",
        "The effort was cut toward zero to whole steps, as a cast to a whole number does it: half a step was put back, "
        "which is what was cut off on average.",
        "Round to the nearest step in the driver, or publish the effort with more digits.",
    )  # fmt: skip
    EFFORT_STEPS = (
        "effort_steps", "info",
        "The effort comes in steps, and whether it was rounded or cut toward zero does not show: the intervals hold "
        "both.",
        "Round to the nearest step in the driver, or publish the effort with more digits.",
    )  # fmt: skip
    EFFORT_FROZEN = (
        "effort_frozen", "doubt",
        "The effort stands still where it cannot, as after a protective stop or a lost connection: left out.",
        "Look at the robot's log, and record again without the stop.",
    )  # fmt: skip
    POSITION_UNWRAPPED = (
        "position_unwrapped", "info",
        "A position that wraps at a turn, or at another seam of its encoder, was made continuous.",
        "Nothing, if the encoder counts one turn only.",
    )  # fmt: skip
    POSITION_REZEROED = (
        "position_rezeroed", "doubt",
        "A position jumps and goes on from there, as after a new zero; it was made continuous with its first part, "
        "whose zero need not be the right one for gravity.",
        "Record again without homing or zeroing the encoder in between.",
    )  # fmt: skip
    LINK_REPEATS_MOTOR = (
        "link_repeats_motor", "info",
        "The link position is the motor position number by number, and was left out.",
        "Name the topic of the second encoder with --link-position, if there is one.",
    )  # fmt: skip

    # Units and kinds of the signals.
    POSITION_NOT_SI = (
        "position_not_si", "doubt",
        "The position cannot be in rad or m on the link side: no joint moves like that.",
        "Record rad or m; give --gear-ratio where the position is on the motor shaft.",
    )  # fmt: skip
    EFFORT_NOT_SI = (
        "effort_not_si", "doubt",
        "The effort is by its name, or by its magnitude, not in N m or N.",
        "Give N m per recorded unit with --effort-scale: torque constant times gear ratio for a current.",
    )  # fmt: skip
    EFFORT_SIDE = (
        "effort_side", "info",
        "The motor position was divided by the gear ratio, and the effort was not multiplied by it.",
        "Give --effort-scale with the gear ratio where the effort is the motor shaft's too.",
    )  # fmt: skip
    EFFORT_REVERSED = (
        "effort_reversed", "reject",
        "The effort has the opposite sign of the position: inertia, stiffness and friction come out negative.",
        "Give --effort-scale -1, or the opposite of yours.",
    )  # fmt: skip
    EFFORT_JOINT_SENSOR = (
        "effort_joint_sensor", "info",
        "The effort is the torque through the transmission, from a sensor behind the gear: it says nothing of the "
        "motor's inertia and friction.",
        "Record the motor's torque or current as well, if Jm, FVm and FSm are wanted; or say --effort-kind motor.",
    )  # fmt: skip
    EFFORT_GRAVITY_COMPENSATED = (
        "effort_gravity_compensated", "info",
        "The gravity that the controller adds is not in the effort: MX and MY are the link's own, as far as its mode "
        "shows; how much of them the controller takes off is fitted (gravity_removed).",
        "Record the effort before that is subtracted to know gravity better; or say --effort-kind motor.",
    )  # fmt: skip
    URDF_GRAVITY = (
        "urdf_gravity", "info",
        "How much of the weight that the robot's description gives is in the effort: all of the motor's torque, none "
        "where the controller's share was taken off; doubts where that is not the kind of effort that was said.",
        "Say the kind of effort that it is (--effort-kind), and check masses and payload in the URDF.",
    )  # fmt: skip
    EFFORT_FRICTION_COMPENSATED = (
        "effort_friction_compensated", "info",
        "The friction that the controller adds is not in the effort: the motor's friction cannot be told from it.",
        "Record the effort before that is subtracted, if the motor's friction is wanted; or say --effort-kind motor.",
    )  # fmt: skip
    EFFORT_CURRENT = (
        "effort_current", "info",
        "The effort is a current of unknown scale: frequencies and ratios hold as they are, all else is in units of "
        "the current.",
        "Give N m per ampere with --effort-scale: torque constant times gear ratio.",
    )  # fmt: skip
    MOTOR_CURRENT = (
        "motor_current", "info",
        "The motor's inertia and friction, and its torque constant, are from its current, the rest from the torque "
        "sensor; doubts where they explain the current badly.",
        "Record current and torque by one clock, and look whether it is this motor's current.",
    )  # fmt: skip
    EFFORT_COMMANDED = (
        "effort_commanded", "info",
        "The effort is what was asked of the drive, not what it delivered.",
        "Record the measured current or torque: a drive that saturates or lags does not deliver what it is asked for.",
    )  # fmt: skip
    EFFORT_KIND_UNCLEAR = (
        "effort_kind_unclear", "doubt",
        "The recording does not tell whether the effort holds gravity or is less what the controller adds: it was "
        "taken as the motor's torque, and the intervals reach as far as the other would move them.",
        "Say what the effort is with --effort-kind, or give the robot's --urdf, whose weight tells.",
    )  # fmt: skip
    EFFORT_KIND_OPEN = (
        "effort_kind_open", "info",
        "The recording does not tell whether the effort holds gravity (or the motor's friction) or is less what the "
        "controller adds. It was taken as the motor's torque: the intervals reach as far as gravity would move them, "
        "and FVm and FSm are left open.",
        "Say what the effort is with --effort-kind, and the intervals become narrower.",
    )  # fmt: skip
    EFFORT_LAG = (
        "effort_lag", "info",
        "The effort is low-passed on its way to the recording; corrected for.",
        "Record it before the drive's filter, or with a faster one, where the lag is as long as the fastest motion.",
    )  # fmt: skip
    TORQUE_DELAY = (
        "torque_delay", "doubt",
        "The torque is recorded late or early against the motor position, by more than a sample; corrected for.",
        "Look at the drive's time stamps.",
    )  # fmt: skip
    LINK_SKEW = (
        "link_skew", "doubt",
        "The link position is recorded late or early against the motor's, by more than a sample; corrected for.",
        "Look at the time stamps of the link encoder.",
    )  # fmt: skip
    CHAIN_AT_ITS_END = (
        "chain_at_its_end", "doubt",
        "A delay, a low-pass or an averaging of the recorded signals is estimated at the end of what it can be: it "
        "stands in for something else, as torque from above half the sampling rate that folds back, or damping across "
        "the spring.",
        "Record at a higher rate, or excite with less above half of it, a chirp rather than steps; else run "
        "explain_gap.",
    )  # fmt: skip
    TORQUE_DELAY_BELOW_A_SAMPLE = (
        "torque_delay_below_a_sample", "info",
        "The torque fits best a little late or early: measurement, corrected for, not a finding.",
        "Nothing, while it is less than a sample.",
    )  # fmt: skip
    LINK_SKEW_BELOW_A_SAMPLE = (
        "link_skew_below_a_sample", "info",
        "The link position fits best a little late or early: measurement, corrected for, not a finding.",
        "Nothing, while it is less than a sample.",
    )  # fmt: skip

    # The motion.
    OTHER_JOINTS_MOVE = (
        "other_joints_move", "info",
        "Other joints move in the recording: their motion may load this one, which the model does not know.",
        "Move this joint alone, all others held; or give the robot with --urdf.",
    )  # fmt: skip
    OTHER_JOINTS_EXPLAIN = (
        "other_joints_explain", "doubt",
        "What the model leaves is in part the motion of other joints: their inertia, speed or weight loads this one.",
        "Move this joint alone, all others held; or give the robot with --urdf.",
    )  # fmt: skip
    CONSTANT_SPEED = (
        "constant_speed", "doubt",
        "The joint moves at one speed: viscous and Coulomb friction, or inertia and gravity, cannot be told apart.",
        "Record a chirp, or at least motion at several speeds in both directions.",
    )  # fmt: skip
    SINGLE_TONE = (
        "single_tone", "doubt",
        "The motion holds one frequency: inertia, spring and gravity act alike there.",
        "Sweep the frequency (chirp.start_frequency_hz, chirp.end_frequency_hz), across the first mode.",
    )  # fmt: skip
    MODE_OUTSIDE_BAND = (
        "mode_outside_band", "doubt",
        "The locked-motor frequency of the result lies above the band that was excited, or at its end and no resonance "
        "is seen.",
        "Sweep beyond that frequency.",
    )  # fmt: skip
    SAMPLED_SLOWLY = (
        "sampled_slowly", "doubt",
        "The recording's rate is low for the joint's resonance: commands held that long fold back onto it.",
        "Command and record at ten times the locked-motor frequency or more.",
    )  # fmt: skip
    LOW_SAMPLING_RATE = (
        "low_sampling_rate", "doubt",
        "The recording's rate is below that of the paper's eq. 29: derivatives are distorted.",
        "Record faster, or use --method auto.",
    )  # fmt: skip

    # What the data determine.
    UNDETERMINED = (
        "undetermined", "info",
        "Only a combination of some parameters is determined; rejects where inertia or stiffness is among them and a "
        "linear method was asked for.",
        "Record a wider sweep.",
    )  # fmt: skip
    NOT_IDENTIFIABLE = (
        "not_identifiable", "info",
        "The recording does not determine this parameter; rejects where it is an inertia or the stiffness.",
        "Record the experiment that the sentence names: a wider sweep, a larger range, a payload or a link encoder.",
    )  # fmt: skip
    LOW_EXCITATION = (
        "low_excitation", "doubt",
        "An inertia or the stiffness is known poorly.",
        "Record the experiment that the sentence names.",
    )  # fmt: skip
    STARTS_DISAGREE = (
        "starts_disagree", "doubt",
        "Fits from different starts end apart, though all fit alike: the recording does not decide between them.",
        "Record a wider sweep or a larger amplitude, or start from a known model with --model.",
    )  # fmt: skip
    NOT_PHYSICAL = (
        "not_physical", "reject",
        "The fit has a negative inertia or stiffness: the model does not hold for this recording.",
        "Check sign and scale of the effort (--effort-scale), and that the signals are this joint's.",
    )  # fmt: skip
    CUTOFF_DEPENDENT = (
        "cutoff_dependent", "info",
        "The estimate changes with the filter's cutoff: something in that band is not in the model.",
        "Run explain_gap.",
    )  # fmt: skip

    # What the model leaves.
    MODEL_MISMATCH = (
        "model_mismatch", "doubt",
        "The model leaves much of the torque unexplained, and not by noise alone; rejects from half of it on.",
        "Run explain_gap to see what is missing.",
    )  # fmt: skip
    LINK_TAKEN_AS_RIGID = (
        "link_taken_as_rigid", "info",
        "From the motor alone K is of all that yields with the joint, base and neighbouring joints included, and holds "
        "for a link that is rigid well above the band: a part of it that swings just above cannot be told from another "
        "stiffness.",
        "Read a link encoder, or sweep further up, where another mode may lie near the end of the band.",
    )  # fmt: skip
    ENCODER_TAKEN_AS_TRUE = (
        "encoder_taken_as_true", "info",
        "Most of the interval of MX or MY is what an error of the link's encoder once or twice a turn would do.",
        "Compare with identify --sensors motor; move over a turn, or take MX and MY from the robot's description.",
    )  # fmt: skip
    GRAVITY_TAKEN_ALONE = (
        "gravity_taken_alone", "info",
        "MX, MY and offset hold where nothing but gravity pulls on the link: over the range that was moved a cable, a "
        "hose, a balancing spring or a torque that repeats twice a turn cannot be told from it.",
        "Move over a larger range (chirp.profile: rich); with a spring or a cable on the link, run explain_gap --add "
        "cable_torque.",
    )  # fmt: skip
    SLOPE_TAKEN_ON_LINK = (
        "slope_taken_on_link", "info",
        "K and JL hold where the torque that grows with the position acts on the link: from the motor alone, a spring "
        "or cogging on the motor's side is the same for other K and JL.",
        "Read a link encoder; or move over a larger range (chirp.profile: rich), where gravity bends and a spring does "
        "not.",
    )  # fmt: skip
    LOSS_UNSEEN = (
        "loss_unseen", "info",
        "Viscous friction holds as far as the spring has no loss of its own: one of a hundredth, which this recording "
        "does not rule out, damps the mode likewise. The interval holds it.",
        "Sample faster and sweep well beyond both resonances; with a spring that is known to lose, run explain_gap "
        "--add joint_damping or viscoelastic_spring.",
    )  # fmt: skip
    STRUCTURED_LINK = (
        "structured_link", "doubt",
        "The link's position is not what the model says, by more than its noise: the link encoder sits behind a "
        "further spring, or reads something else than this link.",
        "Look where the link encoder is mounted; run explain_gap, or identify with --sensors motor and compare.",
    )  # fmt: skip
    STRUCTURED_RESIDUAL = (
        "structured_residual", "doubt",
        "What the model leaves is more than noise: it has a structure that repeats or that the motion explains.",
        "Run explain_gap to see what is missing.",
    )  # fmt: skip
    CAUSE_SUSPECTED = (
        "cause_suspected", "doubt",
        "One effect accounts best for what is left, by a quick look: the intervals are wide enough for it.",
        "Run explain_gap, which fits it and says whether it holds.",
    )  # fmt: skip
    NOISE_UNKNOWN = (
        "noise_unknown", "doubt",
        "How large the noise is cannot be told: nothing repeats, and no part of the spectrum is free of motion.",
        "Repeat the motion (chirp.repeats: 2 or more), or record it twice and give both bags.",
    )  # fmt: skip
    VALIDATION_GAP = (
        "validation_gap", "doubt",
        "The error is larger where the fit did not look; rejects where the recording is too short to keep such a part.",
        "Record longer.",
    )  # fmt: skip
    TAKEN_AS_RIGID = (
        "taken_as_rigid", "info",
        "The motion shows no spring: a rigid joint explains the torque as well, and is what was fitted; from the motor "
        "alone where the link's position, used unasked, led to nothing.",
        "Sweep to higher frequencies, or read a link encoder, for the spring.",
    )  # fmt: skip
    RIGID_AS_WELL = (
        "rigid_as_well", "reject",
        "A rigid joint explains the recording as well: there is no sign of the spring that was fitted.",
        "Use --rigid, or sweep to higher frequencies for the spring.",
    )  # fmt: skip
    MOTOR_EQUATION = (
        "motor_equation", "info",
        "What the motor's equation alone (eq. 6), which holds whatever moves the link, says of the stiffness.",
        "Take K from it, nothing else, and record again with all other axes at rest.",
    )  # fmt: skip
    X5_INCONSISTENT = (
        "x5_inconsistent", "doubt",
        "X5 of the paper's eq. 19 contradicts the other six X; rejects from ten standard deviations on.",
        "Use --method auto.",
    )  # fmt: skip
    SIMPLIFIED_MODEL = (
        "simplified_model", "doubt",
        "The paper's eq. 18 leaves out gravity and the link's Coulomb friction: K and JL may be far off.",
        "Use --method auto.",
    )  # fmt: skip

    # Several recordings.
    RECORDING_LEFT_OUT = (
        "recording_left_out", "info",
        "A recording of the set was left out; doubts where that was not asked for.",
        "Look at that recording by itself: identify_bag BAG.",
    )  # fmt: skip
    RECORDINGS_DOUBTFUL = (
        "recordings_doubtful", "doubt",
        "Some of the recordings are doubtful by themselves, and the set with them.",
        "Read what is said of each, and leave it out with --leave-out BAG, or record it again.",
    )  # fmt: skip
    RECORDING_DISAGREES = (
        "recording_disagrees", "doubt",
        "A recording disagrees with the others by more than they do among themselves; it is in the result.",
        "Find out what was different about it, or leave it out with --leave-out BAG.",
    )  # fmt: skip
    RECORDINGS_SCATTER = (
        "recordings_scatter", "info",
        "A parameter differs between recordings by more than each of them can be wrong; the interval holds it.",
        "Where a condition is named, give the parameter for the condition that you need it at.",
    )  # fmt: skip
    SCATTER_TOO_LARGE = (
        "scatter_too_large", "reject",
        "An inertia or a stiffness differs so much between recordings that together they do not determine it.",
        "Look at each recording by itself, leave out what does not belong, or record more of them.",
    )  # fmt: skip
    FEW_RECORDINGS = (
        "few_recordings", "info",
        "Two or three recordings say little of how far others would scatter: the intervals are wide for that.",
        "Record five times or more, under all conditions that matter.",
    )  # fmt: skip
    FEW_SESSIONS = (
        "few_sessions", "info",
        "The recordings are of one day, or of two or three: they say little or nothing of how far days differ.",
        "Record on other days as well, five or more: recordings of one day share its temperature and mounting.",
    )  # fmt: skip
    EFFECT_NOT_SHARED = (
        "effect_not_shared", "info",
        "An effect that some recordings of the joint show by themselves, and that the others do not bear out.",
        "Read those recordings' own explanations: what was different there? Record that condition again.",
    )  # fmt: skip
    EFFECT_CONTRADICTED = (
        "effect_contradicted", "info",
        "A recording is predicted worse with an effect that most others confirm.",
        "Find out what was different about it, or leave it out with --leave-out BAG.",
    )  # fmt: skip
    JOINT_NAMES_DIFFER = (
        "joint_names_differ", "info",
        "The joints that were identified have different names in the recordings.",
        "Make sure that they are one joint; --joint NAME takes it in all.",
    )  # fmt: skip
    TORQUE_SCALE = (
        "torque_scale", "info",
        "What recordings with and without a known mass say of the effort's scale.",
        "Give it with --effort-scale where it is not 1, or record with more masses for a narrower interval.",
    )  # fmt: skip
    TORQUE_SCALE_UNKNOWN = (
        "torque_scale_unknown", "info",
        "Recordings with a known mass do not tell the effort's scale, and why.",
        "Fix the mass far from the axis, and record with and without it.",
    )  # fmt: skip
    TORQUE_SCALE_OFF = (
        "torque_scale_off", "doubt",
        "By the known mass the effort is to be multiplied: inertia, stiffness and friction are all off by that.",
        "Give --effort-scale as the message says, once mass and place are sure.",
    )  # fmt: skip
    TORQUE_SCALES_DIFFER = (
        "torque_scales_differ", "doubt",
        "The known mass adds to the inertia as if the effort had one scale, and to gravity as if it had another.",
        "Check mass and place, whether gravity is in the effort at all (--effort-kind), and whether the axis is level.",
    )  # fmt: skip

    # What was asked for.
    MODEL_IGNORED = (
        "model_ignored", "info",
        "The model given is not used: linear least squares needs no start and knows no effects.",
        "Use --method auto to start from it.",
    )  # fmt: skip
    MODEL_AS_GIVEN = (
        "model_as_given", "info",
        "How far the model as it was given is from the measurement, before its parameters are identified again.",
        "Nothing.",
    )  # fmt: skip
    BASE_NOT_DETERMINED = (
        "base_not_determined", "reject",
        "The recording does not determine the base model, so no missing effect is named.",
        "Record again as identify_bag advises for this recording; then look for what is missing.",
    )  # fmt: skip


CASES: Mapping[tuple[Code, str], Severity] = {
    (Code.HELD_SAMPLES, "slow"): "doubt", (Code.RECORDING_LEFT_OUT, "failed"): "doubt",
    (Code.RECORDING_LEFT_OUT, "rejected"): "doubt", (Code.RECORDING_LEFT_OUT, "other_model"): "doubt",
    (Code.MOTOR_CURRENT, "poor"): "doubt", (Code.URDF_GRAVITY, "against"): "doubt",
}  # fmt: skip
"""Severities of single cases of a code, where they are worse than the code's."""
NOT_SI = (Code.POSITION_NOT_SI, Code.EFFORT_NOT_SI)
"""A signal is not what it is taken for: no number that stands on it can be trusted."""
