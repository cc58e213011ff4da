"""Names and paths from outside, made harmless where they are shown: no control characters, no broken UTF-8."""

from __future__ import annotations

import os
import re
from collections.abc import Collection
from pathlib import Path

REPLACEMENT = "\N{REPLACEMENT CHARACTER}"
LONGEST = 80
_HARMFUL = re.compile("[\x00-\x1f\x7f-\x9f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff]")
"""Control characters, line separators, marks that turn the direction of writing, and halves of surrogates."""


def harmless(text: str) -> str:
    """`text` with a replacement character for each that could act on a terminal, a line or an encoding."""
    return _HARMFUL.sub(REPLACEMENT, text)


def decoded(raw: bytes) -> str:
    """The harmless text of UTF-8 bytes, whatever stands in them."""
    return harmless(raw.decode("utf-8", "replace"))


def at_home(path: str | Path) -> Path:
    """The path with `~` for the home folder; as it is, and so not found, where a user of that name is not there."""
    return Path(os.path.expanduser(path))


def path_text(path: Path) -> str:
    r"""A path as it can be shown: bytes that are not UTF-8 as `\xff`, control characters replaced."""
    return harmless(os.fsencode(path).decode("utf-8", "backslashreplace"))


def shortened(value: object) -> str:
    """`repr` of a value from a file, harmless and no longer than a line has room for."""
    if isinstance(value, (dict, list)):
        return f"a {'mapping' if isinstance(value, dict) else 'list'} of {len(value)}"
    text = harmless(repr(value))
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 1]}…"


def first_of(names: Collection[str], most: int) -> str:
    """The first `most` names, and how many more there are."""
    more = f" and {len(names) - most} more" if len(names) > most else ""
    return ", ".join(list(names)[:most]) + more
