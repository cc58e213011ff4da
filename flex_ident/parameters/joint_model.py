"""The model of a joint as it is handed on: base parameters and accepted effects; `model.yaml`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

from flex_ident.errors import ConfigurationError
from flex_ident.parameters.documents import yaml_document
from flex_ident.parameters.keys import key_parts, key_text
from flex_ident.parameters.parameter import FLEXIBLE_KEYS, NON_NEGATIVE, RIGID_KEYS
from flex_ident.parameters.tables import as_lists, numbered, yaml_text
from flex_ident.recording.names import harmless, path_text, shortened

SCHEMA = "flex_ident/model/1"


@dataclass(frozen=True)
class JointModel:
    """Eqs. 5 and 6 of the paper with numbers, and effects: `{"backlash": {"gap": 0.0008}}`. SI, link side.

    `parameters` holds keys of eq. 11 and `offset` (flexible) or J, FV, FS, offset, MX, MY (rigid). Keys left out are
    zero. Raises ConfigurationError on unknown keys.
    """

    parameters: Mapping[str, float]
    effects: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    joint: str = ""

    def __post_init__(self) -> None:
        known = RIGID_KEYS if "J" in self.parameters else FLEXIBLE_KEYS
        unknown = sorted(set(self.parameters) - set(known))
        if unknown:
            raise ConfigurationError(f"unknown model parameter {', '.join(unknown)}: expected {', '.join(known)}.")
        object.__setattr__(self, "parameters", MappingProxyType({k: float(v) for k, v in self.parameters.items()}))
        frozen = {n: MappingProxyType({k: float(v) for k, v in p.items()}) for n, p in self.effects.items()}
        object.__setattr__(self, "effects", MappingProxyType(frozen))

    @property
    def rigid(self) -> bool:
        """Whether the model has no spring."""
        return "J" in self.parameters

    def value(self, key: str) -> float:
        """A base parameter (`K`) or an effect's (`backlash.gap`); 0 when the model does not hold it."""
        effect, name = key_parts(key)
        own = self.parameters if effect is None else self.effects.get(effect, {})
        return own.get(name, 0.0)

    def with_effect(self, name: str, parameters: Mapping[str, float]) -> JointModel:
        """The same model with one effect added or replaced."""
        return replace(self, effects={**self.effects, name: dict(parameters)})

    def without(self, keys: tuple[str, ...]) -> JointModel:
        """The same model with base parameters dropped (they are zero then)."""
        return replace(self, parameters={k: v for k, v in self.parameters.items() if k not in keys})

    def write(self, path: Path | str) -> None:
        """Write `model.yaml`."""
        content = {
            "schema": SCHEMA, "joint": self.joint, "parameters": dict(self.parameters),
            "effects": {name: as_lists(p) for name, p in self.effects.items()},
        }  # fmt: skip
        Path(path).write_text(yaml_text(content), encoding="utf-8")


def read_joint_model(path: Path) -> JointModel:
    """The model in a `model.yaml`. Raises ConfigurationError, naming file and key, when it is not one."""
    content, file = yaml_document(path), path_text(path)
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise ConfigurationError(f"{file}: no model file, which begins with 'schema: {SCHEMA}'.")
    unknown = [shortened(key) for key in content if key not in ("schema", "joint", "parameters", "effects")]
    if unknown:
        raise ConfigurationError(f"{file}: unknown key {', '.join(unknown[:8])}.")
    joint = content.get("joint")
    if joint is not None and not isinstance(joint, (str, int)):
        raise ConfigurationError(f"{file}: joint is {shortened(joint)}: expected a name.")
    try:
        parameters = _numbers(content.get("parameters"), "parameters")
        effects = {
            harmless(str(name)): _numbers(_without_lists(own), f"effects.{harmless(str(name))}")
            for name, own in _mapping(content.get("effects"), "effects").items()
        }
        for key, value in parameters.items():
            if key in NON_NEGATIVE and value < 0.0:
                raise ConfigurationError(f"{key} = {value:g} is not physical.")
        return JointModel(parameters, effects, "" if joint is None else harmless(str(joint)))
    except ConfigurationError as error:
        raise ConfigurationError(f"{file}: {error}") from error


def _mapping(content: object, where: str) -> dict[object, object]:
    if content is None:
        return {}
    if not isinstance(content, dict):
        raise ConfigurationError(f"{where} is {shortened(content)}: expected keys and values.")
    return content


def _without_lists(content: object) -> object:
    """An effect's section with the items of its lists under their numbered names."""
    if not isinstance(content, dict):
        return content
    found: dict[object, object] = {}
    for key, value in content.items():
        found.update(numbered(str(key), value) if isinstance(value, list) else {key: value})
    return found


def _numbers(content: object, where: str) -> dict[str, float]:
    """Finite numbers by name; none of an empty section. Raises ConfigurationError."""
    found = {}
    for key, value in _mapping(content, where).items():
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            place = key_text(where, harmless(str(key)))
            raise ConfigurationError(f"{place} is {shortened(value)}: expected a finite number.")
        found[harmless(str(key))] = float(value)
    return found
