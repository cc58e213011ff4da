"""The robot's description that `--urdf` names: a file of bounded size, and never waited for."""

import os
from pathlib import Path

import pytest
from waiting import no_longer_than

from flex_ident.errors import UsageError
from flex_ident.jobs.robots import description_of
from flex_ident.robot.xml import LARGEST


def test_a_file_is_read(tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_text("<robot name='Greifer ä'/>", encoding="utf-8")
    assert description_of({"urdf": str(file)}) == "<robot name='Greifer ä'/>"
    assert description_of({"urdf": ""}) is None


def test_what_is_no_file_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path, why in (
        (tmp_path / "pipe", "a pipe or a device"), (Path("/dev/null"), "a pipe or a device"), (tmp_path, "a folder"),
        (tmp_path / "none", "No such file"),
    ):  # fmt: skip
        with no_longer_than(2.0), pytest.raises(UsageError, match=f"^--urdf {path}: .*{why}"):
            description_of({"urdf": str(path)})


def test_a_huge_file_is_not_read_to_its_end(tmp_path: Path) -> None:
    with (tmp_path / "huge").open("wb") as file:
        file.truncate(40 * LARGEST)
    with pytest.raises(UsageError, match=f"{LARGEST} are read at most"):
        description_of({"urdf": str(tmp_path / "huge")})


def test_what_is_not_text_is_refused(tmp_path: Path) -> None:
    (tmp_path / "latin").write_bytes(b"<robot name='\xe4'/>")
    with pytest.raises(UsageError, match="is not UTF-8"):
        description_of({"urdf": str(tmp_path / "latin")})
