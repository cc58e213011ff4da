"""rosbag2's sqlite3 files, read in blocks of rows; of a file that was cut, the rows in front of the cut."""

from __future__ import annotations

import contextlib
import sqlite3
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from flex_ident.bags.messages import ROWS, Block, Topic, block_of
from flex_ident.errors import BagError
from flex_ident.notices import Code, Notice

MAGIC = b"SQLite format 3\x00"


class SqliteFile:
    """One .db3 file, opened read-only. Raises BagError when it holds no rosbag2 tables."""

    ros1 = False

    def __init__(self, path: Path) -> None:
        self.path = path
        self._notices: list[Notice] = []
        # A write-ahead log beside the file holds the newest messages of a recorder that was killed: it needs mode=ro;
        # without one, immutable also reads from a folder that cannot be written.
        log = path.with_name(path.name + "-wal")
        self._lost_log: list[Notice] = []
        logged = log.exists() and log.stat().st_size > 0
        try:
            self._database, rows = _opened(path, "mode=ro" if logged else "mode=ro&immutable=1")
        except BagError:
            if not logged:
                raise
            self._database, rows = _opened(path, "mode=ro&immutable=1")
            self._lost_log.append(Notice(Code.BAG_DAMAGED, log.name, texts={"case": "log"}))
        definitions: dict[str, tuple[str, str]] = {}
        with contextlib.suppress(sqlite3.Error):
            for kind, encoding, text in self._database.execute(
                "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions"
            ):
                definitions[str(kind)] = (str(text), "idl" if encoding == "ros2idl" else "msg")
        self._topics = {
            number: Topic(name, kind, *definitions.get(kind, ("", "msg")))
            for number, name, kind in rows
            if isinstance(name, str) and isinstance(kind, str)
        }

    def topics(self) -> tuple[Topic, ...]:
        """The topics of the database."""
        return tuple({topic.name: topic for topic in self._topics.values()}.values())

    def notices(self) -> tuple[Notice, ...]:
        """What was lost to damage."""
        return (*self._lost_log, *self._notices)

    def close(self) -> None:
        """Let go of the file."""
        self._database.close()

    def blocks(self, wanted: frozenset[str]) -> Iterator[Block]:
        """Messages of the wanted topics in blocks of rows."""
        self._notices.clear()
        names = {number: topic.name for number, topic in self._topics.items() if topic.name in wanted}
        read = 0
        try:
            # Damage can leave numbers where bytes belong: what is not a message is passed over.
            cursor = self._database.execute(
                f"SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN ({','.join('?' * len(names))}) "
                "AND typeof(timestamp) = 'integer' AND typeof(data) = 'blob' ORDER BY id",
                tuple(names),
            )
            damage = None
            while damage is None:
                rows: list[tuple[int, int, bytes]] = []
                try:
                    rows.extend(islice(cursor, ROWS))  # keeps the rows in front of an error
                except (sqlite3.Error, MemoryError) as error:
                    damage = error
                if not rows:
                    break
                read += len(rows)
                yield from _blocks(rows, names)
        except sqlite3.Error as error:
            damage = error
        if damage is not None:
            said = {"case": "database", "error": str(damage)}
            self._notices.append(Notice(Code.BAG_DAMAGED, self.path.name, {"read": read}, said))


def _opened(path: Path, mode: str) -> tuple[sqlite3.Connection, list[tuple[int, str, str]]]:
    """The database and the rows of its table of topics. Raises BagError."""
    database = None
    try:
        database = sqlite3.connect(f"{path.resolve().as_uri()}?{mode}", uri=True, check_same_thread=False)
        database.text_factory = lambda raw: raw.decode("utf-8", "replace")
        # sqlite refuses a file shorter than its header says, unless its schema may be repaired.
        database.execute("PRAGMA writable_schema = ON")
        return database, database.execute("SELECT id, name, type FROM topics").fetchall()
    except sqlite3.Error as error:
        if database is not None:
            database.close()
        raise BagError(f"{path}: cannot be read as a rosbag2 database ({error}).") from error


def _blocks(rows: list[tuple[int, int, bytes]], names: dict[int, str]) -> Iterator[Block]:
    for number, name in names.items():
        own = rows if len(names) == 1 else [row for row in rows if row[0] == number]
        if own:
            _, received, payloads = zip(*own, strict=True)
            yield block_of(name, received, payloads)
