"""compare and export, on results written by hand."""

import json
import os
from pathlib import Path

import pytest

from flex_ident.errors import DataError
from flex_ident.report.comparison import compared
from flex_ident.report.export import exported
from flex_ident.report.export.formats import FORMATS
from flex_ident.report.folder import stored_content

TEMPLATE = (
    '{"schema": "flex_ident/result/1", "joint": "elbow", "sensors": "motor", "method": "auto", "verdict": "trusted", '
    '"parameters": {"Jm": {"value": 1.0, "std": 0.1, "unit": "kg m^2", "identifiable": true}}}'
)


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


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("[" * 100_000, "is not JSON"), ('{"a": 1' + "0" * 5000 + "}", "digits"), ("\0", "is not JSON"),
        ("\ud800", "is not UTF-8"), ("{", "is not JSON"), ("[]", "is not a result"), ('"x"', "is not a result"),
        (TEMPLATE.replace("elbow", "el\\u001b[2Jbow\\n").replace('"unit"', '"u\\n"'), "'unit' is missing"),
        (TEMPLATE.replace('"value": 1.0', '"value": "\\u001b[2J"'), "expected a number"),
        (TEMPLATE.replace('"value": 1.0', '"value": true'), "expected a number"),
        (TEMPLATE.replace('"elbow"', '{"a": [1]}'), "expected a text"),
        (TEMPLATE.replace('"kg m^2"', "[]"), "expected a text"),
        (TEMPLATE.replace('"elbow"', '"' + "x" * 100_000 + '"'), "expected a text"),
        (TEMPLATE.replace('{"Jm"', '[{"Jm"').replace("}}}", "}}]}"), "is damaged"),
    ],
)  # fmt: skip
def test_hostile_results_are_refused_in_one_line(tmp_path: Path, content: str, said: str) -> None:
    (tmp_path / "result.json").write_text(content, errors="surrogatepass")
    with pytest.raises(DataError, match=said) as caught:
        compared([tmp_path, tmp_path])
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 400
    stored_content(tmp_path, "result.json")


def test_names_in_a_result_are_harmless(tmp_path: Path) -> None:
    (tmp_path / "result.json").write_text(TEMPLATE.replace("elbow", "el\\u001b[2Jbow\\n"))
    assert compared([tmp_path, tmp_path]).replace("\n", "").isprintable()


def test_a_pipe_is_no_result(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "result.json")
    with pytest.raises(DataError, match="a pipe or a device"):
        compared([tmp_path, tmp_path])
    assert stored_content(tmp_path, "result.json") is None
