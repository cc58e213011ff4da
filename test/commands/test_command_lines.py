"""Commands at their edges: several joints, full disks, folders that cannot be written, numbers that are none."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from flex_ident.bags import writing
from flex_ident.commands.common import finite_number, seed_number
from flex_ident.commands.explain_gap import main as explain_gap
from flex_ident.commands.flex_ident import EXAMPLES
from flex_ident.commands.flex_ident import main as flex_ident
from flex_ident.commands.identify_bag import main as identify_bag
from flex_ident.parameters import Parameter
from flex_ident.report.table import delay_text, meaning_of, parameter_row, percent_text


@pytest.fixture(scope="module")
def three_joints(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Rigid joints: a, b without effort, c."""
    t = np.arange(0.0, 12.0, 2e-3)
    phase, omega = 2 * np.pi * (0.2 * t + 0.15 * t**2), 2 * np.pi * (0.2 + 0.3 * t)
    q, v = 0.3 * np.sin(phase), 0.3 * omega * np.cos(phase)
    a = 0.3 * (2 * np.pi * 0.3 * np.cos(phase) - omega**2 * np.sin(phase))
    torque = 2.0 * a + 3.0 * v + np.sign(v) + np.random.default_rng(0).normal(0.0, 0.3, t.size)
    path = tmp_path_factory.mktemp("bags") / "three"
    writing.write_joint_states(
        path, t, ["a", "b", "c"], np.stack((q, q, 0.5 * q), axis=1), np.stack((v, v, 0.5 * v), axis=1),
        np.stack((torque, np.zeros_like(t), torque), axis=1),
    )  # fmt: skip
    return path


def test_all_joints_go_on_past_one_that_fails(
    three_joints: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status = identify_bag(
        [str(three_joints), "--joint", "all", "--rigid", "--json", "--no-plots", "--out", str(tmp_path)]
    )
    said = capsys.readouterr()
    assert status == 3
    assert [c["joint"] for c in json.loads(said.out)] == ["a", "c"]
    assert said.err.splitlines() == [
        line for line in said.err.splitlines() if line.startswith("identify_bag: joint b: ")
    ]
    assert (tmp_path / "c" / "result.json").exists()


def test_one_of_all_joints_is_an_array_too(
    three_joints: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ["--rigid", "--json", "--no-plots", "--out", str(tmp_path)]
    assert identify_bag([str(three_joints), "--joint", "a", *given]) == 0
    assert json.loads(capsys.readouterr().out)["joint"] == "a"


@pytest.mark.skipif(not os.access("/dev/full", os.W_OK), reason="needs /dev/full")
def test_full_disk_is_one_line(three_joints: Path, tmp_path: Path) -> None:
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "flex_ident.commands.identify_bag", str(three_joints), "--joint", "a", "--rigid",
             "--no-plots", "--out", str(tmp_path)],
            stdout=full, stderr=subprocess.PIPE, text=True, timeout=120, check=False,
        )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr == "identify_bag: the output cannot be read or written (No space left on device).\n"


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("design-filter", "--first-mode", "4", "--sample-rate", "inf"), "--sample-rate"),
        (("design-filter", "--first-mode", "nan"), "--first-mode"),
        (("design-filter", "--first-mode", "4", "--decimation", "0"), "decimation is 0"),
        (("design-filter", "--first-mode", "4", "--figure", "/proc/x.png"), "--figure /proc/x.png"),
        (("demo", "--without-ros", "--out", "/proc/zz"), "--out /proc/zz"),
        (("demo", "--without-ros", "--seed", "-1"), "--seed"),
        (("reproduce-paper", "--seed", "-1"), "--seed"),
        (("check-bag", "bag", "--rigid"), "--rigid"),
    ],
)
def test_wrong_usage_is_one_line(arguments: tuple[str, ...], text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert flex_ident(arguments) == 2
    said = capsys.readouterr().err
    assert text in said
    assert "internal error" not in said
    assert len(said.splitlines()) == 1


@pytest.mark.parametrize("subcommand", ["demo", "design-filter", "reproduce-paper", "check-bag", "export"])
def test_every_option_has_a_help_text(subcommand: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        flex_ident([subcommand, "--help"])
    lines = capsys.readouterr().out.partition("options:")[2].splitlines()
    for line, following in zip(lines, [*lines[1:], ""], strict=True):
        if line.startswith("  -"):
            assert "   " in line.strip() or "  " in line.strip() or following.startswith("          "), line


def test_numbers_of_the_command_line() -> None:
    assert (seed_number("7"), finite_number("1e3")) == (7, 1000.0)


def test_shares_and_delays_in_words() -> None:
    assert [percent_text(x) for x in (0.0, 1e-11, 0.516, 12.3, 100.0)] == ["0 %", "0 %", "0.52 %", "12 %", "100 %"]
    late = Parameter("torque_delay", 1.2e-4, 2e-6, "s")
    assert delay_text(late) == "torque recorded 0.120 ± 0.004 ms late"
    assert delay_text(Parameter("link_skew", -3e-3, 0.0, "s", at_bound=True)) == (
        "link position read 3.000 ms early, which is its limit"
    )
    assert delay_text(late, 0.35e-3) == (
        "torque recorded 0.120 ± 0.004 ms late, behind a low-pass that makes it 0.350 ms later"
    )
    assert delay_text(late, 1e-9) == delay_text(late)


def test_what_slides_has_a_mass() -> None:
    assert parameter_row(Parameter("J", 95.0, 0.2, "kg"), rigid=True)[5] == "mass"
    assert parameter_row(Parameter("J", 95.0, 0.2, "kg m^2"), rigid=True)[5] == "inertia"
    assert meaning_of("offset", prismatic=True) == "constant motor force"
    assert meaning_of("K", alone=True) == "stiffness seen from the motor"


@pytest.mark.parametrize("command", ["identify_bag", "explain_gap"])
def test_help_has_examples_and_exit_statuses(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        {"identify_bag": identify_bag, "explain_gap": explain_gap}[command](["--help"])
    said = capsys.readouterr().out
    assert f"examples:\n  {command} my_bag" in said
    assert "  4  done, but the result must not be trusted" in said
    assert ("'all' for each" in " ".join(said.split())) == (command == "identify_bag")
    if command == "explain_gap":
        assert "the base whose gap is sought" in " ".join(said.split())


@pytest.mark.parametrize("subcommand", [s for s in EXAMPLES if s != "all"])
def test_help_of_subcommands_likewise(subcommand: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        flex_ident([subcommand, "--help"])
    said = capsys.readouterr().out
    assert f"examples:\n  flex_ident {subcommand}" in said
    assert "exit status:" in said


def test_json_is_printed_where_nothing_can_be_written(
    three_joints: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("")
    given = [str(three_joints), "--joint", "a", "--rigid", "--no-plots"]
    assert identify_bag([*given, "--json", "--out", str(tmp_path / "file" / "below")]) == 2
    said = capsys.readouterr()
    assert json.loads(said.out)["joint"] == "a"
    assert len(said.err.splitlines()) == 1
    assert "cannot be written" in said.err
    assert identify_bag([*given, "--out", str(tmp_path / "file" / "below")]) == 2
    assert capsys.readouterr().out == ""
