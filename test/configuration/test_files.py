"""Parameter files: which sections apply to a command, and what is refused by name."""

from pathlib import Path

import pytest

from flex_ident.configuration import IDENTIFY_SETTINGS, read_settings
from flex_ident.configuration.settings import Value
from flex_ident.errors import ConfigurationError


def settings_in(folder: Path, text: str) -> dict[str, Value]:
    """What identify_bag reads from a file with this text."""
    file = folder / "mine.yaml"
    file.write_text(text)
    return read_settings(file, IDENTIFY_SETTINGS, node="identifier", command="identify_bag")


@pytest.mark.parametrize(
    "section", ["/**", "/*", "identifier", "/identifier", "/ns/identifier", "/**/identifier", "/ns/**", "identify_bag"]
)
def test_a_section_applies_by_its_last_part(section: str, tmp_path: Path) -> None:
    assert settings_in(tmp_path, f"{section}:\n  ros__parameters:\n    rigid: true\n") == {"rigid": True}
    with pytest.raises(ConfigurationError, match=r"unknown key 'rigidd': did you mean rigid\?"):
        settings_in(tmp_path, f"{section}:\n  ros__parameters:\n    rigidd: true\n")


def test_other_sections_are_for_others_and_later_ones_win(tmp_path: Path) -> None:
    text = "chirp_exciter: {ros__parameters: {rate_hz: 1.0}}\n/**: {ros__parameters: {joint: a, rigid: true}}\n"
    assert settings_in(tmp_path, text) == {"joint": "a", "rigid": True}
    text += "/ns/identifier: {ros__parameters: {joint: b}}\n"
    assert settings_in(tmp_path, text) == {"joint": "b", "rigid": True}


@pytest.mark.parametrize("section", ["/identifier/other", "explain_gap", "identifer", "identify_bag/"])
def test_a_file_without_a_section_that_applies_is_refused(section: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError) as caught:
        settings_in(tmp_path, f"{section}:\n  ros__parameters:\n    rigid: true\n")
    said = str(caught.value)
    assert str(tmp_path / "mine.yaml") in said
    assert f"'{section}'" in said
    assert "'/**' or 'identifier' or 'identify_bag'" in said


@pytest.mark.parametrize("given", ["5", "[1, 2]", "text", "false", "''"])
def test_parameters_that_are_no_keys_and_values_are_refused(given: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"mine\.yaml: ros__parameters of '/ns/x' is .*keys and values"):
        settings_in(tmp_path, f"/ns/x:\n  ros__parameters: {given}\n/**:\n  ros__parameters:\n")


def test_an_empty_section_says_nothing(tmp_path: Path) -> None:
    assert settings_in(tmp_path, "/**:\n  ros__parameters:\n") == {}
