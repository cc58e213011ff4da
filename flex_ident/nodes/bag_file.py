"""A bag written by a thread of its own, so that no disk ever holds up a command; flushed every half second."""

from __future__ import annotations

import math
import shutil
import threading
import time
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from rosbags.rosbag2 import StoragePlugin, Writer

from flex_ident.bags.run_file import RUN_FILE
from flex_ident.errors import BagError

PLUGINS = {"mcap": StoragePlugin.MCAP, "sqlite3": StoragePlugin.SQLITE3}
FLUSH_S = 0.4
WAIT_S = 0.02
"""How long messages are collected before they are handed to the writer together."""
STUCK_S = 3.0
MOST_WAITING = 200_000
"""Messages kept while the disk is slow; more are lost, and counted."""
MIB = 2**20


@dataclass(frozen=True)
class _Topic:
    """A topic to announce, in its place among the messages."""

    name: str
    message_type: str
    definition: str
    digest: str


class BagFile:
    """A rosbag2 being written. `failure` says why writing ended early; empty while all is well.

    `information` becomes the bag's custom data. Raises BagError when the folder cannot be made, or less than
    `least_free` bytes are free.
    """

    def __init__(self, folder: Path, *, storage: str, information: Mapping[str, str], least_free: int) -> None:
        self.path = folder
        self.messages = 0
        self.lost = 0
        self._information = dict(information)
        self._least_free = least_free
        self._waiting: deque[tuple[str, int, bytes] | _Topic] = deque()
        self._failure = ""
        self._alive = time.monotonic()
        self._opened = threading.Event()
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, args=(storage,), name="bag", daemon=True)
        self._thread.start()
        self._opened.wait(STUCK_S)
        if self.failure:
            raise BagError(self.failure)

    @property
    def failure(self) -> str:
        """Why nothing is recorded any more; empty while all is well."""
        if self._failure:
            return self._failure
        if self._thread.is_alive():
            silent = time.monotonic() - self._alive
            return f"recording to {self.path} hangs for {silent:.1f} s" if silent > STUCK_S else ""
        return "" if self._closing.is_set() else f"recording to {self.path} has died"

    def add_topic(self, topic: str, message_type: str, definition: str, digest: str) -> None:
        """Announce a topic: its type, the type's full definition and hash (RIHS01)."""
        self._waiting.append(_Topic(topic, message_type, definition, digest))

    def write(self, topic: str, stamp_ns: int, data: bytes) -> None:
        """Have a message written; never waits."""
        if self._closing.is_set() or self._failure or len(self._waiting) >= MOST_WAITING:
            self.lost += 1
            return
        self._waiting.append((topic, stamp_ns, data))

    def close(self, timeout_s: float = 10.0) -> None:
        """Write what waits and end the bag."""
        self._closing.set()
        self._thread.join(timeout_s)
        if self._thread.is_alive():
            self._failure = self._failure or f"closing {self.path} takes more than {timeout_s:.0f} s"

    # -- the thread

    def _run(self, storage: str) -> None:
        try:
            writer = self._open(storage)
        except Exception as error:
            self._failure = f"recording.directory: {self.path} cannot be written ({_plain(error)})."
            return
        finally:
            self._opened.set()
        try:
            self._write_all(writer)
        except Exception as error:
            self._failure = f"recording to {self.path} failed ({_plain(error)})"
            self.lost += len(self._waiting)
        try:
            writer.close()
        except Exception as error:  # what is on the disk reads without an end
            self._failure = self._failure or f"closing {self.path} failed ({_plain(error)})"

    def _open(self, storage: str) -> Writer:
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self._check_space()
        writer = Writer(self.path, version=9, storage_plugin=PLUGINS[storage])
        for key, value in self._information.items():
            writer.set_custom_data(key, value)
        writer.open()
        text = yaml.safe_dump(self._information, sort_keys=False, allow_unicode=True)
        # From the first moment on: a bag that is cut short has no metadata.yaml.
        (self.path / RUN_FILE).write_text(text, encoding="utf-8")
        return writer

    def _write_all(self, writer: Writer) -> None:
        connections: dict[str, Any] = {}
        flushed = time.monotonic()
        while not self._closing.wait(WAIT_S) or self._waiting:
            while self._waiting:
                match self._waiting.popleft():
                    case _Topic() as t:
                        connections[t.name] = writer.add_connection(
                            t.name, t.message_type, msgdef=t.definition, rihs01=t.digest
                        )
                    case topic, stamp_ns, data:
                        writer.write(connections[topic], stamp_ns, data)
                        self.messages += 1
            self._alive = time.monotonic()
            if self._alive - flushed > FLUSH_S:
                flushed = self._alive
                self._check_space()
                flush_storage(writer.storage)

    def _check_space(self) -> None:
        free = shutil.disk_usage(self.path.parent).free
        if free < self._least_free:
            raise BagError(
                f"{math.floor(free / MIB)} MiB free, {math.ceil(self._least_free / MIB)} MiB needed: make room, or "
                "lower recording.least_free_mib"
            )


def flush_storage(storage: Any) -> None:
    """Hand what is buffered to the operating system: an MCAP chunk, or an sqlite3 transaction."""
    if hasattr(storage, "close_chunk"):
        if storage.chunk.bio.tell():
            storage.close_chunk()
        storage.bio.flush()
    else:
        storage.conn.commit()


def unique_folder(directory: Path, stem: str) -> Path:
    """A folder name that does not exist yet. Raises BagError."""
    for k in range(1000):
        path = directory / (stem if k == 0 else f"{stem}_{k}")
        if not path.exists():
            return path
    raise BagError(f"recording.directory: {directory} holds a thousand recordings named {stem}.")


def _plain(error: Exception) -> str:
    """An error's text in one line, without the file that the sentence names already."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return " ".join(str(error).split()) or type(error).__name__
