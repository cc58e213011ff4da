"""rosbag2's sqlite3 files, read in blocks of rows; of a file that was cut, the rows in front of the cut.

Nothing in the file is executed: views and triggers are refused, and the work of a query is bounded by the file's size.
"""

from __future__ import annotations

import contextlib
import os
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

from flex_ident.bags.messages import ROWS, Block, Topic, block_of
from flex_ident.errors import BagError
from flex_ident.notices import Code, Notice
from flex_ident.recording.names import harmless, path_text

MAGIC = b"SQLite format 3\x00"
STEPS = 100_000
"""Instructions of sqlite between two looks at how many there were."""
FREE_STEPS, STEPS_PER_BYTE = 10_000_000, 4
"""Instructions of a query, at most: so many, and so many for each byte of the file. A message takes about twenty."""
LARGEST = 1 << 27
"""Bytes of one message, at most."""
SMALLEST = 1 << 16
"""Bytes of one message that are allowed in any file; else it is no longer than the file."""
FETCHED = 32 << 20
"""Bytes of messages that are fetched together."""
MOST_TOPICS = 1 << 16
CIRCLES = "its pages refer to each other in circles"
TABLES = "('messages', 'topics', 'message_definitions')"
NO_TABLE = (
    f"SELECT name FROM sqlite_master WHERE lower(name) IN {TABLES} AND (type <> 'table' OR rootpage = 0) UNION "
    f"SELECT x.name FROM sqlite_master AS m, pragma_table_xinfo(m.name) AS x WHERE lower(m.name) IN {TABLES} "
    "AND x.hidden > 0"
)
"""Views, virtual tables and computed columns where rosbag2 has plain ones."""
WHOLE = "typeof(timestamp) = 'integer' AND typeof(data) = 'blob'"
"""Damage can leave numbers where bytes belong: what is not a message is passed over, and counted."""


class _CirclesError(Exception):
    """More was fetched than the file holds."""


class SqliteFile:
    """One .db3 file, opened read-only. Raises BagError when it holds no rosbag2 tables.

    `name` is that of the file it was unpacked from, if it was.
    """

    ros1 = False

    def __init__(self, path: Path, *, name: str = "") -> None:
        self.name = path_text(Path(name or path.name))
        self._notices: list[Notice] = []
        self._read, self._uncounted = 0, False
        # A write-ahead log beside the file holds the newest messages of a recorder that was killed: it needs mode=ro;
        # without one, immutable also reads from a folder that cannot be written.
        log = path.with_name(path.name + "-wal")
        self._lost_log: list[Notice] = []
        logged = not name and log.is_file() and log.stat().st_size > 0
        self._size = path.stat().st_size + (log.stat().st_size if logged else 0)
        try:
            self._database, rows = _opened(path, "mode=ro" if logged else "mode=ro&immutable=1", self._size)
        except BagError:
            if not logged:
                raise
            self._database, rows = _opened(path, "mode=ro&immutable=1", self._size)
            name_of_log = path_text(Path(log.name))
            self._lost_log.append(Notice(Code.BAG_DAMAGED, name_of_log, texts={"case": "log"}))
        definitions = self._definitions()
        self._topics = {
            number: Topic(harmless(name), harmless(kind), *definitions.get(harmless(kind), ("", "msg")))
            for number, name, kind in rows
            if isinstance(name, str) and isinstance(kind, str)
        }

    def _definitions(self) -> dict[str, tuple[str, str]]:
        """Definition and its format by message type, as far as the database has any."""
        found: dict[str, tuple[str, str]] = {}
        columns = "topic_type, encoding, encoded_message_definition"
        with contextlib.suppress(sqlite3.Error, _CirclesError):
            for kind, encoding, text in _rows(self._database, columns, "message_definitions", self._size):
                found[harmless(str(kind))] = (str(text), "idl" if encoding == "ros2idl" else "msg")
        return found

    def topics(self) -> tuple[Topic, ...]:
        """The topics of the database."""
        return tuple({topic.name: topic for topic in self._topics.values()}.values())

    def notices(self) -> tuple[Notice, ...]:
        """What was lost to damage."""
        return (*self._lost_log, *self._notices)

    def announced(self) -> dict[str, int]:
        """None: the database counts no topic's messages; what its index of all messages says is a notice."""
        return {}

    def close(self) -> None:
        """Let go of the file."""
        self._database.close()

    def blocks(self, wanted: frozenset[str]) -> Iterator[Block]:
        """Messages of the wanted topics in blocks of rows."""
        self._notices.clear()
        self._uncounted = False
        names = {number: topic.name for number, topic in self._topics.items() if topic.name in wanted}
        self._read = size = 0
        damage: Exception | str | None = None
        self._bound_work()
        try:
            cursor = self._database.execute(
                f"SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN ({','.join('?' * len(names))}) "
                f"AND {WHOLE} ORDER BY id",
                tuple(names),
            )
            ended = False
            while not ended and damage is None:
                rows: list[tuple[int, int, bytes]] = []
                fetched, ended = 0, True
                try:
                    for row in cursor:
                        rows.append(row)
                        fetched += len(row[2])
                        if len(rows) >= ROWS or fetched > FETCHED:
                            ended = False
                            break
                except (sqlite3.Error, MemoryError) as error:
                    damage = error
                self._read += len(rows)
                size += fetched + len(rows)
                if size > self._size:
                    damage = CIRCLES
                yield from _blocks(rows, names)
        except sqlite3.Error as error:
            damage = error
        if damage is not None:
            said = {"case": "database", "error": _reason(damage)}
            self._notices.append(Notice(Code.BAG_DAMAGED, self.name, {"read": self._read}, said))
        elif wanted:
            self._compare()

    def _compare(self) -> None:
        """Note messages that are no messages, that belong to no topic, and that only the index knows."""
        known = ",".join(str(int(number)) for number in self._topics if isinstance(number, int)) or "NULL"
        total = self._count("messages NOT INDEXED")
        unlike = self._count(f"messages WHERE NOT ({WHOLE})")
        # Not 'topic_id IS NULL': sqlite believes the schema, which says that it never is.
        named = f"typeof(topic_id) = 'integer' AND topic_id IN ({known})"
        nameless = self._count(f"messages WHERE {WHOLE} AND NOT ({named})")
        indexed = self._count("messages INDEXED BY timestamp_idx")
        with contextlib.suppress(sqlite3.Error, TypeError):
            low, high = self._database.execute("SELECT min(id), max(id) FROM messages").fetchone()
            # rosbag2 numbers messages from 1 on; numbers far off are damage themselves.
            if 0 < high - low + 1 - total <= total:
                sizes = {"count": high - low + 1 - total, "total": high - low + 1}
                self._notices.append(Notice(Code.BAG_DAMAGED, self.name, sizes, {"case": "numbered_rows"}))
        if unlike:
            sizes = {"count": unlike, "total": total}
            self._notices.append(Notice(Code.BAG_DAMAGED, self.name, sizes, {"case": "damaged_rows"}))
        if nameless:
            sizes = {"count": nameless, "total": total}
            self._notices.append(Notice(Code.BAG_DAMAGED, self.name, sizes, {"case": "nameless_rows"}))
        if indexed > total:
            sizes = {"read": total, "indexed": indexed}
            self._notices.append(Notice(Code.BAG_DAMAGED, self.name, sizes, {"case": "indexed_rows"}))

    def _count(self, what: str) -> int:
        """Rows of a table under a condition; 0 where they cannot be counted, which is a notice where damage is why."""
        self._bound_work()
        try:
            (count,) = self._database.execute(f"SELECT count(*) FROM {what}").fetchone()
            return int(count)
        except sqlite3.Error as error:
            # An error of SQL is about an index or a column that this version of rosbag2 does not have.
            if error.sqlite_errorcode != sqlite3.SQLITE_ERROR and not self._uncounted:
                self._uncounted = True
                said = {"case": "database", "error": _reason(error)}
                self._notices.append(Notice(Code.BAG_DAMAGED, self.name, {"read": self._read}, said))
            return 0

    def _bound_work(self) -> None:
        _bound_work(self._database, self._size)


def _bound_work(database: sqlite3.Connection, size: int) -> None:
    """Let the next query end with an error when it takes more steps than a file of `size` bytes can need."""
    left = (FREE_STEPS + STEPS_PER_BYTE * size) // STEPS

    def counted() -> bool:
        nonlocal left
        left -= 1
        return left < 0

    database.set_progress_handler(counted, STEPS)


def _opened(path: Path, mode: str, size: int) -> tuple[sqlite3.Connection, list[tuple[int, str, str]]]:
    """The database, in files of `size` bytes, and the rows of its table of topics. Raises BagError."""
    database = None
    try:
        # The path's own bytes, which need not be UTF-8.
        address = "file:" + quote(os.fsencode(path.resolve()))
        database = sqlite3.connect(f"{address}?{mode}", uri=True, check_same_thread=False)
        database.text_factory = lambda raw: raw.decode("utf-8", "replace")
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, min(LARGEST, max(size, SMALLEST)))
        _bound_work(database, size)
        # sqlite refuses a file shorter than its header says, unless its schema may be repaired.
        database.execute("PRAGMA writable_schema = ON")
        database.execute("PRAGMA trusted_schema = OFF")
        if database.execute(NO_TABLE).fetchone() is not None:
            raise BagError(f"{path_text(path)}: its messages are computed and no table: this is no recording.")
        return database, list(_rows(database, "id, name, type", "topics", size))
    except BagError:
        _close(database)
        raise
    except (_CirclesError, sqlite3.Error, OSError, MemoryError) as error:
        _close(database)
        raise BagError(f"{path_text(path)}: cannot be read as a rosbag2 database ({_reason(error)}).") from error


def _rows(database: sqlite3.Connection, columns: str, table: str, size: int) -> Iterator[tuple[Any, ...]]:
    """Rows of a small table in a file of `size` bytes, one by one. Raises _CirclesError when they hold more than it."""
    fetched = 0
    for row in database.execute(f"SELECT {columns} FROM {table} LIMIT {MOST_TOPICS}"):
        fetched += sum(len(value) for value in row if isinstance(value, (str, bytes)))
        if fetched > size:
            raise _CirclesError(CIRCLES)
        yield row


def _close(database: sqlite3.Connection | None) -> None:
    if database is not None:
        database.close()


def _reason(error: Exception | str) -> str:
    """What sqlite says, harmless and short."""
    return harmless(str(error))[:80] or "not enough memory"


def _blocks(rows: list[tuple[int, int, bytes]], names: dict[int, str]) -> Iterator[Block]:
    for number, name in names.items():
        own = rows if len(names) == 1 else [row for row in rows if row[0] == number]
        if own:
            _, received, payloads = zip(*own, strict=True)
            yield block_of(name, received, payloads)
