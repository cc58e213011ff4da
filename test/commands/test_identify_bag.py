"""`identify_bag` as a user runs it: files, exit statuses, one line for each error."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from flex_ident.bags import writing as rosbags_writing
from flex_ident.parameters import read_joint_model

REAL = Path(__file__).resolve().parents[3] / "shared" / "real"
RATE_HZ = 500.0


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "flex_ident.commands.identify_bag", *map(str, arguments)],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip


@pytest.fixture(scope="module")
def rigid_bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A rigid joint of J 2, FV 3, FS 1, moved by a chirp; the others stand still."""
    t = np.arange(0.0, 20.0, 1.0 / RATE_HZ)
    omega = 2 * np.pi * (0.2 + 0.2 * t)
    phase = 2 * np.pi * (0.2 * t + 0.1 * t**2)
    q, v = 0.3 * np.sin(phase), 0.3 * omega * np.cos(phase)
    a = 0.3 * 2 * np.pi * 0.2 * np.cos(phase) - 0.3 * omega**2 * np.sin(phase)
    noise = np.random.default_rng(0).normal(0.0, 0.3, t.size)
    torque = 2.0 * a + 3.0 * v + np.sign(v) + noise
    still = np.zeros_like(t)
    path = tmp_path_factory.mktemp("bags") / "rigid"
    rosbags_writing.write_joint_states(
        path, t, ["elbow", "shoulder"], np.stack((still, q), axis=1), np.stack((still, v), axis=1),
        np.stack((still, torque), axis=1),
    )  # fmt: skip
    return path


@pytest.mark.slow
def test_files_and_numbers(rigid_bag: Path, tmp_path: Path) -> None:
    done = run(rigid_bag, "--rigid", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert "motor position: /joint_states:shoulder.position" in done.stdout
    content = json.loads((tmp_path / "result.json").read_text())
    assert content["schema"] == "flex_ident/result/1"
    assert content["joint"] == "shoulder"
    for key, truth in (("J", 2.0), ("FV", 3.0), ("FS", 1.0)):
        p = content["parameters"][key]
        assert p["ci95"][0] - p["std"] <= truth <= p["ci95"][1] + p["std"], key
    assert {p.name for p in tmp_path.iterdir()} >= {
        "result.json", "parameters.yaml", "model.yaml", "report.html", "signals.png", "torque.png",
    }  # fmt: skip
    assert read_joint_model(tmp_path / "model.yaml").value("J") == content["parameters"]["J"]["value"]
    page = (tmp_path / "report.html").read_text()
    assert "http://" not in page
    assert "https://" not in page


@pytest.mark.slow
def test_json_is_all_there_is_on_standard_output(rigid_bag: Path, tmp_path: Path) -> None:
    done = run(rigid_bag, "--rigid", "--json", "--no-plots", "--out", tmp_path)
    assert json.loads(done.stdout)["verdict"] == "trusted"
    assert not (tmp_path / "report.html").exists()


@pytest.mark.slow
def test_options_win_over_the_file(rigid_bag: Path, tmp_path: Path) -> None:
    config = tmp_path / "c.yaml"
    config.write_text("/**:\n  ros__parameters:\n    rigid: true\n    effort_scale: 2.0\n")
    done = run(rigid_bag, "--config", config, "--effort-scale", 1.0, "--json", "--no-plots", "--out", tmp_path)
    assert json.loads(done.stdout)["parameters"]["J"]["value"] == pytest.approx(2.0, rel=0.02)


@pytest.mark.parametrize(
    ("arguments", "status", "text"),
    [
        (("--bogus",), 2, "--bogus"),
        (("--gear-ratio", "many"), 2, "--gear-ratio"),
        (("--gear-ratio", "0"), 2, "gear_ratio"),
        (("--sensors", "camera"), 2, "motor+link"),
        (("--joint", "wrist"), 3, "shoulder"),
        (("--joint", "elbow"), 3, "does not move"),
        (("--effort", "/wrench"), 3, "/joint_states"),
        (("--sensors", "motor+link"), 3, "--link-position"),
        (("--model", "missing.yaml"), 2, "missing.yaml"),
        (("--rigid", "--out", "/proc/nothing"), 2, "--out"),
    ],
)
def test_bad_arguments_are_one_line(
    rigid_bag: Path, arguments: tuple[str, ...], status: int, text: str, tmp_path: Path
) -> None:
    out = () if "--out" in arguments else ("--out", tmp_path)
    done = run(rigid_bag, *arguments, *out)
    assert done.returncode == status, done.stderr
    assert text in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("/**:\n  ros__parameters:\n    jont: a\n", "did you mean joint?"),
        ("/**:\n  ros__parameters:\n    gear_ratio: fast\n", "gear_ratio"),
        ("/**:\n  ros__parameters:\n    method: guess\n", "weighted"),
        ("joint: a\n", "ros__parameters"),
        (":\n  - [", "not YAML"),
    ],
)
def test_bad_configuration_names_file_and_key(rigid_bag: Path, tmp_path: Path, content: str, text: str) -> None:
    config = tmp_path / "c.yaml"
    config.write_text(content)
    done = run(rigid_bag, "--config", config)
    assert done.returncode == 2
    assert str(config) in done.stderr
    assert text in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


@pytest.mark.skipif(not REAL.exists(), reason="needs ../shared/real")
@pytest.mark.slow
@pytest.mark.parametrize("axis", ["a2", pytest.param("a3", marks=pytest.mark.campaign)])
def test_kuka_says_why_and_gives_a_k_of_the_right_order(axis: str, tmp_path: Path) -> None:
    done = run(REAL / "kuka_kr300_a", "--joint", axis, "--no-plots", "--json", "--out", tmp_path)
    assert done.returncode == 4
    content = json.loads(done.stdout)
    assert content["verdict"] == "rejected"
    [said] = [w["message"] for w in content["warnings"] if w["code"] == "motor_equation"]
    k = float(said.split("K = ")[1].split(" ")[0])
    assert 2e6 < k < 1e7
    assert "ms after the motor's" in said
