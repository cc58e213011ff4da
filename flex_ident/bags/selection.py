"""Where each signal is to be found, as the user says it: TOPIC[:NAME[.FIELD]]."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass

from flex_ident.errors import SignalError, UsageError

FIELDS = ("position", "velocity", "effort")
BY_NUMBER = rf"({'|'.join(FIELDS)})\[\d+\]|joints\[\d+\]\.\w+"
"""A joint by its number in a message of joint states, or in Foxglove's."""
JOINT_STATES = "/joint_states"
REFERENCE = "/chirp_exciter/reference"
LINK_STATES = "/link_joint_states"


def is_link_topic(topic: str) -> bool:
    """Whether the topic, in whatever namespace, is where link encoders are published."""
    return f"/{topic}".endswith(LINK_STATES)


def is_reference_topic(topic: str) -> bool:
    """Whether the topic, in whatever namespace, is the exciter's reference."""
    return f"/{topic}".endswith(REFERENCE)


@dataclass(frozen=True)
class SignalSelection:
    """Which joint and signals to read; None: look for it. Raises UsageError on numbers that make no sense.

    `effort_scale` is N m per recorded unit of effort; `gear_ratio` motor turns per link turn, when the motor position
    is on the motor shaft. `sensors`: motor (the link position is not looked for), motor+link (it must be there), auto.
    `type_files` are .msg files, or folders of them, that define message types.
    """

    joint: str | None = None
    motor_position: str | None = None
    link_position: str | None = None
    effort: str | None = None
    reference: str | None = None
    effort_scale: float = 1.0
    gear_ratio: float = 1.0
    sensors: str = "auto"
    type_files: tuple[str, ...] = ()
    motor_current: str | None = None

    def __post_init__(self) -> None:
        for name in ("effort_scale", "gear_ratio"):
            value = getattr(self, name)
            if not (abs(value) > 0.0 and abs(value) < 1e12):
                raise UsageError(f"{name} is {value}: expected a number other than zero.")


@dataclass(frozen=True)
class Place:
    """A signal's topic, and in it the joint's `name` and `field`, or the dotted `field` of another message."""

    topic: str
    name: str
    field: str

    @property
    def source(self) -> str:
        """The place as the user would write it."""
        rest = ".".join(part for part in (self.name, self.field) if part)
        return f"{self.topic}:{rest}" if rest else self.topic


def topic_of(text: str, topics: Collection[str] = ()) -> str:
    """The topic that `text`, TOPIC[:NAME[.FIELD]], names, of `topics` where one of them is meant.

    A name without a slash in front may stand below any namespace, if only one topic ends with it. Raises UsageError
    when `text` names no topic, and SignalError when it could be several.
    """
    topic = text.partition(":")[0]
    if not topic.strip("/"):
        raise UsageError(f"'{text}' names no topic: expected TOPIC[:NAME[.FIELD]].")
    absolute = f"/{topic.lstrip('/')}"
    for known in (topic, absolute, absolute[1:]):
        if known in topics:
            return known
    below = [known for known in topics if f"/{known}".endswith(absolute)] if not topic.startswith("/") else []
    if len(below) > 1:
        raise SignalError(f"'{topic}' may be {' or '.join(sorted(below))}: name one in full.")
    return below[0] if below else absolute


def dotted(path: str) -> str:
    """A path of fields with indexes as fields: `tau_J.3` for `tau_J[3]`."""
    return re.sub(r"\[(\d+)\]", r".\1", path).lstrip(".")


def place_of(
    text: str, *, topic: str, joint: str, field: str, is_joint_state: bool, any_field: bool = False
) -> Place:  # fmt: skip
    """The place in `topic` that `text` names; NAME and FIELD default to the joint and the role's `field`.

    Of joint states, NAME is a joint, or else `position[3]` and the like count the joints from 0; `any_field`: the
    joint has more fields than position, velocity and effort.
    """
    rest = text.partition(":")[2]
    if not is_joint_state or re.fullmatch(BY_NUMBER, rest):
        return Place(topic, "", dotted(rest))
    name, dot, last = rest.rpartition(".")
    if dot and (last in FIELDS or name == joint or any_field):
        return Place(topic, name, last)
    return Place(topic, rest or joint, field)
