"""The sentence of each notice: the one place where a code and its numbers become words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from flex_ident.judgement.priorities import REVERSED
from flex_ident.notices import Code, Notice, Reason
from flex_ident.report.reasons import reason_text
from flex_ident.report.several_worded import OF_SEVERAL
from flex_ident.report.worded import (
    TAKEN,
    Template,
    base_not_determined,
    below_a_sample,
    cause_suspected,
    chain_at_its_end,
    clock_drift,
    clock_stepped,
    effort_frozen,
    isolated,
    jumped_back,
    late,
    low_excitation,
    motor_equation,
    motor_equation_undetermined,
    motor_over_link,
    not_identifiable,
    other_joints,
    rezeroed,
    seam,
)


def sentence(notice: Notice | Reason) -> str:
    """What a notice or a reason says, in one sentence or two that begin with a small letter."""
    if isinstance(notice, Reason):
        return reason_text(notice)
    template = SENTENCES[notice.code]
    if isinstance(template, Mapping):
        template = template[notice.case]
    if callable(template):
        return template(notice)
    return template.format(subject=notice.subject, **notice.numbers, **notice.texts)


def finding_of(notice: Notice) -> str:
    """The sentence without what to do, for where that does not apply."""
    if notice.code is Code.MODEL_MISMATCH:
        return LEAVES.format(**notice.numbers)
    return sentence(notice)


def warning_content(notice: Notice) -> dict[str, Any]:
    """A notice in the `warnings` of result.json and gap.json."""
    return {
        "code": str(notice.code), "message": sentence(notice), "subject": notice.subject,
        "numbers": {k: v if math.isfinite(v) else None for k, v in notice.numbers.items()},
    }  # fmt: skip


LEAVES = "the model leaves {left_percent:.0f} % of the torque unexplained"
CUT = "{subject} {how} at byte {at:.0f} of {size:.0f}: the last {lost_percent:.1f} % are lost, what is whole was read."
STRUCTURE = "the model leaves {gap:.3g} {unit} rms, of which noise accounts for {noise:.3g}: "
HELD = (
    "{subject} is stamped at {stamped_hz:.4g} Hz and measured at {measured_hz:.4g} Hz: the {count:.0f} of {total:.0f} "
    "samples that repeat others were left out."
)
EFFORTS_TAKEN = "Efforts are taken as N m or N on the link side: --effort-scale converts them."

DESCRIBED = "by the URDF gravity pulls with MX = {MX:.3g}, MY = {MY:.3g} kg m"
HOLDS = "the effort holds {share_percent:.0f} ± {two_std_percent:.0f} % (2σ) of it{beside}"
SENTENCES: Mapping[Code, Template | Mapping[str, Template]] = {
    Code.BAG_DAMAGED: {
        "part": "a part was left out: {error}",
        "metadata": "{subject} {why} How many messages it announces is not known.",
        "part_missing": "{subject} of the bag is missing.",
        "cut_chunk": (
            "{subject} is cut at byte {at:.0f}, inside a chunk: {missing:.0f} bytes of that are lost, and all behind "
            "it; what is whole was read."
        ),
        "messages_lost": "{read:.0f} of {announced:.0f} messages of {subject} were read: the others are lost.",
        "compressed": "{count:.0f} compressed messages of {subject} are damaged and lost.",
        "names": "{count:.0f} messages of {subject} hold names that no others do: damaged, left out.",
        "messages": "{count:.0f} messages of {subject} are damaged and were left out.",
        "decompression": "{subject} is cut or damaged: what could be decompressed was read, the rest is lost.",
        "cut": CUT,
        "chunk": "{subject}: the chunk at byte {at:.0f} is damaged and was left out.",
        "rest_of_chunk": (
            "{subject}: the chunk at byte {at:.0f} is damaged at byte {inside:.0f} of its {size:.0f}: {read:.0f} "
            "messages in front were read, what follows is lost."
        ),
        "nameless": ("{subject}: {count:.0f} messages belong to no topic that the file describes, and were left out."),
        "short": "{subject}: {count:.0f} messages are shorter than a message can be, and were left out.",
        "summary": "{subject}: its summary is damaged at byte {at:.0f} of {size:.0f}.",
        "between": (
            "{subject}: what stands between bytes {at:.0f} and {further:.0f} of {size:.0f} is damaged and lost."
        ),
        "unknown_record": "{subject}: the record at byte {at:.0f} is of no known kind and was left out.",
        "end": "{subject} is cut: of what stood behind its {size:.0f} bytes nothing is left.",
        "record": "{subject}: damaged {kind} records left out: {count:.0f}.",
        "log": "{subject} cannot be read: the newest messages are lost. Copy the bag to a folder that is writable.",
        "database": "{subject} is damaged ({error}): {read:.0f} messages were read, the rest is lost.",
        "numbered_rows": "{subject}: {count:.0f} of {total:.0f} numbered messages are lost.",
        "damaged_rows": "{subject}: {count:.0f} of {total:.0f} messages are damaged and were left out.",
        "nameless_rows": (
            "{subject}: {count:.0f} of {total:.0f} messages belong to no topic of the file, and were left out."
        ),
        "indexed_rows": (
            "{subject}: {read:.0f} of {indexed:.0f} messages in its index were read: the others are lost."
        ),
    },
    Code.BAG_UNFINISHED: "{subject} was not closed: read to its end.",
    Code.COLUMNS_GUESSED: "columns of {subject} taken by their names: {columns}.",
    Code.NONFINITE_VALUES: (
        "{count:.0f} of {total:.0f} messages of {subject} hold no finite number, or no stamp, and were dropped."
    ),
    Code.TIME_JUMPED_BACK: jumped_back,
    Code.STAMPS_OUT_OF_ORDER: (
        "{count:.0f} of {total:.0f} messages of {subject} are out of order in time, or have a stamp far from their "
        "neighbours', and were dropped."
    ),
    Code.CLOCK_STEPPED: clock_stepped,
    Code.COARSE_STAMPS: ("stamps of {subject} come in ticks of {tick_ms:.4g} ms: samples were taken as evenly spaced."),
    Code.DUPLICATE_STAMPS: (
        "{count:.0f} of {total:.0f} messages of {subject} repeat the stamp before them: one of each was kept, which "
        "lowers the rate. Stamp each message when it is measured."
    ),
    Code.CLOCK_DRIFT: clock_drift,
    Code.DIFFERENT_CLOCKS: (
        "stamps of {subject} come from a clock {off_s:.6g} s off: brought to the motor position's by the usual time "
        "from stamp to reception."
    ),
    Code.RECEIVE_TIMES: (
        "header stamps of {subject} {why}: times of reception were used, and samples taken as evenly spaced. Stamp the "
        "messages where they are measured."
    ),
    Code.MIXED_CLOCKS: (
        "{subject} carry no usable stamp: times of reception were used, shifted by the usual latency of "
        "{latency_ms:.2f} ms. A skew between torque and position biases viscous friction."
    ),
    Code.PAUSED: "the recording pauses: only its longest part, of {longest_s:.6g} s, was used.",
    Code.GAPS: "{percent:.2f} % of the recording lies in gaps of over {periods:.0f} samples: left out.",
    Code.ISOLATED_VALUES: {
        "few": isolated(),
        "second_publisher": isolated(" Does a second node publish on this topic?"),
    },
    Code.SPIKES: "{count:.0f} of {total:.0f} values of {subject} are spikes of a single sample: left out.",
    Code.HELD_SAMPLES: {
        "fast": HELD,
        "slow": HELD + " That is slow: it says nothing of faster motion. Measure it as often as the position.",
    },
    Code.EFFORT_TRUNCATED: (
        "{subject} stays at zero for two of its steps of {step:.3g}, and so was cut toward zero instead of rounded: "
        "half a step is put back."
    ),
    Code.EFFORT_STEPS: (
        "{subject} comes in steps of {step:.3g}, and whether it was rounded or cut toward zero does not show: the "
        "intervals hold both."
    ),
    Code.EFFORT_FROZEN: effort_frozen,
    Code.POSITION_UNWRAPPED: {
        "turn": "{subject} jumps by a turn and back: taken as the angle of one turn, and made continuous.",
        "seam": seam,
    },
    Code.POSITION_REZEROED: rezeroed,
    Code.LINK_REPEATS_MOTOR: "{subject} repeats the motor position number by number: left out.",
    Code.POSITION_NOT_SI: {
        "counts": f"the {{which}} position holds whole numbers only, over {{swing:.4g}}: encoder counts? {TAKEN}",
        "swing": (
            "the {which} position spans {swing:.4g} at up to {speed:.4g} a second: degrees, millimetres, or the motor "
            f"shaft's (--gear-ratio)? {TAKEN}"
        ),
        "ratio": motor_over_link,
    },
    Code.EFFORT_NOT_SI: {
        "counts": (
            f"the effort holds whole numbers only, up to {{largest:.4g}}: raw units of the drive? {EFFORTS_TAKEN}"
        ),
        "inertia": (
            "efforts of up to {largest:.3g} for these accelerations suggest an inertia of {inertia:.2g}: a current, or "
            f"another unit? {EFFORTS_TAKEN}"
        ),
    },
    Code.EFFORT_SIDE: (
        "the motor position was divided by {gear_ratio:g}, and the effort taken as N m on the link side: if it is the "
        "motor shaft's too, give --effort-scale {gear_ratio:g}."
    ),
    Code.EFFORT_REVERSED: {
        "": REVERSED,
        "brakes": (
            "effort seems reversed: it takes up far more work than it does, and friction asks for the opposite: "
            "--effort-scale -1, or the opposite of yours."
        ),
    },
    Code.EFFORT_JOINT_SENSOR: {
        "found": (
            "the effort is the torque through the transmission, from a sensor behind the gear: it holds a motor "
            "inertia of less than {inertia_percent:.2g} % of the link's, and no friction of a motor. Jm, FVm and FSm "
            "are not in it; if it is the motor's, say --effort-kind motor."
        ),
        "given": (
            "the effort was taken as the torque through the transmission, as you say: Jm, FVm and FSm are not in it."
        ),
    },
    Code.EFFORT_GRAVITY_COMPENSATED: {
        "found": (
            "the effort is less the gravity that the controller adds: that explains torque and mode better than the "
            "motor's torque does (by {gain:.3g} in twice the log-likelihood; 20 are clear). If it is the motor's, say "
            "--effort-kind motor."
        ),
        "given": "the effort was taken as less the gravity that the controller adds, as told.",
    },
    Code.URDF_GRAVITY: {
        "held": (f"{DESCRIBED}, and {HOLDS}: it is torque that bears the arm, as the motor's is."),
        "absent": (f"{DESCRIBED}, and {HOLDS}: what the controller adds for gravity is not in it."),
        "other": (f"{DESCRIBED}, and {HOLDS}: check masses and payload of the URDF, and the scale of the effort."),
        "against": (f"{DESCRIBED}, and {HOLDS}: that is not the kind of effort that you say."),
        "open": f"{DESCRIBED}; whether the effort holds that, this motion does not tell{{beside}}.",
    },
    Code.EFFORT_FRICTION_COMPENSATED: {
        "found": (
            "the effort is less the friction that the controller adds: what is left of the motor's is negative. If it "
            "is the motor's torque, say --effort-kind motor."
        ),
        "given": (
            "the effort was taken as less the friction that the controller adds, as you say: {absent} are not in it."
        ),
    },
    Code.EFFORT_CURRENT: {
        "by_name": (
            "{subject} is by its name a current: frequencies and ratios hold, all else is in units of it; give N m per "
            "ampere with --effort-scale."
        ),
        "given": (
            "the effort was taken as a current, as you say: frequencies and ratios hold, all else is in units of it; "
            "give N m per ampere with --effort-scale."
        ),
    },
    Code.MOTOR_CURRENT: {
        "well": (
            "Jm, FVm and FSm are from the motor's current, with a torque constant of {torque_constant:.4g} ± {std:.2g} "
            "N m/A on the link side, one standard deviation: {left_percent:.1f} % of the current are left."
        ),
        "poor": (
            "Jm, FVm and FSm are from the motor's current, and leave {left_percent:.0f} % of it unexplained (torque "
            "constant {torque_constant:.4g} ± {std:.2g} N m/A): is it the current of this motor?"
        ),
    },
    Code.EFFORT_COMMANDED: "the effort was taken as what the drive was asked for, as you say.",
    Code.EFFORT_KIND_UNCLEAR: {
        "": (
            "the recording does not tell whether the effort holds gravity or is less what the controller adds: say "
            "--effort-kind motor or --effort-kind gravity_compensated. The intervals reach as far as the other would "
            "move them."
        ),
        "sensor": (
            "the recording does not tell whether the torque sensor's effort holds gravity or is less what the "
            "controller adds: say --effort-kind joint_sensor if it holds all of it. The intervals reach as far as the "
            "other would move them."
        ),
        "both": (
            "the effort holds hardly any gravity either, and the recording does not tell whether the controller adds "
            "it: the intervals reach as far as that would move them. Give the robot's --urdf, whose weight tells."
        ),
    },
    Code.EFFORT_KIND_OPEN: {
        "": (
            "the recording does not tell whether the effort holds gravity or is less what the controller adds; the "
            "intervals hold both. With --effort-kind motor or --effort-kind gravity_compensated they become narrower."
        ),
        "sensor": (
            "the recording does not tell whether the torque sensor's effort holds gravity or is less what the "
            "controller adds; the intervals hold both. With --effort-kind joint_sensor, if it holds all of it, they "
            "become narrower."
        ),
        "friction": (
            "the effort shows less friction of the motor than of the link: the recording does not tell whether the "
            "motor has hardly any or the controller adds what it takes, so that FVm and FSm are left open. Say "
            "--effort-kind motor or --effort-kind friction_compensated."
        ),
        "both": (
            "the effort holds hardly any gravity either, and the recording does not tell whether the controller adds "
            "it: the intervals reach as far as that would move them. Give the robot's --urdf, whose weight tells."
        ),
    },
    Code.EFFORT_LAG: "the effort lags by {lag_ms:.3g} ms, as behind a low-pass: corrected for.",
    Code.CHAIN_AT_ITS_END: chain_at_its_end,
    Code.TORQUE_DELAY: late("torque"),
    Code.LINK_SKEW: late("link position"),
    Code.TORQUE_DELAY_BELOW_A_SAMPLE: below_a_sample("torque"),
    Code.LINK_SKEW_BELOW_A_SAMPLE: below_a_sample("link position"),
    Code.OTHER_JOINTS_MOVE: other_joints,
    Code.OTHER_JOINTS_EXPLAIN: (
        "the motion of other joints ({joints}) explains {share_percent:.0f} % of what the model leaves, by energy, "
        "where it was not fitted: it loads this joint, which the model does not know. Move this joint alone, all "
        "others held."
    ),
    Code.CONSTANT_SPEED: (
        "the joint moves at one speed: viscous and Coulomb friction cannot be told apart. Record a chirp."
    ),
    Code.SINGLE_TONE: (
        "the motion holds {frequency_hz:.3g} Hz and little else: inertia, spring and gravity act alike there. Sweep "
        "the frequency across the first mode."
    ),
    Code.MODE_OUTSIDE_BAND: {
        "": (
            "the locked-motor frequency, {locked_motor_hz:.3g} Hz, lies above the excited band, {band_hz:.3g} Hz: "
            "sweep beyond it."
        ),
        "end": (
            "the locked-motor frequency, {locked_motor_hz:.3g} Hz, lies at the end of the excited band, {band_hz:.3g} "
            "Hz, and no resonance is seen: sweep beyond it."
        ),
    },
    Code.SAMPLED_SLOWLY: (
        "{rate_hz:.4g} Hz is slow for a locked-motor frequency of {locked_motor_hz:.3g} Hz: commands held that long "
        "fold back onto it. Command and record at {wanted_hz:.0f} Hz or more."
    ),
    Code.LOW_SAMPLING_RATE: (
        "{rate_hz:.4g} Hz is below the {required_hz:.0f} Hz of eq. 29: derivatives are distorted."
    ),
    Code.UNDETERMINED: {
        "": "only a combination of {subject} is determined.",
        "linear": "only a combination of {subject} is determined: record a wider sweep.",
    },
    Code.NOT_IDENTIFIABLE: not_identifiable,
    Code.LOW_EXCITATION: low_excitation,
    Code.STARTS_DISAGREE: (
        "fits from different starts end at {subject} from {lowest:.4g} to {highest:.4g} and fit alike: record a wider "
        "sweep or a larger amplitude."
    ),
    Code.NOT_PHYSICAL: "the fit has a negative inertia or stiffness: the model does not hold for this recording.",
    Code.CUTOFF_DEPENDENT: (
        "{subject} depends on the filter: {there:.4g} at a cutoff of {cutoff_rad_s:.0f} rad/s, {here:.4g} at "
        "{used_rad_s:.0f} rad/s. Something in that band is not in the model: run explain_gap."
    ),
    Code.MODEL_MISMATCH: LEAVES + ": run explain_gap to see what is missing.",
    Code.STRUCTURED_RESIDUAL: {
        "throughout": STRUCTURE + "run explain_gap to see what is missing.",
        "burst": STRUCTURE + "most of that from {from_s:.1f} to {to_s:.1f} s of the recording. If the joint was "
        "touched or disturbed there, record it again; else run explain_gap to see what is missing.",
    },
    Code.LINK_TAKEN_AS_RIGID: {
        "yields": "{subject} is that of all that yields with the joint, base and neighbouring joints included: the "
        "motor alone does not tell them apart, an encoder on the link does.",
        "far": "{subject} is that of all that yields with the joint, base and neighbouring joints included, and of a "
        "link which is rigid above the band: {share_percent:.0f} % of it swinging just above would make {subject} "
        "{moved_percent:+.2g} % ({moved_stds:.0f} standard deviations), and the motor alone does not tell.",
    },
    Code.GRAVITY_TAKEN_ALONE: (
        "gravity and offset hold where nothing else pulls on the link: a cable or a spring of a tenth of its slope, or "
        "half as much torque twice a turn, would move {subject} by {moved_percent:.2g} % ({moved_stds:.0f} standard "
        "deviations) and the rest with it, and over this range nothing tells them apart."
    ),
    Code.ENCODER_TAKEN_AS_TRUE: (
        "{subject} holds as far as the link's encoder is true over its turn: an error of 0.1 mrad once or twice a "
        "turn, as of an eccentric disk, would move it by {moved:.2g}, and over this range nothing tells; its interval "
        "holds that."
    ),
    Code.SLOPE_TAKEN_ON_LINK: (
        "{subject} holds where the torque that grows with the position acts on the link: on the motor (a cable, "
        "cogging) it would make {subject} {moved_percent:+.2g} % ({moved_stds:.0f} standard deviations) and K "
        "{stiffness_percent:+.2g} %, and over this range nothing tells."
    ),
    Code.LOSS_UNSEEN: (
        "{subject} holds as far as the spring has no loss of its own: a hundredth, as far as this recording "
        "does not rule it out, would move it by {moved_percent:.2g} %; its interval holds that."
    ),
    Code.STRUCTURED_LINK: (
        "the model leaves {gap:.3g} {unit} rms of the link's position, of which noise accounts for {noise:.3g}: the "
        "link encoder reads something else than this link, or sits behind a further spring."
    ),
    Code.CAUSE_SUSPECTED: cause_suspected,
    Code.NOISE_UNKNOWN: (
        "how large the noise is cannot be told from this recording: repeat the motion, or give two recordings of it."
    ),
    Code.VALIDATION_GAP: {
        "short": "too short to keep a part that the fit does not see: record at least ten seconds of motion.",
        "larger": (
            "the error is {unseen_percent:.1f} % where the fit did not look, {error_percent:.1f} % overall: record "
            "longer."
        ),
    },
    Code.TAKEN_AS_RIGID: {
        "as_well": (
            "the motion shows no spring: a rigid joint explains it as well ({rigid_percent:.1f} against "
            "{sprung_percent:.1f} % of the torque left), and is what was fitted. Sweep to higher frequencies, or read "
            "a link encoder, for the stiffness."
        ),
        "alone": (
            "the motion shows no spring: a rigid joint leaves {rigid_percent:.1f} % of the torque, and is what was "
            "fitted. Sweep to higher frequencies, or read a link encoder, for the stiffness."
        ),
        "beside_link": (
            "with the link's position nothing could be determined: a rigid joint leaves {rigid_percent:.1f} % of the "
            "torque, and is what was fitted, from the motor alone. Sweep to higher frequencies for the stiffness, and "
            "look whether the link's position is of this joint."
        ),
    },
    Code.RIGID_AS_WELL: (
        "a rigid joint explains it as well ({rigid_percent:.1f} against {sprung_percent:.1f} % of the torque left): "
        "use --rigid, or sweep to higher frequencies for the spring."
    ),
    Code.MOTOR_EQUATION: {"determined": motor_equation, "undetermined": motor_equation_undetermined},
    Code.X5_INCONSISTENT: (
        "X5 contradicts the other six X by {sigmas:.1f} standard deviations: gravity and the link's Coulomb friction, "
        "which eq. 18 leaves out, or noise bias K and JL. Use --method auto."
    ),
    Code.SIMPLIFIED_MODEL: (
        "eq. 18 leaves out gravity and the link's Coulomb friction; K and JL may be far off. Use --method auto."
    ),
    **OF_SEVERAL,
    Code.MODEL_IGNORED: "the model given is not used: linear least squares needs no start and knows no effects.",
    Code.MODEL_AS_GIVEN: (
        "the model as given leaves {given:.3g} {unit}; with its parameters identified again, which is the base here, "
        "{refitted:.3g} {unit}."
    ),
    Code.BASE_NOT_DETERMINED: base_not_determined,
}
