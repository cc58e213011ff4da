"""The recording of one run: what goes into the bag, what is missing in it, and what is said of it at the end."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rclpy.node import Node

from flex_ident import __version__
from flex_ident.excitation import Limits
from flex_ident.nodes.exciter_settings import TOPICS
from flex_ident.nodes.joint_messages import JOINT_STATE
from flex_ident.nodes.raw_topics import RawTopics
from flex_ident.nodes.recorder import Recorder, opened_recorder


class RunRecording:
    """No recording between runs; `path` is that of the latest one, None when there is none."""

    def __init__(self, node: Node, own: Sequence[str]) -> None:
        """`own` are the topics of joint states that the node writes itself."""
        self._node, self._own = node, tuple(own)
        self.raw = RawTopics(node)
        self.path: Path | None = None
        self._recorder: Recorder | None = None

    def open(self, values: dict[str, Any], limits: Limits) -> None:
        """Open a bag, unless none is wanted. Raises FlexIdentError."""
        self._recorder, self.path = None, None
        directory = str(values["recording.directory"])
        if not directory:
            return
        information = {
            "flex_ident_version": __version__,
            "flex_ident_parameters": json.dumps(values),
            "flex_ident_limits": json.dumps({k: str(v) for k, v in vars(limits).items()}),
        }
        recorder = opened_recorder(
            self._node, self.raw, Path(directory), values, information, values[TOPICS], self._own
        )  # fmt: skip
        for topic in self._own:
            recorder.announce(topic, JOINT_STATE)
        recorder.find_topics()
        self._recorder, self.path = recorder, recorder.bag.path
        if recorder.unpublished:
            self._node.get_logger().warning(f"not received so far: {recorder.unpublished}")

    def __str__(self) -> str:
        return f"recording to {self.path or 'nowhere'}"

    @property
    def unpublished(self) -> str:
        """Topics wanted that are not being received; empty when all are."""
        return "" if self._recorder is None else self._recorder.unpublished

    @property
    def failure(self) -> str:
        """Why nothing is recorded any more; empty while all is well."""
        return "" if self._recorder is None else self._recorder.bag.failure

    def write(self, topic: str, data: bytes, stamp_ns: int | None = None) -> None:
        """Record a message as of an instant of ROS time, of now without one."""
        recorder = self._recorder
        if recorder is not None:
            recorder.write(topic, data, stamp_ns)

    def find_topics(self) -> None:
        """Subscribe to what has appeared of the topics wanted, and say what stops or thins out."""
        self.raw.follow()
        if self._recorder is not None:
            self._recorder.find_topics()
            for change in self._recorder.changes():
                self._node.get_logger().warning(change)

    def close(self) -> str:
        """Close the bag and say what is in it; why recording ended early, empty when it did not."""
        recorder, self._recorder = self._recorder, None
        if recorder is None:
            return ""
        recorder.close()
        log = self._node.get_logger()
        lost = recorder.lost
        failure = recorder.bag.failure
        told = f"recorded {recorder.bag.messages} messages to {self.path}, "
        if failure:
            log.error(f"{told}and what came after that is lost: {failure}")
        elif lost:
            log.warning(f"{told}{lost} lost")
        else:
            log.info(f"{told}0 lost")
        log.info(recorder.paces())
        if recorder.silent:
            log.warning(f"not in the recording: {recorder.silent}")
        return failure
