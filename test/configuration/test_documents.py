"""YAML and JSON from anywhere: plain data, or one line; never much time or memory."""

import os
from pathlib import Path

import numpy as np
import pytest

from flex_ident.configuration import IDENTIFY_SETTINGS, read_settings
from flex_ident.errors import ConfigurationError
from flex_ident.parameters import JointModel, read_joint_model
from flex_ident.parameters.documents import DocumentError, json_content, yaml_content, yaml_document

LAUGHS = "a0: &a0 [x, x]\n" + "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 12))
HOSTILE = {
    "aliases": (LAUGHS, "alias"),
    "alias of itself": ("a: &a [*a]", "alias"),
    "merge of itself": ("a: &a {<<: *a}", "alias"),
    "deep list": ("[" * 500_000, "ne"),
    "deep map": ("{a: " * 100_000, "levels deep"),
    "deep block": ("".join(" " * i + "a:\n" for i in range(1000)), "levels deep"),
    "many nodes": ("- a\n" * 200_000, "keys and values"),
    "whole number of 400 digits": (f"a: {'9' * 400}", "400 digits"),
    "whole number of 5000 digits": (f"a: -{'9' * 5000}", "5001 digits"),
    "whole number of 20 digits": (f"a: {'9' * 20}", "64 bits"),
    "repeated key": ("a: 1\nb: 2\na: 3", "'a' twice"),
    "key that is a list": ("? [1, 2]\n: 3", "not a text"),
    "python object": ("a: !!python/object/apply:os.system [true]", "tag"),
    "own tag": ("a: !thing 5", "tag"),
    "number of text": ("a: !!int abc", "not YAML"),
    "truth of a map": ("a: !!bool {b: c}", "not YAML"),
    "map of text": ("a: !!map abc", "not YAML"),
    "two documents": ("a: 1\n---\na: 2", "not YAML"),
    "zero byte": ("a: \0", "not YAML"),
    "long anchor": (f"a: &{'x' * 900_000} 1", ""),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_yaml_is_refused_in_one_short_line(name: str, tmp_path: Path) -> None:
    text, said = HOSTILE[name]
    file = tmp_path / "hostile.yaml"
    file.write_text(text)
    if said:
        with pytest.raises(ConfigurationError, match=said) as caught:
            yaml_document(file)
        assert str(file) in str(caught.value)
        assert "\n" not in str(caught.value)
        assert len(str(caught.value)) < 300 + len(str(file))
    else:
        yaml_document(file)


def test_a_file_that_is_too_large_a_pipe_or_a_folder_is_refused(tmp_path: Path) -> None:
    large, pipe = tmp_path / "large.yaml", tmp_path / "pipe.yaml"
    with large.open("wb") as file:
        file.truncate(1 << 40)
    os.mkfifo(pipe)
    for path, said in ((large, "bytes"), (pipe, "pipe"), (tmp_path, "folder"), (Path("/dev/zero"), "device"),
                       (Path("/nowhere\x1b[2J"), "No such file")):  # fmt: skip
        with pytest.raises(ConfigurationError, match=said) as caught:
            yaml_document(path)
        assert "\x1b" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 1e-3), ("1e5", 1e5), ("-.5", -0.5), ("100:1", "100:1"), ("2026-11-26", "2026-11-26"), ("yes", True),
        ("0x10", 16), ("12", 12), ("~", None), ("", None), (".nan", "nan"), ("-.inf", float("-inf")), ("'1'", "1"),
        ("[]", []), ("{}", {}), ("1_000", "1_000"), ("12:30:45", "12:30:45"),
    ],
)  # fmt: skip
def test_scalars_are_those_of_ros_2(text: str, value: object) -> None:
    read = yaml_content(f"a: {text}")["a"]
    assert type(read) is type(value) if value != "nan" else read != read
    assert value == "nan" or read == value


def test_any_text_is_a_document_or_one_line() -> None:
    random = np.random.default_rng(16)
    alphabet = list("ab:-[]{}&*!<|>#'\"%@?, \n\n  \t0123456789.eEx")
    said: list[str] = []
    for _ in range(2000):
        text = "".join(random.choice(alphabet, int(random.integers(60))))
        for reader in (yaml_content, json_content):
            try:
                reader(text)
            except DocumentError as error:
                said.append(str(error))
    assert len(said) > 2000
    assert not any("\n" in text for text in said)


def test_a_configuration_names_file_and_key_whatever_stands_there(tmp_path: Path) -> None:
    file = tmp_path / "a.yaml"
    for body, said in (
        ("effort_scale: 9" + "9" * 399, "400 digits"), ("effort_scale: [1, 2]", "effort_scale is a list of 2"),
        ('"\\e[2J": 1', "unknown key"), ("effort_scale: .inf", "effort_scale is inf"),
        (f"joint: {{{', '.join(f'a{i}: 1' for i in range(50))}}}", "unknown key"),
    ):  # fmt: skip
        file.write_text(f"/**:\n  ros__parameters:\n    {body}\n")
        with pytest.raises(ConfigurationError, match=said) as caught:
            read_settings(file, IDENTIFY_SETTINGS, node="identifier")
        assert "\x1b" not in str(caught.value)
        assert str(file) in str(caught.value)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("parameters: {K: .nan}", r"parameters.K is nan"), ("effects: {backlash: {gap: .inf}}", "backlash.gap is inf"),
        ("parameters: {K: 1" + "0" * 400 + "}", "401 digits"), ("parameters: [1]", "parameters is a list of 1"),
        ("effects: {backlash: 3}", "effects.backlash is 3"), ("parameters: {K: true}", "K is True"),
        ("parameters: {K: '5'}", "K is '5'"), ("joint: [a]", "joint is a list"), ("parameters: {K: -1.0}", "physical"),
        ("other: 1", "unknown key 'other'"), ("parameters: {Q: 1.0}", "unknown model parameter Q"),
    ],
)  # fmt: skip
def test_a_model_file_that_is_none_is_refused_by_key(tmp_path: Path, content: str, said: str) -> None:
    file = tmp_path / "model.yaml"
    file.write_text(f"schema: flex_ident/model/1\n{content}\n")
    with pytest.raises(ConfigurationError, match=said):
        read_joint_model(file)


def test_a_model_is_read_as_it_was_written(tmp_path: Path) -> None:
    model = JointModel({"K": 2e20, "Jm": 1e-300, "JL": 0.1}, {"backlash": {"gap": 1e-7}}, "Gelenk ä")
    model.write(tmp_path / "model.yaml")
    assert read_joint_model(tmp_path / "model.yaml") == model
