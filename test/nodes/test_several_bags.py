"""The identifier takes several recordings of one joint by its parameter `bag`."""

import json
from pathlib import Path

import numpy as np
import pytest

rclpy = pytest.importorskip("rclpy", reason="needs rclpy")

from rclpy.parameter import Parameter  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from flex_ident.bags import writing  # noqa: E402
from flex_ident.nodes.identifier import Identifier  # noqa: E402

pytestmark = pytest.mark.ros


def test_bags_of_one_joint_are_put_together(tmp_path: Path) -> None:
    t = np.arange(0.0, 14.0, 4e-3)
    phase, omega = 2 * np.pi * (0.2 * t + 0.12 * t**2), 2 * np.pi * (0.2 + 0.24 * t)
    q, v = 0.3 * np.sin(phase), 0.3 * omega * np.cos(phase)
    a = 0.3 * (2 * np.pi * 0.24 * np.cos(phase) - omega**2 * np.sin(phase))
    for i, name in enumerate("ab"):
        torque = 2.0 * a + 3.0 * v + np.sign(v) + np.random.default_rng(i).normal(0.0, 0.3, t.size)
        writing.write_joint_states(tmp_path / name, t, ["elbow"], q[:, None], v[:, None], torque[:, None])
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
