"""An effort in amperes gives nothing in N m."""

import json
from pathlib import Path

import numpy as np
import pytest

from flex_ident.bags import writing
from flex_ident.commands.identify_bag import main as identify_bag
from flex_ident.effects import CATALOGUE
from flex_ident.errors import DataError
from flex_ident.notices import Code, Notice
from flex_ident.parameters import PRISMATIC_UNITS, UNITS
from flex_ident.parameters.current import is_current, unit_in_amperes
from flex_ident.recording import Recording
from flex_ident.report.export import exported


def test_every_unit_of_an_effort_becomes_one_of_a_current() -> None:
    units = [*UNITS.values(), *PRISMATIC_UNITS.values(), *(p.unit for e in CATALOGUE.values() for p in e.parameters)]
    for unit in units:
        turned = unit_in_amperes(unit)
        assert ("A" in turned) == any(own in unit for own in ("N", "kg")), unit
        assert "N" not in turned, unit
        assert "kg" not in turned, unit


def test_units_in_texts() -> None:
    assert unit_in_amperes("K is 5 N m/rad, J 2 kg m^2, MX 1 kg m.") == "K is 5 A/rad, J 2 A s^2/rad, MX 1 A s^2/m."
    assert unit_in_amperes("3 N remain; No effect; Nm; nN") == "3 A remain; No effect; Nm; nN"


def bag(path: Path) -> Path:
    t = np.arange(0.0, 12.0, 2e-3)
    phase, omega = 2 * np.pi * (0.2 * t + 0.15 * t**2), 2 * np.pi * (0.2 + 0.3 * t)
    q, v = 0.3 * np.sin(phase), 0.3 * omega * np.cos(phase)
    a = 0.3 * (2 * np.pi * 0.3 * np.cos(phase) - omega**2 * np.sin(phase))
    current = 0.1 * (2.0 * a + 3.0 * v + np.sign(v) + np.random.default_rng(0).normal(0.0, 0.3, t.size))
    names = ["a"]
    writing.write_joint_states(path, t, names, q[:, None], v[:, None], current[:, None], topic="/motor_current")
    return path


@pytest.mark.parametrize("scale", [None, "10"])
def test_amperes_are_never_printed_as_newton_metres(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], scale: str | None
) -> None:
    given = ["--motor-position", "/motor_current:a.position", "--effort", "/motor_current:a.effort", "--rigid"]
    given += [] if scale is None else ["--effort-scale", scale]
    assert identify_bag([str(bag(tmp_path / "b")), *given, "--out", str(tmp_path / "out")]) == 0
    table = capsys.readouterr().out.partition("parameter")[2].partition("modes")[0].partition("warning")[0]
    content = json.loads((tmp_path / "out" / "result.json").read_text())
    assert content["verdict"] == "trusted"
    assert ("FV/J" in content["combined"]) == (not scale)
    assert ("N m" in table) == bool(scale)
    assert ("A s/rad" in table) == (not scale)
    assert content["parameters"]["J"]["unit"] == ("kg m^2" if scale else "A s^2/rad")
    if scale is None:
        exported(tmp_path / "out", "csv")
        with pytest.raises(DataError, match="in amperes"):
            exported(tmp_path / "out", "urdf")


def test_only_a_current_by_name_is_one() -> None:
    time = np.arange(0.0, 4.0, 0.01)
    recording = Recording("a", 100.0, np.sin(time), np.cos(time))
    assert not is_current(recording.notices)
    counts = Notice(Code.EFFORT_NOT_SI, "motor_torque", {"largest": 1.0}, {"case": "counts"})
    assert not is_current((counts,))
    assert is_current((Notice(Code.EFFORT_CURRENT, "motor_torque"),))
