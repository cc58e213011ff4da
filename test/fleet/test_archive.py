"""The archive's files: whole or not there, one for each thing asked, readable by others."""

import csv
import json
import os
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from flex_ident.errors import DataError, UsageError
from flex_ident.fleet.rows import COLUMNS, common_row, error_row, result_row

pytest.importorskip("pyarrow", reason="needs pyarrow", exc_type=ImportError)
from flex_ident.fleet.archive import Archive

CONTENT: dict[str, Any] = {
    "joint": "elbow", "sensors": "motor", "method": "auto", "verdict": "doubtful",
    "parameters": {
        "K": {"value": 0.1 + 0.2, "std": 1e-17, "identifiable": True},
        "JL": {"value": 3.0, "std": None, "identifiable": False},
        "backlash.gap": {"value": 1e-3, "std": 1e-5, "identifiable": True},
    },
    "warnings": [{"code": "low_excitation"}, {"code": "short_recording"}],
    "covariance": {"keys": ["K"], "matrix": [[1e-34]]},
}  # fmt: skip


def row(sha256: str = "1") -> dict[str, Any]:
    common = common_row(robot="r", bag="b", sha256=sha256, tag="t", conditions={"temperature": 20.0}, settings={})
    return result_row(common, CONTENT, start_time_s=1.7e9, seconds=2.0)


def test_rows_come_back_to_the_bit(tmp_path: Path) -> None:
    archive = Archive(tmp_path / "new").opened()
    archive.write(archive.file_of("1", {}), [row("1"), error_row(row("1"), "wrist", "no motion")])
    archive.write(archive.file_of("2", {}), [row("2")])
    rows = archive.rows()
    assert set(rows[0]) == set(COLUMNS)
    assert sorted((r["sha256"], r["joint"], r["verdict"]) for r in rows) == [
        ("1", "elbow", "doubtful"), ("1", "wrist", "error"), ("2", "elbow", "doubtful"),
    ]  # fmt: skip
    own = next(r for r in rows if r["sha256"] == "2")
    assert (own["K"], own["K_std"], own["JL"]) == (0.1 + 0.2, 1e-17, None)
    assert own["recorded_at"] == datetime.fromtimestamp(1.7e9, UTC)
    assert own["warnings"] == "low_excitation,short_recording"
    assert json.loads(own["result"]) == CONTENT
    assert json.loads(own["covariance"]) == CONTENT["covariance"]
    archive.write_csv(tmp_path / "table.csv")
    with (tmp_path / "table.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [r["K"] for r in table if r["verdict"] != "error"] == [repr(0.1 + 0.2)] * 2
    with pytest.raises(UsageError, match="--csv"):
        archive.write_csv(tmp_path / "none" / "table.csv")


def test_others_read_the_folder_as_one_table(tmp_path: Path) -> None:
    archive = Archive(tmp_path).opened()
    for name in "123":
        archive.write(archive.file_of(name, {}), [row(name)])
    (tmp_path / ".aside_left").write_bytes(b"half")
    assert pytest.importorskip("pyarrow.dataset", exc_type=ImportError).dataset(tmp_path).to_table().num_rows == 3
    pandas = pytest.importorskip("pandas", reason="the rest needs pandas", exc_type=ImportError)
    assert list(pandas.read_parquet(tmp_path)["K"]) == [0.1 + 0.2] * 3


def test_a_file_for_each_thing_asked(tmp_path: Path) -> None:
    archive = Archive(tmp_path)
    asked = [("1", {"rigid": True}), ("1", {"rigid": False}), ("2", {"rigid": True})]
    assert len({archive.file_of(sha256, settings) for sha256, settings in asked}) == 3
    assert archive.file_of("1", {"a": 1, "b": 2}) == archive.file_of("1", {"b": 2, "a": 1})


def test_damage_is_named_and_not_taken_for_a_result(tmp_path: Path) -> None:
    archive = Archive(tmp_path).opened()
    with pytest.raises(DataError, match="no archive"):
        archive.rows()
    file = archive.file_of("1", {})
    file.write_bytes(b"PAR1 half of a file")
    assert archive.rows_in(file) == []
    with pytest.raises(DataError, match="is damaged"):
        archive.rows()


def test_what_killed_workers_left_goes_after_an_hour(tmp_path: Path) -> None:
    for name, age in ((".aside_old", 4000.0), (".aside_new", 10.0)):
        (tmp_path / name).write_bytes(b"")
        now = (tmp_path / name).stat().st_mtime
        os.utime(tmp_path / name, (now - age, now - age))
    Archive(tmp_path).opened()
    assert [p.name for p in tmp_path.iterdir()] == [".aside_new"]


def test_rows_of_many_files_are_gathered_and_follow_what_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from flex_ident.fleet import archive as module
    from flex_ident.fleet.gathered import GATHERED

    def written(number: int, tag: str = "") -> Path:
        common = common_row(
            robot="arm", bag=f"bag {number}", sha256=f"{number:024d}", tag=tag, conditions={}, settings={}
        )
        file = archive.file_of(common["sha256"], {})
        archive.write(file, [error_row(common, "one", "no"), error_row(common, "two", "no")])
        return file

    archive = Archive(tmp_path / "fleet").opened()
    files = [written(i) for i in (3, 1, 2)]
    plain = archive.rows(["bag", "joint", "tag"])
    monkeypatch.setattr(module, "FEWEST", 2)
    assert archive.rows(["bag", "joint", "tag"]) == plain
    assert (tmp_path / "fleet" / GATHERED).exists()
    assert archive.rows(["bag", "joint", "tag"]) == plain
    written(2, tag="again")
    written(0)
    files[0].unlink()
    found = archive.rows(["bag", "joint", "tag"])
    assert [(row["bag"], row["joint"]) for row in found] == [(f"bag {i}", j) for i in (0, 1, 2) for j in ("one", "two")]
    assert [row["tag"] for row in found] == ["", "", "", "", "again", "again"]
    (tmp_path / "fleet" / GATHERED).write_bytes(b"damaged")
    assert archive.rows(["bag", "joint", "tag"]) == found
    files[1].write_bytes(b"damaged")
    with pytest.raises(DataError, match="is damaged; remove it"):
        archive.rows(["bag"])
