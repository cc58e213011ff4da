"""Signals from CSV files: guessed or mapped columns, any separator, and one line for everything else."""

from pathlib import Path

import numpy as np
import pytest

from flex_ident.bags.tables import guessed_columns, read_csv, table_signals
from flex_ident.errors import SignalError

TIME = np.arange(500) / 250.0
Q, TAU = 0.3 * np.sin(8.0 * TIME), 5.0 * np.cos(8.0 * TIME)


def written(path: Path, head: str, *, separator: str = ",", decimal: str = ".") -> Path:
    rows = [separator.join(f"{x:.9f}".replace(".", decimal) for x in row) for row in zip(TIME, Q, TAU, strict=True)]
    path.write_text("\n".join([head.replace(",", separator), *rows]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize(
    "head", ["time,position,effort", "t,q,tau", "Time [s],Motor Position [rad],Motor-Torque (Nm)", "stamp,q_1,tau_1",
             "# time,q1,tau1", "\ufefftimestamp,pos,torque"],
)  # fmt: skip
def test_columns_are_guessed_and_said(tmp_path: Path, head: str, separator: str) -> None:
    if separator == " " and ("[" in head or "#" in head):
        pytest.skip("names with blanks cannot be told apart")
    signals, notices = table_signals(read_csv(written(tmp_path / "a.csv", head, separator=separator)))
    assert [s.role for s in signals] == ["motor_position", "motor_torque"]
    np.testing.assert_allclose(signals[0].time, TIME, atol=1e-9)
    np.testing.assert_allclose(signals[0].values, Q, atol=1e-9)
    np.testing.assert_allclose(signals[1].values, TAU, atol=1e-9)
    assert [n.code for n in notices] == ["columns_guessed"]


def test_a_comma_may_be_the_decimal_point(tmp_path: Path) -> None:
    signals, _ = table_signals(read_csv(written(tmp_path / "a.csv", "t,q,tau", separator=";", decimal=",")))
    np.testing.assert_allclose(signals[1].values, TAU, atol=1e-9)


def test_a_mapping_wins_and_units_are_converted(tmp_path: Path) -> None:
    table = read_csv(written(tmp_path / "a.csv", "millis,angle_deg,current"))
    columns = {"time": "millis", "motor_position": "angle_deg", "motor_torque": "current"}
    signals, notices = table_signals(table, columns, time_scale=1e-3, factors={"motor_torque": 2.0})
    np.testing.assert_allclose(signals[0].time, 1e-3 * TIME, atol=1e-9)
    np.testing.assert_allclose(signals[1].values, 2.0 * TAU, atol=1e-8)
    assert notices == []


def test_a_joint_is_chosen_by_its_number(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,q1,q2,tau1,tau2\n0,1,2,3,4\n1,5,6,7,8\n")
    assert guessed_columns(read_csv(tmp_path / "a.csv"), "2") == {
        "time": "t", "motor_position": "q2", "motor_torque": "tau2",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("", "names no columns"), ("1,2,3\n4,5,6\n", "names no columns"), ("a,b,c\n1,2,3\n", "no column for time"),
        ("t,q,tau\n", "no messages"), ("t,q,tau\nx,y,z\n", "finite number"), ("x" * (2 << 20), "no table"),
        ("t,q,tau\n" + "0,1,2\n", "one message"), ("t,q,tau\n" + "1,1,2\n" * 9, "does not advance"),
    ],
)  # fmt: skip
def test_what_is_no_table_is_refused(tmp_path: Path, content: str, said: str) -> None:
    (tmp_path / "a.csv").write_text(content)
    with pytest.raises(SignalError, match=said) as caught:
        table_signals(read_csv(tmp_path / "a.csv"))
    assert str(caught.value).isprintable()


def test_damaged_cells_are_dropped_and_counted(tmp_path: Path) -> None:
    file = written(tmp_path / "a.csv", "t,q,tau")
    lines = file.read_text().split("\n")
    lines[100], lines[200], lines[300] = "0.396,nonsense,1", "0.796", '0.4,"1\x1b[2J,2'
    file.write_text("\n".join(lines))
    signals, notices = table_signals(read_csv(file))
    assert signals[0].values.size < 500
    assert "nonfinite_values" in {n.code for n in notices}
