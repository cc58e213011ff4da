"""What `--help` of a node prints, from the tables that its parameters are declared by; needs no ROS network."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from flex_ident.configuration.settings import Setting

WIDTH = 100
ALLOWED_OF_TEXTS = "a text"


@dataclass(frozen=True)
class Usage:
    """A node's purpose in a sentence or two, its settings, and what else it takes: key to description."""

    node: str
    purpose: str
    settings: Sequence[Setting]
    others: Mapping[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        keys = [*(s.key for s in self.settings), *self.others]
        width = max(map(len, keys))
        rows = [(s.key, _described(s)) for s in self.settings] + list(self.others.items())
        return "\n".join([
            f"usage: ros2 run flex_ident {self.node} [--help] [--ros-args [-p KEY:=VALUE]... [--params-file FILE]]",
            "",
            *textwrap.wrap(self.purpose, WIDTH),
            "",
            "Parameters are set with -p KEY:=VALUE, or in a FILE that begins like",
            f"$(ros2 pkg prefix flex_ident)/share/flex_ident/config/{self.node}.yaml (config/ in the repository).",
            "",
            "parameters:",
            *(_row(key, text, width) for key, text in rows),
        ])  # fmt: skip


def help_wanted(arguments: Sequence[str]) -> bool:
    """Whether the arguments before `--ros-args` ask for help."""
    own = arguments[: arguments.index("--ros-args")] if "--ros-args" in arguments else arguments
    return "--help" in own or "-h" in own


def _described(setting: Setting) -> str:
    default = "''" if setting.default == "" else str(setting.default)
    if isinstance(setting.default, bool):
        default = default.lower()
    allowed = setting.range_text
    return f"{setting.description} [{default}{'' if allowed == ALLOWED_OF_TEXTS else '; ' + allowed}]"


def _row(key: str, text: str, width: int) -> str:
    indent = " " * (width + 4)
    return textwrap.fill(text, max(WIDTH, width + 60), initial_indent=f"  {key:<{width}}  ", subsequent_indent=indent)
