"""A parameter file that holds nothing for a node, or a key twice, is refused before anything moves."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="needs rclpy")
from flex_ident.errors import ConfigurationError
from flex_ident.nodes import chirp_exciter, identifier, simulated_joint
from flex_ident.nodes.parameter_files import parameter_files, section_applies, sections_in
from flex_ident.parameters.documents import yaml_document

pytestmark = pytest.mark.ros
MAINS = {"chirp_exciter": chirp_exciter.main, "identifier": identifier.main, "simulated_joint": simulated_joint.main}


@pytest.mark.parametrize(
    ("section", "node", "applies"),
    [
        ("/**", "/left/arm/chirp_exciter", True), ("chirp_exciter", "/chirp_exciter", True),
        ("/chirp_exciter", "/chirp_exciter", True), ("chirp_exciter", "/left/chirp_exciter", False),
        ("chirp_exciter", "/exciter_left", False), ("/**/chirp_exciter", "/left/chirp_exciter", True),
        ("/**/chirp_exciter", "/chirp_exciter", True), ("/*/chirp_exciter", "/left/chirp_exciter", True),
        ("/*/chirp_exciter", "/chirp_exciter", False), ("/right/chirp_exciter", "/left/chirp_exciter", False),
        ("left/chirp_exciter", "/left/chirp_exciter", True), ("chirp", "/chirp_exciter", False),
    ],
)  # fmt: skip
def test_sections_apply_as_ros_takes_them(section: str, node: str, applies: bool) -> None:
    assert section_applies(section, node) == applies


def test_namespaces_may_be_nested(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text("left:\n  arm:\n    chirp_exciter:\n      ros__parameters:\n        joint: a\n")
    assert sections_in(file) == ["/left/arm/chirp_exciter"]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("/**:\n  ros__parameters:\n    joint: a\n    joint: b\n", r"the key 'joint' twice \(again in line 4\)"),
        ("/**: [\n", "is not YAML"),
        ("a: b: c\n", "mapping values"),
        ("a: &a [*a]\n", r"an alias \(\*a\) in line 1"),
        ("a: " * 40 + "b\n", "is not YAML"),
        ("{a: " * 40 + "}" * 40, "nested more than 32 levels"),
    ],
)
def test_what_is_ambiguous_is_refused(text: str, why: str, tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    file.write_text(text)
    with pytest.raises(ConfigurationError, match=why):
        sections_in(file)


def test_the_files_that_a_launch_file_makes_are_read(tmp_path: Path) -> None:
    """As launch_ros writes them for a Node's own parameters, its lists as tuples."""
    file = tmp_path / "launch_params_jbwp6i48"
    file.write_text(
        "/**:\n  ros__parameters:\n    bag_directories: !!python/tuple\n    - recordings\n    joint: joint_2\n"
        "    topics: !!python/tuple []\n"
    )
    assert sections_in(file) == ["/**"]
    found = yaml_document(file)["/**"]["ros__parameters"]
    assert found == {"bag_directories": ["recordings"], "joint": "joint_2", "topics": []}


def test_the_files_on_the_command_line() -> None:
    given = ["node", "--ros-args", "--params-file", "a.yaml", "-p", "x:=1", "--params-file", "b.yaml"]
    assert parameter_files(given) == [Path("a.yaml"), Path("b.yaml")]


@pytest.mark.parametrize(
    ("node", "more", "section", "taken"),
    [
        ("chirp_exciter", ["-r", "__node:=exciter_left"], "chirp_exciter", False),
        ("chirp_exciter", ["-r", "__ns:=/left"], "chirp_exciter", False),
        ("identifier", ["-r", "__node:=other"], "identifier", False),
        ("simulated_joint", ["-r", "__ns:=/left"], "/right/simulated_joint", False),
        ("chirp_exciter", ["-r", "__ns:=/left"], "/left/chirp_exciter", True),
        ("chirp_exciter", ["-r", "__ns:=/left"], "/**/chirp_exciter", True),
    ],
)
def test_a_file_of_which_no_section_applies_is_refused(
    node: str, more: list[str], section: str, taken: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    file = tmp_path / "a.yaml"
    file.write_text(f"{section}:\n  ros__parameters:\n    {'rate_hz: 1.0' if taken else 'joint: a'}\n")
    given = ["--ros-args", "-p", "joint:=a", *more, "--params-file", str(file)]
    monkeypatch.setattr(sys, "argv", [node, *given])
    assert MAINS[node]() == 2
    said = capsys.readouterr().err
    assert ("rate_hz is 1.0" if taken else f"{file}: no section applies to /") in said
    assert said.count("\n") == 1
