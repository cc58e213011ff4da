"""Every file of config/ for a robot is accepted by the exciter and by the identifier, in a namespace or not."""

from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
import rclpy

from flex_ident.configuration.files import parameters_in
from flex_ident.errors import FlexIdentError
from flex_ident.nodes.exciter_settings import declare_all, experiment
from flex_ident.nodes.identifier import Identifier

pytestmark = pytest.mark.ros
CONFIG = Path(__file__).resolve().parents[2] / "config"
NODES = ("chirp_exciter", "identifier", "simulated_joint")
"""Files for one node each."""
KINDS = {
    path.stem: str(parameters_in(path, ("identifier",))["effort_kind"])
    for path in sorted(CONFIG.glob("*.yaml"))
    if path.stem not in NODES
}


@pytest.mark.parametrize("robot", [*KINDS, "chirp_exciter"])
def test_the_exciter_accepts_the_file(robot: str, monkeypatch: pytest.MonkeyPatch) -> None:
    arguments = ["--ros-args", "--params-file", str(CONFIG / f"{robot}.yaml"), "-r", "__ns:=/lbr"]
    monkeypatch.setattr("sys.argv", ["chirp_exciter", *arguments])
    context = rclpy.Context()
    rclpy.init(args=arguments, context=context)
    try:
        node = rclpy.create_node("chirp_exciter", context=context)
        declare_all(node)
        assert experiment(node).values["joint"] == parameters_in(CONFIG / f"{robot}.yaml", ())["joint"]
        node.destroy_node()
    finally:
        rclpy.shutdown(context=context)


@pytest.mark.parametrize("robot", [*KINDS, "identifier"])
def test_the_identifier_accepts_the_file(robot: str, monkeypatch: pytest.MonkeyPatch) -> None:
    arguments = ["--ros-args", "--params-file", str(CONFIG / f"{robot}.yaml")]
    monkeypatch.setattr("sys.argv", ["identifier", *arguments])
    rclpy.init(args=arguments)
    try:
        if KINDS.get(robot) == "unsigned":
            with pytest.raises(FlexIdentError, match="does not tell inertia from friction"):
                Identifier()
            return
        node = Identifier()
        assert node.get_parameter("effort_kind").value == KINDS.get(robot, "auto")
        node.destroy_node()
    finally:
        rclpy.shutdown()
