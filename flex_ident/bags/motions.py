"""What each joint of a bag did: how the joint to identify is found, and what a message lists when it is not."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.decoding import message_layouts
from flex_ident.bags.joint_messages import DYNAMIC_JOINT_STATE, JOINT_STATES_BY_NAME
from flex_ident.bags.layouts import joint_numbers
from flex_ident.bags.message_numbers import Layout
from flex_ident.bags.messages import Topic
from flex_ident.bags.namings import UnlikelyTopicError
from flex_ident.bags.selection import JOINT_STATES, is_link_topic, is_reference_topic
from flex_ident.bags.storage import Bag
from flex_ident.errors import ExcitationError, SignalError
from flex_ident.recording import Floats
from flex_ident.recording.cleaning import measurable
from flex_ident.recording.names import first_of
from flex_ident.recording.stillness import FEW_STEPS, STILL, UNRELATED, WANDERING, still_error

HELD = 0.02
"""A joint that moves less than this share of the one that moves most counts as held."""
FEWEST = 3
"""Messages below which one cannot say whether a joint moved."""
GROUP, OUTLIERS = 8, 2
"""Of so many positions in a row, so many at either end say nothing of how far a joint moved: they may be outliers."""

TOGETHER = 1 << 17
"""Positions, and as many efforts, that wait to be taken in together."""
MOST_TOPICS = 512
"""Topics of joint states in which joints are looked for."""
MOST_LISTED = 24
"""Joints that a message lists."""


@dataclass
class JointMotion:
    """What one joint of a topic did: messages, range of its position, largest effort; `link`: a link encoder's."""

    topic: str
    name: str
    messages: int = 0
    low: float = np.inf
    high: float = -np.inf
    largest_effort: float = 0.0
    link: bool = False
    _left: Floats = field(default_factory=lambda: np.zeros(0), repr=False, compare=False)
    """Positions that wait for others to make a group."""
    smallest_step: float = np.inf
    """Smallest change of its position from one message to the next."""
    _fresh: int = 0
    _sums: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Sums over changed positions: their distance from the first one met, its square, and that of each change."""
    _origin: float = np.nan
    _last: float = np.nan

    @property
    def range(self) -> float:
        """Range of positions, rad or m, single outliers left out; 0 when it has none."""
        if not np.isfinite(self.low):
            return float(np.ptp(self._left)) if self._left.size else 0.0
        return self.high - self.low if self.high > self.low else 0.0

    @property
    def moves(self) -> bool:
        """Whether it does more than noise, or the last digits of its encoder: see `recording.stillness`."""
        if self.range < STILL or self.range < FEW_STEPS * self.smallest_step:
            return False
        total, squares, changes = self._sums
        variance = squares / self._fresh - (total / self._fresh) ** 2 if self._fresh else 0.0
        return self.range > WANDERING or changes < 2.0 * UNRELATED * variance * self._fresh

    @property
    def has_position(self) -> bool:
        """Whether any of its positions is a number that may have been measured."""
        return bool(np.isfinite(self.low)) or self._left.size > 0

    def add(self, position: Floats, effort: Floats) -> None:
        """Take in further messages, (k,) each."""
        self.messages += position.size
        position, effort = position[measurable(position)], np.abs(effort[measurable(effort)])
        fresh = position
        if self._left.size:
            position = np.concatenate((self._left, position))
        whole = position.size // GROUP * GROUP
        self._left = position[whole:].copy()
        if whole:
            groups = np.partition(position[:whole].reshape(-1, GROUP), (OUTLIERS, -1 - OUTLIERS), axis=1)
            self.low = min(self.low, float(groups[:, OUTLIERS].min()))
            self.high = max(self.high, float(groups[:, -1 - OUTLIERS].max()))
        if fresh.size:
            self._follow(fresh)
        if effort.size:
            self.largest_effort = max(self.largest_effort, float(effort.max()))

    def _follow(self, position: Floats) -> None:
        if np.isnan(self._origin):
            self._origin = self._last = float(position[0])
        steps = np.abs(np.diff(position, prepend=self._last))
        changed = steps > 0.0
        self._last = float(position[-1])
        if changed.any():
            away, steps = position[changed] - self._origin, steps[changed]
            self.smallest_step = min(self.smallest_step, float(steps.min()))
            self._fresh += away.size
            added = (float(away.sum()), float(away @ away), float(steps @ steps))
            self._sums = (self._sums[0] + added[0], self._sums[1] + added[1], self._sums[2] + added[2])


class _Motions:
    """The motions of a topic's joints, which take in many messages at once."""

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self._found: dict[str, JointMotion] = {}
        self._waiting: dict[tuple[str, ...], list[tuple[Floats, Floats]]] = {}
        """Positions and efforts (k, joints) by the joints' names."""
        self._numbers = 0

    def take(self, layout: Layout, rows: NDArray[np.uint8]) -> None:
        """Take in the messages `rows` of one layout."""
        names = layout.names
        nothing = np.full((rows.shape[0], len(names)), np.nan)
        position, effort = (joint_numbers(layout, f, len(names)) for f in ("position", "effort"))
        positions = nothing if position is None else position.of(rows)
        efforts = nothing if effort is None else effort.of(rows)
        # Copies: what waits is not to keep the whole chunk in memory that it came from.
        self._waiting.setdefault(names, []).append((positions.copy(), efforts.copy()))
        self._numbers += positions.size + rows.shape[0]
        if self._numbers > TOGETHER:
            self._add()

    def all(self) -> list[JointMotion]:
        """The motion of each joint."""
        self._add()
        return list(self._found.values())

    def _add(self) -> None:
        for names, pieces in self._waiting.items():
            positions, efforts = (np.concatenate(columns) for columns in zip(*pieces, strict=True))
            for i, name in enumerate(names):
                motion = self._found.setdefault(name, JointMotion(self._topic, name))
                motion.add(positions[:, i], efforts[:, i])
        self._waiting.clear()
        self._numbers = 0


def is_joint_state(topic: Topic) -> bool:
    """Whether the topic's messages hold joints by name, each with position, velocity and effort."""
    return topic.message_type in JOINT_STATES_BY_NAME


def joint_state_topics(topics: Iterable[Topic]) -> list[str]:
    """Topics of joint states, the robot's own first; those of ros2_control's other type where there are no others.

    No more than MOST_TOPICS.
    """
    found = [t for t in topics if is_joint_state(t) and not is_reference_topic(t.name)]
    plain = [t.name for t in found if t.message_type != DYNAMIC_JOINT_STATE]
    return sorted(
        plain or [t.name for t in found],
        key=lambda n: (f"/{n.lstrip('/')}" != JOINT_STATES, is_link_topic(n), not n.endswith("joint_states"), n),
    )[:MOST_TOPICS]


def joint_motions(path: Path) -> list[JointMotion]:
    """What each joint in the bag did, topic by topic. Raises BagError."""
    with Bag(path) as bag:
        return motions_of(bag, joint_state_topics(bag.topics()))


def motions_of(bag: Bag, topics: Iterable[str]) -> list[JointMotion]:
    """What each joint of some topics of joint states did."""
    known = {t.name: t for t in bag.topics()}
    layouts = {name: message_layouts(known[name], ros1=bag.ros1, size=bag.size) for name in topics}
    found: dict[str, _Motions] = {name: _Motions(name) for name in layouts}
    refused: dict[str, UnlikelyTopicError] = {}
    for block in bag.blocks(frozenset(layouts)):
        if block.topic in refused:
            continue
        try:
            for layout, rows, _ in layouts[block.topic](block):
                found[block.topic].take(layout, rows)
        except UnlikelyTopicError as error:
            refused[block.topic] = error
    motions = [m for name, own in found.items() if name not in refused for m in own.all()]
    if refused and not motions:
        raise next(iter(refused.values()))
    links = {link for name in {m.name for m in motions} for link in link_names(name)}
    for motion in motions:
        motion.link = is_link_topic(motion.topic) or motion.name in links
    return motions


def link_names(joint: str) -> tuple[str, ...]:
    """Names under which the same message may hold the link side of a joint."""
    stem = joint
    for suffix in ("_motor", "/motor", "_motor_side"):
        stem = stem.removesuffix(suffix)
    names = [f"{stem}_link", f"{stem}/link", f"{stem}_link_side", f"{stem}_output", f"{stem}_secondary"]
    return tuple(n for n in names if n != joint)


def motor_names(joint: str) -> tuple[str, ...]:
    """Names under which the motor side of a joint may be recorded, the likeliest first."""
    return (joint, f"{joint}_motor", f"{joint}/motor", f"{joint}_motor_side")


def listed(motions: Iterable[JointMotion]) -> str:
    """Joints and how much each moved, for a message."""
    ranges = ((m.name, f"{m.range:.3g}" if m.has_position else "no number") for m in motions)
    return first_of([f"{name} ({text})" for name, text in ranges], MOST_LISTED) or "none"


def moving_joint(motions: Iterable[JointMotion]) -> str:
    """The only joint that moves. Raises SignalError or ExcitationError, listing the joints."""
    sides = [m for m in motions if not m.link]
    if not sides:
        raise SignalError("no joint in any joint_states topic: name the motor position with --motor-position.")
    longest = max(m.messages for m in sides)
    if longest < FEWEST:
        count = f"{longest} message{'s' if longest > 1 else ''}"
        raise ExcitationError(f"{count} of joint states in all: record at least ten seconds of motion.")
    most = max((m.range for m in sides if m.moves), default=0.0)
    empty = [m.name for m in sides if not m.has_position]
    if most < STILL and empty:
        others = f", and no other joint moved: {listed(sides)}" if len(empty) < len(sides) else ""
        raise SignalError(
            f"the position of {first_of(empty, MOST_LISTED)} holds no finite number in {longest} messages"
            f"{others}. Name the motor position with --motor-position."
        )
    if most < STILL:
        if len(sides) == 1 and sides[0].range > 0.0:
            raise still_error(sides[0].name, sides[0].range)
        raise ExcitationError(f"no joint moved: {listed(sides)} in rad or m. Record while the joint follows a chirp.")
    moving = [m for m in sides if m.moves and m.range > HELD * most]
    if len(moving) > 1:
        raise SignalError(f"{len(moving)} joints moved: name one with --joint. Range of each: {listed(sides)}.")
    return moving[0].name
