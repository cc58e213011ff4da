"""Topics recorded byte for byte into a rosbag2, flushed so that a crash loses at most half a second."""

from __future__ import annotations

import importlib
import os
import shutil
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks, UnsupportedEventTypeError
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from flex_ident.errors import BagError

FLUSH_S = 0.4
LEAST_FREE_BYTES = 100 * 2**20
DEPTH = 2000
PLUGINS = {"mcap": StoragePlugin.MCAP, "sqlite3": StoragePlugin.SQLITE3}


class Recorder:
    """A bag being written. `failure` says why writing ended early; empty while all is well."""

    def __init__(self, node: Node, folder: Path, *, storage: str, information: dict[str, str]) -> None:
        self.path = folder
        self.failure = ""
        self.messages = 0
        self.lost = 0
        self._node = node
        self._store = get_typestore(Stores.ROS2_JAZZY)
        self._lock = threading.Lock()
        self._connections: dict[str, Any] = {}
        self._subscriptions: dict[str, Any] = {}
        self._open = False
        try:
            folder.parent.mkdir(parents=True, exist_ok=True)
            self._check_space()
            self._writer = Writer(folder, version=9, storage_plugin=PLUGINS[storage])
            for key, value in information.items():
                self._writer.set_custom_data(key, value)
            self._writer.open()
        except Exception as error:
            raise BagError(f"recording.directory: {folder} cannot be written ({error}).") from error
        self._open = True
        self._timer = node.create_timer(FLUSH_S, self._flush)

    def subscribe(self, topic: str, message_type: str, on_message: Any = None) -> bool:
        """Record a topic of type `pkg/msg/Name`; `on_message` gets the bytes too. False when the type is unknown."""
        name = self._node.resolve_topic_name(topic)
        if name in self._subscriptions:
            return True
        kind = message_class(message_type)
        if kind is None or not self._connect(name, message_type):
            self._node.get_logger().warning(f"{name}: the type {message_type} is not installed: not recorded.")
            return False
        offers = self._node.get_publishers_info_by_topic(name)
        reliable = all(o.qos_profile.reliability == ReliabilityPolicy.RELIABLE for o in offers)
        qos = QoSProfile(
            depth=DEPTH, reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT
        )

        def received(data: bytes) -> None:
            self.write(name, data)
            if on_message is not None:
                on_message(data)

        try:
            events = SubscriptionEventCallbacks(message_lost=self._on_lost)
            made = self._node.create_subscription(kind, name, received, qos, raw=True, event_callbacks=events)
        except UnsupportedEventTypeError:
            made = self._node.create_subscription(kind, name, received, qos, raw=True)
        self._subscriptions[name] = made
        return True

    def add(self, topic: str, message_type: str) -> str:
        """Prepare a topic that this process writes itself; its full name."""
        name = self._node.resolve_topic_name(topic)
        self._connect(name, message_type)
        return name

    def _connect(self, name: str, message_type: str) -> bool:
        if message_type not in self._store.types and not self._register(message_type):
            return False
        with self._lock:
            self._connections[name] = self._writer.add_connection(name, message_type, typestore=self._store)
        return True

    def _register(self, message_type: str) -> bool:
        """Take a type's definition, and those that it is made of, from the installation."""
        definition = installed_definition(message_type)
        if definition is None:
            return False
        found = get_types_from_msg(definition, message_type)
        for fields in found.values():
            for _, (_, detail) in fields[1]:
                inner = detail[0][1][0] if isinstance(detail[0], tuple) else detail[0]
                if isinstance(inner, str) and "/" in inner and inner not in self._store.types:
                    self._register(inner)
        self._store.register(found)
        return True

    def write(self, name: str, data: bytes) -> None:
        """Write one message at the time of now; a failure ends the recording and is kept in `failure`."""
        if not self._open or self.failure:
            return
        stamp = self._node.get_clock().now().nanoseconds
        try:
            with self._lock:
                self._writer.write(self._connections[name], stamp, data)
            self.messages += 1
        except Exception as error:
            self.failure = f"recording to {self.path} failed ({error})"

    def _on_lost(self, event: Any) -> None:
        self.lost += int(event.total_count_change)

    def _flush(self) -> None:
        if not self._open or self.failure:
            return
        try:
            self._check_space()
            with self._lock:
                _flush_storage(self._writer.storage)
        except Exception as error:
            self.failure = f"recording to {self.path} failed ({error})"

    def _check_space(self) -> None:
        free = shutil.disk_usage(self.path.parent).free
        least = int(os.environ.get("FLEX_IDENT_LEAST_FREE_BYTES", LEAST_FREE_BYTES))
        if free < least:
            raise BagError(f"{free / 2**20:.0f} MiB free, {least / 2**20:.0f} MiB needed")

    def close(self) -> None:
        """End the recording; the bag is complete then."""
        if not self._open:
            return
        self._open = False
        self._timer.cancel()
        for made in self._subscriptions.values():
            self._node.destroy_subscription(made)
        with self._lock:
            try:
                self._writer.close()
            except Exception as error:
                self.failure = self.failure or f"closing {self.path} failed ({error})"


def _flush_storage(storage: Any) -> None:
    """Hand what is buffered to the operating system: an MCAP chunk, or an sqlite3 transaction."""
    if hasattr(storage, "close_chunk"):
        if storage.chunk.bio.tell():
            storage.close_chunk()
        storage.bio.flush()
    else:
        storage.conn.commit()


def message_class(message_type: str) -> Any:
    """The Python class of `pkg/msg/Name`; None when it is not installed."""
    parts = message_type.split("/")
    if len(parts) != 3:
        return None
    try:
        return getattr(importlib.import_module(f"{parts[0]}.{parts[1]}"), parts[2], None)
    except ImportError:
        return None


def installed_definition(message_type: str) -> str | None:
    """The text of an installed .msg file; None when there is none."""
    package, _, name = message_type.split("/")
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        path = Path(prefix) / "share" / package / "msg" / f"{name}.msg"
        if prefix and path.is_file():
            return path.read_text(encoding="utf-8")
    return None


def unique_folder(directory: Path, stem: str, taken: Sequence[str] = ()) -> Path:
    """A folder name that does not exist yet."""
    for k in range(1000):
        path = directory / (stem if k == 0 else f"{stem}_{k}")
        if not path.exists() and path.name not in taken:
            return path
    raise BagError(f"recording.directory: {directory} holds a thousand recordings named {stem}.")
