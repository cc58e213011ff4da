"""The reader of a topic's messages, by how they are encoded."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from flex_ident.bags.flat_messages import FlatLayouts
from flex_ident.bags.joint_messages import KEYS
from flex_ident.bags.json_messages import json_decoder
from flex_ident.bags.layouts import MessageLayouts
from flex_ident.bags.message_numbers import Layout
from flex_ident.bags.messages import Block, Topic
from flex_ident.bags.namings import Namings
from flex_ident.bags.protobuf_messages import protobuf_decoder


class Layouts(Protocol):
    """Sorts the messages of one topic by layout."""

    versions: tuple[Any, ...]
    damaged: int
    named: Namings

    def tell_apart(self, key: str) -> None:
        """Tell layouts apart by the texts in this field too."""
        ...

    def __call__(self, block: Block) -> Iterator[tuple[Layout, NDArray[np.uint8], NDArray[np.int64]]]:
        """The block's messages, layout by layout: the layout, payloads (k, length), their places (k,) in the block."""
        ...


def message_layouts(topic: Topic, *, ros1: bool, size: int = 0) -> Layouts:
    """The layouts of a topic's messages, in a bag of `size` bytes.

    Raises SignalError and MissingExtraError when they cannot be decoded.
    """
    if topic.encoding == "json":
        return FlatLayouts(topic, json_decoder)
    if topic.encoding == "protobuf":
        return FlatLayouts(topic, protobuf_decoder(topic))
    return MessageLayouts(topic, ros1=ros1, keys=tuple(KEYS.get(topic.message_type, "").split()), size=size)
