"""What reports say first, what plots leave blank, and which file an explanation is written to."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flex_ident.gap.explanation import Alternative, Finding, GapCurves, GapExplanation, Proof, Region, Rejected, Step
from flex_ident.gap.sizes import GapSize
from flex_ident.notices import Code, Notice, Reason, Why
from flex_ident.parameters import FitQuality, Identification, JointModel, Parameter
from flex_ident.recording import Recording
from flex_ident.report.advice import first_thing, other_things
from flex_ident.report.figures import thinned
from flex_ident.report.gap_table import change, closed_share, gap_text, others_text
from flex_ident.report.gap_writing import write_explanation
from flex_ident.report.sentences import sentence
from flex_ident.report.table import result_text

LEAVES = Notice(Code.MODEL_MISMATCH, numbers={"left_percent": 97.0})
GAPS = Notice(Code.GAPS, numbers={"percent": 3.0, "periods": 10})


def result(verdict: str, error: float, weak: tuple[str, ...] = (), *notices: Notice) -> Identification:
    keys = ("Jm", "K", "JL", "FVm", "MX", "MY")
    parameters = tuple(Parameter(k, 1.0, 0.01 if k not in weak else 5.0, "", k not in weak) for k in keys)
    said = tuple(Notice(Code.NOT_IDENTIFIABLE, k, {"value": 1.0, "std": 5.0}, {"unit": ""}) for k in weak)
    return Identification(
        joint="elbow", sensors="motor", method="auto", verdict=verdict, parameters=parameters,  # type: ignore[arg-type]
        fit=FitQuality(100, 10.0, 6, error, error), model=JointModel(dict.fromkeys(keys, 1.0)),
        notices=(*notices, *said),
    )  # fmt: skip


def test_noise_is_told_to_look_at_the_effort_and_nothing_else() -> None:
    r = result("rejected", 97.0, ("Jm", "K", "JL", "MX", "MY"), LEAVES)
    first = first_thing(r)
    assert first is not None
    assert first.startswith("Check the effort signal: the model leaves 97 %")
    assert "explain_gap" not in " ".join((first, *other_things(r)))
    assert len(other_things(r)) == 1


def test_what_is_not_determined_is_told_by_the_experiment_that_helps() -> None:
    r = result("rejected", 5.0, ("K", "JL", "MX", "MY"))
    first = first_thing(r)
    assert first is not None
    assert first.startswith("Record again: sweep through the resonance with a larger amplitude")
    assert "K and JL are not determined" in first
    assert sum("MX and MY are not determined" in line for line in other_things(r)) == 1


def test_a_reversed_effort_comes_before_all_else() -> None:
    first = first_thing(result("rejected", 97.0, ("K",), Notice(Code.EFFORT_REVERSED))) or ""
    assert first.startswith("Effort seems reversed")
    assert "--effort-scale -1" in first


def test_other_joints_that_moved_come_before_experiments() -> None:
    moved = Notice(Code.OTHER_JOINTS_MOVE, "", {"count": 2}, {"joints": "shoulder, wrist"})
    r = result("rejected", 60.0, ("K", "JL", "MX"), moved, LEAVES)
    first = first_thing(r) or ""
    assert first.startswith("Record this joint alone, all others held: 2 other joints moved: shoulder, wrist.")
    assert other_things(r) == ("K, JL and MX are not determined by this recording, as things are.",)
    text = result_text(r)
    assert text.count("not determined") == 1
    assert f"to do first: {first}" in text
    assert (first_thing(result("rejected", 5.0, (), moved, Notice(Code.NOT_PHYSICAL))) or "").startswith(
        "Record"
    ) is False


def test_modes_of_a_rejected_result_are_not_shown() -> None:
    derived = {"locked_motor_hz": 0.3, "free_resonance_hz": 1.7e5}
    assert "modes:" not in result_text(replace(result("rejected", 30.0, ("K",)), derived=derived))
    assert "modes:" in result_text(replace(result("doubtful", 30.0), derived=derived))


def test_the_motors_equation_is_told_with_what_to_do() -> None:
    numbers = {"K": 1e4, "std": 100.0, "left_percent": 10.0, "least_skew_s": 0.0}
    said = Notice(Code.MOTOR_EQUATION, "K", numbers, {"case": "determined", "unit": "N m/rad"})
    r = result("rejected", 40.0, ("K",), said)
    assert (first_thing(r) or "").startswith("Take K from the motor's equation")
    assert not any("eq. 6" in line for line in other_things(r))


def test_a_trusted_result_has_nothing_to_be_done_first() -> None:
    assert first_thing(result("trusted", 1.0)) is None
    assert first_thing(result("doubtful", 20.0, (), LEAVES)) == "T" + sentence(LEAVES)[1:]


def test_what_is_doubted_for_its_rate_is_told_what_to_do() -> None:
    numbers = {"rate_hz": 100.0, "locked_motor_hz": 15.0, "wanted_hz": 150.0}
    first = first_thing(result("doubtful", 2.0, (), Notice(Code.SAMPLED_SLOWLY, numbers=numbers))) or ""
    assert "Command and record at 150 Hz or more" in first


def test_a_line_is_interrupted_where_nothing_was_compared() -> None:
    time = np.arange(20000.0)
    values = np.where((time >= 5000) & (time < 9000), np.nan, np.sin(time))
    t, v = thinned(time, values)
    blank = t[np.isnan(v)]
    assert blank.size
    assert blank.min() >= 5000 - 14
    assert blank.max() < 9000
    assert np.nanmax(v) == pytest.approx(1.0, abs=1e-3)


def explanation(**changes: object) -> GapExplanation:
    time = np.arange(0.0, 20.0, 0.01)
    measured = 3.0 * np.sin(8.0 * time)
    noise = np.random.default_rng(0).normal(size=(2, time.size))
    usable = (time > 1.0).astype(float)
    final = result("doubtful", 20.0, (), GAPS,
                   LEAVES, GAPS)  # fmt: skip
    e = GapExplanation(
        joint="elbow", sensors="motor", verdict="complete", unit="N m", before=1.0, after=0.999, noise_floor=0.9,
        steps=(Step("base", 1.0), Step("base + backlash", 0.9999)), findings=(), not_testable=(),
        where=(Region("frequency", 0.0, 2.1, 0.98, 0.1, "Hz"),),
        rejected=(
            Rejected("backlash", -0.62, Reason(Why.WITHIN_NOISE)), Rejected("gravity", -0.001, Reason(Why.RUNS_AWAY)),
        ), final=final,
        curves=GapCurves(time, measured, measured + noise[0], measured + noise[1], usable),
    )  # fmt: skip
    return replace(e, **changes)  # type: ignore[arg-type]


def test_a_rejected_explanation_says_what_to_do_first() -> None:
    text = gap_text(explanation(verdict="rejected", final=result("rejected", 97.0, ("Jm", "K", "JL"))))
    assert text.splitlines()[2].startswith("do this first: Check the effort signal")
    assert "warning: Jm, K and JL are not determined" in text


def test_the_headline_says_where_the_model_takes_something_for_granted() -> None:
    assert "granted" not in gap_text(explanation()).splitlines()[0]
    lossy = Notice(Code.LOSS_UNSEEN, "FV", {"moved_percent": 12.0})
    text = gap_text(explanation(final=result("trusted", 1.0, (), lossy)))
    assert "takes for granted is said below" in text.splitlines()[0]
    assert sentence(lossy).rstrip(".") in text
    unexplained = explanation(verdict="unexplained", final=result("doubtful", 20.0, (), lossy))
    assert "granted" not in gap_text(unexplained).splitlines()[0]


def test_what_is_within_the_methods_own_error_is_not_called_noise() -> None:
    """EMPS was `explained`, "and the rest is noise", with 0.98 N left over noise of 0.33."""
    assert "left of the gap is noise" in gap_text(explanation()).splitlines()[0]
    for verdict in ("complete", "explained"):
        first = gap_text(explanation(verdict=verdict, noise_floor=0.3, method_error=1.08)).splitlines()[0]
        assert "more than noise (0.3 N m), and no more than the method's own error (1.08 N m)" in first


def test_a_suspect_is_said_in_place_of_a_gap() -> None:
    suspected = (Reason(Why.CAUSE_SUSPECTED, "stribeck_friction", {"stds": 6.1}),)
    text = gap_text(explanation(verdict="unexplained", unexplained=suspected, final=result(
        "doubtful", 2.0, (), Notice(Code.CAUSE_SUSPECTED, "stribeck_friction", {"moved_stds": 6.1}),
    )))  # fmt: skip
    assert "an effect is suspected all the same" in text.splitlines()[0]
    assert "unexplained: stribeck_friction is suspected" in text
    assert "see what --add stribeck_friction does" in text
    assert "run explain_gap" not in text


def test_shares_of_the_gap_are_words_where_numbers_would_puzzle() -> None:
    assert [closed_share(x) for x in (-0.62, -0.001, 0.4, 1.2)] == ["makes it worse", "0", "40", "100"]
    assert [change(1.0, x, 1) for x in (0.9999, 1.0, 0.5)] == ["±0 %", "±0 %", "-50.0 %"]


def test_the_terminal_shows_the_recordings_warnings_once() -> None:
    text = gap_text(explanation())
    assert text.count("warning: 3.00 % of the recording lies in gaps") == 1
    assert sentence(LEAVES) not in text
    header = text.splitlines()[2]
    assert header.endswith("change")


PROOF = Proof(GapSize(1.0), GapSize(0.5), 0.4, 3.0, 80.0, 0.9)


def test_another_effect_whose_gap_is_larger_than_before_is_explained() -> None:
    found = Finding("backlash", "accepted", 0.9, 1.0, 0.5, (), PROOF, (Alternative("hysteresis", 0.7),))
    assert others_text(found) == "hysteresis (gap 0.7)"
    worse = replace(found, also_considered=(*found.also_considered, Alternative("gravity", 1.4)))
    assert "gravity (gap 1.4); a gap above 1 is larger than without that" in others_text(worse)
    assert "a gap above 1 is larger" in gap_text(explanation(findings=(worse,)))


def recording() -> Recording:
    time = np.arange(0.0, 20.0, 0.01)
    return Recording(joint="elbow", sample_rate_hz=100.0, motor_position=np.sin(time), motor_torque=np.cos(time))


def test_the_report_of_an_identification_is_not_overwritten(tmp_path: Path) -> None:
    paths = write_explanation(explanation(), recording(), tmp_path / "alone", {"schema": "any"})
    assert "report.html" in paths
    assert paths["gap.json"].read_text() == '{\n "schema": "any"\n}\n'
    page = paths["report.html"].read_text()
    assert "makes it worse" in page
    assert ">-62<" not in page
    assert page.count("3.00 % of the recording lies in gaps") == 1
    both = tmp_path / "both"
    both.mkdir()
    (both / "result.json").write_text('{"joint": "elbow", "bag": {"path": "", "sha256": ""}}')
    (both / "report.html").write_text("kept")
    paths = write_explanation(explanation(), recording(), both, {})
    assert (both / "report.html").read_text() == "kept"
    assert paths["gap_report.html"].exists()
    assert "report.html" not in paths


@pytest.mark.parametrize("method", ["paper", "weighted"])
def test_explain_gap_knows_only_auto(method: str, tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "flex_ident.commands.explain_gap", str(tmp_path), "--method", method],
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 2
    assert len(done.stderr.strip().splitlines()) == 1
    assert "explain_gap knows only auto" in done.stderr
