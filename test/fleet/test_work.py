"""One recording: done once, its errors in the archive, tried again where that may help."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from fleet_bags import small_bag

pytest.importorskip("pyarrow", reason="needs pyarrow", exc_type=ImportError)
from flex_ident.commands.batch import twin_lines
from flex_ident.configuration.settings import IDENTIFY_SETTINGS
from flex_ident.errors import UsageError
from flex_ident.fleet import work
from flex_ident.fleet.archive import Archive
from flex_ident.fleet.running import asked
from flex_ident.fleet.work import Work, archived, lost

VALUES = {s.key: s.default for s in IDENTIFY_SETTINGS} | {"rigid": True}


def one(bag: Path, folder: Path, **values: Any) -> Work:
    folder.mkdir(exist_ok=True)
    return Work(bag, "r9", "", asked({**VALUES, **values}), folder)


def test_joints_that_fail_have_rows_of_their_own(bags: Path, tmp_path: Path) -> None:
    for joint, message in (("wrist", "wrist"), ("held_joint", "does not move")):
        outcome = archived(one(bags / "r1" / "monday", tmp_path / joint, joint=joint))
        assert [(own.joint, own.verdict) for own in outcome.joints] == [(joint, "error")]
        assert message in outcome.joints[0].message
        assert not outcome.there
        assert archived(one(bags / "r1" / "monday", tmp_path / joint, joint=joint)).there


def test_a_recording_that_may_be_answered_later_is_tried_again(
    bags: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = one(bags / "r2" / "tuesday" / "x.mcap", tmp_path)
    assert lost(own, "its worker was killed").joints[0].message == "its worker was killed"
    again = archived(own)
    assert not again.there
    assert "x.mcap" in again.joints[0].message
    assert archived(own).there
    assert "x.mcap" in lost(own, "its worker was killed").joints[0].message
    [row] = Archive(tmp_path).rows()
    assert (row["verdict"], row["again"]) == ("error", False)

    def memory(*_: object, **__: object) -> None:
        raise MemoryError

    monkeypatch.setattr(work, "finished_identification", memory)
    full = one(bags / "r1" / "monday", tmp_path / "full")
    assert archived(full).joints[0].message == "not enough memory for this recording."
    assert not archived(full).there


def test_the_run_file_names_the_robot(tmp_path: Path) -> None:
    bag = small_bag(tmp_path / "run")
    (bag / "flex_ident_run.yaml").write_text("conditions:\n  robot: arm 7\n  temperature: 31.5\n")
    archived(one(bag, tmp_path / "fleet"))
    [row] = Archive(tmp_path / "fleet").rows()
    assert (row["robot"], row["conditions"]) == ("arm 7", '{"robot": "arm 7", "temperature": 31.5}')
    (bag / "flex_ident_run.yaml").write_text("conditions: 3\n")
    assert "flex_ident_run.yaml" in archived(one(bag, tmp_path / "fleet_2")).joints[0].message


def test_a_copy_of_a_recording_counts_once_and_is_said(tmp_path: Path) -> None:
    first, copy = small_bag(tmp_path / "arm_1" / "day"), tmp_path / "backup" / "day"
    shutil.copytree(first, copy)
    archived(replace(one(first, tmp_path / "fleet"), robot="arm_1"))
    found = archived(replace(one(copy, tmp_path / "fleet"), robot="backup"))
    assert found.twin == (str(first), "arm_1")
    assert [row["robot"] for row in Archive(tmp_path / "fleet").rows()] == ["arm_1"]
    [said] = twin_lines(found)
    assert "the same recording as" in said
    assert "of robot arm_1" in said


def test_a_recording_that_was_moved_is_of_its_new_place(tmp_path: Path) -> None:
    """A robot that was renamed kept its old name in the archive without a word."""
    first = small_bag(tmp_path / "arm_1" / "day")
    archived(replace(one(first, tmp_path / "fleet"), robot="arm_1"))
    moved = (tmp_path / "arm_1").rename(tmp_path / "arm_2") / "day"
    found = archived(replace(one(moved, tmp_path / "fleet"), robot="arm_2"))
    assert (found.there, found.twin) == (True, None)
    [row] = Archive(tmp_path / "fleet").rows()
    assert (row["robot"], row["bag"]) == ("arm_2", str(moved))
    assert archived(one(moved, tmp_path / "fleet")).there  # r9: the pattern says so
    assert Archive(tmp_path / "fleet").rows()[0]["robot"] == "r9"
    assert archived(replace(one(moved, tmp_path / "fleet"), robot="")).there
    assert Archive(tmp_path / "fleet").rows()[0]["robot"] == "r9"


def test_files_are_asked_for_by_what_is_in_them(tmp_path: Path) -> None:
    definition = tmp_path / "X.msg"
    hashes = []
    for content in ("float64 a", "float64 b"):
        definition.write_text(content)
        settings = asked({**VALUES, "type_file": str(definition)})
        hashes.append(settings["type_file_sha256"])
    assert hashes[0] != hashes[1]
    with pytest.raises(UsageError, match=r"gone\.msg"):
        asked({**VALUES, "type_file": str(tmp_path / "gone.msg")})
