"""The XML of a robot's description, from a file or from `/robot_description`."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from flex_ident.errors import UsageError

LARGEST = 4 << 20
"""Characters of a URDF, and bytes of a file of it, at most."""


def parsed(description: str, name: str) -> ET.Element:
    """The root element. Raises UsageError with one line, which calls the description by `name`."""
    if len(description) > LARGEST:
        raise UsageError(f"{name} holds {len(description)} characters: {LARGEST} are read at most.")
    try:
        return ET.fromstring(description)
    except (ET.ParseError, ValueError, LookupError) as error:  # the last two are about its encoding
        raise UsageError(f"{name} is not XML ({error}).") from error
