"""rosbag2's sqlite3 files, read in blocks of rows."""

from __future__ import annotations

import contextlib
import sqlite3
from collections.abc import Iterator
from pathlib import Path

from flex_ident.bags.compression import decompressed
from flex_ident.bags.messages import Block, Topic, block_of
from flex_ident.errors import BagError
from flex_ident.recording import Notice

MAGIC = b"SQLite format 3\x00"
ROWS = 20_000


class SqliteFile:
    """One .db3 file, opened read-only. Raises BagError when it holds no rosbag2 tables."""

    ros1 = False

    def __init__(self, path: Path, *, message_zstd: bool = False) -> None:
        self.path = path
        self._message_zstd = message_zstd
        self._notices: list[Notice] = []
        # A write-ahead log beside the file holds the newest messages of a recorder that was killed: it needs mode=ro;
        # without one, immutable also reads from a folder that cannot be written.
        log = path.with_name(path.name + "-wal")
        mode = "mode=ro" if log.exists() and log.stat().st_size else "mode=ro&immutable=1"
        try:
            self._database = sqlite3.connect(f"{path.resolve().as_uri()}?{mode}", uri=True, check_same_thread=False)
            rows = self._database.execute("SELECT id, name, type FROM topics").fetchall()
        except sqlite3.Error as error:
            raise BagError(f"{path}: cannot be read as a rosbag2 database ({error}).") from error
        definitions: dict[str, tuple[str, str]] = {}
        with contextlib.suppress(sqlite3.Error):
            for kind, encoding, text in self._database.execute(
                "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
            ):
                definitions[kind] = (str(text), "idl" if encoding == "ros2idl" else "msg")
        self._topics = {
            int(number): Topic(str(name), str(kind), *definitions.get(str(kind), ("", "msg")))
            for number, name, kind in rows
        }

    def topics(self) -> tuple[Topic, ...]:
        """The topics of the database."""
        return tuple(self._topics.values())

    def notices(self) -> tuple[Notice, ...]:
        """What was lost to damage."""
        return tuple(self._notices)

    def blocks(self, wanted: frozenset[str]) -> Iterator[Block]:
        """Messages of the wanted topics, topic by topic, in blocks of rows."""
        for number, topic in self._topics.items():
            if topic.name not in wanted:
                continue
            read = 0
            try:
                cursor = self._database.execute(
                    "SELECT timestamp, data FROM messages WHERE topic_id = ? ORDER BY id", (number,)
                )
                while rows := cursor.fetchmany(ROWS):
                    payloads = [bytes(row[1]) for row in rows]
                    if self._message_zstd:
                        payloads = [bytes(decompressed(memoryview(p), "zstd", 0)) for p in payloads]
                    read += len(rows)
                    yield block_of(topic.name, [row[0] for row in rows], payloads)
            except sqlite3.DatabaseError as error:
                text = f"{self.path.name} is damaged ({error}): after {read} messages of {topic.name} the rest is lost."
                self._notices.append(Notice("bag_damaged", text))
