"""CSV files: any separator, and one line for everything else."""

from pathlib import Path

import numpy as np
import pytest

from flex_ident.errors import SignalError
from flex_ident.formats.csv_files import CsvFile
from flex_ident.formats.tables import MOST_COLUMNS

TIME = np.arange(500) / 250.0
Q, TAU = 0.3 * np.sin(8.0 * TIME), 5.0 * np.cos(8.0 * TIME)


def written(path: Path, head: str, *, separator: str = ",", decimal: str = ".") -> Path:
    rows = [separator.join(f"{x:.9f}".replace(".", decimal) for x in row) for row in zip(TIME, Q, TAU, strict=True)]
    path.write_text("\n".join([head.replace(",", separator), *rows]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize("head", ["t,q,tau", "# t,q,tau", "\ufefft,q,tau"])
def test_separators(tmp_path: Path, head: str, separator: str) -> None:
    table = CsvFile(written(tmp_path / "a.csv", head, separator=separator))
    assert list(table.columns) == ["t", "q", "tau"]
    columns = table.read(["tau", "t"])
    assert list(columns) == ["tau", "t"]
    np.testing.assert_allclose(columns["tau"], TAU, atol=1e-9)
    np.testing.assert_allclose(columns["t"], TIME, atol=1e-9)


def test_a_comma_may_be_the_decimal_point(tmp_path: Path) -> None:
    table = CsvFile(written(tmp_path / "a.csv", "t,q,tau", separator=";", decimal=","))
    np.testing.assert_allclose(table.read(["tau"])["tau"], TAU, atol=1e-9)


def test_damaged_cells_are_no_numbers(tmp_path: Path) -> None:
    file = written(tmp_path / "a.csv", "t,q,tau")
    lines = file.read_text().split("\n")
    lines[100], lines[200], lines[300] = "0.396,nonsense,1", "0.796", '0.4,"1\x1b[2J,2'
    file.write_text("\n".join(lines))
    q = CsvFile(file).read(["q"])["q"]
    assert np.isnan(q[[99, 199]]).all()
    assert np.isfinite(q[:99]).all()


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "neither names of columns"), ("nonsense\n1\n", "neither names of columns"), ("x" * (2 << 20), "no table"),
        (",".join(f"q{i}" for i in range(MOST_COLUMNS + 1)) + "\n1\n", "are read at most"),
    ],
)  # fmt: skip
def test_what_is_no_table_is_refused(tmp_path: Path, content: str, said: str) -> None:
    (tmp_path / "a.csv").write_text(content)
    with pytest.raises(SignalError, match=said) as caught:
        CsvFile(tmp_path / "a.csv")
    assert str(caught.value).isprintable()


@pytest.mark.parametrize("separator", [",", ";", "\t", " ", "   "])
@pytest.mark.parametrize("comments", ["", "# a log of 2020\n% q in rad, torque in newton metres\n"])
def test_columns_without_names_are_numbered(tmp_path: Path, separator: str, comments: str) -> None:
    file = written(tmp_path / "a.txt", "t,q,tau", separator=separator)
    file.write_text(comments + file.read_text().partition("\n")[2])
    table = CsvFile(file)
    assert list(table.columns) == ["column_1", "column_2", "column_3"]
    columns = table.read(["column_1", "column_3"])
    np.testing.assert_allclose(columns["column_1"], TIME, atol=1e-9)
    np.testing.assert_allclose(columns["column_3"], TAU, atol=1e-9)


@pytest.mark.parametrize("names", ["t,q,tau", "# t,q,tau"])
def test_comments_before_the_names(tmp_path: Path, names: str) -> None:
    file = written(tmp_path / "a.csv", names)
    file.write_text("# Test started at noon, by hand\n#\n# gear: 6.0; sensor: none\n" + file.read_text())
    table = CsvFile(file)
    assert list(table.columns) == ["t", "q", "tau"]
    np.testing.assert_allclose(table.read(["q"])["q"], Q, atol=1e-9)


def test_one_column_without_a_name(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "a.txt", TIME)
    np.testing.assert_allclose(CsvFile(tmp_path / "a.txt").read(["column_1"])["column_1"], TIME)


def test_two_columns_of_one_name_are_refused_where_they_are_needed(tmp_path: Path) -> None:
    file = written(tmp_path / "a.csv", "t,q,q")
    table = CsvFile(file)
    np.testing.assert_allclose(table.read(["t"])["t"], TIME, atol=1e-9)
    with pytest.raises(SignalError, match="two columns are called 'q'"):
        table.read(["t", "q"])


@pytest.mark.parametrize("head", ["stamp,q\n", ""])
@pytest.mark.parametrize(
    ("first", "zone", "seconds"),
    [
        ("2026-11-28T23:59:59.", "Z", 1795910399.0), ("2026-11-28 23:59:59.", "", 1795910399.0),
        ("2026-11-28T23:59:59.", "+02:00", 1795903199.0), ("10:00:00.", "", 36000.0),
    ],
)  # fmt: skip
def test_dates_and_times_of_day_are_seconds(tmp_path: Path, head: str, first: str, zone: str, seconds: float) -> None:
    rows = "".join(f"{first}{i:06d}{zone},{0.1 * i}\n" for i in range(0, 50000, 4000))
    (tmp_path / "a.csv").write_text(head + rows)
    table = CsvFile(tmp_path / "a.csv")
    time = next(iter(table.columns))
    np.testing.assert_allclose(table.read([time])[time] - seconds, np.arange(0, 0.05, 0.004), atol=1e-6)
