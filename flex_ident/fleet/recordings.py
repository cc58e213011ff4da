"""Which recordings patterns mean, and of which robot each is.

A folder with `metadata.yaml` is one bag, and so is one whose files are numbered after it as rosbag2 does (a recording
that a crash cut short has no metadata). Any other folder only holds bags: each of its bag files is one.
"""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from flex_ident.bags.storage import SUFFIXES
from flex_ident.errors import UsageError
from flex_ident.recording.names import harmless

ROBOT = "{robot}"
"""Stands in a pattern for one part of a path, as `*` does, and says that it is the robot's name."""


@dataclass(frozen=True)
class Found:
    """A recording's place, absolute, and its robot as far as the pattern says it, else empty."""

    path: Path
    robot: str = ""


def found_recordings(patterns: Sequence[str]) -> list[Found]:
    """Every recording that the patterns mean, once, in the order of their paths within each pattern.

    `**` stands for any number of folders; a folder named without wildcards stands for all below it. Raises UsageError
    for a pattern that no recording matches.
    """
    found: dict[Path, Found] = {}
    for pattern in patterns:
        own = [Found(bag, _robot(pattern, bag)) for bag in _bags(_matches(pattern))]
        if not own:
            raise UsageError(f"{harmless(pattern)}: no recording there (folders of rosbag2, .mcap, .db3, .bag).")
        for recording in own:
            found.setdefault(recording.path, recording)
    return list(found.values())


def is_bag(path: Path) -> bool:
    """Whether a folder is one bag, or a file is a bag by its name."""
    if not path.is_dir():
        return path.suffix in SUFFIXES and path.is_file()
    if (path / "metadata.yaml").exists():
        return True
    numbered = re.compile(rf"{re.escape(path.name)}_\d+$")
    return any(numbered.match(p.name.partition(".")[0]) for p in _files(path))


def _matches(pattern: str) -> Iterable[Path]:
    if ROBOT not in pattern and os.path.lexists(pattern):  # a name with [ or * in it is a name first
        path = Path(os.path.abspath(pattern))
        return [path] if is_bag(path) or not path.is_dir() else sorted(path.rglob("*"))
    parts = pattern.split(ROBOT)
    return [Path(os.path.abspath(p)) for p in sorted(glob.glob("*".join(parts), recursive=True))]


def _bags(paths: Iterable[Path]) -> dict[Path, None]:
    """The bags among paths: of a file within a bag's folder, the folder."""
    bags: dict[Path, None] = {}
    for path in paths:
        if path.is_dir():
            if is_bag(path):
                bags[path] = None
        elif path.suffix in SUFFIXES or path.name == "metadata.yaml":
            bags[path.parent if is_bag(path.parent) else path] = None
    return bags


def _files(folder: Path) -> list[Path]:
    try:
        return [p for p in folder.iterdir() if p.suffix in SUFFIXES]
    except OSError:
        return []


def _robot(pattern: str, bag: Path) -> str:
    """The part of the bag's path that stands where the pattern has `{robot}`."""
    if ROBOT not in pattern:
        return ""
    before, _, after = os.path.abspath(pattern).partition(ROBOT)
    head = glob_expression(before)
    tail = glob_expression(after.partition(os.sep)[0])
    match = re.match(rf"{head}([^/]*?){tail}(?:/|$)", str(bag))
    return harmless(match.group(1)) if match else ""


def glob_expression(pattern: str) -> str:
    """A regular expression of what a pattern's part of a path matches."""
    text = ""
    for piece in re.split(r"(\*\*/?|\*|\?|\[[^\]]*\])", pattern):
        if piece.startswith("**"):
            text += "(?:.*/)?" if piece.endswith("/") else ".*"
        elif piece == "*":
            text += "[^/]*"
        elif piece == "?":
            text += "[^/]"
        elif piece.startswith("["):
            text += piece.replace("[!", "[^", 1)
        else:
            text += re.escape(piece)
    return text
