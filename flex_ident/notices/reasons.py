"""Why an effect is not accepted, and what is left at the end of a search, as data: sentences are made in
`report/reasons.py`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum


class Why(StrEnum):
    """What speaks against an effect, or that more is left than noise."""

    # Against a candidate, as it is tried.
    LITTLE_LIKELIHOOD = "little_likelihood"
    WITHIN_NOISE = "within_noise"
    NOT_CONFIRMED = "not_confirmed"
    WITHIN_OWN_ERROR = "within_own_error"
    WITHIN_ROUNDING = "within_rounding"
    WITHIN_FILTER = "within_filter"
    WITHIN_TORQUE_NOISE = "within_torque_noise"
    TORQUE_GAP_GROWS = "torque_gap_grows"
    AT_BOUND = "at_bound"
    PART_OF_A_PERIOD = "part_of_a_period"
    NOT_SIGNIFICANT = "not_significant"
    OTHER_WITHOUT = "other_without"
    SHAPE_OPEN = "shape_open"
    BELOW_A_SAMPLE = "below_a_sample"
    CLOSES_LITTLE = "closes_little"
    PART_OF_OWN_ERROR = "part_of_own_error"

    # Against one that was not tried, or whose trial failed.
    EXPLAINS_NOTHING = "explains_nothing"
    OTHERS_EXPLAIN_MORE = "others_explain_more"
    RUNS_AWAY = "runs_away"
    NOTHING_LEFT = "nothing_left"

    # Against one that was accepted.
    BESIDE_ANOTHER = "beside_another"
    ALREADY_EXPLAINED = "already_explained"
    RESEMBLES = "resembles"
    MEASURED_INSTEAD = "measured_instead"
    GAP_DOES_NOT_FALL = "gap_does_not_fall"
    LINK_ALONE = "link_alone"
    NOISE_UNKNOWN = "noise_unknown"
    OPEN_IN_FINAL = "open_in_final"
    OPEN_WITH_ALL = "open_with_all"
    VARIES_BEYOND_FRICTION = "varies_beyond_friction"
    PEAK_WITHOUT_FRICTION = "peak_without_friction"

    # What is left.
    MORE_THAN_NOISE = "more_than_noise"
    OTHER_JOINTS = "other_joints"
    ONE_OF_MANY = "one_of_many"
    NOISE_UNTOLD = "noise_untold"
    LINK_LEFT = "link_left"
    SCALE_SUSPECTED = "scale_suspected"
    CAUSE_SUSPECTED = "cause_suspected"
    CHAIN_AT_ITS_END = "chain_at_its_end"


@dataclass(frozen=True)
class Reason:
    """One reason: the `subject` it is about (a key, an effect), and the numbers of its sentence.

    Numbers are in the units that their names carry, else SI; `case` where one reason has several sentences. `because`:
    a reason of another reason's own.
    """

    why: Why
    subject: str = ""
    numbers: Mapping[str, float] = field(default_factory=dict, hash=False)
    case: str = ""
    because: Reason | None = None
