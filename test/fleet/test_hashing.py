"""Hashes of files: of their bytes, piece by piece, and of nothing that is no file."""

import hashlib
import os
from pathlib import Path

import pytest
from waiting import no_longer_than

pytest.importorskip("pyarrow", reason="needs pyarrow", exc_type=ImportError)
from flex_ident.configuration.settings import IDENTIFY_SETTINGS
from flex_ident.errors import DataError, UsageError
from flex_ident.fleet.archive import Archive
from flex_ident.fleet.running import asked
from flex_ident.fleet.work import content_hash

VALUES = {s.key: s.default for s in IDENTIFY_SETTINGS}


def test_a_broken_recording_is_hashed_by_its_bytes(tmp_path: Path) -> None:
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "2.mcap").write_bytes(b"two")
    (tmp_path / "b" / "1.mcap").write_bytes(b"one" * 700_000)
    expected = hashlib.sha256(b"unreadable" + b"one" * 700_000 + b"two").hexdigest()
    assert content_hash(tmp_path / "b") == expected


def test_a_pipe_is_hashed_by_its_path(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.mcap")
    with no_longer_than(2.0):
        found = content_hash(tmp_path / "pipe.mcap")
    assert found == hashlib.sha256(b"unreadable" + os.fsencode(tmp_path / "pipe.mcap")).hexdigest()


def test_a_model_that_is_a_pipe_is_refused_at_once(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "model.yaml")
    with no_longer_than(2.0), pytest.raises(UsageError, match=r"model\.yaml: cannot be read \(it is a pipe"):
        asked({**VALUES, "model": str(tmp_path / "model.yaml")})


def test_a_pipe_in_an_archive_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "a.parquet")
    with no_longer_than(2.0):
        assert Archive(tmp_path).rows_in(tmp_path / "a.parquet") == []
        with pytest.raises(DataError, match=r"a\.parquet: is no file"):
            Archive(tmp_path).rows()
