"""The public Python API: its names, their docstrings, what an import costs, and the page whose blocks are run."""

import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import flex_ident
from flex_ident.bags.virtual import write_virtual_bag
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain

PAGE = (Path(__file__).resolve().parents[1] / "docs" / "api.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, re.S)


@pytest.mark.parametrize("name", flex_ident.__all__)
def test_every_name_is_there_documented_and_on_the_page(name: str) -> None:
    assert getattr(flex_ident, name).__doc__
    assert f"`{name}`" in PAGE or f"`{name}(" in PAGE
    assert name in dir(flex_ident)


def test_a_name_that_is_none_is_said_to_be_none() -> None:
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        flex_ident.nonsense  # noqa: B018


def test_the_import_is_cheap() -> None:
    code = "import sys, flex_ident; print([m for m in ('numpy', 'scipy', 'yaml', 'rosbags') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == "[]"


def test_a_path_may_be_a_text(tmp_path: Path) -> None:
    with pytest.raises(flex_ident.FlexIdentError, match="no such file"):
        flex_ident.read_recording(str(tmp_path / "none"))


@pytest.mark.slow
def test_the_pages_blocks_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    experiment = Experiment(duration_s=20.0, sample_rate_hz=500.0)
    model = replace(COBOT_JOINT, joint="joint_2")
    write_virtual_bag(tmp_path / "my_bag", model, experiment, MeasurementChain(torque_noise=0.01, jitter=0.02))
    monkeypatch.chdir(tmp_path)
    scope: dict[str, object] = {}
    assert len(BLOCKS) > 5
    for block in BLOCKS:
        exec(compile(block, "docs/api.md", "exec"), scope)
    assert (tmp_path / "model.yaml").exists()
