"""The whole chain as processes: excite, record, identify by service, parameters from YAML."""

import json
import signal
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from diagnostic_msgs.srv import SelfTest
from rig import JOINT, rig
from std_srvs.srv import Trigger

pytestmark = pytest.mark.ros
URDF = f"""<robot name="arm"><link name="base"/>
<link name="forearm"><inertial><mass value="3"/><origin xyz="-0.1667 0 -1"/></inertial></link>
<joint name="{JOINT}" type="continuous"><parent link="base"/><child link="forearm"/><axis xyz="0 1 0"/></joint>
</robot>"""
"""A body with the first moments of the simulated joint."""
TRUTH = {"Jm": 1.0, "K": 1.0e4, "JL": 1.0}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("storage", "rate_hz"),  # at 1 kHz these processes need all of a machine of two cores
    [("mcap", 500.0), *(pytest.param(s, 1000.0, marks=pytest.mark.campaign) for s in ("mcap", "sqlite3"))],
)
def test_excite_record_identify(storage: str, rate_hz: float, tmp_path: Path) -> None:
    with rig(tmp_path) as made:
        made.simulated_joint(rate_hz=rate_hz)
        made.exciter(
            auto_start=True,
            rate_hz=rate_hz,
            **{"chirp.duration_s": 10.0, "chirp.end_frequency_hz": 30.0, "recording.storage": storage},
        )
        assert made.ended("chirp_exciter", 40.0) == 0, made.output("chirp_exciter")
        assert [s for s in made.states if s != "idle"][-1] == "done"
        bag = made.bag()
        assert "0 lost" in made.output("chirp_exciter")
        (tmp_path / "robot.urdf").write_text(URDF)
        made.start("identifier", {
            "bag_directories": [str(tmp_path)], "bag": str(bag), "joint": JOINT, "urdf": "robot.urdf",
            "output_directory": str(tmp_path / "results"),
        })  # fmt: skip
        success, message = made.call("/identifier/identify", 60.0)
        assert success, message
        content = json.loads(message)
        for key, true in TRUTH.items():
            p = content["parameters"][key]
            assert abs(p["value"] - true) < 4.0 * p["std"], key
            assert abs(p["value"] / true - 1.0) < 0.05, key
        answer = made.ask(SelfTest, "/identifier/self_test", SelfTest.Request(), 60.0)
        status = {s.name: {v.key: v.value for v in s.values} for s in answer.status}
        (weight,) = (w for w in content["warnings"] if w["code"] == "urdf_gravity")
        assert abs(weight["numbers"]["share_percent"] - 100.0) < 35.0
        assert float(status["K"]["value"]) == content["parameters"]["K"]["value"]
        assert (tmp_path / "results" / f"{bag.stem}_{JOINT}" / "report.html").exists()
        client = made.node.create_client(Trigger, "/identifier/explain_gap")
        assert client.wait_for_service(5.0)
        made.spin(0.3)
        asked = client.call_async(Trigger.Request())
        made.spin(1.0)
        made.processes["identifier"].send_signal(signal.SIGINT)
        assert made.ended("identifier", 15.0) == 0, made.output("identifier")
        assert asked.result().message == "stopped: the node ends."
        assert "internal error" not in made.output("identifier")


def test_a_bag_outside_the_allowed_folders_is_refused(tmp_path: Path) -> None:
    (tmp_path / "allowed").mkdir()
    (tmp_path / "secret").mkdir()
    (tmp_path / "allowed" / "link").symlink_to(tmp_path / "secret")
    for path in (tmp_path / "secret", tmp_path / "allowed" / "link", tmp_path / "allowed" / ".." / "secret"):
        from flex_ident.errors import UsageError
        from flex_ident.nodes.allowed_paths import allowed_path

        with pytest.raises(UsageError, match="outside the folders allowed"):
            allowed_path(str(path), [str(tmp_path / "allowed")], what="bag")
    with rig(tmp_path) as made:
        made.start("identifier", {"bag_directories": [str(tmp_path / "allowed")], "bag": str(tmp_path / "secret")})
        success, message = made.call("/identifier/identify")
        assert not success
        assert "outside the folders allowed" in message
        (tmp_path / "allowed" / "bag").mkdir()
        assert made.set_parameter("identifier", "bag", "bag") == ""
        for urdf, said in ((tmp_path / "secret" / "robot.urdf", "outside the folders"), ("robot.urdf", "No such file")):
            assert made.set_parameter("identifier", "urdf", str(urdf)) == ""
            success, message = made.call("/identifier/identify")
            assert not success
            assert said in message


@pytest.mark.parametrize(
    ("node", "parameters", "text"),
    [
        ("chirp_exciter", ["-p", "joint:=''"], "joint is empty"),
        pytest.param("simulated_joint", ["-p", "K:=stiff"], "expected a number", marks=pytest.mark.campaign),
        pytest.param("identifier", ["-p", "method:=guess"], "weighted", marks=pytest.mark.campaign),
        pytest.param("simulated_joint", ["-p", "model_file:=missing.yaml"], "missing.yaml", marks=pytest.mark.campaign),
        *(
            pytest.param(
                "chirp_exciter", ["-p", "joint:=a", "-p", given], given.partition(":")[0], marks=pytest.mark.campaign
            )
            for given in ("chirp.profile:=steady", "rate_hz:=1.0")
        ),
    ],
)
def test_bad_parameters_are_one_line(node: str, parameters: list[str], text: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "flex_ident.nodes", node, "--ros-args", *parameters],
        capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 2, done.stderr
    assert text in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("node", [pytest.param("simulated_joint", marks=pytest.mark.campaign), "identifier"])
def test_the_shipped_configuration_loads(node: str, tmp_path: Path) -> None:
    config = Path(__file__).resolve().parents[2] / "config" / f"{node}.yaml"
    with rig(tmp_path) as made:
        with (tmp_path / "log").open("wb") as out:
            process = subprocess.Popen(
                [sys.executable, "-m", "flex_ident.nodes", node, "--ros-args", "--params-file", str(config)],
                stdout=out, stderr=out,
            )  # fmt: skip
        made.processes[node] = process
        assert made.node_appears(node), (tmp_path / "log").read_text()
        made.spin(0.3)
        assert process.poll() is None, (tmp_path / "log").read_text()
