"""The model of a joint as it is handed on: base parameters and accepted effects; `model.yaml`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

import yaml

from flex_ident.errors import ConfigurationError
from flex_ident.parameters.keys import key_parts
from flex_ident.parameters.parameter import FLEXIBLE_KEYS, NON_NEGATIVE, RIGID_KEYS

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
            "effects": {name: dict(p) for name, p in self.effects.items()},
        }  # fmt: skip
        Path(path).write_text(yaml.safe_dump(content, sort_keys=False), encoding="utf-8")


def read_joint_model(path: Path) -> JointModel:
    """The model in a `model.yaml`. Raises ConfigurationError, naming file and key, when it is not one."""
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigurationError(f"{path}: cannot be read ({error.strerror}).") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"{path}: is not YAML.") from error
    if not isinstance(content, dict) or content.get("schema") != SCHEMA:
        raise ConfigurationError(f"{path}: is not a model file: expected 'schema: {SCHEMA}'.")
    unknown = sorted(set(content) - {"schema", "joint", "parameters", "effects"})
    if unknown:
        raise ConfigurationError(f"{path}: unknown key {', '.join(unknown)}.")
    try:
        parameters = {str(k): float(v) for k, v in (content.get("parameters") or {}).items()}
        effects = {
            str(n): {str(k): float(v) for k, v in (p or {}).items()} for n, p in (content.get("effects") or {}).items()
        }
        for key, value in parameters.items():
            if not math.isfinite(value) or (key in NON_NEGATIVE and value < 0.0):
                raise ConfigurationError(f"{key} = {value:g} is not physical.")
        return JointModel(parameters, effects, str(content.get("joint", "")))
    except (TypeError, ValueError, AttributeError) as error:
        raise ConfigurationError(f"{path}: parameters and effects must be numbers by name ({error}).") from error
    except ConfigurationError as error:
        raise ConfigurationError(f"{path}: {error}") from error
