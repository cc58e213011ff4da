"""`explain_gap A B C` from bags to one gap.json: what several recordings bear out is accepted, not what one shows."""

import json
import re
from pathlib import Path
from typing import Any

import pytest
from set_bags import joint_bag

from flex_ident.commands.explain_gap import main as explain_gap
from flex_ident.report.stored import stored_result

QUADRATIC = 1.5


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three recordings of one joint whose friction is quadratic too; in the last one alone the torque ripples."""
    folder = tmp_path_factory.mktemp("bags")
    joint_bag(folder / "a", seed=1, quadratic=QUADRATIC)
    joint_bag(folder / "b", seed=2, quadratic=QUADRATIC, inertia=2.05)
    joint_bag(folder / "c", seed=3, quadratic=QUADRATIC, ripple=1.5)
    (folder / "broken").mkdir()
    (folder / "broken" / "x.mcap").write_bytes(b"no bag")
    return folder


def run(*arguments: object) -> int:
    return explain_gap([*map(str, arguments), "--rigid", "--quiet"])


@pytest.fixture(scope="module")
def out(bags: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of all of them."""
    folder = tmp_path_factory.mktemp("out")
    effects = ("--effects", "viscous_nonlinearity,torque_ripple,viscous_asymmetry")
    assert run(*(bags / name for name in ("a", "b", "c", "broken")), *effects, "--out", folder) == 0
    return folder


@pytest.fixture(scope="module")
def content(out: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((out / "gap.json").read_text())
    return found


@pytest.mark.slow
def test_an_effect_that_all_find_is_accepted_with_one_size(content: dict[str, Any]) -> None:
    assert content["schema"] == "flex_ident/gap/1"
    [finding] = content["findings"]
    assert finding["effect"] == "viscous_nonlinearity"
    assert finding["verdict"] == "accepted"
    assert finding["found_in"] == ["a", "b", "c"]
    low, high = finding["parameters"]["coefficient"]["ci95"]
    assert low <= QUADRATIC <= high
    assert high - low < 0.2
    assert finding["agree"]["coefficient"] > 0.01
    assert "viscous_nonlinearity.coefficient" in content["parameters"]


@pytest.mark.slow
def test_validation_leaves_out_whole_recordings(content: dict[str, Any]) -> None:
    assert content["gap"]["measured_on"] == "recordings left out"
    for own in content["recordings"]:
        assert own["gap"]["values_from"] == "others"
        assert own["gap"]["after"] < 0.5 * own["gap"]["before"]
    for own in content["recordings"][:2]:
        assert own["gap"]["after"] < 0.1 * own["gap"]["before"]
    models = [step["model"] for step in content["gap"]["steps"]]
    assert models == ["base", "base + viscous_nonlinearity"]
    assert content["gap"]["steps"][-1]["gap"] == pytest.approx(content["gap"]["after"])


@pytest.mark.slow
def test_an_effect_of_one_that_the_others_contradict_is_not_accepted(content: dict[str, Any]) -> None:
    [refused] = content["rejected"]
    assert refused["effect"] == "torque_ripple"
    assert refused["outcome"] == "contradicted"
    assert [own["others_values"] for own in refused["recordings"]] == ["contradicts", "contradicts", "not_tried"]
    assert refused["recordings"][0]["gap_after"] > refused["recordings"][0]["gap_before"]
    assert content["verdict"] == "partly_explained"
    assert content["unexplained"].startswith("c: ")
    by_name = {own["name"]: own for own in content["recordings"]}
    assert by_name["c"]["findings"] == ["viscous_nonlinearity", "torque_ripple"]
    assert by_name["a"]["unexplained"] is None
    assert "effect_not_shared" in [w["code"] for w in content["warnings"]]


@pytest.mark.slow
def test_what_cannot_be_read_is_named(content: dict[str, Any]) -> None:
    assert content["left_out"] == [{"name": "broken", "why": "failed"}]


@pytest.mark.slow
def test_files_are_those_of_one_recording_and_each_has_its_own(out: Path) -> None:
    assert {p.name for p in out.iterdir()} == {
        "a", "b", "c", "gap.json", "gap_recordings.png", "model.yaml", "parameters.yaml", "recordings.png",
        "report.html",
    }  # fmt: skip
    assert stored_result(out).value("J") == pytest.approx(2.02, abs=0.03)
    assert json.loads((out / "c" / "gap.json").read_text())["verdict"] == "explained"
    page = (out / "report.html").read_text()
    assert "contradicted by a, b" in page
    assert not re.search(r'(?:src|href)="https?:', page)


@pytest.mark.parametrize(
    ("names", "options", "status", "text"),
    [
        (("a",), ("--leave-out", "a"), 2, "--leave-out: needs several recordings"),
        (("a", "a"), (), 2, "given twice"),
        (("a", "b"), ("--simulated", "x"), 3, "x"),
        (("a", "b"), ("--joint", "all"), 2, "explain_gap takes one joint"),
        (("broken", "b"), ("--leave-out", "b"), 3, "0 of 2 recordings can be used"),
    ],
)
def test_wrong_usage_is_one_line(
    bags: Path, names: tuple[str, ...], options: tuple[str, ...], status: int, text: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    assert run(*(bags / name for name in names), *options, "--out", tmp_path) == status
    said = capsys.readouterr().err
    assert text in said
    assert len(said.splitlines()) == 1


@pytest.mark.campaign
def test_put_in_by_hand_and_beside_a_simulator(bags: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A simulator that lacks quadratic friction and is too heavy, against two recordings together."""
    joint_bag(tmp_path / "theirs", seed=4, inertia=2.5)
    status = run(
        bags / "a", bags / "b", "--add", "viscous_asymmetry", "--effects", "viscous_nonlinearity", "--simulated",
        tmp_path / "theirs", "--json", "--out", tmp_path / "out",
    )  # fmt: skip
    assert status == 0
    content = json.loads(capsys.readouterr().out)
    assert {f["effect"]: f["verdict"] for f in content["findings"]} == {
        "viscous_nonlinearity": "accepted", "viscous_asymmetry": "by_hand",
    }  # fmt: skip
    assert any("put in by hand" in f["evidence"] for f in content["findings"])
    assert content["simulated"]["lacks"] == ["viscous_nonlinearity", "viscous_asymmetry"]
    inertia = content["simulated"]["parameters"]["J"]
    assert inertia["off_percent"] == pytest.approx(
        100.0 * (2.5 / 2.02 - 1.0), abs=3.0
    )  # two recordings: not beyond chance


@pytest.mark.slow
@pytest.mark.parametrize("names", [("a",), pytest.param(("a", "b"), marks=pytest.mark.campaign)])
def test_a_simulator_without_torque_costs_the_comparison_alone(
    bags: Path, names: tuple[str, ...], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    joint_bag(tmp_path / "silent", seed=5, scale=0.0)
    given = (*(bags / name for name in names), "--effects", "viscous_nonlinearity", "--simulated", tmp_path / "silent")
    assert run(*given, "--json", "--out", tmp_path / "out") == 3
    captured = capsys.readouterr()
    content = json.loads(captured.out)
    assert [f["effect"] for f in content["findings"]] == ["viscous_nonlinearity"]
    assert set(content["simulated"]) == {"failed"}
    [line] = captured.err.splitlines()
    assert line == f"explain_gap: {content['simulated']['failed']}"
    assert json.loads((tmp_path / "out" / "gap.json").read_text())["findings"] == content["findings"]
