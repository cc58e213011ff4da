"""export: what other tools read is what was identified, and a rejected result is not handed on."""

import json
import math
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from flex_ident.commands.flex_ident import main
from flex_ident.errors import DataError
from flex_ident.report.export import exported
from flex_ident.report.export.formats import FORMATS

FLEXIBLE = {
    "Jm": 1.2, "K": 1.0e4, "JL": 0.9, "FVm": 8.0, "FSm": 4.0, "FV": 2.0, "FS": 1.0, "MX": 0.5, "MY": 3.0, "offset": 0.7,
}  # fmt: skip
RIGID = {"J": 2.5, "FV": 3.0, "FS": 1.0, "offset": -0.2, "MX": 0.4, "MY": -0.3}


def written(path: Path, values: dict[str, float], verdict: str = "trusted", unit: str = "") -> Path:
    parameters = {
        k: {"value": v, "std": 0.01 * abs(v), "unit": unit, "identifiable": verdict != "rejected"}
        for k, v in values.items()
    }
    content = {
        "schema": "flex_ident/result/1", "joint": "el--bow", "sensors": "motor", "method": "auto", "verdict": verdict,
        "parameters": parameters, "warnings": [{"code": "model_mismatch", "message": "the model leaves 97 %."}],
    }  # fmt: skip
    path.mkdir()
    (path / "result.json").write_text(json.dumps(content))
    return path


def compiled(text: str) -> Any:
    return pytest.importorskip("mujoco").MjModel.from_xml_string(text)


def equations(model: Any, position: list[float], velocity: list[float]) -> tuple[Any, Any]:
    """Mass matrix, and forces that act on the joints with no control (bias, passive and actuator)."""
    mujoco = pytest.importorskip("mujoco")
    numpy = pytest.importorskip("numpy")
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = position, velocity
    mujoco.mj_forward(model, data)
    mass = numpy.zeros((model.nv, model.nv))
    for i, unit in enumerate(numpy.eye(model.nv)):
        column = numpy.zeros(model.nv)
        mujoco.mj_mulM(model, data, column, unit)
        mass[:, i] = column
    return mass, data.qfrc_passive + data.qfrc_actuator - data.qfrc_bias


def test_mujoco_has_the_equations_of_the_paper(tmp_path: Path) -> None:
    model = compiled(exported(written(tmp_path / "a", FLEXIBLE), "mujoco"))
    v = FLEXIBLE
    q, qm, dq, dqm = 0.3, 0.302, 0.5, 0.6
    mass, force = equations(model, [q, qm], [dq, dqm])
    assert mass[0] == pytest.approx([v["JL"], 0.0], rel=1e-6)
    assert mass[1] == pytest.approx([0.0, v["Jm"]], rel=1e-5)
    tau = v["K"] * (qm - q)
    weight = 9.81 * (v["MX"] * math.cos(q) + v["MY"] * math.sin(q))
    assert force[0] == pytest.approx(tau - weight - v["FV"] * dq, rel=1e-6)
    assert force[1] == pytest.approx(-tau - v["FVm"] * dqm - v["offset"], rel=1e-6)
    assert model.dof_frictionloss.tolist() == [v["FS"], v["FSm"]]


def test_mujoco_has_effects_of_the_spring_and_names_the_others(tmp_path: Path) -> None:
    values = {**FLEXIBLE, "backlash.gap": 8e-4, "joint_damping.damping": 5.0, "stribeck_friction.amplitude": 2.0}
    text = exported(written(tmp_path / "a", values), "mujoco")
    model = compiled(text)
    assert model.tendon_lengthspring[0].tolist() == [-4e-4, 4e-4]
    assert model.tendon_damping.ravel()[0] == pytest.approx(5.0)
    [line] = [line for line in text.splitlines() if "Left out" in line]
    assert "stribeck_friction.amplitude" in line
    assert "backlash" not in line


def test_mujoco_has_a_spring_to_ground_and_none_of_a_cable_that_pushes_away(tmp_path: Path) -> None:
    cable = {"cable_torque.stiffness": 40.0, "cable_torque.torque": -8.0}
    plain = equations(compiled(exported(written(tmp_path / "a", FLEXIBLE), "mujoco")), [0.3, 0.302], [0.0, 0.0])[1]
    text = exported(written(tmp_path / "b", {**FLEXIBLE, **cable}), "mujoco")
    _, force = equations(compiled(text), [0.3, 0.302], [0.0, 0.0])
    assert force[0] - plain[0] == pytest.approx(8.0 - 40.0 * 0.3, rel=1e-6)
    assert "Left out" not in text
    away = {**cable, "cable_torque.stiffness": -40.0}
    assert "cable_torque.stiffness" in exported(written(tmp_path / "c", {**FLEXIBLE, **away}), "mujoco")


def test_mujoco_of_a_rigid_joint(tmp_path: Path) -> None:
    model = compiled(exported(written(tmp_path / "a", RIGID), "mujoco"))
    mass, force = equations(model, [0.3], [0.5])
    assert mass[0, 0] == pytest.approx(RIGID["J"], rel=1e-6)
    weight = 9.81 * (RIGID["MX"] * math.cos(0.3) + RIGID["MY"] * math.sin(0.3))
    assert force[0] == pytest.approx(-weight - RIGID["FV"] * 0.5 - RIGID["offset"], rel=1e-6)


def test_mujoco_of_a_prismatic_joint_slides(tmp_path: Path) -> None:
    model = compiled(exported(written(tmp_path / "a", FLEXIBLE, unit="kg"), "mujoco"))
    mass, force = equations(model, [0.01, 0.01], [0.0, 0.0])
    assert mass[0, 0] == pytest.approx(FLEXIBLE["JL"], rel=1e-6)
    assert mass[1, 1] == pytest.approx(FLEXIBLE["Jm"], rel=1e-5)
    assert force == pytest.approx([0.0, -FLEXIBLE["offset"]], abs=1e-9)


def test_mujoco_without_gravity_compiles(tmp_path: Path) -> None:
    values = {k: v for k, v in FLEXIBLE.items() if k in ("Jm", "K", "JL")}
    mass, _ = equations(compiled(exported(written(tmp_path / "a", values), "mujoco")), [0.0, 0.0], [0.0, 0.0])
    assert mass[0, 0] == pytest.approx(values["JL"])


def test_urdf_of_a_rigid_joint_has_no_motor_and_no_spring(tmp_path: Path) -> None:
    text = exported(written(tmp_path / "a", RIGID), "urdf")
    assert "K =" not in text
    assert "motorInertia" not in text
    assert "J = 2.5" in text
    dynamics = ElementTree.fromstring(f"<robot>{text}</robot>").find("joint/dynamics")
    assert dynamics is not None
    assert dynamics.attrib == {"damping": "3", "friction": "1"}


def test_urdf_of_a_flexible_joint(tmp_path: Path) -> None:
    text = exported(written(tmp_path / "a", FLEXIBLE), "urdf")
    assert "K = 10000" in text
    robot = ElementTree.fromstring(f"<robot>{text}</robot>")
    assert robot.findtext("transmission/actuator/motorInertia") == "1.2"


@pytest.mark.parametrize("to", FORMATS)
def test_a_rejected_result_is_refused(tmp_path: Path, to: str, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path / "a", FLEXIBLE, verdict="rejected")
    assert main(["export", str(path), "--to", to]) == 3
    said = capsys.readouterr()
    assert said.out == ""
    assert len(said.err.strip().splitlines()) == 1
    assert "rejected: not determined: Jm, K" in said.err
    assert "97 %" in said.err


def test_an_offset_that_is_not_determined_is_not_written(tmp_path: Path) -> None:
    path = written(tmp_path / "a", FLEXIBLE)
    content = json.loads((path / "result.json").read_text())
    content["parameters"]["offset"]["identifiable"] = False
    (path / "result.json").write_text(json.dumps(content))
    assert "biasprm" not in exported(path, "mujoco")
    assert "offset" not in exported(path, "yaml")
    assert "offset,0.7,0.007,,False" in exported(path, "csv")


@pytest.mark.parametrize("to", FORMATS)
def test_the_final_model_of_an_explanation_is_exported(tmp_path: Path, to: str) -> None:
    path = written(tmp_path / "a", {**FLEXIBLE, "backlash.gap": 8e-4}, verdict="explained")
    content = json.loads((path / "result.json").read_text())
    del content["method"]
    (path / "gap.json").write_text(json.dumps({**content, "schema": "flex_ident/gap/1"}))
    (path / "result.json").unlink()
    assert exported(path, to) == exported(path / "gap.json", to)
    assert "1.2" in exported(path, to)


def test_an_explanation_without_a_base_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path / "a", FLEXIBLE, verdict="unexplained")
    content = json.loads((path / "result.json").read_text())
    content["warnings"] = [{"code": "base_not_determined", "message": "nothing is named."}]
    (path / "gap.json").write_text(json.dumps({**content, "schema": "flex_ident/gap/1"}))
    with pytest.raises(DataError, match="rejected: nothing is named"):
        exported(path / "gap.json", "csv")


def test_a_refusal_does_not_advise_to_explain(tmp_path: Path) -> None:
    path = written(tmp_path / "a", FLEXIBLE, verdict="rejected")
    content = json.loads((path / "result.json").read_text())
    said = "the model leaves 97 % of the torque unexplained: run explain_gap to see what is missing."
    content["warnings"] = [{"code": "model_mismatch", "message": said, "numbers": {"left_percent": 97.0}}]
    (path / "result.json").write_text(json.dumps(content))
    with pytest.raises(DataError, match=r"97 % of the torque unexplained\. Nothing"):
        exported(path, "csv")
