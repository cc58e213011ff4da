"""Messages that are decoded one by one (JSON, protobuf), as rows of numbers of one layout."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.layouts import REMEMBERED
from flex_ident.bags.message_numbers import Layout, Numbers, with_joints
from flex_ident.bags.messages import Block, Topic
from flex_ident.bags.namings import Namings
from flex_ident.recording.names import harmless

LARGEST = 1 << 22
"""Bytes of one message, at most."""
MOST_VALUES = 1 << 16
"""Numbers and texts of one message, at most."""
TOGETHER = 1 << 20
"""Numbers of messages that are kept together, at most."""
NUMBER_BYTES = 8


@dataclass
class Flat:
    """One message: runs of numbers and single texts by their dotted path. Raises ValueError when it grows too large."""

    numbers: dict[str, list[float]] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)
    size: int = 0

    def add(self, value: Any, path: str) -> None:
        """Take in a value with all that is within it; what is neither number nor text is passed over."""
        if isinstance(value, dict):
            for key, inner in value.items():
                self.add(inner, f"{path}.{key}" if path else str(key))
        elif isinstance(value, list):
            self._row(value, path)
        elif isinstance(value, str):
            self._count(1)
            self.texts[path] = harmless(value)
        elif value is None or isinstance(value, (int, float)):
            self._count(1)
            self.numbers[path] = [_number(value)]

    def _row(self, values: list[Any], path: str) -> None:
        self._count(len(values))
        if all(value is None or isinstance(value, (int, float)) for value in values):
            self.numbers[path] = [_number(value) for value in values]
            return
        for i, value in enumerate(values):
            self.add(value, f"{path}.{i}")

    def _count(self, size: int) -> None:
        self.size += size
        if self.size > MOST_VALUES:
            raise ValueError("more values than a message has room for")


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)


Decoder = Callable[[bytes], Flat]
"""What a message's bytes hold. Raises ValueError, KeyError or RecursionError for damaged ones."""


class FlatLayouts:
    """Sorts the messages of one topic by what numbers and names they hold."""

    def __init__(self, topic: Topic, decoder: Decoder) -> None:
        self._topic, self._decoder = topic, decoder
        self.versions: tuple[Any, ...] = ()
        """None: what there is shows in the messages alone."""
        self.damaged = 0
        self.named = Namings(topic.name)
        self._layouts: dict[tuple[Any, ...], Layout] = {}

    def tell_apart(self, key: str) -> None:
        """Nothing: texts under a key named or ending in `name` or `names` tell layouts apart anyway."""

    def __call__(self, block: Block) -> Iterator[tuple[Layout, NDArray[np.uint8], NDArray[np.int64]]]:
        """The block's messages, layout by layout: the layout, rows (k, bytes), their places (k,) in the block."""
        groups: dict[tuple[Any, ...], tuple[Layout, list[list[float]], list[int]]] = {}
        kept = 0
        for i in range(block.lengths.size):
            flat = self._decoded(block, i)
            if flat is None:
                self.damaged += 1
                continue
            sizes = tuple((path, len(values)) for path, values in flat.numbers.items())
            names = tuple((path, text) for path, text in flat.texts.items() if _is_name(path))
            if (sizes, names) not in groups:
                groups[sizes, names] = (self._layout(sizes, names), [], [])
            _, rows, which = groups[sizes, names]
            rows.append([value for values in flat.numbers.values() for value in values])
            which.append(i)
            kept += len(rows[-1])
            if kept > TOGETHER:
                yield from self._joined(groups.values())
                groups, kept = {}, 0
        yield from self._joined(groups.values())

    def _joined(
        self, groups: Iterable[tuple[Layout, list[list[float]], list[int]]]
    ) -> Iterator[tuple[Layout, NDArray[np.uint8], NDArray[np.int64]]]:
        for layout, rows, which in groups:
            self.named.count(layout.names, len(which))
            values = np.array(rows, np.float64).reshape(len(which), -1)
            yield layout, values.view(np.uint8), np.array(which, np.int64)

    def _decoded(self, block: Block, i: int) -> Flat | None:
        if not 0 < block.lengths[i] <= LARGEST:
            return None
        try:
            return self._decoder(block.payload(i))
        except (ValueError, KeyError, TypeError, OverflowError, RecursionError):
            return None

    def _layout(self, sizes: tuple[tuple[str, int], ...], names: tuple[tuple[str, str], ...]) -> Layout:
        known = self._layouts.get((sizes, names))
        if known is not None:
            return known
        numbers, at = {}, 0
        for path, count in sizes:
            numbers[path] = Numbers(at, "<f8", count)
            at += NUMBER_BYTES * count
        nothing = np.zeros(0, np.intp)
        layout = with_joints(
            Layout(at, dict(numbers), dict(names), nothing, np.zeros(0, np.uint8)), self._topic.message_type
        )
        while len(self._layouts) >= REMEMBERED:
            del self._layouts[next(iter(self._layouts))]
        self._layouts[sizes, names] = layout
        return layout


def _is_name(path: str) -> bool:
    last = next((part for part in reversed(path.split(".")) if not part.isdigit()), "")
    return last.endswith(("name", "names"))
