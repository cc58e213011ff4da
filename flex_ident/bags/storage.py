"""Any bag, by what is in it and not by its name: folder or file, split or not, compressed or not."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

from flex_ident.bags import mcap, ros1, sqlite
from flex_ident.bags.compression import ZSTD_MAGIC, decompress_file, decompressed
from flex_ident.bags.messages import Block, Storage, Topic, block_of
from flex_ident.errors import BagError
from flex_ident.notices import Code, Notice

SUFFIXES = (".mcap", ".db3", ".zstd", ".zst", ".bag")


class Bag:
    """A recording of one or more files, in order. Raises BagError, in one line, when there is none.

    Use as a context manager: compressed files are unpacked into a temporary folder that goes with it.
    """

    def __init__(self, path: Path) -> None:
        path = path.parent if path.name == "metadata.yaml" else path
        self.path = path
        self._temporary: tempfile.TemporaryDirectory[str] | None = None
        self._notices: list[Notice] = []
        self._damaged: dict[str, int] = {}
        self._read: dict[str, int] = {}
        """Messages of each topic met in the last walk through the whole bag."""
        self._walked = False
        self._information = _metadata(path)
        self.files = self._files(path)
        self._parts: list[Storage] = []
        failures: list[BagError] = []
        for file in self.files:
            try:
                self._parts.append(self._opened(file))
            except BagError as error:
                failures.append(error)
        if not self._parts:
            raise failures[0]
        self._notices += [Notice(Code.BAG_DAMAGED, texts={"case": "part", "error": str(error)}) for error in failures]

    def __enter__(self) -> Bag:
        return self

    def __exit__(self, *_: object) -> None:
        for part in self._parts:
            part.close()
        if self._temporary is not None:
            self._temporary.cleanup()

    @property
    def ros1(self) -> bool:
        """Whether the messages are serialised as in ROS 1; known after `topics`."""
        return any(part.ros1 for part in self._parts)

    def topics(self) -> tuple[Topic, ...]:
        """All topics, each once."""
        found: dict[str, Topic] = {}
        for part in self._parts:
            for topic in part.topics():
                found.setdefault(topic.name, topic)
        counts = self._announced()
        return tuple(replace(topic, count=counts.get(topic.name)) for topic in found.values())

    def blocks(self, wanted: frozenset[str]) -> Iterator[Block]:
        """Messages of the wanted topics from all files."""
        self._damaged, self._read = {}, {}
        self._walked = False
        read = dict.fromkeys(wanted, 0)
        for part in self._parts:
            for block in part.blocks(wanted):
                read[block.topic] += block.received.size
                yield self._unpacked(block)
        self._walked, self._read = True, read

    def notices(self) -> tuple[Notice, ...]:
        """What could not be read, once each; complete after `blocks` ran to its end."""
        collected = [*self._notices]
        for part in self._parts:
            collected += part.notices()
        announced = self._announced()
        for topic, read in self._read.items():
            if read < announced.get(topic, 0):
                sizes = {"read": read, "announced": announced[topic]}
                collected.append(Notice(Code.BAG_DAMAGED, topic, sizes, {"case": "messages_lost"}))
        for topic, count in self._damaged.items():
            collected.append(Notice(Code.BAG_DAMAGED, topic, {"count": count}, {"case": "compressed"}))
        return tuple(dict.fromkeys(collected))

    def damage(self) -> tuple[Notice, ...]:
        """What could not be read of the whole bag, whatever was read so far."""
        if not self._walked:
            for _ in self.blocks(frozenset()):
                pass
        return self.notices()

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
                self._notices.append(Notice(Code.BAG_DAMAGED, missing.name, texts={"case": "part_missing"}))
        if not files:
            raise BagError(f"{path}: holds no bag (no .mcap, .db3 or .bag file).")
        return files

    def _listed(self) -> list[str]:
        names = self._information.get("relative_file_paths", [])
        return [Path(str(name)).name for name in names] if isinstance(names, list) else []

    def _announced(self) -> dict[str, int]:
        """Messages of each topic that the bag says it holds, where it does."""
        if self.path.is_dir() or self._listed() == [self.path.name]:
            return _counts(self._information)
        counts: dict[str, int] = {}
        for part in self._parts:
            for topic in part.topics():
                if topic.count is not None:
                    counts[topic.name] = counts.get(topic.name, 0) + topic.count
        return counts

    def _unpacked(self, block: Block) -> Block:
        """The block with messages that are compressed one by one (rosbag2's compression mode MESSAGE) plain."""
        packed = self._information.get("compression_mode", "") in ("MESSAGE", "message")
        if not block.lengths.size or not (packed or block.payload(0).startswith(ZSTD_MAGIC)):
            return block
        received, payloads = [], []
        for i in range(block.lengths.size):
            try:
                payloads.append(decompressed(block.payload(i), "zstd").tobytes())
                received.append(int(block.received[i]))
            except BagError:
                self._damaged[block.topic] = self._damaged.get(block.topic, 0) + 1
        return block_of(block.topic, received, payloads)

    def _opened(self, file: Path) -> Storage:
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
            if not decompress_file(file, plain):
                self._notices.append(Notice(Code.BAG_DAMAGED, file.name, texts={"case": "decompression"}))
            return self._opened(plain)
        if head.startswith(mcap.MAGIC):
            return mcap.McapFile(file)
        if head.startswith(sqlite.MAGIC):
            return sqlite.SqliteFile(file)
        if head.startswith(ros1.MAGIC):
            return ros1.Ros1File(file)
        what = "is empty" if not head else "is neither an MCAP, a rosbag2 sqlite3 nor a ROS 1 file"
        raise BagError(f"{file}: {what}.")


def _split_order(path: Path) -> tuple[str, int, str]:
    """Files of a split bag in the order of their number (name_0, name_1, … name_10)."""
    stem = path.name.split(".")[0]
    head, _, number = stem.rpartition("_")
    return (head, int(number), path.name) if number.isdigit() else (stem, -1, path.name)


def _metadata(path: Path) -> dict[str, object]:
    """What `metadata.yaml` says of the bag; nothing when it is missing or damaged."""
    file = (path if path.is_dir() else path.parent) / "metadata.yaml"
    try:
        content = yaml.safe_load(file.read_text(encoding="utf-8"))
        information = content["rosbag2_bagfile_information"]
        return information if isinstance(information, dict) else {}
    except (OSError, yaml.YAMLError, ValueError, KeyError, TypeError):
        return {}


def _counts(information: dict[str, object]) -> dict[str, int]:
    """Messages of each topic by `metadata.yaml`."""
    try:
        topics: Any = information.get("topics_with_message_count", [])
        return {str(t["topic_metadata"]["name"]): int(t["message_count"]) for t in topics}
    except (KeyError, TypeError, ValueError):
        return {}
