"""Where the signals of a joint stand in a bag, as far as the user does not say."""

from __future__ import annotations

from dataclasses import dataclass

from flex_ident.bags.joint_messages import DYNAMIC_JOINT_STATE
from flex_ident.bags.messages import Topic
from flex_ident.bags.motions import (
    MOST_LISTED,
    JointMotion,
    is_joint_state,
    joint_state_topics,
    link_names,
    listed,
    motions_of,
    motor_names,
    moving_joint,
)
from flex_ident.bags.selection import Place, SignalSelection, is_link_topic, is_reference_topic, place_of, topic_of
from flex_ident.bags.storage import Bag
from flex_ident.errors import SignalError
from flex_ident.recording.names import first_of


@dataclass(frozen=True)
class SignalPlaces:
    """Where the signals of a joint of this name would stand; `links` in order of preference."""

    joint: str
    motor: Place
    torque: Place
    links: tuple[Place, ...]
    reference: Place | None
    current: Place | None = None

    def all(self) -> list[Place]:
        """Every place."""
        return [self.motor, self.torque, *self.links, *(p for p in (self.reference, self.current) if p is not None)]


class SignalFinder:
    """Turns a selection into places of one bag. Its methods raise SignalError, listing what there is."""

    def __init__(self, bag: Bag, selection: SignalSelection) -> None:
        bag.refuse_empty()
        self._bag, self._selection = bag, selection
        self.topics: dict[str, Topic] = {t.name: t for t in bag.topics()}
        named = joint_state_topics(self.topics.values())
        self._links = [name for name in named if is_link_topic(name)]
        self._states = [name for name in named if not is_link_topic(name)]
        self._reference = next((name for name in sorted(self.topics) if is_reference_topic(name)), None)

    def candidates(self) -> list[SignalPlaces]:
        """The places of each name that the joint may have, topic by topic, the likeliest first."""
        joint, motor = self._selection.joint, self._selection.motor_position
        if motor is not None:
            topic = self._known(motor)
            if not is_joint_state(self.topics[topic]):
                return [self._places(joint or "joint", next(iter(self._states), None))]
            joint = joint or self._place(motor, "", "position").name or self._moving([topic])[0]
            return [self._places(joint, topic)]
        if not self._states:
            raise SignalError(f"{self._bag.name}: no joint_states topic: it has {self._topic_names()}.")
        if joint is None:
            return [self._places(*self._moving(self._states))]
        return [self._places(name, topic) for topic in self._states for name in motor_names(joint)]

    def missing(self, places: SignalPlaces) -> SignalError:
        """The error of a motor position that holds no messages."""
        if not is_joint_state(self.topics[places.motor.topic]):
            return SignalError(f"{places.motor.source} holds no messages: name another signal.")
        topics = [places.motor.topic] if self._selection.motor_position else self._states
        there = listed(m for m in motions_of(self._bag, topics) if not m.link)
        return SignalError(f"no joint '{places.motor.name}' in {first_of(topics, MOST_LISTED)}: it has {there}.")

    def _moving(self, topics: list[str]) -> tuple[str, str]:
        """The only joint that moves in the first of the topics in which any does, and that topic."""
        motions = motions_of(self._bag, topics)
        sides: dict[str, list[JointMotion]] = {}
        for motion in motions:
            if not motion.link:
                sides.setdefault(motion.topic, []).append(motion)
        for topic in topics:
            if any(m.moves for m in sides.get(topic, [])):
                return moving_joint(sides[topic]), topic
        return moving_joint(motions), topics[0]

    def _topic_names(self) -> str:
        return first_of(sorted(self.topics), MOST_LISTED)

    def _known(self, text: str) -> str:
        topic = topic_of(text, self.topics)
        if topic not in self.topics:
            raise SignalError(f"no topic '{topic}' in the recording: it has {self._topic_names()}.")
        return topic

    def _place(self, text: str, joint: str, field: str) -> Place:
        topic = self.topics[self._known(text)]
        states, any_field = is_joint_state(topic), topic.message_type == DYNAMIC_JOINT_STATE
        return place_of(
            text, topic=topic.name, joint=joint, field=field, is_joint_state=states, any_field=any_field
        )  # fmt: skip

    def _places(self, joint: str, states: str | None) -> SignalPlaces:
        """The places of a joint of this name, by default in the topic `states`."""
        given = self._selection
        effort = given.effort or states
        if effort is None:
            there = self._topic_names()
            raise SignalError(f"no joint_states topic holds an effort: name its signal with --effort, of {there}.")
        reference = given.reference or self._reference
        return SignalPlaces(
            joint,
            self._place(given.motor_position or states or "", joint, "position"),
            self._place(effort, joint, "effort"),
            tuple(self._link_places(joint, states)),
            self._place(reference, joint, "position") if reference else None,
            self._place(given.motor_current, joint, "effort") if given.motor_current else None,
        )

    def _link_places(self, joint: str, states: str | None) -> list[Place]:
        given = self._selection
        if given.sensors == "motor":
            return []
        if given.link_position:
            return [self._place(given.link_position, joint, "position")]
        own = [Place(states, name, "position") for name in link_names(joint)] if states else []
        stems = dict.fromkeys((joint, *(joint.removesuffix(end) for end in ("_motor", "/motor", "_motor_side"))))
        return own + [Place(t, name, "position") for t in self._links for name in (*stems, *link_names(joint))]
