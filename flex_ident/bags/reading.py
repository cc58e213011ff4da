"""From a bag and a selection to the joint's recording."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.fields import FieldDecoder
from flex_ident.bags.joint_states import JOINT_STATE, JointStateDecoder, JointStates
from flex_ident.bags.messages import Topic
from flex_ident.bags.selection import JOINT_STATES, LINK_TOPICS, REFERENCE_TOPIC, Place, SignalSelection, place_of
from flex_ident.bags.storage import Bag
from flex_ident.errors import ExcitationError, SignalError
from flex_ident.recording import Floats, Notice, Recording, Signal
from flex_ident.recording.alignment import aligned_recording
from flex_ident.recording.cleaning import cleaned_signal, usable_stamps
from flex_ident.recording.recording import Role

Progress = Callable[[float], None]
HELD = 0.02
"""A joint that moves less than this share of the one that moves most counts as held."""
STILL = 1e-6
"""A range of positions, rad or m, below which nothing moved."""


@dataclass
class JointMotion:
    """What one joint of a topic did: messages, range of its position, largest effort."""

    topic: str
    name: str
    messages: int = 0
    low: float = np.inf
    high: float = -np.inf
    largest_effort: float = 0.0
    link: bool = False

    @property
    def range(self) -> float:
        """Range of positions, rad or m; 0 when it has none."""
        return max(0.0, self.high - self.low) if np.isfinite(self.high - self.low) else 0.0


@dataclass
class _Channel:
    received: list[NDArray[np.int64]] = field(default_factory=list)
    stamps: list[NDArray[np.int64]] = field(default_factory=list)
    values: list[Floats] = field(default_factory=list)

    def add(self, received: NDArray[np.int64], stamps: NDArray[np.int64], values: Floats) -> None:
        self.received.append(received)
        self.stamps.append(stamps)
        self.values.append(np.array(values, np.float64))

    def joined(self) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
        if not self.values:
            empty = np.zeros(0, np.int64)
            return empty, empty, np.zeros(0)
        return np.concatenate(self.received), np.concatenate(self.stamps), np.concatenate(self.values)


def joint_state_topics(topics: Iterable[Topic]) -> list[str]:
    """Topics of joint states, the robot's own first."""
    names = [t.name for t in topics if _is_joint_state(t) and t.name != REFERENCE_TOPIC]
    return sorted(names, key=lambda n: (n != JOINT_STATES, n in LINK_TOPICS, not n.endswith("joint_states"), n))


def _is_joint_state(topic: Topic) -> bool:
    return topic.message_type in (JOINT_STATE, "sensor_msgs/JointState")


def joint_motions(path: Path) -> list[JointMotion]:
    """What each joint in the bag did, topic by topic. Raises BagError."""
    with Bag(path) as bag:
        return _motions(bag, joint_state_topics(bag.topics()))


def _motions(bag: Bag, topics: list[str]) -> list[JointMotion]:
    decoders = {name: JointStateDecoder(ros1=bag.ros1) for name in topics}
    found: dict[tuple[str, str], JointMotion] = {}
    for block in bag.blocks(frozenset(topics)):
        for states in decoders[block.topic](block):
            for i, name in enumerate(states.names):
                motion = found.setdefault((block.topic, name), JointMotion(block.topic, name))
                motion.messages += states.received.size
                position, effort = states.position[:, i], states.effort[:, i]
                if np.isfinite(position).any():
                    motion.low = min(motion.low, float(np.nanmin(position)))
                    motion.high = max(motion.high, float(np.nanmax(position)))
                if np.isfinite(effort).any():
                    motion.largest_effort = max(motion.largest_effort, float(np.nanmax(np.abs(effort))))
    names = {name for _, name in found}
    for (topic, name), motion in found.items():
        motion.link = topic in LINK_TOPICS or any(name in _link_names(other) for other in names if other != name)
    return list(found.values())


def _link_names(joint: str) -> tuple[str, ...]:
    """Names under which the same message may hold the link side of a joint."""
    stem = joint
    for suffix in ("_motor", "/motor", "_motor_side"):
        stem = stem.removesuffix(suffix)
    names = [f"{stem}_link", f"{stem}/link", f"{stem}_link_side", f"{stem}_output", f"{stem}_secondary"]
    return tuple(n for n in names if n != joint)


def listed(motions: Iterable[JointMotion]) -> str:
    """Joints and how much each moved, for a message."""
    return ", ".join(f"{m.name} ({m.range:.3g})" for m in motions)


def _chosen_joint(motions: list[JointMotion], path: Path) -> str:
    """The only joint that moves. Raises SignalError or ExcitationError, listing the joints."""
    sides = [m for m in motions if not m.link]
    if not sides:
        raise SignalError(f"{path}: no joint in any joint_states topic.")
    most = max(m.range for m in sides)
    if most < STILL:
        raise ExcitationError(f"no joint moved: {listed(sides)} in rad or m. Record while the joint follows a chirp.")
    moving = [m for m in sides if m.range > HELD * most]
    if len(moving) > 1:
        raise SignalError(f"{len(moving)} joints moved: name one with --joint. Range of each: {listed(sides)}.")
    return moving[0].name


def _resolved_joint(joint: str, motions: list[JointMotion]) -> str:
    """The name in the bag: as given, or with `_motor` behind it. Raises SignalError that lists the joints."""
    names = [m.name for m in motions]
    for name in (joint, f"{joint}_motor", f"{joint}/motor"):
        if name in names:
            return name
    raise SignalError(f"no joint '{joint}' in the recording: it has {listed(m for m in motions if not m.link)}.")


def _places(
    selection: SignalSelection, joint: str, topics: dict[str, Topic], motions: list[JointMotion], main: str
) -> dict[Role, Place]:
    def given(text: str, name: str) -> Place:
        topic = text.partition(":")[0]
        topic = topic if topic.startswith("/") else f"/{topic}"
        if topic not in topics:
            raise SignalError(f"no topic '{topic}' in the recording: it has {', '.join(sorted(topics))}.")
        return place_of(text, joint=joint, field=name, is_joint_state=_is_joint_state(topics[topic]))

    places: dict[Role, Place] = {
        "motor_position": given(selection.motor_position or main, "position"),
        "motor_torque": given(selection.effort or main, "effort"),
    }
    if selection.sensors != "motor":
        found = given(selection.link_position, "position") if selection.link_position else None
        found = found or _link_place(joint, motions, main)
        if found is not None:
            places["link_position"] = found
        elif selection.sensors == "motor+link":
            raise SignalError(f"no link position of {joint} in the recording: name one with --link-position.")
    if selection.reference:
        places["reference"] = given(selection.reference, "position")
    elif REFERENCE_TOPIC in topics:
        places["reference"] = Place(REFERENCE_TOPIC, joint, "position")
    return places


def _link_place(joint: str, motions: list[JointMotion], main: str) -> Place | None:
    names = _link_names(joint)
    for motion in motions:
        if motion.topic == main and motion.name in names and motion.range > 0.0:
            return Place(main, motion.name, "position")
    for motion in motions:
        if motion.topic in LINK_TOPICS and motion.name in (joint, *names) and motion.range > 0.0:
            return Place(motion.topic, motion.name, "position")
    return None


def read_recording(
    path: Path, selection: SignalSelection | None = None, *, progress: Progress | None = None
) -> Recording:
    """The joint's recording on one uniform clock. Raises BagError, SignalError, ExcitationError and UsageError."""
    selection = selection or SignalSelection()
    with Bag(path) as bag:
        topics = {t.name: t for t in bag.topics()}
        joint_topics = joint_state_topics(topics.values())
        motions = _motions(bag, joint_topics) if joint_topics else []
        if progress is not None:
            progress(0.4)
        main = next((t for t in joint_topics if t not in LINK_TOPICS), None)
        if main is None and selection.motor_position is None:
            raise SignalError(
                f"{path}: no joint_states topic: it has {', '.join(sorted(topics)) or 'no topic at all'}."
            )
        main = main or ""
        here = [m for m in motions if m.topic == main]
        joint = selection.joint
        if joint is None and main:
            joint = _chosen_joint(here, path)
        elif joint is not None and main and selection.motor_position is None:
            joint = _resolved_joint(joint, here)
        joint = joint or "joint"
        places = _places(selection, joint, topics, motions, main)
        channels = _channels(bag, places, topics)
        if progress is not None:
            progress(0.8)
        signals, notices, origin = _signals(channels, places, selection, joint)
        notices = [*bag.notices(), *notices]
        _check_signals(signals, joint)
        return aligned_recording(
            signals, joint=joint, notices=notices, path=str(path), sha256=bag.sha256(), start_time_s=origin
        )


def _channels(bag: Bag, places: dict[Role, Place], topics: dict[str, Topic]) -> dict[Role, _Channel]:
    channels: dict[Role, _Channel] = {role: _Channel() for role in places}
    joint_states = {
        p.topic: JointStateDecoder(ros1=bag.ros1) for p in places.values() if _is_joint_state(topics[p.topic])
    }
    fields = {
        role: FieldDecoder(topics[p.topic], p.field, ros1=bag.ros1)
        for role, p in places.items()
        if p.topic not in joint_states
    }
    for block in bag.blocks(frozenset(p.topic for p in places.values())):
        states = joint_states[block.topic](block) if block.topic in joint_states else []
        for role, place in places.items():
            if place.topic != block.topic:
                continue
            if role in fields:
                channels[role].add(*fields[role](block))
                continue
            for s in states:
                if place.name in s.names:
                    channels[role].add(s.received, s.stamps, _column(s, place))
    return channels


def _column(states: JointStates, place: Place) -> Floats:
    values: Floats = getattr(states, place.field)[:, states.names.index(place.name)]
    return values


def _signals(
    channels: dict[Role, _Channel], places: dict[Role, Place], selection: SignalSelection, joint: str
) -> tuple[list[Signal], list[Notice], float]:
    """The signals in SI on one time axis, what was dropped, and that axis' origin, s."""
    factor: dict[Role, float] = {"motor_position": 1.0 / selection.gear_ratio, "motor_torque": selection.effort_scale}
    joined = {role: channel.joined() for role, channel in channels.items()}
    received, stamps, _ = joined["motor_position"]
    if received.size == 0:
        raise SignalError(f"{places['motor_position'].source} holds no messages.")
    headed = usable_stamps(stamps)
    origin = int(stamps[0] if headed else received[0])
    # Signals without a stamp are shifted by the usual time from stamp to reception, so that all share one axis.
    latency = int(np.median(received - stamps)) if headed else 0
    signals, notices = [], []
    for role, (got, stamped, values) in joined.items():
        if role == "reference" and not np.isfinite(values).any():
            continue
        own = headed and usable_stamps(stamped)
        clock: Literal["header", "receive"] = "header" if own else "receive"
        time: Floats = ((stamped if own else got - latency) - origin).astype(np.float64) * 1e-9
        order = np.argsort(got, kind="stable") if not bool(np.all(np.diff(got) >= 0)) else slice(None)
        signal, dropped = cleaned_signal(
            role, places[role].source, clock, time[order], values[order] * factor.get(role, 1.0)
        )
        signals.append(signal)
        notices += dropped
    if len({s.clock for s in signals if s.role != "reference"}) > 1:
        mixed = ", ".join(f"{s.source} ({s.clock})" for s in signals)
        notices.append(
            Notice("mixed_clocks", f"not all signals of {joint} carry a stamp: {mixed}; received times were shifted "
                   f"by the usual latency of {latency * 1e-6:.2f} ms.")
        )  # fmt: skip
    return signals, notices, origin * 1e-9


def _check_signals(signals: list[Signal], joint: str) -> None:
    by_role = {s.role: s for s in signals}
    motor, torque = by_role["motor_position"], by_role["motor_torque"]
    moved = float(np.ptp(motor.values))
    if moved < STILL:
        raise ExcitationError(f"joint {joint} does not move: its position spans {moved:.2g} rad. Record it in motion.")
    if not torque.values.any():
        raise SignalError(f"{torque.source} is zero throughout: name the effort's signal with --effort.")
    if float(np.ptp(torque.values)) == 0.0:
        raise SignalError(f"{torque.source} is constant at {torque.values[0]:.4g}: name the effort with --effort.")
