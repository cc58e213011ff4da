"""Several recordings of one joint from bags to a folder, as a user runs it: rates, names and sensors mix."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from flex_ident.bags import writing
from flex_ident.bags.run_file import RUN_FILE
from flex_ident.commands.identify_bag import main as identify_bag
from flex_ident.report.comparison import compared
from flex_ident.report.stored import stored_result

TRUTH = {"J": 2.0, "FV": 3.0, "FS": 1.0}


def rigid_bag(
    path: Path, *, inertia: float = 2.0, rate_hz: float = 500.0, joint: str = "elbow", seed: int = 0, sign: float = 1.0,
    temperature: float | None = None, topic: str = "",
) -> Path:  # fmt: skip
    """A rigid joint moved by a chirp."""
    t = np.arange(0.0, 14.0, 1.0 / rate_hz)
    phase, omega = 2 * np.pi * (0.2 * t + 0.12 * t**2), 2 * np.pi * (0.2 + 0.24 * t)
    q, v = 0.3 * np.sin(phase), 0.3 * omega * np.cos(phase)
    a = 0.3 * (2 * np.pi * 0.24 * np.cos(phase) - omega**2 * np.sin(phase))
    torque = inertia * a + 3.0 * v + np.sign(v) + np.random.default_rng(seed).normal(0.0, 0.3, t.size)
    columns = (x[:, None] for x in (q, v, sign * torque))
    writing.write_joint_states(path, t, [joint], *columns)
    if temperature is not None:
        (path / RUN_FILE).write_text(f"conditions:\n  temperature: {temperature}\n  drive: old\n")
    return path


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bags")
    rigid_bag(folder / "a", seed=1)
    rigid_bag(folder / "b", seed=2, rate_hz=250.0, inertia=2.1, temperature=25.0)
    rigid_bag(folder / "c", seed=3, joint="axis_3", inertia=1.9)
    rigid_bag(folder / "other" / "a", seed=4)
    (folder / "broken").mkdir()
    (folder / "broken" / "x.mcap").write_bytes(b"no bag")
    return folder


def run(*arguments: object) -> int:
    return identify_bag([*map(str, arguments), "--rigid", "--no-plots"])


@pytest.mark.slow
def test_the_set_has_files_values_weights_and_scatter(
    bags: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert identify_bag([*(str(bags / n) for n in "abc"), "--rigid", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "3 recordings together" in said
    content = json.loads((tmp_path / "result.json").read_text())
    assert content["schema"] == "flex_ident/result/1"
    assert content["verdict"] == "trusted"
    for key, truth in TRUTH.items():
        low, high = content["parameters"][key]["ci95"]
        assert low <= truth <= high, key
    codes = [w["code"] for w in content["warnings"]]
    assert {"joint_names_differ", "few_recordings", "recordings_scatter"} <= set(codes)
    assert content["scatter"]["J"]["std"] == pytest.approx(0.1, rel=0.1)
    assert content["scatter"]["FV"]["relative_percent"] < 1.0
    assert [r["name"] for r in content["recordings"]] == ["a", "b", "c"]
    assert [round(r["sample_rate_hz"]) for r in content["recordings"]] == [500, 250, 500]
    assert sum(r["weight"]["J"] for r in content["recordings"]) == pytest.approx(1.0)
    assert content["recordings"][1]["conditions"] == {"temperature": 25.0, "drive": "old"}
    keys = content["covariance"]["keys"]
    own = content["covariance"]["matrix"][keys.index("J")][keys.index("J")]
    assert own**0.5 == pytest.approx(content["parameters"]["J"]["std"])
    assert {p.name for p in tmp_path.iterdir()} >= {"a", "b", "c", "model.yaml", "parameters.yaml", "recordings.png"}
    single = stored_result(tmp_path / "b")
    assert single.value("J") == pytest.approx(2.1, rel=0.01)
    page = (tmp_path / "report.html").read_text()
    assert "https://" not in page
    assert "data:image/png" in page
    assert "A and B: of the same recording" in compared([tmp_path, tmp_path / "a"])
    assert "A and B: do NOT agree over" in compared([tmp_path / "a", tmp_path / "b"])


def test_what_is_left_out_and_what_cannot_be_read_is_named(
    bags: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = (bags / "a", bags / "b", bags / "c", bags / "broken")
    assert run(*given, "--leave-out", "b", "--json", "--out", tmp_path) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["left_out"] == [{"name": "b", "why": "asked"}, {"name": "broken", "why": "failed"}]
    assert [r["name"] for r in content["recordings"]] == ["a", "c"]
    assert content["verdict"] == "doubtful"


def test_bags_of_one_name_go_by_their_paths(bags: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(bags / "a", bags / "other" / "a", "--json", "--out", tmp_path) == 0
    content = json.loads(capsys.readouterr().out)
    assert [r["name"] for r in content["recordings"]] == [str(bags / "a"), str(bags / "other" / "a")]
    assert content["parameters"]["J"]["value"] == pytest.approx(2.0, rel=0.01)
    assert content["parameters"]["J"]["std"] < 0.02


@pytest.mark.slow
def test_a_known_mass_gives_the_scale(bags: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    loaded = rigid_bag(tmp_path / "loaded", inertia=2.8, seed=5)
    given = ("--json", "--effort-scale", "0.8", "--out", tmp_path / "out")
    assert run(bags / "a", loaded, "--payload", "loaded=5.0@0.40", *given) == 0
    content = json.loads(capsys.readouterr().out)
    scale = content["torque_constant"]["scale"]
    assert scale["ci95"][0] <= 1.25 <= scale["ci95"][1]
    assert scale["value"] == pytest.approx(1.25, rel=0.01)
    assert content["verdict"] == "doubtful"
    assert "torque_scale_off" in [w["code"] for w in content["warnings"]]
    given = ("--json", "--effort-kind", "current", "--out", tmp_path / "out")
    assert run(bags / "a", loaded, "--payload", "loaded=5.0@0.40", *given) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["torque_constant"]["unit"] == "N m/A"
    assert content["parameters"]["J"]["unit"] == "kg m^2"
    assert content["parameters"]["J"]["value"] == pytest.approx(2.0, rel=0.01)
    assert run(bags / "a", bags / "other" / "a", "--payload", f"{bags / 'a'}=5.0@0.0", *given) == 0
    content = json.loads(capsys.readouterr().out)
    assert content["torque_constant"]["outcome"] == "on_axis"
    assert content["parameters"]["FS"]["unit"] == "A"
    assert run(bags / "a", loaded, "--json", "--out", tmp_path / "out") == 4
    content = json.loads(capsys.readouterr().out)
    assert "scatter_too_large" in [w["code"] for w in content["warnings"]]
    assert not content["parameters"]["J"]["identifiable"]


def test_a_copy_under_another_name_counts_once(bags: Path, tmp_path: Path) -> None:
    shutil.copytree(bags / "a", tmp_path / "later")
    assert run(bags / "a", bags / "b", tmp_path / "later", "--out", tmp_path / "out", "--quiet") == 0
    content = json.loads((tmp_path / "out" / "result.json").read_text())
    assert [r["name"] for r in content["recordings"]] == ["a", "b"]
    said = next(w["message"] for w in content["warnings"] if w["code"] == "recording_left_out")
    assert said.startswith("later was left out: it is a copy of a")


@pytest.mark.parametrize(
    ("names", "options", "status", "text"),
    [
        (("a",), ("--payload", "5@1"), 2, "--payload: needs several recordings"),
        (("a",), ("--leave-out", "a"), 2, "--leave-out: needs several recordings"),
        (("a", "a"), (), 2, "given twice"),
        (("a", "b"), ("--leave-out", "x"), 2, "--leave-out x: is none of the recordings: a, b"),
        (("a", "b"), ("--payload", "x=1@1"), 2, "none of the recordings"),
        (("a", "b"), ("--payload", "heavy"), 2, "expected [BAG=]MASS@X[,Y]"),
        (("a", "b"), ("--payload", "-3@0.4"), 2, "expected a mass of 0 kg or more"),
        (("a", "b"), ("--joint", "all"), 2, "one joint"),
        (
            ("a", "b"),
            ("--leave-out", "b"),
            3,
            "1 of 2 recordings can be used, two are needed: b was left out, as you say",
        ),
        (("a", "broken"), (), 3, "recordings can be used, two are needed: broken was left out, it cannot be"),
        (("a", "b"), ("--out", "/proc/nothing"), 2, "--out"),
    ],
)
def test_wrong_usage_is_one_line(
    bags: Path, names: tuple[str, ...], options: tuple[str, ...], status: int, text: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    out = () if "--out" in options else ("--out", tmp_path)
    assert run(*(bags / n for n in names), *options, *out, "--quiet") == status
    said = capsys.readouterr().err
    assert text in said
    assert len(said.strip().splitlines()) == 1


@pytest.mark.slow
def test_a_set_has_one_folder_by_default_and_keeps_it(
    bags: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for _ in range(2):
        assert run(bags / "a", bags / "c", "--quiet") == 0
    assert [p.name for p in (tmp_path / "flex_ident_results").iterdir()] == ["a+c_elbow"]
    assert (tmp_path / "flex_ident_results" / "a+c_elbow" / "c" / "result.json").exists()


def test_a_recording_that_is_rejected_is_left_out(bags: Path, tmp_path: Path) -> None:
    wrong = rigid_bag(tmp_path / "wrong", sign=-1.0, seed=6)
    assert run(bags / "a", bags / "b", wrong, "--quiet", "--out", tmp_path / "out") == 0
    content = json.loads((tmp_path / "out" / "result.json").read_text())
    assert [own["name"] for own in content["left_out"]] == ["wrong"]
    assert content["verdict"] == "doubtful"


def test_conditions_that_are_none_are_refused_with_the_file(
    bags: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(bags / "b", copy)
    (copy / RUN_FILE).write_text("conditions: [1, 2]\n")
    assert run(bags / "a", copy, "--quiet", "--out", tmp_path / "out") == 2
    assert RUN_FILE in capsys.readouterr().err
    (copy / RUN_FILE).write_text("conditions:\n  temperature: [1]\n")
    assert run(bags / "a", copy, "--quiet", "--out", tmp_path / "out") == 2
    assert "temperature" in capsys.readouterr().err
