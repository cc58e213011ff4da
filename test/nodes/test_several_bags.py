"""The identifier takes several recordings of one joint by its parameter `bag`, and tells the health of its result."""

import json
import signal
from pathlib import Path

import numpy as np
import pytest

rclpy = pytest.importorskip("rclpy", reason="needs rclpy")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from rig import LATCHED, rig  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from flex_ident.bags import writing  # noqa: E402
from flex_ident.commands.identify_bag import main as identify_bag  # noqa: E402
from flex_ident.nodes.identifier import Identifier  # noqa: E402

pytestmark = pytest.mark.ros


def bag(path: Path, *, seed: int, inertia: float = 2.0, quadratic: float = 0.0) -> None:
    """A rigid joint moved by a chirp."""
    t = np.arange(0.0, 14.0, 4e-3)
    phase, omega = 2 * np.pi * (0.2 * t + 0.12 * t**2), 2 * np.pi * (0.2 + 0.24 * t)
    q, v = 0.3 * np.sin(phase), 0.3 * omega * np.cos(phase)
    a = 0.3 * (2 * np.pi * 0.24 * np.cos(phase) - omega**2 * np.sin(phase))
    torque = inertia * a + 3.0 * v + np.sign(v) + quadratic * v * np.abs(v)
    torque += np.random.default_rng(seed).normal(0.0, 0.3, t.size)
    writing.write_joint_states(path, t, ["elbow"], q[:, None], v[:, None], torque[:, None])


@pytest.mark.slow
def test_a_set_and_its_health_over_dds(tmp_path: Path) -> None:
    for i, name in enumerate("abc"):
        bag(tmp_path / name, seed=i, quadratic=2.0 if name == "c" else 0.0)
    bag(tmp_path / "lighter", seed=7, inertia=1.7)
    before = tmp_path / "before"
    assert identify_bag([str(tmp_path / "lighter"), "--rigid", "--quiet", "--no-plots", "--out", str(before)]) == 0
    told: list[DiagnosticArray] = []
    with rig(tmp_path) as made:
        made.node.create_subscription(DiagnosticArray, "/identifier/health", told.append, LATCHED)
        made.start("identifier", {
            "bag_directories": [str(tmp_path)], "bag": ["a", "b"], "rigid": True, "health": True,
            "effects": "viscous_nonlinearity", "output_directory": str(tmp_path / "out"),
        })  # fmt: skip

        def status_after(service: str) -> tuple[dict[str, object], DiagnosticStatus]:
            count = len(told)
            success, message = made.call(f"/identifier/{service}", 120.0)
            assert success, message
            for _ in range(40):
                if len(told) > count:
                    break
                made.spin(0.1)
            [status] = told[-1].status
            return json.loads(message), status

        content, status = status_after("identify")
        assert [own["name"] for own in content["recordings"]] == ["a", "b"]  # type: ignore[attr-defined]
        assert (status.level, status.hardware_id, status.message) == (DiagnosticStatus.OK, "elbow", "trusted")
        values = {own.key: own.value for own in status.values}
        assert float(values["J"]) == pytest.approx(2.0, rel=0.01)
        assert values["J.unit"] == "kg m^2"
        assert "agrees" not in values
        made.set_parameter("identifier", "baseline", "before")
        _, status = status_after("identify")
        values = {own.key: own.value for own in status.values}
        assert status.level == DiagnosticStatus.WARN
        assert "changed: do NOT agree" in status.message
        assert (values["agrees"], values["differs_most"]) == ("no", "J")
        assert float(values["J.change_percent"]) == pytest.approx(100.0 * (2.0 / 1.7 - 1.0), abs=1.0)
        made.set_parameter("identifier", "baseline", "../elsewhere")
        _, status = status_after("identify")
        assert status.level == DiagnosticStatus.WARN
        assert "outside the folders allowed" in status.message
        content, status = status_after("explain_gap")
        assert content["schema"] == "flex_ident/gap/1"
        assert len(content["recordings"]) == 2  # type: ignore[arg-type]
        assert (tmp_path / "out" / "a+b_elbow" / "gap.json").exists()
        made.set_parameter("identifier", "bag", ["a", "gone"])
        success, message = made.call("/identifier/identify", 60.0)
        made.spin(0.5)
        assert not success
        assert told[-1].status[0].level == DiagnosticStatus.ERROR
        assert told[-1].status[0].message == f"identify: {message}"
        made.processes["identifier"].send_signal(signal.SIGINT)
        assert made.ended("identifier", 15.0) == 0, made.output("identifier")


def test_bags_of_one_joint_are_put_together(tmp_path: Path) -> None:
    for i, name in enumerate("ab"):
        bag(tmp_path / name, seed=i)
    given = ["bag:='a;b'", "rigid:=true", f"bag_directories:=['{tmp_path}']", f"output_directory:={tmp_path / 'out'}"]
    rclpy.init(args=["--ros-args", *(word for text in given for word in ("-p", text))])
    node = Identifier()
    try:
        answer = node._identify(Trigger.Request(), Trigger.Response())
        assert answer.success, answer.message
        content = json.loads(answer.message)
        assert [own["name"] for own in content["recordings"]] == ["a", "b"]
        assert content["parameters"]["J"]["value"] == pytest.approx(2.0, rel=0.01)
        assert list((tmp_path / "out").glob("a+b_elbow/result.json"))
        node.set_parameters([Parameter("bag", value="a;../b")])
        refused = node._identify(Trigger.Request(), Trigger.Response())
        assert not refused.success
        assert "outside the folders allowed" in refused.message
        node.set_parameters([Parameter("bag", value="a"), Parameter("payload", value="a=5@0.4")])
        refused = node._identify(Trigger.Request(), Trigger.Response())
        assert not refused.success
        assert "needs several recordings" in refused.message
    finally:
        node.destroy_node()
        rclpy.shutdown()
