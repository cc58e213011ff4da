"""Any bag, by what is in it and not by its name: folder or file, split or not, compressed or not."""

from __future__ import annotations

import hashlib
import os
import secrets
import shutil
import signal
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO

from flex_ident.bags import mcap, ros1, sqlite
from flex_ident.bags.compression import ZSTD_MAGIC, Budget, TooMuchError, decompress_file, decompressed
from flex_ident.bags.messages import Block, Storage, Topic, block_of
from flex_ident.bags.type_files import TypeFile, defined, type_files
from flex_ident.errors import BagError, SignalError
from flex_ident.notices import Code, Notice
from flex_ident.parameters.documents import DocumentError, opened_file, text_of, yaml_content
from flex_ident.recording.names import harmless, path_text

LARGEST_METADATA = 16 << 20
SEEN = 16
TABLES = (".csv", ".txt", ".tsv", ".mat", ".h5", ".hdf5", ".parquet")
"""Endings of files that can be imported."""
SUFFIXES = (".mcap", ".db3", ".zstd", ".zst", ".bag")


class Bag:
    """A recording of one or more files, in order. Raises BagError, in one line, when there is none.

    Use as a context manager: compressed files are unpacked into temporary files that have no name, and so go with the
    process, however it ends.
    """

    def __init__(self, path: Path) -> None:
        path = path.parent if path.name == "metadata.yaml" else path
        self.path = path
        self._notices: list[Notice] = []
        self._damaged: dict[str, int] = {}
        self._read: dict[str, int] = {}
        """Messages of each topic met in the last walk through the whole bag."""
        self._walked = False
        self._types: tuple[TypeFile, ...] = ()
        self._information, complaint = _metadata(path)
        if complaint:
            said = {"case": "metadata", "why": complaint}
            self._notices.append(Notice(Code.BAG_DAMAGED, "metadata.yaml", texts=said))
        self._counts = _counts(self._information)
        self.files = self._files(path)
        self.size = 0
        """Bytes of its files, as they are on the disk."""
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

    @property
    def name(self) -> str:
        """The path as it can be shown."""
        return path_text(self.path)

    def __enter__(self) -> Bag:
        return self

    def __exit__(self, *_: object) -> None:
        for part in self._parts:
            part.close()

    def define(self, paths: Iterable[str]) -> None:
        """Take definitions of message types from .msg files. Raises UsageError."""
        self._types = type_files(paths)

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
        return tuple(defined(replace(t, count=counts.get(t.name)), self._types) for t in found.values())

    def refuse_empty(self) -> None:
        """Raises SignalError when the recording has no topic at all."""
        if not self.topics():
            raise SignalError(f"{self.name}: no joint_states topic: it has no topic.")

    def blocks(self, wanted: frozenset[str]) -> Iterator[Block]:
        """Messages of the wanted topics from all files."""
        self._damaged, self._read = {}, {}
        self._walked = False
        budget = Budget()
        read = dict.fromkeys(wanted, 0)
        for part in self._parts:
            for block in part.blocks(wanted):
                read[block.topic] += block.received.size
                yield self._unpacked(block, budget)
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
        every = frozenset(topic.name for topic in self.topics())
        if not self._walked or not every <= set(self._read):
            for _ in self.blocks(every):
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
        shown = path_text(path)
        try:
            if not path.exists():
                raise BagError(f"{shown}: no such file or folder.")
            if not path.is_dir():
                return [path]
            listed = self._listed()
            found = sorted((p for p in path.iterdir() if p.suffix in SUFFIXES and p.is_file()), key=_split_order)
            known = [path / name for name in listed]
            files = [p for p in known if p.exists()] or found
        except PermissionError as error:
            raise BagError(f"{shown}: permission denied.") from error
        except (OSError, ValueError) as error:
            raise BagError(f"{shown}: cannot be read ({getattr(error, 'strerror', None) or error}).") from error
        for missing in (p for p in known if p not in files):
            if files is not found:
                name = path_text(Path(missing.name))
                self._notices.append(Notice(Code.BAG_DAMAGED, name, texts={"case": "part_missing"}))
        if not files:
            raise BagError(f"{shown}: holds no bag (no .mcap, .db3 or .bag file).")
        return files

    def _listed(self) -> list[str]:
        names = self._information.get("relative_file_paths", [])
        plain = [Path(str(name)).name for name in names] if isinstance(names, list) else []
        return [name for name in dict.fromkeys(plain) if name and "\0" not in name]

    def _announced(self) -> dict[str, int]:
        """Messages of each topic that the bag or an index in it says it holds, whichever says more."""
        counts: dict[str, int] = {}
        for part in self._parts:
            for topic, count in part.announced().items():
                counts[topic] = counts.get(topic, 0) + count
        if self.path.is_dir() or self._listed() == [self.path.name]:
            for topic, count in self._counts.items():
                counts[topic] = max(counts.get(topic, 0), count)
        return counts

    def _unpacked(self, block: Block, budget: Budget) -> Block:
        """The block with messages that are compressed one by one (rosbag2's compression mode MESSAGE) plain."""
        packed = self._information.get("compression_mode", "") in ("MESSAGE", "message")
        if not block.lengths.size or not (packed or _looks_packed(block)):
            return block
        received, payloads = [], []
        for i in range(block.lengths.size):
            try:
                payloads.append(decompressed(block.payload(i), "zstd", None, budget).tobytes())
                received.append(int(block.received[i]))
            except TooMuchError as error:
                raise BagError(f"{self.name}: a message of {block.topic} {error}") from error
            except BagError:
                self._damaged[block.topic] = self._damaged.get(block.topic, 0) + 1
        return block_of(block.topic, received, payloads)

    def _opened(self, path: Path) -> Storage:
        shown = path_text(path)
        try:
            file = opened_file(path)
        except PermissionError as error:
            raise BagError(f"{shown}: permission denied.") from error
        except OSError as error:
            raise BagError(f"{shown}: cannot be read ({error.strerror}).") from error
        with file:
            self.size += os.fstat(file.fileno()).st_size
            if not file.peek(len(ZSTD_MAGIC)).startswith(ZSTD_MAGIC):
                return _storage(path, file)
            with self._plain(file, path) as plain:
                return _storage(path, plain, unnamed=True)

    def _plain(self, packed: BinaryIO, path: Path) -> BinaryIO:
        """A temporary file with what a compressed one holds. Raises BagError."""
        shown, plain = path_text(path), tempfile.TemporaryFile(prefix="flex_ident_")  # noqa: SIM115
        try:
            whole = decompress_file(packed, plain)
            plain.flush()
        except TooMuchError as error:
            plain.close()
            raise BagError(f"{shown}: {error}") from error
        except OSError as error:
            plain.close()
            where = tempfile.gettempdir()
            raise BagError(f"{shown}: cannot be decompressed to {where} ({error.strerror}).") from error
        if not plain.tell():
            plain.close()
            raise BagError(f"{shown}: the compressed file is damaged.")
        if not whole:
            name = path_text(Path(path.name))
            self._notices.append(Notice(Code.BAG_DAMAGED, name, texts={"case": "decompression"}))
        return plain


def _storage(path: Path, file: BinaryIO, *, unnamed: bool = False) -> Storage:
    """The bag file at `path`, opened as `file`, by what is in it; `unnamed`: it is not what stands at `path`."""
    file.seek(0)
    head = file.read(16)
    if head.startswith(mcap.MAGIC):
        return mcap.McapFile(path, file)
    if head.startswith(ros1.MAGIC):
        return ros1.Ros1File(path, file)
    if head.startswith(sqlite.MAGIC):
        return sqlite.SqliteFile(path) if not unnamed else _sqlite_without_a_name(path, file)
    what = "is empty" if not head else "is neither an MCAP, a rosbag2 sqlite3 nor a ROS 1 file"
    if head and path.suffix.lower() in TABLES:
        what += ": make a bag of it with flex_ident import FILE --out BAG"
    raise BagError(f"{path_text(path)}: {what}.")


def _sqlite_without_a_name(path: Path, file: BinaryIO) -> sqlite.SqliteFile:
    """A database in a temporary file: sqlite opens nothing but names, so it has one for as long as that takes."""
    folder = Path(tempfile.gettempdir())
    named = folder / f"flex_ident_{os.getpid()}_{secrets.token_hex(8)}.db3"
    signals = {signal.SIGINT, signal.SIGTERM, signal.SIGHUP}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    try:
        try:
            os.link(f"/proc/self/fd/{file.fileno()}", named, follow_symlinks=True)
        except OSError:  # a file system without files that have no name: a copy
            file.seek(0)
            with named.open("xb") as copy:
                shutil.copyfileobj(file, copy)
        return sqlite.SqliteFile(named, name=path.stem)
    except OSError as error:
        raise BagError(f"{path_text(path)}: cannot be unpacked to {folder} ({error.strerror}).") from error
    finally:
        named.unlink(missing_ok=True)
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _looks_packed(block: Block) -> bool:
    """Whether most of the first messages begin as zstd frames do."""
    first = range(min(SEEN, block.lengths.size))
    return 2 * sum(block.payload(i).startswith(ZSTD_MAGIC) for i in first) > len(first)


def _split_order(path: Path) -> tuple[str, int, str]:
    """Files of a split bag in the order of their number (name_0, name_1, … name_10)."""
    stem = path.name.split(".")[0]
    head, _, number = stem.rpartition("_")
    return (head, int(number), path.name) if number.isdigit() else (stem, -1, path.name)


def _metadata(path: Path) -> tuple[dict[str, object], str]:
    """What `metadata.yaml` says of the bag, and what is wrong with it; nothing when it is missing."""
    file = (path if path.is_dir() else path.parent) / "metadata.yaml"
    if not os.path.lexists(file):
        return {}, ""
    try:
        content = yaml_content(text_of(file, LARGEST_METADATA))
    except DocumentError as error:
        return {}, str(error)
    information = content.get("rosbag2_bagfile_information") if isinstance(content, dict) else None
    if not isinstance(information, dict):
        return {}, "describes no bag."
    return information, ""


def _counts(information: dict[str, object]) -> dict[str, int]:
    """Messages of each topic by `metadata.yaml`."""
    found: dict[str, int] = {}
    topics = information.get("topics_with_message_count", [])
    for entry in topics if isinstance(topics, list) else []:
        try:
            found[harmless(str(entry["topic_metadata"]["name"]))] = int(entry["message_count"])
        except (KeyError, TypeError, ValueError, OverflowError):
            continue
    return found
