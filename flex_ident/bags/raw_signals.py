"""Many places read in one pass over a bag."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.decoding import Layouts, message_layouts
from flex_ident.bags.messages import Block
from flex_ident.bags.places import PlaceReader
from flex_ident.bags.selection import Place
from flex_ident.bags.storage import Bag
from flex_ident.notices import Code, Notice
from flex_ident.recording import Floats
from flex_ident.recording.clocks import RawSignal


@dataclass
class _Gathered:
    """Pieces of one place's signal; places of one topic share the pieces of their times."""

    received: list[NDArray[np.int64]] = field(default_factory=list)
    stamps: list[NDArray[np.int64]] = field(default_factory=list)
    values: list[Floats] = field(default_factory=list)


def raw_signals(
    bag: Bag, places: Iterable[Place], *, progress: Callable[[float], None] | None = None
) -> tuple[dict[Place, RawSignal], list[Notice]]:
    """What each place held, messages in the order of the bag, and what could not be decoded.

    Raises SignalError when a topic's type is unknown or has no such field.
    """
    known = {t.name: t for t in bag.topics()}
    wanted = list(dict.fromkeys(places))
    layouts = {
        name: message_layouts(known[name], ros1=bag.ros1, size=bag.size)
        for name in dict.fromkeys(p.topic for p in wanted)
    }
    readers = {p: PlaceReader(p, known[p.topic], layouts[p.topic]) for p in wanted}
    gathered = {p: _Gathered() for p in wanted}
    total = sum(known[name].count or 0 for name in layouts)
    read = 0
    of_topic: dict[str, dict[Place, PlaceReader]] = {name: {} for name in layouts}
    for place, reader in readers.items():
        of_topic[place.topic][place] = reader
    for block in bag.blocks(frozenset(layouts)):
        _take(block, layouts[block.topic], of_topic[block.topic], gathered)
        read += block.received.size
        if progress is not None and total:
            progress(min(1.0, read / total))
    for place in wanted:
        readers[place].refuse_absent(layouts[place.topic])
    joiner = _Joiner()
    found = {place: joiner.signal(place, gathered[place]) for place in wanted}
    notices = [
        Notice(Code.BAG_DAMAGED, name, {"count": own.damaged}, {"case": "messages"})
        for name, own in layouts.items()
        if own.damaged
    ]
    notices += [
        Notice(Code.BAG_DAMAGED, name, {"count": own.named.misnamed}, {"case": "names"})
        for name, own in layouts.items()
        if own.named.misnamed
    ]
    return found, notices


def _take(block: Block, layouts: Layouts, readers: dict[Place, PlaceReader], gathered: dict[Place, _Gathered]) -> None:
    """Gather what the places of the block's topic hold in it."""
    groups: list[tuple[NDArray[np.int64], NDArray[np.int64]]] = []
    found: dict[Place, dict[int, Floats]] = {p: {} for p in readers}
    for layout, rows, which in layouts(block):
        for place in readers:
            if readers[place].holds(layout):
                number = readers[place].number(layout)
                found[place][len(groups)] = (
                    np.full(which.size, np.nan) if number is None else number.of(rows)[:, 0].copy()
                )
        groups.append((which, layout.stamps(rows)))
    times: dict[tuple[int, ...], tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]] = {}
    for place, own in found.items():
        if not own:
            continue
        if tuple(own) not in times:
            which = np.concatenate([groups[g][0] for g in own])
            order = np.argsort(which)  # layouts may take turns: back to the order of the bag
            stamps = np.concatenate([groups[g][1] for g in own])[order]
            times[tuple(own)] = order, block.received[which[order]], stamps
        order, received, stamps = times[tuple(own)]
        gathered[place].received.append(received)
        gathered[place].stamps.append(stamps)
        gathered[place].values.append(np.concatenate(list(own.values()))[order])


class _Joiner:
    """Joins pieces; the same pieces become the same array."""

    def __init__(self) -> None:
        self._done: dict[tuple[int, ...], NDArray[np.int64]] = {}

    def times(self, pieces: list[NDArray[np.int64]]) -> NDArray[np.int64]:
        key = tuple(map(id, pieces))
        if key not in self._done:
            self._done[key] = np.concatenate(pieces) if pieces else np.zeros(0, np.int64)
        return self._done[key]

    def signal(self, place: Place, own: _Gathered) -> RawSignal:
        values: Floats = np.concatenate(own.values) if own.values else np.zeros(0)
        own.values.clear()
        return RawSignal(place.source, self.times(own.received), self.times(own.stamps), values)
