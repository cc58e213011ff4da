"""Settings from a ROS 2 parameter file; what is unknown or out of range is refused by name."""

from __future__ import annotations

import difflib
import sys
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

from flex_ident.configuration.settings import Setting, Value
from flex_ident.errors import ConfigurationError
from flex_ident.parameters.documents import yaml_document
from flex_ident.recording.names import harmless, path_text, shortened

MOST_NAMED = 8
"""Sections that a message lists."""


def flattened(content: Mapping[Any, Any], prefix: str = "") -> dict[str, Any]:
    """Nested keys joined by dots, as ROS 2 parameters are named."""
    flat: dict[str, Any] = {}
    for key, value in content.items():
        name = f"{prefix}{key}"
        if isinstance(value, Mapping):
            flat.update(flattened(value, f"{name}."))
        else:
            flat[name] = value
    return flat


def applies(section: str, names: Collection[str]) -> bool:
    """Whether a section's name, `/**`, `/**/NAME`, `/namespace/NAME` or `NAME`, means one of `names`.

    Only its last part counts: a command has no namespace, and that of a node is ROS's business.
    """
    return section.rpartition("/")[2] in ("**", "*", *names)


def parameters_in(path: Path, names: Collection[str]) -> dict[str, Any]:
    """The flat parameters that a ROS 2 parameter file holds for every node and for those called one of `names`.

    Later sections win. Raises ConfigurationError, naming file and section, also when no section applies.
    """
    content, file = yaml_document(path), path_text(path)
    if not isinstance(content, dict):
        raise ConfigurationError(f"{file}: expected '/**:' and below it 'ros__parameters:'.")
    found: dict[str, Any] = {}
    for name, section in content.items():
        if not isinstance(section, dict) or set(section) != {"ros__parameters"}:
            raise ConfigurationError(f"{file}: below {shortened(name)} expected 'ros__parameters:' and nothing else.")
        given = section["ros__parameters"]
        if given is not None and not isinstance(given, dict):
            raise ConfigurationError(
                f"{file}: ros__parameters of '{harmless(str(name))}' is {shortened(given)}: expected keys and values."
            )
        if applies(str(name), names):
            found.update(flattened(given or {}))
    if not any(applies(str(name), names) for name in content):
        there = ", ".join(f"'{harmless(str(name))}'" for name in list(content)[:MOST_NAMED]) or "none"
        wanted = " or ".join(f"'{name}'" for name in ("/**", *names))
        raise ConfigurationError(f"{file}: no section applies, there is {there}: expected {wanted}.")
    return found


def read_settings(
    path: Path, settings: Iterable[Setting], *, node: str, others: Iterable[str] = (), command: str | None = None
) -> dict[str, Value]:
    """The settings that a file gives, checked. `others` are keys that are known but not for this command.

    Sections of `node` and of the `command` itself count, by default the program that runs.

    Raises ConfigurationError naming the file, the key and what is allowed.
    """
    program = Path(sys.argv[0]).stem if command is None else command
    known = {s.key: s for s in settings}
    allowed = {*known, *others}
    result: dict[str, Value] = {}
    for key, value in parameters_in(path, dict.fromkeys((node, program))).items():
        if key not in allowed:
            close = difflib.get_close_matches(key, allowed, 1)
            hint = f"did you mean {close[0]}?" if close else f"known are {', '.join(sorted(known))}."
            raise ConfigurationError(f"{path_text(path)}: unknown key {shortened(key)}: {hint}")
        if key in known:
            result[key] = known[key].checked(value, path_text(path))
    return result
