"""Where the numbers and texts of one message stand in its bytes, and those of joints that it names."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.joint_messages import DYNAMIC_JOINT_STATE, FOXGLOVE_JOINT_STATES
from flex_ident.recording import Floats

STAMPS = ("header.stamp", "stamp", "timestamp")
LATEST_S = 2.0**33
"""Seconds of a stamp, or its nanoseconds, at most: more than ROS can write."""
CLOCKS = (("sec", "nanosec"), ("seconds", "nanos"), ("sec", "nsec"), ("secs", "nsecs"))
"""Names of a stamp's seconds and nanoseconds: ROS 2, protobuf, Foxglove, ROS 1."""


@dataclass(frozen=True)
class Numbers:
    """`count` numbers of numpy's type `dtype` in a row at byte `offset`."""

    offset: int
    dtype: str
    count: int

    def of(self, rows: NDArray[np.uint8]) -> Floats:
        """Their values (k, count) in the messages `rows` (k, bytes)."""
        stop = self.offset + self.count * np.dtype(self.dtype).itemsize
        values: Floats = (
            np.ascontiguousarray(rows[:, self.offset : stop]).view(self.dtype).astype(np.float64, copy=False)
        )
        return values

    def element(self, index: int) -> Numbers:
        """The one of number `index`."""
        return Numbers(self.offset + np.dtype(self.dtype).itemsize * index, self.dtype, 1)


@dataclass(frozen=True)
class Scattered:
    """Numbers that stand apart, in the order of the joints that they belong to; None: a joint has none."""

    elements: tuple[Numbers | None, ...]

    @property
    def count(self) -> int:
        """How many there are, with those that are missing."""
        return len(self.elements)

    def of(self, rows: NDArray[np.uint8]) -> Floats:
        """Their values (k, count) in the messages `rows` (k, bytes), NaN where a joint has none."""
        missing = np.full((rows.shape[0], 1), np.nan)
        return np.hstack([missing if element is None else element.of(rows) for element in self.elements])

    def element(self, index: int) -> Numbers | None:
        """The one of joint `index`."""
        return self.elements[index]


@dataclass(frozen=True)
class Layout:
    """Numbers and texts of one message by their dotted path; `fixed` are the bytes that all its messages share."""

    length: int
    numbers: dict[str, Numbers | Scattered]
    texts: dict[str, str]
    fixed: NDArray[np.intp]
    expected: NDArray[np.uint8]

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Joint names, in order, when it is a JointState's."""
        return tuple(text for path, text in self.texts.items() if path.startswith("name."))

    def fits(self, rows: NDArray[np.uint8]) -> NDArray[np.bool_]:
        """Which (k,) of the messages `rows` (k, length) have this layout."""
        fits: NDArray[np.bool_] = (rows[:, self.fixed] == self.expected).all(axis=1)
        return fits

    def stamps(self, rows: NDArray[np.uint8]) -> NDArray[np.int64]:
        """Header stamps (k,), ns; zero where the message has none, or none that can be."""
        for stamp in STAMPS:
            for whole, rest in CLOCKS:
                seconds, nanoseconds = self.numbers.get(f"{stamp}.{whole}"), self.numbers.get(f"{stamp}.{rest}")
                if seconds is not None and nanoseconds is not None:
                    parts = np.column_stack([part.of(rows)[:, 0] for part in (seconds, nanoseconds)])
                    parts[~(np.abs(parts) < LATEST_S).all(axis=1)] = 0.0
                    stamps: NDArray[np.int64] = parts.astype(np.int64) @ np.array((1_000_000_000, 1))
                    return stamps
        return np.zeros(rows.shape[0], np.int64)


def with_joints(layout: Layout, message_type: str) -> Layout:
    """The layout with each joint's numbers as a JointState has them, where the message type holds them otherwise."""
    joints: list[tuple[str, dict[str, Numbers | None]]] = []
    if message_type == DYNAMIC_JOINT_STATE:
        joints = [(name, _interfaces(layout, i)) for i, name in _listed(layout, "joint_names.{}")]
    elif message_type == FOXGLOVE_JOINT_STATES:
        fields_of = _fields(layout)
        joints = [(name, fields_of.get(str(i), {})) for i, name in _listed(layout, "joints.{}.name")]
    if not joints:
        return layout
    fields = dict.fromkeys(field for _, own in joints for field in own)
    numbers = {field: Scattered(tuple(own.get(field) for _, own in joints)) for field in fields}
    texts = {f"name.{i}": name for i, (name, _) in enumerate(joints)}
    return replace(layout, numbers={**layout.numbers, **numbers}, texts={**layout.texts, **texts})


def _listed(layout: Layout, pattern: str) -> list[tuple[int, str]]:
    found: list[tuple[int, str]] = []
    while (text := layout.texts.get(pattern.format(len(found)))) is not None:
        found.append((len(found), text))
    return found


def _interfaces(layout: Layout, joint: int) -> dict[str, Numbers | None]:
    values = layout.numbers.get(f"interface_values.{joint}.values")
    names = _listed(layout, f"interface_values.{joint}.interface_names.{{}}")
    return {} if values is None else {name: values.element(j) for j, name in names if j < values.count}


def _fields(layout: Layout) -> dict[str, dict[str, Numbers | None]]:
    """The single numbers `joints.NUMBER.FIELD` by number and field."""
    found: dict[str, dict[str, Numbers | None]] = {}
    for path, numbers in layout.numbers.items():
        head, _, rest = path.partition(".")
        joint, _, name = rest.partition(".")
        if head == "joints" and name and numbers.count == 1:
            found.setdefault(joint, {})[name] = numbers.element(0)
    return found
