"""Where each signal is to be found, as the user says it: TOPIC[:NAME[.FIELD]]."""

from __future__ import annotations

from dataclasses import dataclass

from flex_ident.errors import UsageError

FIELDS = ("position", "velocity", "effort")
JOINT_STATES = "/joint_states"
REFERENCE = "/chirp_exciter/reference"
LINK_STATES = "/link_joint_states"


def is_link_topic(topic: str) -> bool:
    """Whether the topic, in whatever namespace, is where link encoders are published."""
    return topic.endswith(LINK_STATES)


def is_reference_topic(topic: str) -> bool:
    """Whether the topic, in whatever namespace, is the exciter's reference."""
    return topic.endswith(REFERENCE)


@dataclass(frozen=True)
class SignalSelection:
    """Which joint and signals to read; None: look for it. Raises UsageError on numbers that make no sense.

    `effort_scale` is N m per recorded unit of effort; `gear_ratio` motor turns per link turn, when the motor position
    is on the motor shaft. `sensors`: motor (the link position is not looked for), motor+link (it must be there), auto.
    """

    joint: str | None = None
    motor_position: str | None = None
    link_position: str | None = None
    effort: str | None = None
    reference: str | None = None
    effort_scale: float = 1.0
    gear_ratio: float = 1.0
    sensors: str = "auto"

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


def topic_of(text: str) -> str:
    """The topic that `text`, TOPIC[:NAME[.FIELD]], names. Raises UsageError when it names none."""
    topic = text.partition(":")[0]
    if not topic:
        raise UsageError(f"'{text}' names no topic: expected TOPIC[:NAME[.FIELD]].")
    return topic if topic.startswith("/") else f"/{topic}"


def place_of(text: str, *, joint: str, field: str, is_joint_state: bool) -> Place:
    """The place that `text` names; NAME and FIELD default to the joint and the role's `field`."""
    topic, rest = topic_of(text), text.partition(":")[2]
    if not is_joint_state:
        return Place(topic, "", rest)
    name, dot, last = rest.rpartition(".")
    if dot and last in FIELDS:
        return Place(topic, name, last)
    return Place(topic, rest or joint, field)
