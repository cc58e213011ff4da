"""JSON messages, as Foxglove and other tools leave them in MCAP files."""

from __future__ import annotations

import json

from flex_ident.bags.flat_messages import Flat


def json_decoder(payload: bytes) -> Flat:
    """What a JSON object holds. Raises ValueError and RecursionError."""
    content = json.loads(payload)
    flat = Flat()
    flat.add(content, "" if isinstance(content, dict) else "data")
    return flat
