"""Any other message: deserialised by rosbags, one number taken by the path of its attribute."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

from flex_ident.bags.messages import Block, Topic
from flex_ident.errors import SignalError
from flex_ident.recording import Floats


class FieldDecoder:
    """Takes one number of each message of a topic: `path` is dotted (`wrench.torque.z`, `data.3`)."""

    def __init__(self, topic: Topic, path: str, *, ros1: bool) -> None:
        self._topic = topic
        self._path = path.split(".") if path else []
        store: Any = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_JAZZY)
        if topic.message_type not in store.types:
            try:
                read = get_types_from_idl if topic.definition_format == "idl" else None
                types = read(topic.definition) if read else get_types_from_msg(topic.definition, topic.message_type)
                store.register({k: v for k, v in types.items() if k not in store.types})
            except Exception as error:
                raise SignalError(
                    f"{topic.name} is of type {topic.message_type}, which the bag does not define: name another topic."
                ) from error
        self._read = store.deserialize_ros1 if ros1 else store.deserialize_cdr
        self.damaged = 0

    def __call__(self, block: Block) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
        """Receive times (k,), stamps (k,), ns, zero where there is none, and the numbers (k,).

        Raises SignalError when the message has no such field.
        """
        stamps = np.zeros(block.lengths.size, np.int64)
        values = np.full(block.lengths.size, np.nan)
        for i in range(block.lengths.size):
            try:
                message = self._read(block.payload(i), self._topic.message_type)
            except Exception:
                self.damaged += 1
                continue
            header = getattr(message, "header", None)
            if header is not None:
                stamps[i] = header.stamp.sec * 1_000_000_000 + header.stamp.nanosec
            values[i] = self._number(message)
        return block.received, stamps, values

    def _number(self, message: Any) -> float:
        value = message
        path = self._path or (["data"] if hasattr(message, "data") else [])
        for name in path:
            if name.isdigit():
                if len(value) <= int(name):
                    return float("nan")
                value = value[int(name)]
            elif hasattr(value, name):
                value = getattr(value, name)
            else:
                fields = ", ".join(getattr(value, "__dataclass_fields__", {}))
                raise SignalError(
                    f"{self._topic.name} ({self._topic.message_type}) has no field '{name}': it has {fields or 'none'}."
                )
        if isinstance(value, np.ndarray | list) and len(value) == 1:
            value = value[0]
        try:
            return float(value)
        except (TypeError, ValueError) as error:
            raise SignalError(
                f"{self._topic.name}: '{'.'.join(path) or 'the message'}' is not a number; add the field, as in "
                f"{self._topic.name}:{'.'.join([*path, '0'])}."
            ) from error
