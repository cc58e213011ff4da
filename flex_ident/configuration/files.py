"""Settings from a ROS 2 parameter file; what is unknown or out of range is refused by name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml

from flex_ident.configuration.settings import Setting, Value
from flex_ident.errors import ConfigurationError


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


def parameters_in(path: Path, node: str) -> dict[str, Any]:
    """The flat parameters that a ROS 2 parameter file holds for every node (`/**`) and for `node`."""
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be read ({error.strerror}).") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"{path}: is not YAML.") from error
    if not isinstance(content, dict):
        raise ConfigurationError(f"{path}: expected '/**:' and below it 'ros__parameters:'.")
    found: dict[str, Any] = {}
    for name, section in content.items():
        if not isinstance(section, dict) or set(section) != {"ros__parameters"}:
            raise ConfigurationError(f"{path}: below '{name}:' expected 'ros__parameters:' and nothing else.")
        if str(name).strip("/") in ("**", node):
            found.update(flattened(section["ros__parameters"] or {}))
    return found


def read_settings(
    path: Path, settings: Iterable[Setting], *, node: str, others: Iterable[str] = ()
) -> dict[str, Value]:
    """The settings that a file gives, checked. `others` are keys that are known but not for this command.

    Raises ConfigurationError naming the file, the key and what is allowed.
    """
    known = {s.key: s for s in settings}
    allowed = {*known, *others}
    result: dict[str, Value] = {}
    for key, value in parameters_in(path, node).items():
        if key not in allowed:
            close = difflib.get_close_matches(key, allowed, 1)
            hint = f"did you mean {close[0]}?" if close else f"known are {', '.join(sorted(known))}."
            raise ConfigurationError(f"{path}: unknown key '{key}': {hint}")
        if key in known:
            result[key] = known[key].checked(value, str(path))
    return result
