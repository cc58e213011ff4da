"""The rules of a verdict, each by itself on made-up evidence: no simulation."""

from dataclasses import replace

import numpy as np
import pytest

from flex_ident.estimation.verdict import CERTAIN_GAIN, MOVED, SAMPLES_A_PERIOD, Evidence, judged
from flex_ident.likelihood.remainder import STRUCTURE, Remainder
from flex_ident.notices import Code
from flex_ident.parameters import Parameter, Verdict
from flex_ident.regression.verdict import HOPELESS_PERCENT, POOR_PERCENT, WEAK_PERCENT
from flex_ident.report.sentences import sentence
from flex_ident.screening.suspects import STRONG, Suspect

NOISE = Remainder(np.zeros(1), 1.0, 1.0, 0.0, None, "above_band")
SOUND = Evidence(
    parameters=(Parameter("Jm", 1.5, 0.01), Parameter("K", 1e4, 10.0), Parameter("JL", 2.0, 0.01)),
    error_percent=1.0, validation_percent=1.1, measurement=(Parameter("torque_delay", 1e-4, 1e-6),),
    sample_time=1e-3, locked_motor_hz=11.0, band_hz=30.0, left=NOISE,
)  # fmt: skip


def left(gap: float, floor: float = 1.0, **others: object) -> Remainder:
    return replace(NOISE, gap=gap, floor=floor, **others)  # type: ignore[arg-type]


def with_parameter(key: str, std: float, *, identifiable: bool = True) -> tuple[Parameter, ...]:
    return tuple(p if p.key != key else replace(p, std=std, identifiable=identifiable) for p in SOUND.parameters)


def suspect(gain: float) -> Suspect:
    return Suspect("backlash", gain, np.zeros(3))


HIDDEN = {"suspects": (suspect(2.0 * CERTAIN_GAIN),), "moved": {"backlash": 2.0 * MOVED}}
RULES: list[tuple[str, dict[str, object], Verdict, set[str]]] = [
    ("nothing", {}, "trusted", set()),
    ("weak", {"parameters": with_parameter("K", 1.1e-2 * WEAK_PERCENT * 1e4)}, "doubtful", {"low_excitation"}),
    ("known well enough", {"parameters": with_parameter("K", 0.9e-2 * WEAK_PERCENT * 1e4)}, "trusted", set()),
    ("not determined", {"parameters": with_parameter("JL", 1.0, identifiable=False)}, "rejected", set()),
    ("friction may be weak", {"parameters": (*SOUND.parameters, Parameter("FV", 1.0, 5.0))}, "trusted", set()),
    (
        "poor", {"error_percent": 1.1 * POOR_PERCENT, "validation_percent": 1.1 * POOR_PERCENT}, "doubtful",
        {"model_mismatch"},
    ),
    (
        "hopeless", {"error_percent": 1.1 * HOPELESS_PERCENT, "validation_percent": 1.1 * HOPELESS_PERCENT}, "rejected",
        {"model_mismatch"},
    ),
    (
        "no sum", {"error_percent": np.nan, "validation_percent": np.nan}, "rejected",
        {"model_mismatch", "validation_gap"},
    ),
    ("worse unseen", {"error_percent": 2.0, "validation_percent": 6.0}, "doubtful", {"validation_gap"}),
    ("nothing unseen", {"validation_percent": np.inf}, "rejected", {"validation_gap"}),
    ("mode outside", {"locked_motor_hz": 31.0}, "doubtful", {"mode_outside_band"}),
    ("slow", {"sample_time": 1.02 / (SAMPLES_A_PERIOD * 11.0)}, "doubtful", {"sampled_slowly"}),
    ("just fast enough", {"sample_time": 0.98 / (SAMPLES_A_PERIOD * 11.0)}, "trusted", set()),
    ("late", {"measurement": (Parameter("torque_delay", 2e-3, 1e-5),)}, "doubtful", {"torque_delay"}),
    ("late, perhaps", {"measurement": (Parameter("torque_delay", 2e-3, 6e-4),)}, "trusted", set()),
    ("structure", {"left": left(1.01 * STRUCTURE)}, "doubtful", {"structured_residual"}),
    ("no more than noise", {"left": left(0.99 * STRUCTURE)}, "trusted", set()),
    ("no more than the method's own", {"left": left(2.0, own_error=2.0)}, "trusted", set()),
    ("noise unknown", {"left": left(1.0, evidence="none")}, "doubtful", {"noise_unknown"}),
    ("an effect that moves", HIDDEN, "doubtful", {"cause_suspected"}),
    ("one that moves nothing", {**HIDDEN, "moved": {"backlash": 0.5 * MOVED}}, "trusted", set()),
    ("one that is chance", {**HIDDEN, "suspects": (suspect(0.9 * STRONG),)}, "trusted", set()),
    ("one without a gap, perhaps", {**HIDDEN, "suspects": (suspect(0.9 * CERTAIN_GAIN),)}, "trusted", set()),
    (
        "structure with its cause", {**HIDDEN, "moved": {}, "left": left(3.0)}, "doubtful",
        {"structured_residual", "cause_suspected"},
    ),
    (
        "a rejection stands", {**HIDDEN, "left": left(3.0), "validation_percent": np.inf}, "rejected",
        {"structured_residual", "cause_suspected", "validation_gap"},
    ),
]  # fmt: skip


@pytest.mark.parametrize(("change", "verdict", "codes"), [r[1:] for r in RULES], ids=[r[0] for r in RULES])
def test_each_rule(change: dict[str, object], verdict: Verdict, codes: set[str]) -> None:
    found, notices = judged(replace(SOUND, **change))  # type: ignore[arg-type]
    assert found == verdict
    assert {str(n.code) for n in notices} == codes
    assert all(sentence(n) for n in notices)


def test_worst_rule_decides_whatever_the_order() -> None:
    poor = replace(SOUND, left=left(3.0), locked_motor_hz=31.0)
    assert judged(poor)[0] == "doubtful"
    assert judged(replace(poor, parameters=with_parameter("Jm", 9.0, identifiable=False)))[0] == "rejected"


def test_the_strongest_cause_is_named_and_structure_says_its_numbers() -> None:
    both = (Suspect("hysteresis", 500.0, np.zeros(3)), suspect(100.0))
    _, notices = judged(replace(SOUND, suspects=both, moved={"hysteresis": 4.0, "backlash": 2.0}, left=left(3.0)))
    found = {n.code: n for n in notices}
    assert found[Code.CAUSE_SUSPECTED].subject == "hysteresis"
    assert found[Code.CAUSE_SUSPECTED].numbers == {"moved_stds": 4.0, "gain": 500.0}
    assert found[Code.STRUCTURED_RESIDUAL].numbers == {"gap": 3.0, "noise": 1.0}


def test_without_structure_the_cause_named_is_one_that_moves_a_parameter() -> None:
    """The recording may speak louder for an effect that does no harm: the doubt is about the other."""
    both = (Suspect("kinematic_error", 3.0 * CERTAIN_GAIN, np.zeros(3)), suspect(2.0 * CERTAIN_GAIN))
    verdict, notices = judged(
        replace(SOUND, suspects=both, moved={"kinematic_error": 0.1 * MOVED, "backlash": 2.0 * MOVED})
    )
    assert verdict == "doubtful"
    (notice,) = notices
    assert notice.subject == "backlash"
    assert notice.numbers["moved_stds"] == 2.0 * MOVED
