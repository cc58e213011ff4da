"""Parameter files given to a node: one of which no section applies to it is refused, where ROS would pass over it."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import yaml
from rclpy.node import Node

from flex_ident.errors import ConfigurationError

PARAMETERS = "ros__parameters"
PATTERNS = {"**": r"(/\w+)*", "*": r"/\w+"}


def parameter_files(arguments: list[str] | None = None) -> list[Path]:
    """The parameter files on the command line."""
    given = sys.argv if arguments is None else arguments
    return [Path(after) for before, after in pairwise(given) if before == "--params-file"]


def refuse_files_that_do_not_apply(node: Node) -> None:
    """Refuse a file that holds nothing for this node, and one that holds a key twice. Raises ConfigurationError."""
    for path in parameter_files():
        sections = sections_in(path)
        name = node.get_fully_qualified_name()
        if not any(section_applies(section, name) for section in sections):
            there = ", ".join(f"'{section}'" for section in sections) or "none"
            raise ConfigurationError(
                f"{path}: no section applies to {name}, there is {there}: rename one to '/**' or '{name}'."
            )


def section_applies(section: str, node: str) -> bool:
    """Whether ROS takes a section for a node of that full name: `/**`, `/*/NAME`, `/NAMESPACE/NAME`, `NAME`."""
    parts = section.strip("/").split("/")
    return re.fullmatch("".join(PATTERNS.get(part, "/" + re.escape(part)) for part in parts), node) is not None


def sections_in(path: Path) -> list[str]:
    """The full names of the sections of a parameter file. Raises ConfigurationError."""
    try:
        content = yaml.load(path.read_text(encoding="utf-8"), _Strict)
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be read ({error.strerror}).") from error
    except yaml.MarkedYAMLError as error:
        raise ConfigurationError(f"{path}: {error.problem}.") from error
    except (yaml.YAMLError, UnicodeDecodeError, RecursionError) as error:
        raise ConfigurationError(f"{path}: is not YAML.") from error
    return list(_sections(content, ""))


def _sections(content: Any, prefix: str) -> Iterator[str]:
    """Names below which parameters stand; namespaces may be nested."""
    if isinstance(content, Mapping):
        for key, inner in content.items():
            if key == PARAMETERS:
                yield prefix
            else:
                yield from _sections(inner, f"{prefix}/{str(key).strip('/')}")


class _Strict(yaml.SafeLoader):
    """YAML in which a key stands once."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        """The mapping. Raises MarkedYAMLError for a key that stands twice."""
        seen = set()
        for key_node, _ in node.value:
            if key_node.value in seen and isinstance(key_node, yaml.ScalarNode):
                line = key_node.start_mark.line + 1
                raise yaml.MarkedYAMLError(problem=f"the key '{key_node.value}' stands twice, again in line {line}")
            seen.add(key_node.value if isinstance(key_node, yaml.ScalarNode) else id(key_node))
        return super().construct_mapping(node, deep=deep)
