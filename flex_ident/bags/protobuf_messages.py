"""Protobuf messages of MCAP files, by the descriptors in the file and protobuf's own library."""

from __future__ import annotations

from typing import Any

from flex_ident.bags.extras import extra_module
from flex_ident.bags.flat_messages import Decoder, Flat
from flex_ident.bags.messages import Topic
from flex_ident.errors import SignalError

DEEPEST = 32
"""Messages within each other, at most."""


def protobuf_decoder(topic: Topic) -> Decoder:
    """The decoder of a topic's messages. Raises MissingExtraError without the library, SignalError without a schema."""
    what = f"the protobuf messages of {topic.name}"
    descriptors = extra_module("google.protobuf.descriptor_pb2", "foxglove", what)
    pools = extra_module("google.protobuf.descriptor_pool", "foxglove", what)
    factory = extra_module("google.protobuf.message_factory", "foxglove", what)
    errors = extra_module("google.protobuf.message", "foxglove", what)
    try:
        files = descriptors.FileDescriptorSet.FromString(topic.schema)
        pool = pools.DescriptorPool()
        _add_all(pool, list(files.file))
        kind = factory.GetMessageClass(pool.FindMessageTypeByName(topic.schema_name))
    except Exception as error:
        raise SignalError(f"{topic.name}: the protobuf schema {topic.schema_name!r} is not whole.") from error

    def decode(payload: bytes) -> Flat:
        try:
            message = kind.FromString(payload)
        except errors.DecodeError as error:
            raise ValueError("not such a message") from error
        flat = Flat()
        flat.add(_content(message, DEEPEST), "")
        return flat

    return decode


def _add_all(pool: Any, files: list[Any]) -> None:
    """Add files to the pool, those that others need first."""
    waiting = {file.name: file for file in files}

    def add(name: str) -> None:
        file = waiting.pop(name, None)
        if file is not None:
            for needed in file.dependency:
                add(needed)
            pool.Add(file)

    while waiting:
        add(next(iter(waiting)))


def _content(message: Any, levels: int) -> dict[str, Any]:
    """The message's fields as plain data: those that are not set at their default, optional numbers as None."""
    if not levels:
        raise ValueError("messages within each other without end")
    return {
        field.name: _value(message, field, levels)
        for field in message.DESCRIPTOR.fields
        if field.message_type is None or _is_list(field) or message.HasField(field.name)
    }


def _value(message: Any, field: Any, levels: int) -> Any:
    value = getattr(message, field.name)
    if field.message_type is not None and field.message_type.GetOptions().map_entry:
        return {}
    if _is_list(field):
        return [_content(own, levels - 1) for own in value] if field.message_type is not None else list(value)
    if field.message_type is not None:
        return _content(value, levels - 1)
    optional = getattr(field, "has_presence", False) and not isinstance(value, str)
    return None if optional and not message.HasField(field.name) else value


def _is_list(field: Any) -> bool:
    repeated = getattr(field, "is_repeated", None)
    return bool(repeated if repeated is not None else field.label == field.LABEL_REPEATED)
