"""compare and export, on results written by hand."""

import json
from pathlib import Path

import pytest

from flex_ident.errors import DataError
from flex_ident.report.comparison import compared
from flex_ident.report.export import exported
from flex_ident.report.export.formats import FORMATS


def written(path: Path, k: float) -> Path:
    def p(value: float, std: float, unit: str) -> dict[str, object]:
        return {"value": value, "std": std, "unit": unit, "identifiable": True}

    content = {
        "schema": "flex_ident/result/1", "joint": "elbow", "sensors": "motor", "method": "auto", "verdict": "trusted",
        "parameters": {"Jm": p(1.0, 0.01, "kg m^2"), "K": p(k, 10.0, "N m/rad"), "JL": p(2.0, 0.01, "kg m^2")},
    }  # fmt: skip
    path.mkdir()
    (path / "result.json").write_text(json.dumps(content))
    return path


def test_a_difference_beyond_chance_is_marked(tmp_path: Path) -> None:
    text = compared([written(tmp_path / "a", 1000.0), written(tmp_path / "b", 1100.0)])
    [row] = [line for line in text.splitlines() if line.startswith("K ")]
    assert "(+10.0 %)" in row
    assert row.endswith("7.1 *")
    [row] = [line for line in text.splitlines() if line.startswith("Jm ")]
    assert row.endswith("0.0")


@pytest.mark.parametrize("to", FORMATS)
def test_exports_hold_the_inertia(tmp_path: Path, to: str) -> None:
    assert "1" in exported(written(tmp_path / "a", 1000.0), to)


def test_what_is_no_result_is_refused(tmp_path: Path) -> None:
    (tmp_path / "result.json").write_text("{}")
    with pytest.raises(DataError, match="not a result"):
        compared([tmp_path, tmp_path])
