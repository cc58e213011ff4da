"""Parameter files given to a node: one of which no section applies to it is refused, where ROS would pass over it."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

from rclpy.node import Node

from flex_ident.errors import ConfigurationError
from flex_ident.parameters.documents import yaml_document

PARAMETERS = "ros__parameters"
PATTERNS = {"**": r"(/\w+)*", "*": r"/\w+"}


def parameter_files(arguments: list[str] | None = None) -> list[Path]:
    """The parameter files on the command line."""
    given = sys.argv if arguments is None else arguments
    return [Path(after) for before, after in pairwise(given) if before == "--params-file"]


def refuse_what_is_no_file(arguments: list[str] | None) -> None:
    """Refuse a pipe or a device, for which ROS would wait, and which cannot be read twice. Raises ConfigurationError.

    One that is not there is left to ROS, which says so.
    """
    for path in parameter_files(arguments):
        if path.exists() and not path.is_file():
            raise ConfigurationError(f"--params-file {path}: it is no file, but a folder, a pipe or a device.")


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
    return list(_sections(yaml_document(path), ""))


def _sections(content: Any, prefix: str) -> Iterator[str]:
    """Names below which parameters stand; namespaces may be nested."""
    if isinstance(content, Mapping):
        for key, inner in content.items():
            if key == PARAMETERS:
                yield prefix
            else:
                yield from _sections(inner, f"{prefix}/{str(key).strip('/')}")
