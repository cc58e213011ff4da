"""`flex_ident check-bag`: what a bag holds, how well it was recorded, and whether a joint can be identified from it.

What looks at joints is imported when there is a topic to look at: a file that is no recording is refused at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from flex_ident.bags.messages import Topic
from flex_ident.bags.selection import SignalSelection
from flex_ident.bags.storage import Bag
from flex_ident.commands.check_tables import first_rows, messages_text
from flex_ident.errors import FlexIdentError, SignalError
from flex_ident.notices import Notice
from flex_ident.report.sentences import sentence

if TYPE_CHECKING:
    from flex_ident.bags.motions import JointMotion

MOST_SHOWN = 64
"""Joints that are looked at one by one."""


def checked_bag(path: Path, selection: SignalSelection) -> str:
    """A page about the bag. Raises BagError when it cannot be opened."""
    return bag_check(path, selection)[0]


def bag_check(path: Path, selection: SignalSelection) -> tuple[str, FlexIdentError | None]:
    """A page about the bag, and the error that stands in the way when no joint can be identified from it.

    Without a joint in `selection`, each joint that moves is looked at. Raises BagError when the bag cannot be opened.
    """
    with Bag(path) as bag:
        topics, files, damage = bag.topics(), len(bag.files), bag.damage()
        try:
            bag.refuse_empty()
        except SignalError as nothing:
            return _contents(path, files, topics, damage), nothing
    from flex_ident.bags.motions import joint_motions

    motions = joint_motions(path)
    from flex_ident.commands.check_joints import joint_check, joints_to_check, motions_text, why_none

    parts = [_contents(path, files, _counted(topics, motions), damage), motions_text(motions)]
    joints = joints_to_check(selection, motions)
    errors: list[FlexIdentError] = []
    if not joints:
        errors.append(why_none(motions))
        parts.append(f"cannot be identified: {errors[-1]}")
    if len(joints) > MOST_SHOWN:
        parts.append(f"{len(joints)} joints move: of the first {MOST_SHOWN}:")
    for joint in joints[:MOST_SHOWN]:
        text, error = joint_check(path, replace(selection, joint=joint))
        parts.append(text)
        if error is not None:
            errors.append(error)
    none_fits = len(errors) >= max(1, len(joints[:MOST_SHOWN]))
    return "\n\n".join(part for part in parts if part), errors[0] if none_fits else None


def _counted(topics: Sequence[Topic], motions: Sequence[JointMotion]) -> list[Topic]:
    """Topics with the messages that were met, where the bag, cut or unfinished, does not say how many it holds."""
    met: dict[str, int] = {}
    for motion in motions:
        met[motion.topic] = max(motion.messages, met.get(motion.topic, 0))
    return [replace(t, count=met.get(t.name)) if t.count is None else t for t in topics]


def _contents(path: Path, files: int, topics: Sequence[Topic], damage: Sequence[Notice]) -> str:
    rows = [
        (topic.name, topic.message_type, "" if topic.count is None else messages_text(topic.count))
        for topic in sorted(topics, key=lambda t: t.name)
    ]
    lines = [f"{path}: {files} file{'s' if files > 1 else ''}", *first_rows(rows)]
    return "\n".join([*lines, *(f"  damage: {sentence(notice)}" for notice in damage)])
