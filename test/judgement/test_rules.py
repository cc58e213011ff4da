"""The rules of a verdict, each by itself on made-up evidence: no simulation."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flex_ident.judgement.evidence import Cause, FitEvidence, LinearEvidence, OtherJoints
from flex_ident.judgement.rules import FIT_RULES, LINEAR_RULES, judged
from flex_ident.judgement.thresholds import (
    CERTAIN_GAIN,
    HOPELESS_PERCENT,
    MOVED,
    POOR_PERCENT,
    SAMPLES_A_PERIOD,
    SCALE_GAIN,
    WEAK_PERCENT,
)
from flex_ident.notices import Code, Notice
from flex_ident.parameters import Parameter, Verdict
from flex_ident.report.sentences import sentence

SOUND = FitEvidence(
    parameters=(Parameter("Jm", 1.5, 0.01), Parameter("K", 1e4, 10.0), Parameter("JL", 2.0, 0.01)),
    error_percent=1.0, validation_percent=1.1, measurement=(Parameter("torque_delay", 1e-4, 1e-6),),
    sample_time=1e-3, locked_motor_hz=11.0, band_hz=30.0, gap=1.0, noise=1.0,
)  # fmt: skip
STRUCTURED = {"gap": 3.0, "structured": True}


def with_parameter(key: str, std: float, *, identifiable: bool = True) -> tuple[Parameter, ...]:
    return tuple(p if p.key != key else replace(p, std=std, identifiable=identifiable) for p in SOUND.parameters)


def cause(gain: float, moved: float = 2.0 * MOVED, *, effect: str = "backlash", strong: bool = True) -> Cause:
    return Cause(effect, gain, moved, strong)


HIDDEN = {"causes": (cause(2.0 * CERTAIN_GAIN),)}
RULES: list[tuple[str, dict[str, object], Verdict, set[str]]] = [
    ("nothing", {}, "trusted", set()),
    ("weak", {"parameters": with_parameter("K", 1.1e-2 * WEAK_PERCENT * 1e4)}, "doubtful", {"low_excitation"}),
    ("known well enough", {"parameters": with_parameter("K", 0.9e-2 * WEAK_PERCENT * 1e4)}, "trusted", set()),
    ("not determined", {"parameters": with_parameter("JL", 1.0, identifiable=False)}, "rejected", {"not_identifiable"}),
    ("friction may be weak", {"parameters": (*SOUND.parameters, Parameter("FV", 1.0, 5.0))}, "trusted", set()),
    (
        "poor", {"error_percent": 1.1 * POOR_PERCENT, "validation_percent": 1.1 * POOR_PERCENT, **STRUCTURED},
        "doubtful", {"model_mismatch", "structured_residual"},
    ),
    ("poor, for noise", {"error_percent": 1.1 * POOR_PERCENT, "validation_percent": 1.1 * POOR_PERCENT}, "trusted",
     set()),
    (
        "poor, perhaps for noise", {"error_percent": 1.1 * POOR_PERCENT, "noise_known": False}, "doubtful",
        {"model_mismatch", "noise_unknown"},
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
    ("low-passed", {"measurement": (Parameter("effort_lag", 5e-3, 1e-5),)}, "trusted", {"effort_lag"}),
    ("low-passed, perhaps", {"measurement": (Parameter("effort_lag", 5e-3, 2e-3),)}, "trusted", set()),
    ("structure", STRUCTURED, "doubtful", {"structured_residual"}),
    ("noise unknown", {"noise_known": False}, "doubtful", {"noise_unknown"}),
    ("an effect that moves", HIDDEN, "doubtful", {"cause_suspected"}),
    ("one that moves nothing", {"causes": (cause(2.0 * CERTAIN_GAIN, 0.5 * MOVED),)}, "trusted", set()),
    ("one that is chance", {"causes": (cause(2.0 * CERTAIN_GAIN, strong=False),)}, "trusted", set()),
    ("one that scales the torque", {"causes": (Cause("torque_droop", 2.0 * SCALE_GAIN, 2.0 * MOVED, True, True),)},
     "doubtful", {"cause_suspected"}),
    ("one without a gap, perhaps", {"causes": (cause(0.9 * CERTAIN_GAIN),)}, "trusted", set()),
    (
        "structure with its cause", {**STRUCTURED, "causes": (cause(100.0, 0.0),)}, "doubtful",
        {"structured_residual", "cause_suspected"},
    ),
    (
        "a rejection stands", {**HIDDEN, **STRUCTURED, "validation_percent": np.inf}, "rejected",
        {"structured_residual", "cause_suspected", "validation_gap"},
    ),
    ("a link that does not follow", {"link": (3e-4, 2e-6)}, "doubtful", {"structured_link"}),
    ("other joints", {"other_joints": OtherJoints(("wrist",), 0.3, 1e-9)}, "doubtful", {"other_joints_explain"}),
    ("two ends", {"other_end": ("K", 1.0e4, 1.2e4)}, "doubtful", {"starts_disagree"}),
    ("a chain at its end", {"strained": ("torque_averaging",)}, "doubtful", {"chain_at_its_end"}),
    (
        "unknown friction", {"parameters": (*SOUND.parameters, Parameter("FV", 1.0, 5.0, identifiable=False))},
        "trusted", {"not_identifiable"},
    ),
]  # fmt: skip


@pytest.mark.parametrize(("change", "verdict", "codes"), [r[1:] for r in RULES], ids=[r[0] for r in RULES])
def test_each_rule(change: dict[str, object], verdict: Verdict, codes: set[str]) -> None:
    found, notices = judged(replace(SOUND, **change), FIT_RULES)  # type: ignore[arg-type]
    assert found == verdict
    assert {str(n.code) for n in notices} == codes
    assert all(sentence(n) for n in notices)


def test_worst_rule_decides_whatever_the_order() -> None:
    poor = replace(SOUND, gap=3.0, structured=True, locked_motor_hz=31.0)
    assert judged(poor, FIT_RULES)[0] == "doubtful"
    worse = replace(poor, parameters=with_parameter("Jm", 9.0, identifiable=False))
    for rules in (FIT_RULES, FIT_RULES[::-1]):
        verdict, notices = judged(worse, rules)
        assert verdict == "rejected"
        assert notices[0].code == Code.NOT_IDENTIFIABLE  # what rejects is said first


def test_the_strongest_cause_is_named_and_structure_says_its_numbers() -> None:
    both = (cause(500.0, 4.0, effect="hysteresis"), cause(100.0, 2.0))
    _, notices = judged(replace(SOUND, causes=both, gap=3.0, structured=True), FIT_RULES)
    found = {n.code: n for n in notices}
    assert found[Code.CAUSE_SUSPECTED].subject == "hysteresis"
    assert found[Code.CAUSE_SUSPECTED].numbers == {"moved_stds": 4.0, "gain": 500.0}
    assert found[Code.STRUCTURED_RESIDUAL].numbers == {"gap": 3.0, "noise": 1.0}


def test_without_structure_the_cause_named_is_one_that_moves_a_parameter() -> None:
    """The recording may speak louder for an effect that does no harm: the doubt is about the other."""
    both = (cause(3.0 * CERTAIN_GAIN, 0.1 * MOVED, effect="kinematic_error"), cause(2.0 * CERTAIN_GAIN))
    verdict, notices = judged(replace(SOUND, causes=both), FIT_RULES)
    assert verdict == "doubtful"
    (notice,) = notices
    assert notice.subject == "backlash"
    assert notice.numbers["moved_stds"] == 2.0 * MOVED


LINEAR = LinearEvidence(SOUND.parameters, 1.0, 1.1, SOUND.measurement, 1e-3)
LINEAR_CASES: list[tuple[str, dict[str, object], Verdict, set[str]]] = [
    ("nothing", {}, "trusted", set()),
    ("reversed", {"opposed": True, "possible": False}, "rejected", {"effort_reversed"}),
    ("impossible", {"possible": False}, "rejected", {"not_physical"}),
    ("K is open", {"undetermined": (("K", "JL"),)}, "rejected", {"undetermined"}),
    ("gravity is open", {"undetermined": (("MX", "offset"),)}, "trusted", {"undetermined"}),
    ("X5 agrees", {"x5_stds": 1.0}, "doubtful", {"simplified_model"}),
    ("X5 is off", {"x5_stds": 4.0}, "doubtful", {"x5_inconsistent"}),
    ("X5 is far off", {"x5_stds": 40.0}, "rejected", {"x5_inconsistent"}),
    ("derivatives need more", {"required_rate_hz": 2000.0}, "doubtful", {"low_sampling_rate"}),
    ("weak", {"parameters": with_parameter("K", 1.1e-2 * WEAK_PERCENT * 1e4)}, "doubtful", {"low_excitation"}),
    ("hopeless", {"error_percent": 2.0 * HOPELESS_PERCENT}, "rejected", {"model_mismatch"}),
]


@pytest.mark.parametrize(
    ("change", "verdict", "codes"), [r[1:] for r in LINEAR_CASES], ids=[r[0] for r in LINEAR_CASES]
)
def test_each_rule_of_a_regression(change: dict[str, object], verdict: Verdict, codes: set[str]) -> None:
    found, notices = judged(replace(LINEAR, **change), LINEAR_RULES)  # type: ignore[arg-type]
    assert found == verdict
    assert {str(n.code) for n in notices} == codes
    assert all(sentence(n) for n in notices)


@pytest.mark.parametrize("rule", [*FIT_RULES, *LINEAR_RULES], ids=lambda r: f"{r.code}-{r.verdict}")
def test_a_rule_speaks_with_codes_that_doubt_as_much_as_it_does(rule: Any) -> None:
    """What makes a result doubtful is no mere information."""
    assert rule.verdict != "doubtful" or rule.code.severity != "info"


def test_notices_are_those_of_the_rules() -> None:
    said: list[Notice] = []
    for change in (r[1] for r in RULES):
        said.extend(judged(replace(SOUND, **change), FIT_RULES)[1])  # type: ignore[arg-type]
    assert {n.code for n in said} <= {r.code for r in FIT_RULES} | {Code.LINK_SKEW}
