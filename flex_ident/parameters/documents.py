"""The one reader of YAML and JSON files: plain data of bounded size and depth, or one line that says why not.

Scalars are what ROS 2's parameter files mean by them: `1e-3` is a number, `100:1` and `2026-11-26` are texts. As
there, a key stands once and there are no aliases. Lists may have the tag of a Python tuple, as launch_ros gives it to
those of a launch file. A file is read only when it is a regular file.
"""

from __future__ import annotations

import errno
import json
import os
import re
import stat
from io import BufferedReader
from pathlib import Path
from typing import Any

import yaml

from flex_ident.errors import ConfigurationError
from flex_ident.recording.names import path_text, shortened

LARGEST_BYTES = 1 << 20
"""Size of a configuration or model file, at most."""
MOST_NODES = 50_000
"""Keys, values and items of a YAML file, at most."""
DEEPEST = 32
"""Levels of mappings and lists within each other, at most."""
INTEGERS = (-(1 << 63), (1 << 64) - 1)
"""Whole numbers of 64 bits, signed or not."""
LONGEST_NUMBER = 64
"""Characters of a number, at most."""
_INTEGER = re.compile(r"[-+]?(?:[0-9]+|0x[0-9a-fA-F]+)$")
_FLOAT = re.compile(
    r"[-+]?(?:(?:[0-9]+\.[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?|[0-9]+[eE][-+]?[0-9]+|\.inf|\.Inf|\.INF)$"
    r"|\.nan$|\.NaN$|\.NAN$"
)
_BOOLEAN = re.compile(r"(?:yes|Yes|YES|no|No|NO|true|True|TRUE|false|False|FALSE|on|On|ON|off|Off|OFF)$")
_NULL = re.compile(r"(?:~|null|Null|NULL|)$")
TRUE = ("yes", "true", "on")


class DocumentError(ConfigurationError):
    """A file that cannot be read as a document; the message does not name the file."""


def text_of(path: Path, largest: int = LARGEST_BYTES) -> str:
    """The text of a regular file of at most `largest` bytes. Raises DocumentError, also on pipes and devices."""
    try:
        with opened_file(path) as file:
            content = file.read(largest + 1)
            size = os.fstat(file.fileno()).st_size
    except OSError as error:
        raise DocumentError(f"cannot be read ({error.strerror}).") from error
    if len(content) > largest:
        raise DocumentError(f"holds {max(size, len(content))} bytes: {largest} are read at most.")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise DocumentError(f"is not UTF-8 (byte {error.start}).") from error


def opened_file(path: Path) -> BufferedReader:
    """A regular file, open. Raises OSError, also for pipes, devices and folders, and without ever waiting."""
    try:
        # Without O_NONBLOCK, a pipe that nobody writes to would be waited for.
        handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except ValueError as error:
        raise OSError(errno.EINVAL, "its name holds a zero byte") from error
    try:
        mode = os.fstat(handle).st_mode
        if stat.S_ISREG(mode):
            return open(handle, "rb")
        what = "a folder" if stat.S_ISDIR(mode) else "a pipe or a device"
        raise OSError(errno.EINVAL, f"it is {what} and no file")
    except BaseException:
        os.close(handle)
        raise


def yaml_document(path: Path, *, largest: int = LARGEST_BYTES) -> Any:
    """The content of a YAML file. Raises ConfigurationError that names the file."""
    try:
        return yaml_content(text_of(path, largest))
    except DocumentError as error:
        raise ConfigurationError(f"{path_text(path)}: {error}") from error


def yaml_content(text: str) -> Any:
    """The one document in a YAML text, its mappings keyed by texts and numbers. Raises DocumentError."""
    try:
        _check_bounds(text)
        return yaml.load(text, Loader=_Loader)
    except DocumentError:
        raise
    except yaml.MarkedYAMLError as error:
        where = f" (line {error.problem_mark.line + 1}: {error.problem})" if error.problem_mark is not None else ""
        raise DocumentError(f"is not YAML{where}.") from error
    except (yaml.YAMLError, ValueError, TypeError, AttributeError, RecursionError) as error:
        raise DocumentError("is not YAML.") from error


def json_document(path: Path, *, largest: int = 64 * LARGEST_BYTES) -> Any:
    """The content of a JSON file. Raises ConfigurationError that names the file."""
    try:
        return json_content(text_of(path, largest))
    except DocumentError as error:
        raise ConfigurationError(f"{path_text(path)}: {error}") from error


def json_content(text: str) -> Any:
    """The content of a JSON text. Raises DocumentError."""
    try:
        return json.loads(text, parse_int=_whole_number)
    except DocumentError:
        raise
    except (ValueError, RecursionError) as error:
        raise DocumentError("is not JSON.") from error


def _check_bounds(text: str) -> None:
    """Raises DocumentError at the first alias, level or node too many: before anything is built."""
    nodes = depth = 0
    for event in yaml.parse(text, Loader=_BASE):
        line = event.start_mark.line + 1 if event.start_mark is not None else 0
        if isinstance(event, yaml.AliasEvent):
            raise DocumentError(f"has an alias (*{shortened(event.anchor)[1:-1]}) in line {line}: write it out.")
        if isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)):
            depth += 1
        elif isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
            depth -= 1
        nodes += isinstance(event, yaml.NodeEvent)
        if depth > DEEPEST:
            raise DocumentError(f"is nested more than {DEEPEST} levels deep in line {line}.")
        if nodes > MOST_NODES:
            raise DocumentError(f"has more than {MOST_NODES} keys and values.")


_BASE: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class _Loader(_BASE):  # type: ignore[misc]
    """PyYAML's safe loader with the scalars of ROS 2's parameter files and without repeated keys."""


def _mapping(loader: Any, node: yaml.MappingNode) -> dict[Any, Any]:
    content: dict[Any, Any] = {}
    for key_node, value_node in node.value:
        line = key_node.start_mark.line + 1
        if not isinstance(key_node, yaml.ScalarNode):
            raise DocumentError(f"has a key that is not a text in line {line}.")
        key = loader.construct_object(key_node)
        if key in content:
            raise DocumentError(f"has the key {shortened(key)} twice (again in line {line}).")
        content[key] = loader.construct_object(value_node, deep=True)
    return content


def _sequence(loader: Any, node: yaml.SequenceNode) -> list[Any]:
    return [loader.construct_object(item, deep=True) for item in node.value]


def _integer(loader: Any, node: yaml.ScalarNode) -> int:
    try:
        return _whole_number(loader.construct_scalar(node))
    except DocumentError as error:
        raise DocumentError(f"{error} (line {node.start_mark.line + 1})") from error


def _whole_number(text: str) -> int:
    if len(text) > LONGEST_NUMBER:
        raise DocumentError(f"has a whole number of {len(text)} digits: 64 bits are read at most.")
    number = int(text, 16 if "x" in text else 10)
    if not INTEGERS[0] <= number <= INTEGERS[1]:
        raise DocumentError(f"has the whole number {text}: 64 bits are read at most.")
    return number


def _float(loader: Any, node: yaml.ScalarNode) -> float:
    text = loader.construct_scalar(node).lower()
    return float(text.replace(".inf", "inf").replace(".nan", "nan"))


def _boolean(loader: Any, node: yaml.ScalarNode) -> bool:
    return loader.construct_scalar(node).lower() in TRUE


def _refused(loader: Any, node: yaml.Node) -> None:
    raise DocumentError(f"has the tag {shortened(node.tag)} in line {node.start_mark.line + 1}: write plain values.")


_Loader.yaml_implicit_resolvers = {}
for _tag, _pattern, _first in (
    ("bool", _BOOLEAN, "yYnNtTfFoO"), ("int", _INTEGER, "-+0123456789"), ("float", _FLOAT, "-+0123456789."),
    ("null", _NULL, ["~", "n", "N", ""]),
):  # fmt: skip
    _Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", _pattern, list(_first))
_Loader.yaml_constructors = {None: _refused}
for _tag, _constructor in (
    ("map", _mapping), ("seq", _sequence), ("python/tuple", _sequence), ("str", _BASE.construct_scalar),
    ("null", lambda *_: None), ("bool", _boolean), ("int", _integer), ("float", _float),
):  # fmt: skip
    _Loader.add_constructor(f"tag:yaml.org,2002:{_tag}", _constructor)
