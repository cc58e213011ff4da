"""Every command of the README is run.

`ros2 run flex_ident NAME` is run as NAME (the ros2 command is not on PyPI); `make demo` and `make test` are what CI
runs, here make is asked what it would do.
"""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from flex_ident.bags.virtual import write_virtual_bag
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
COMMANDS = [line for block in re.findall(r"```bash\n(.*?)```", README, re.S) for line in block.strip().splitlines()]


@pytest.fixture(scope="module")
def workspace(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with `my_bag` and `config`, in which the commands are run in the README's order."""
    folder = tmp_path_factory.mktemp("readme")
    experiment = Experiment(duration_s=12.0, sample_rate_hz=250.0)
    write_virtual_bag(folder / "my_bag", COBOT_JOINT, experiment, MeasurementChain(jitter=0.02))
    shutil.copytree(ROOT / "config", folder / "config")
    return folder


def test_there_are_commands() -> None:
    assert "make demo" in COMMANDS
    assert len(COMMANDS) > 10


def test_result_comes_first() -> None:
    picture, command, output = README.index("!["), README.index("make demo"), README.index("parameter  truth")
    assert picture < command < output < README.index("## ")


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_command(command: str, workspace: Path) -> None:
    words = command.split()
    if words[:3] == ["ros2", "run", "flex_ident"]:
        words = words[3:]
    if words[0] == "make":
        done = subprocess.run(["make", "-n", *words[1:]], cwd=ROOT, capture_output=True, text=True, timeout=60)
        assert done.returncode == 0, done.stderr
        return
    executable = Path(sysconfig.get_path("scripts")) / words[0]
    environment = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    if words[0] == "chirp_exciter":
        pytest.importorskip("rclpy", reason="needs rclpy")
        process = subprocess.Popen([sys.executable, executable, *words[1:]], cwd=workspace, env=environment)
        with pytest.raises(subprocess.TimeoutExpired):  # it waits for ~/start
            process.wait(5.0)
        process.terminate()
        assert process.wait(10.0) == 0
        return
    done = subprocess.run(
        [sys.executable, executable, *words[1:]], cwd=workspace, env=environment, capture_output=True, text=True,
        timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()
    assert not done.stderr.strip()
