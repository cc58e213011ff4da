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


def with_covariance(path: Path, values: dict[str, float], together: float, sha256: str = "") -> Path:
    """A result whose K and JL are known to 1 %, and their errors go together."""
    stds = {key: 0.01 * value for key, value in {"Jm": 1.0, "K": 1000.0, "JL": 2.0}.items()}
    matrix = [[stds[a] * stds[b] * (1.0 if a == b else together) for b in stds] for a in stds]
    parameters = {
        key: {"value": values[key], "std": std, "unit": "kg m^2", "identifiable": True} for key, std in stds.items()
    }
    content = {
        "schema": "flex_ident/result/1", "joint": "elbow", "sensors": "motor", "method": "auto", "verdict": "trusted",
        "bag": {"path": "bag", "sha256": sha256 or path.name}, "parameters": parameters,
        "covariance": {"keys": list(stds), "matrix": matrix},
    }  # fmt: skip
    path.mkdir()
    (path / "result.json").write_text(json.dumps(content))
    return path


def joint_line(one: Path, other: Path) -> str:
    [line] = [line for line in compared([one, other]).splitlines() if line.startswith("A and B: ")]
    return line


def test_all_parameters_are_judged_together(tmp_path: Path) -> None:
    base = {"Jm": 1.0, "K": 1000.0, "JL": 2.0}
    a = with_covariance(tmp_path / "a", base, 0.95)
    same = with_covariance(tmp_path / "same", {**base, "K": 1010.0, "JL": 2.02, "Jm": 1.01}, 0.95)
    assert "agree over 3 shared parameters together" in joint_line(a, same)
    assert "NOT" not in joint_line(a, same)
    # one by one each lies 1.1 standard deviations off; against each other they lie 7
    apart = with_covariance(tmp_path / "apart", {**base, "K": 1015.0, "JL": 1.97}, 0.95)
    rows = [line for line in compared([a, apart]).splitlines() if line.startswith(("Jm ", "K ", "JL "))]
    assert len(rows) == 3
    assert not any(row.endswith("*") for row in rows)
    assert "do NOT agree" in joint_line(a, apart)
    assert "over 3 (" in joint_line(a, apart)
    again = with_covariance(tmp_path / "again", base, 0.95, sha256="a")
    assert "of the same recording" in joint_line(a, again)


def test_without_a_covariance_errors_count_as_independent_and_that_is_said(tmp_path: Path) -> None:
    text = joint_line(written(tmp_path / "a", 1000.0), written(tmp_path / "b", 1100.0))
    assert "do NOT agree over 3 shared parameters" in text
    assert "most by K (errors taken as independent" in text


@pytest.mark.parametrize(
    "covariance",
    ["[]", '{"keys": ["Jm"], "matrix": [[-1.0]]}', '{"keys": ["Jm"], "matrix": [[1.0, 2.0]]}', '{"keys": "Jm"}',
     '{"keys": ["Jm"], "matrix": [["x"]]}', '{"keys": ["Jm", "K"], "matrix": [[1, 2], [2, 1]]}'],
)  # fmt: skip
def test_a_covariance_that_is_none_is_refused(tmp_path: Path, covariance: str) -> None:
    content = TEMPLATE.replace('"parameters":', f'"covariance": {covariance}, "parameters":')
    (tmp_path / "result.json").write_text(content)
    with pytest.raises(DataError, match="damaged") as caught:
        compared([tmp_path, tmp_path])
    assert str(caught.value).isprintable()
