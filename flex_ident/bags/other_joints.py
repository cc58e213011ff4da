"""The other joints of the recording: which there are beside the one to identify, and where they were."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence

import numpy as np

from flex_ident.bags.decoding import message_layouts
from flex_ident.bags.messages import Topic
from flex_ident.bags.motions import HELD, is_joint_state, link_names, motor_names
from flex_ident.bags.selection import Place
from flex_ident.bags.storage import Bag
from flex_ident.notices import Code, Notice
from flex_ident.recording import Floats, Signal
from flex_ident.recording.cleaning import measurable
from flex_ident.recording.clocks import RawSignal
from flex_ident.recording.stillness import is_held

MOST = 64
"""Joints of one topic that are looked at."""
FEWEST = 16
"""Positions below which nobody can say whether a joint moved."""
Track = tuple[Floats, Floats]
"""Times (k,), s, on the axis of the recording's signals, and positions (k,), rad or m."""


def other_places(bag: Bag, topics: Iterable[Topic], joints: Iterable[str]) -> list[Place]:
    """The positions of all joints in topics of joint states but those of these names, their motors and links."""
    own = {name for joint in dict.fromkeys(joints) for name in (*motor_names(joint), *link_names(joint))}
    layouts = {t.name: message_layouts(t, ros1=bag.ros1, size=bag.size) for t in topics if is_joint_state(t)}
    if not layouts:
        return []
    found: dict[str, list[str]] = {}
    for block in bag.blocks(frozenset(layouts)):
        if block.topic not in found:
            found[block.topic] = [name for layout, _, _ in layouts[block.topic](block) for name in layout.names]
        if len(found) == len(layouts):
            break
    return [Place(topic, name, "position") for topic in layouts for name in _kept(found.get(topic, []), own)]


def _kept(names: Sequence[str], own: Collection[str]) -> list[str]:
    """The first names that are neither the joint's own nor those of a link encoder."""
    links = {link for joint in dict.fromkeys(names) for link in link_names(joint)}
    return [name for name in dict.fromkeys(names) if name not in own and name not in links][:MOST]


def tracks(raw: Mapping[str, RawSignal], motor: Signal, origin: float) -> dict[str, Track]:
    """Where the joints that moved were, by name; `origin` of the motor's time axis, s.

    A joint that moves less than a fiftieth of the one that moves most is held, and shakes.
    """
    found: dict[str, Track] = {}
    for name, own in raw.items():
        stamps = own.stamps if motor.clock == "header" else own.received
        time = (stamps - round(origin * 1e9)).astype(np.float64) * 1e-9
        good = measurable(own.values) & (stamps > 0)
        time, values = time[good], own.values[good]
        keep = np.diff(np.maximum.accumulate(time), prepend=-np.inf) > 0.0
        time, values = time[keep], values[keep]
        if values.size >= FEWEST and not is_held(values):
            found[name] = (time, np.unwrap(values))
    ranges = {name: float(np.ptp(values)) for name, (_, values) in found.items()}
    most = max((*ranges.values(), float(np.ptp(motor.values))), default=0.0)
    return {name: track for name, track in found.items() if ranges[name] > HELD * most}


def poses(raw: Mapping[str, RawSignal]) -> dict[str, float]:
    """Where joints were on average, rad or m, by name: those that moved and those that did not."""
    good = {name: own.values[measurable(own.values)] for name, own in raw.items()}
    return {name: float(np.mean(values)) for name, values in good.items() if values.size}


def moved_notice(others: Mapping[str, Track]) -> Notice | None:
    """That other joints moved, how many, and which; None where none did."""
    if not others:
        return None
    return Notice(Code.OTHER_JOINTS_MOVE, "", {"count": len(others)}, {"joints": ", ".join(others)})
