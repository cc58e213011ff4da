"""Any bag, by what is in it and not by its name: folder or file, split or not, compressed or not."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Iterator
from pathlib import Path

import yaml

from flex_ident.bags import mcap, ros1, sqlite
from flex_ident.bags.compression import decompress_file
from flex_ident.bags.messages import Block, Storage, Topic
from flex_ident.errors import BagError
from flex_ident.recording import Notice

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
SUFFIXES = (".mcap", ".db3", ".zstd", ".zst", ".bag")


class Bag:
    """A recording of one or more files, in order. Raises BagError, in one line, when there is none.

    Use as a context manager: compressed files are unpacked into a temporary folder that goes with it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._temporary: tempfile.TemporaryDirectory[str] | None = None
        self._notices: list[Notice] = []
        self.files = self._files(path)
        message_zstd = self._message_zstd()
        self._parts: list[Storage] = []
        failures: list[BagError] = []
        for file in self.files:
            try:
                self._parts.append(self._opened(file, message_zstd))
            except BagError as error:
                failures.append(error)
        if not self._parts:
            raise failures[0]
        self._notices += [Notice("bag_damaged", f"a part was left out: {error}") for error in failures]
        self.ros1 = any(part.ros1 for part in self._parts)

    def __enter__(self) -> Bag:
        return self

    def __exit__(self, *_: object) -> None:
        if self._temporary is not None:
            self._parts.clear()
            self._temporary.cleanup()

    def topics(self) -> tuple[Topic, ...]:
        """All topics, each once."""
        found: dict[str, Topic] = {}
        for part in self._parts:
            for topic in part.topics():
                found.setdefault(topic.name, topic)
        return tuple(found.values())

    def blocks(self, wanted: frozenset[str]) -> Iterator[Block]:
        """Messages of the wanted topics from all files."""
        for part in self._parts:
            yield from part.blocks(wanted)

    def notices(self) -> tuple[Notice, ...]:
        """What could not be read, once each."""
        collected = [*self._notices]
        for part in self._parts:
            collected += part.notices()
        return tuple(dict.fromkeys(collected))

    def sha256(self) -> str:
        """Hash of the data files, in order."""
        digest = hashlib.sha256()
        for file in self.files:
            with file.open("rb") as handle:
                while piece := handle.read(1 << 20):
                    digest.update(piece)
        return digest.hexdigest()

    def _files(self, path: Path) -> list[Path]:
        try:
            if not path.exists():
                raise BagError(f"{path}: no such file or folder.")
            if not path.is_dir():
                return [path]
            listed = self._listed()
            found = sorted((p for p in path.iterdir() if p.suffix in SUFFIXES and p.is_file()), key=_split_order)
        except PermissionError as error:
            raise BagError(f"{path}: permission denied.") from error
        known = [path / name for name in listed]
        files = [p for p in known if p.exists()] or found
        for missing in (p for p in known if not p.exists()):
            if files is not found:
                self._notices.append(Notice("bag_damaged", f"{missing.name} of the bag is missing."))
        if not files:
            raise BagError(f"{path}: holds no bag (no .mcap, .db3 or .bag file).")
        return files

    def _metadata(self) -> dict[str, object]:
        file = (self.path if self.path.is_dir() else self.path.parent) / "metadata.yaml"
        try:
            content = yaml.safe_load(file.read_text(encoding="utf-8"))
            information = content["rosbag2_bagfile_information"]
            return information if isinstance(information, dict) else {}
        except (OSError, yaml.YAMLError, UnicodeDecodeError, KeyError, TypeError):
            return {}

    def _listed(self) -> list[str]:
        names = self._metadata().get("relative_file_paths", [])
        return [Path(str(name)).name for name in names] if isinstance(names, list) else []

    def _message_zstd(self) -> bool:
        return str(self._metadata().get("compression_mode", "")).lower() == "message"

    def _opened(self, file: Path, message_zstd: bool) -> Storage:
        try:
            with file.open("rb") as handle:
                head = handle.read(16)
        except PermissionError as error:
            raise BagError(f"{file}: permission denied.") from error
        except OSError as error:
            raise BagError(f"{file}: cannot be read ({error.strerror}).") from error
        if head.startswith(ZSTD_MAGIC):
            if self._temporary is None:
                self._temporary = tempfile.TemporaryDirectory(prefix="flex_ident_")
            plain = Path(self._temporary.name) / file.stem
            decompress_file(file, plain)
            return self._opened(plain, message_zstd)
        if head.startswith(mcap.MAGIC):
            return mcap.McapFile(file, message_zstd=message_zstd)
        if head.startswith(sqlite.MAGIC):
            return sqlite.SqliteFile(file, message_zstd=message_zstd)
        if head.startswith(ros1.MAGIC):
            return ros1.Ros1File(file)
        what = "is empty" if not head else "is neither an MCAP, a rosbag2 sqlite3 nor a ROS 1 file"
        raise BagError(f"{file}: {what}.")


def _split_order(path: Path) -> tuple[str, int, str]:
    """Files of a split bag in the order of their number (name_0, name_1, … name_10)."""
    stem = path.name.split(".")[0]
    head, _, number = stem.rpartition("_")
    return (head, int(number), path.name) if number.isdigit() else (stem, -1, path.name)
