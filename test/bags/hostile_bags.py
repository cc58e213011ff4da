"""Bags made to hurt, each by its name, and what reading one of them takes.

Needs `backports.zstd`, as reading them does.
"""

from __future__ import annotations

import os
import sqlite3
import struct
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import lz4.frame
from backports import zstd

ZEROS = bytes(1 << 26)
MAGIC = b"\x89MCAP0\r\n"


def record(opcode: int, body: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(body)) + body


def text(value: str) -> bytes:
    return struct.pack("<I", len(value)) + value.encode()


def chunk(packed: bytes, compression: str, size: int) -> bytes:
    body = struct.pack("<QQQI", 0, 0, size, 0) + text(compression) + struct.pack("<Q", len(packed)) + packed
    return record(6, body)


def bomb(path: Path, packed: bytes, compression: str, size: int, times: int = 1) -> Path:
    path.write_bytes(MAGIC + record(1, text("ros2") + text("")) + times * chunk(packed, compression, size))
    return path


def zstd_zeros(mebibytes: int) -> bytes:
    packer = zstd.ZstdCompressor()
    return b"".join(packer.compress(bytes(1 << 20)) for _ in range(mebibytes)) + packer.flush()


def lz4_zeros(mebibytes: int) -> bytes:
    packer = lz4.frame.LZ4FrameCompressor()
    return packer.begin() + b"".join(packer.compress(bytes(1 << 20)) for _ in range(mebibytes)) + packer.flush()


def sqlite_file(path: Path, messages: str) -> Path:
    database = sqlite3.connect(path)
    database.execute("CREATE TABLE topics (id INTEGER, name TEXT, type TEXT)")
    database.execute("INSERT INTO topics VALUES (1, '/joint_states', 'sensor_msgs/msg/JointState')")
    database.execute(messages)
    database.commit()
    database.close()
    return path


ENDLESS = (
    "CREATE VIEW messages AS WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n) "
    "SELECT i AS id, 1 AS topic_id, i AS timestamp, zeroblob(1000000) AS data FROM n"
)
COMPUTED = (
    "CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
    "data BLOB AS (zeroblob(100000000)))"
)
HOSTILE: dict[str, Callable[[Path], Path]] = {
    "zstd, 4 GiB announced": lambda p: bomb(p / "a.mcap", zstd_zeros(4096), "zstd", 4 << 30),
    "zstd, 1 MiB announced": lambda p: bomb(p / "a.mcap", zstd_zeros(4096), "zstd", 1 << 20),
    "zstd, 112 MiB announced, 400 times": lambda p: bomb(p / "a.mcap", zstd_zeros(112), "zstd", 112 << 20, 400),
    "lz4, 4 GiB announced": lambda p: bomb(p / "a.mcap", lz4_zeros(4096), "lz4", 4 << 30),
    "lz4, 112 MiB announced, 40 times": lambda p: bomb(p / "a.mcap", lz4_zeros(112), "lz4", 112 << 20, 40),
    "2^63 bytes announced": lambda p: bomb(p / "a.mcap", b"", "", 1 << 63),
    "empty frames": lambda p: bomb(p / "a.mcap", zstd.compress(b"") * 500_000, "zstd", 1 << 20),
    "whole file": lambda p: (p / "a.mcap.zstd").write_bytes(zstd_zeros(4096)) and p / "a.mcap.zstd",
    "whole file within a file": lambda p: (p / "a.mcap.zstd").write_bytes(zstd.compress(zstd_zeros(100))) and p,
    "empty schemas": lambda p: bomb(p / "a.mcap", zstd.compress(record(3, b"\0\0") * 5_000_000), "zstd", 55_000_000),
    "view": lambda p: sqlite_file(p / "a.db3", ENDLESS),
    "computed": lambda p: sqlite_file(p / "a.db3", COMPUTED),
}


class Refusal(NamedTuple):
    """What reading a bag in a process of its own said on one line, and took."""

    said: str
    seconds: float
    mebibytes: float


def refusal(bag: Path) -> Refusal:
    """Read the bag in a new process; `said` is empty where the bag was not refused."""
    script = """
        import sys, time
        from pathlib import Path
        from flex_ident.bags.reading import read_recording
        from flex_ident.errors import FlexIdentError
        started, said = time.process_time(), ""
        try:
            read_recording(Path(sys.argv[1]))
        except FlexIdentError as error:
            said = str(error)
        peak = Path("/proc/self/status").read_text().partition("VmHWM:")[2].split()[0]  # not that of the caller
        print(said, time.process_time() - started, int(peak) / 1024, sep="\\n")
    """
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script), str(bag)], capture_output=True, text=True, check=True,
        env={**os.environ, "TMPDIR": str(bag if bag.is_dir() else bag.parent)},
    )  # fmt: skip
    said, seconds, mebibytes = run.stdout.strip("\n").rsplit("\n", 2)
    return Refusal(said, float(seconds), float(mebibytes))
