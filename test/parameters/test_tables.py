"""A table in model.yaml: two lists that people read, numbered parameters in the program."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from flex_ident.effects import check_effect_parameters
from flex_ident.errors import ConfigurationError
from flex_ident.parameters import JointModel, read_joint_model
from flex_ident.parameters.tables import as_lists

TABLE = {"torque_1": 1.0, "torque_2": -2.5, "speed_1": -0.5, "speed_2": 0.5}


def test_a_table_is_written_as_lists_and_read_back(tmp_path: Path) -> None:
    model = JointModel({"J": 1.0}, {"motor_friction_curve": TABLE, "torque_offset": {"offset": 1.0}}, "elbow")
    model.write(tmp_path / "model.yaml")
    text = (tmp_path / "model.yaml").read_text()
    assert "    speed: [-0.5, 0.5]\n    torque: [1.0, -2.5]\n" in text
    assert yaml.safe_load(text)["effects"]["torque_offset"] == {"offset": 1.0}
    assert read_joint_model(tmp_path / "model.yaml").effects == model.effects


def test_harmonics_are_no_table() -> None:
    ripple = {"amplitude": 1.0, "amplitude_2": 2.0, "phase_2": 0.0}
    assert as_lists(ripple) == ripple


@pytest.mark.parametrize("item", ["nan", "text", "[1.0]", ".inf"])
def test_what_is_no_number_in_a_list_is_named(tmp_path: Path, item: str) -> None:
    file = tmp_path / "model.yaml"
    file.write_text(
        f"schema: flex_ident/model/1\nparameters: {{J: 1.0}}\neffects: {{spring_curve: {{torque: [1.0, {item}]}}}}\n"
    )
    with pytest.raises(ConfigurationError, match=r"effects\.spring_curve\.torque_2 is"):
        read_joint_model(file)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"torque_1": 1.0, "torque_2": 2.0, "speed_1": 1.0}, "as many values of speed as of torque"),
        ({"torque_1": 1.0, "speed_1": 1.0}, "as many values"),
        ({**TABLE, "speed_2": -0.7}, "values of speed that increase"),
        ({**TABLE, "speed_2": 0.0}, "a point at no speed"),
        ({**TABLE, "speed_40": 0.0}, "has no parameter 'speed_40'"),
    ],
)
def test_what_is_no_table_is_refused_in_words(table: dict[str, float], said: str) -> None:
    check_effect_parameters("motor_friction_curve", TABLE)
    with pytest.raises(ConfigurationError, match=said):
        check_effect_parameters("motor_friction_curve", table)
