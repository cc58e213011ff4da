"""Definitions of message types from .msg files that the user names."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from flex_ident.bags.messages import Topic
from flex_ident.errors import UsageError
from flex_ident.parameters.documents import DocumentError, text_of
from flex_ident.recording.names import at_home, path_text

LARGEST_FILE = 1 << 18
MOST_FILES = 1024
BELOW = ("*.msg", "msg/*.msg", "*/msg/*.msg")
"""Where definitions stand in a folder of them, of a package, or of packages."""
PART = "\n" + "=" * 80 + "\nMSG: "


@dataclass(frozen=True)
class TypeFile:
    """The definition of one type; `package` is the folder's name above `msg/`, or empty where there is none."""

    package: str
    name: str
    text: str


def type_files(paths: Iterable[str]) -> tuple[TypeFile, ...]:
    """Definitions in .msg files, in folders of them, and beside a named file. Raises UsageError."""
    named: dict[Path, None] = {}
    beside: dict[Path, None] = {}
    for given in paths:
        path = at_home(given)
        if path.is_dir():
            found = [own for pattern in BELOW for own in sorted(path.glob(pattern))][:MOST_FILES]
            if not found:
                raise UsageError(f"--type-file {path_text(path)}: holds no .msg file.")
            named.update(dict.fromkeys(found))
        elif path.suffix != ".msg":
            raise UsageError(f"--type-file {path_text(path)}: expected a .msg file, or a folder of them.")
        else:
            named[path] = None
            beside.update(dict.fromkeys(sorted(path.parent.glob("*.msg"))[:MOST_FILES]))
    return tuple(_read(path) for path in {**named, **beside})


def _read(path: Path) -> TypeFile:
    try:
        text = text_of(path, LARGEST_FILE)
    except DocumentError as error:
        raise UsageError(f"--type-file {path_text(path)}: {error}") from error
    folder = path.resolve().parent
    return TypeFile(folder.parent.name if folder.name == "msg" else "", path.stem, text)


def defined(topic: Topic, files: tuple[TypeFile, ...]) -> Topic:
    """The topic with the definition that the files give of its type, if they do."""
    package, _, name = topic.message_type.partition("/msg/")
    own = next((f for f in files if f.name == name and f.package in (package, "")), None)
    if own is None or topic.encoding not in ("cdr", "ros1"):
        return topic
    others = [f for f in files if f is not own and (f.package or package, f.name) != (package, name)]
    text = own.text + "".join(f"{PART}{f.package or package}/{f.name}\n{f.text}" for f in others)
    return replace(topic, definition=text, definition_format="msg", given=True)
