"""Folders of results: never two runs in one, never outside of what was given, found to be unwritable in time."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from flex_ident.configuration.settings import IDENTIFY_SETTINGS, Value
from flex_ident.errors import UsageError
from flex_ident.jobs.places import Place, bag_name, place_of
from flex_ident.parameters import FitQuality, Identification, JointModel, Parameter
from flex_ident.recording import Recording
from flex_ident.report.folder import check_writable, folder_name, own_folder, renewed
from flex_ident.report.writing import write_identification

VALUES: dict[str, Value] = {s.key: s.default for s in IDENTIFY_SETTINGS}


def recording(joint: str = "elbow", path: str = "bag", sha256: str = "1") -> Recording:
    time = np.arange(0.0, 4.0, 0.01)
    return Recording(joint, 100.0, np.sin(time), np.cos(time), path=path, sha256=sha256)


def result(joint: str = "elbow", value: float = 1.0) -> Identification:
    return Identification(
        joint=joint, sensors="motor", method="auto", verdict="trusted", parameters=(Parameter("J", value, 0.1),),
        fit=FitQuality(100, 1.0, 1, 1.0, 1.0), model=JointModel({"J": value}),
    )  # fmt: skip


def stored(folder: Path, joint: str, sha256: str, path: str = "bag", name: str = "result.json") -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(json.dumps({"joint": joint, "bag": {"path": path, "sha256": sha256}}))


@pytest.mark.parametrize("text", ["..", ".", "", "a/b", "/etc", "../../x", "a\0b", "a\nb", ".hidden", "x" * 300, "é/ü"])
def test_a_name_is_one_step_down(tmp_path: Path, text: str) -> None:
    folder = tmp_path / folder_name(text)
    assert folder.resolve().parent == tmp_path.resolve()
    folder.mkdir()


def test_names_stay_apart_and_plain_ones_as_they_are() -> None:
    names = ["a/b", "a_b", "a%2Fb", "a b", "a+b", "..", "%2E.", "", "%", "x" * 300, "x" * 301, "joint_2", "Gelenk-é.1"]
    assert len({folder_name(n) for n in names}) == len(names)
    assert [folder_name(n) for n in names[-2:]] == names[-2:]


def test_bags_of_one_name_have_folders_of_their_own(tmp_path: Path) -> None:
    folder = tmp_path / "run_elbow"
    assert own_folder(folder, recording()) == folder
    stored(folder, "elbow", "1", "/monday/run")
    assert own_folder(folder, recording(path="/monday/run", sha256="1")) == folder
    assert own_folder(folder, recording(path="/monday/run", sha256="recorded anew")) == folder
    assert own_folder(folder, recording(path="/copied/run", sha256="1")) == folder
    other = own_folder(folder, recording(path="/friday/run", sha256="2"))
    assert other == tmp_path / "run_elbow_2"
    stored(other, "elbow", "2", "/friday/run", name="gap.json")
    assert own_folder(folder, recording(path="/friday/run", sha256="2")) == other
    assert own_folder(folder, recording(path="/sunday/run", sha256="3")) == tmp_path / "run_elbow_3"
    assert own_folder(folder, recording("wrist", path="/monday/run", sha256="1")) == tmp_path / "run_elbow_3"


def test_default_and_given_places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    place = place_of(VALUES, Path("/bags/run.mcap.zstd"))
    assert place.found(recording("a/b")) == (Path("flex_ident_results") / "run_a%2Fb", None)
    given = {**VALUES, "out": str(tmp_path / "out")}
    assert place_of(given, Path("run")).found(recording("..")) == (tmp_path / "out", None)
    assert place_of(given, Path("run"), many=True).found(recording("..")) == (tmp_path / "out" / "%2E.", None)
    assert bag_name(Path("/bags/..")) == folder_name(Path("/bags/..").resolve().name)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_known_before(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match="cannot be written"):
        check_writable(tmp_path / "file" / "below")
    needed = Place(lambda _joint: Path("/proc/nothing"))
    with pytest.raises(UsageError, match="/proc/nothing"):
        needed.found(recording())
    folder, why = Place(lambda _joint: Path("/proc/nothing"), needed=False).found(recording())
    assert folder is None
    assert "/proc/nothing" in str(why)


def test_a_run_replaces_what_another_left(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "gap.json").write_text(json.dumps({"joint": "elbow", "bag": {"path": "other", "sha256": "other"}}))
    for name in ("gap_where.png", "cutoff_sweep.png", "torque.png", "report.html", "gap_report.html"):
        (tmp_path / name).write_text("stale")
    paths = write_identification(result(), recording(), tmp_path, plots=False)
    assert {p.name for p in tmp_path.iterdir()} == {"notes.txt", "result.json", "model.yaml", "parameters.yaml"}
    assert set(paths) == {"result.json", "model.yaml", "parameters.yaml"}
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_an_explanation_of_the_same_recording_stays(tmp_path: Path) -> None:
    stored(tmp_path, "elbow", "1", name="gap.json")
    (tmp_path / "gap_where.png").write_text("kept")
    (tmp_path / "report.html").write_text("of the gap")
    write_identification(result(), recording(), tmp_path)
    assert (tmp_path / "gap_report.html").read_text() == "of the gap"
    assert (tmp_path / "gap_where.png").read_text() == "kept"
    assert "elbow" in (tmp_path / "report.html").read_text()
    write_identification(result(), recording(), tmp_path, plots=False)  # and again, without a page of its own
    assert (tmp_path / "gap_report.html").read_text() == "of the gap"
    assert not (tmp_path / "report.html").exists()


def test_a_run_that_fails_leaves_what_was_there(tmp_path: Path) -> None:
    (tmp_path / "result.json").write_text("old")

    def fails() -> None:
        with renewed(tmp_path, ("result.json", "torque.png")) as aside:
            (aside / "result.json").write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        fails()
    assert [p.name for p in tmp_path.iterdir()] == ["result.json"]
    assert (tmp_path / "result.json").read_text() == "old"


def test_a_disk_that_fills_up_is_one_line(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="No space left"), renewed(tmp_path, ()):
        raise OSError(28, os.strerror(28))
    assert list(tmp_path.iterdir()) == []


def test_what_is_read_is_of_one_run_at_any_time(tmp_path: Path) -> None:
    for value in (1.0, 2.0):
        write_identification(result(value=value), recording(), tmp_path, plots=False)
        stored_value = json.loads((tmp_path / "result.json").read_text())["parameters"]["J"]["value"]
        assert stored_value == value
        assert f"J: {value}" in (tmp_path / "model.yaml").read_text()
