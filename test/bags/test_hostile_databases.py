"""sqlite3 bags whose rows share their pages: more than the file holds is not fetched."""

import sqlite3
import struct
from pathlib import Path

import pytest
from hostile_limits import in_mebibytes

from flex_ident.bags.storage import Bag
from flex_ident.errors import BagError

PAGE = 4096
LOCAL = (PAGE - 12) * 32 // 255 - 23
"""Bytes of a long row that stand in its own page, at least; the rest is a chain of pages that ends with four zeros."""
ROWS = 7
LENGTH = 2_000_000
"""Characters of the text in each row, about."""


def fitting(header: int, others: int) -> str:
    """A text so long that of its row, with a header and other fields of so many bytes, LOCAL bytes are in its page."""
    rest = header + others - LOCAL
    return "a" * ((LENGTH + rest) // (PAGE - 4) * (PAGE - 4) - rest)


def laid_over(path: Path, table: str) -> Path:
    """A bag of /joint_states in which ROWS further rows of the table share the pages of one long text."""
    database = sqlite3.connect(path, isolation_level=None)
    database.execute(f"PRAGMA page_size = {PAGE}")
    database.execute("CREATE TABLE topics (id INTEGER PRIMARY KEY, name TEXT, type TEXT)")
    database.execute("CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
    database.execute(
        "CREATE TABLE message_definitions (id INTEGER PRIMARY KEY, topic_type TEXT, encoding TEXT, "
        "encoded_message_definition TEXT)"
    )
    if table == "topics":
        rows = [(i + 1, fitting(7, 4), "p/Ti") for i in range(ROWS)]
        database.executemany("INSERT INTO topics VALUES (?, ?, ?)", rows)
    else:
        database.execute("INSERT INTO topics VALUES (1, '/joint_states', 'sensor_msgs/msg/JointState')")
        text = fitting(8, 4 + 7)
        definitions = [(i + 1, f"p/T{i}", "ros2msg", text) for i in range(ROWS)]
        database.executemany("INSERT INTO message_definitions VALUES (?, ?, ?, ?)", definitions)
    (root,) = database.execute("SELECT rootpage FROM sqlite_master WHERE name = ?", (table,)).fetchone()
    database.close()
    content = bytearray(path.read_bytes())
    page = (root - 1) * PAGE
    (cells,) = struct.unpack_from(">H", content, page + 3)
    assert content[page] == 13  # a leaf
    assert cells == ROWS
    # A cell: three bytes of length, one of the row's number, LOCAL bytes, and where the chain begins.
    links = [page + at + 3 + 1 + LOCAL for at in struct.unpack_from(f">{cells}H", content, page + 8)]
    chains = [struct.unpack_from(">I", content, link)[0] for link in links]
    last = first = min(chains)
    while following := struct.unpack_from(">I", content, (last - 1) * PAGE)[0]:
        last = following
    for link in links:
        struct.pack_into(">I", content, link, first)
    struct.pack_into(">I", content, 28, last)
    path.write_bytes(content[: last * PAGE])
    return path


def test_topics_that_share_their_pages_are_no_bag(tmp_path: Path) -> None:
    bag = laid_over(tmp_path / "bag.db3", "topics")
    assert bag.stat().st_size < 1.1 * LENGTH
    with in_mebibytes(12), pytest.raises(BagError, match="its pages refer to each other in circles"):
        Bag(bag)


def test_definitions_that_share_their_pages_are_left_out(tmp_path: Path) -> None:
    bag = laid_over(tmp_path / "bag.db3", "message_definitions")
    with in_mebibytes(12), Bag(bag) as opened:
        assert [topic.name for topic in opened.topics()] == ["/joint_states"]
