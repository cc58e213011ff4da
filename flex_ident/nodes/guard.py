"""The guard of an exciter, a process of its own: it stops the joint when the exciter dies or stands still.

Under effort commands it watches the joint states itself, of which it keeps the latest and reads none before it acts.
Heartbeats come on standard input and end with the exciter, however that ends; what the guard has to say leaves on
standard output, a line each. It takes no signal but SIGKILL: it ends when there is nothing left to guard.
"""

from __future__ import annotations

import json
import math
import os
import resource
import select
import signal
import sys
import time
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NoReturn

import rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from sensor_msgs.msg import JointState

from flex_ident.excitation import JointSample
from flex_ident.excitation.guarding import Beat, Guarding
from flex_ident.excitation.holding import Hold
from flex_ident.nodes.command_clock import real_time
from flex_ident.nodes.command_messages import CommandMessages
from flex_ident.nodes.joint_samples import joint_sample
from flex_ident.nodes.raw_topics import Polled

READY, TAKEN, WATCH = "ready", "taken over", b"watch"
"""What the guard says, and what it is told beside heartbeats: to listen to the joint states."""
HEARD_S = 0.5
"""Time without a joint state after which the guard hears none."""
AT_ONCE_S = 0.002
"""How long heartbeats are collected before they are looked at together."""
PIPE_BYTES = 65536
LONGEST_SPIN_US = 3_000_000
"""Processor time, us, after which a guard that never waits is killed."""
LOOK_S = 0.1
KEPT = 100
"""Joint states that are kept: a tenth of a second and more."""


@dataclass(frozen=True)
class Post:
    """Where a guard stands: its node's name and namespace, the commands that it may have to send, the joint states."""

    name: str
    namespace: str
    topic: str
    kind: str
    period_s: float
    states: str


class LatestStates:
    """The joint states of the last while, as bytes with the instants at which they came, s."""

    def __init__(self, node: Node, topic: str) -> None:
        quality = QoSProfile(depth=KEPT, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._clock = node.get_clock()
        self._subscription = node.create_subscription(
            JointState, topic, lambda _: None, quality, raw=True, callback_group=Polled()
        )
        self._kept: deque[tuple[float, float, bytes]] = deque(maxlen=KEPT)
        self._latest = -math.inf

    def take(self) -> None:
        """Keep what has come."""
        now, ros_now = time.monotonic(), 1e-9 * self._clock.now().nanoseconds
        handle, kind = self._subscription.handle, self._subscription.msg_type
        with handle:
            while (taken := handle.take_message(kind, True)) is not None:
                self._kept.append((now, ros_now, taken[0]))
                self._latest = now

    def heard(self) -> bool:
        """Whether joint states come."""
        return time.monotonic() - self._latest < HEARD_S

    def read(self, hold: Hold) -> Iterator[JointSample | None]:
        """What was kept, each once; None where it cannot be read."""
        while self._kept:
            received, ros_now, data = self._kept.popleft()
            try:
                yield joint_sample(data, hold.joint, hold.held, received, ros_now)
            except Exception:  # whatever rclpy makes of bytes that are no joint state
                yield None


class Guard:
    """Heartbeats in, at most one command at a time out."""

    def __init__(self, post: Post) -> None:
        self._post = post
        self._rules = Guarding()
        self._node = rclpy.create_node(
            post.name, namespace=post.namespace, use_global_arguments=False, start_parameter_services=False,
            enable_rosout=False,
        )  # fmt: skip
        self._publisher = self._node.create_publisher(
            CommandMessages(post.kind, (), post.period_s).message_class, post.topic, 10
        )
        self._messages = CommandMessages(post.kind, (), post.period_s)
        self._states: LatestStates | None = None
        self._rest = b""
        self._said = ""
        self._told = False

    def run(self) -> None:
        """Guard until nothing is left to guard."""
        while not self._rules.finished(time.monotonic()):
            self._say_how_it_stands()
            self._take(min(LOOK_S, self._rules.wait_s(time.monotonic())))
            now = time.monotonic()
            if self._rules.overdue(now):
                self._take(0.0)  # who was held up itself has beats waiting
            self._watch()
            beat = self._rules.due(now)
            if beat is not None:
                self._send(beat)
            self._told = self._told and self._rules.taken_over

    def _say_how_it_stands(self) -> None:
        """Who takes the guard's commands, and whether it hears the joint states, when that changes."""
        count, heard = self._publisher.get_subscription_count(), self._states is not None and self._states.heard()
        if self._said != (said := f"{count} {int(heard)}"):
            self._said = said
            say(f"{READY} {said} {self._mark()}" if count else "nobody listens")

    def _watch(self) -> None:
        """Keep the joint states where efforts are commanded, and read them when the joint is the guard's."""
        hold = self._rules.hold
        if hold is not None:
            self._listen()
        if self._states is None:
            return
        self._states.take()
        if hold is not None and self._rules.taken_over:
            for sample in self._states.read(hold):
                self._rules.observe(sample)

    def _listen(self) -> None:
        """Listen to the joint states from now on."""
        if self._states is None:
            self._states = LatestStates(self._node, self._post.states)

    def _mark(self) -> str:
        """The mark by which DDS knows the publisher: its node's name gets around later."""
        infos = self._node.get_publishers_info_by_topic(self._publisher.topic_name)
        return next((bytes(i.endpoint_gid).hex() for i in infos if i.node_name == self._post.name), "")

    def _take(self, wait_s: float) -> None:
        """Take heartbeats as they come."""
        if self._rules.alone:  # at its end a pipe is readable for ever
            time.sleep(wait_s)
            return
        readable, _, _ = select.select([0], [], [], wait_s)
        if not readable:
            return
        data = os.read(0, PIPE_BYTES)
        if not data:
            self._rules.gone()
            return
        *lines, self._rest = (self._rest + data).split(b"\n")
        if WATCH in lines:
            self._listen()
        for line in [line for line in lines if line != WATCH][-1:]:
            with suppress(ValueError, TypeError):
                self._rules.beat(Beat.read(line))
        if not self._rules.taken_over:
            time.sleep(AT_ONCE_S)

    def _send(self, beat: Beat) -> None:
        if self._messages.joints != beat.joints:
            self._messages = CommandMessages(self._post.kind, beat.joints, self._post.period_s)
        self._publisher.publish(self._messages.message(beat.row))
        if not self._told:
            self._told = True
            say(TAKEN)
            late = time.monotonic() - beat.sent
            row = ", ".join(f"{value:.4g}" for value in beat.row)
            with suppress(OSError):
                print(
                    f"{self._post.name}: no heartbeat for {late:.2f} s: stops the joint, {row} on {self._post.topic}",
                    file=sys.stderr, flush=True,
                )  # fmt: skip


def say(text: str) -> None:
    """A line to the exciter, which may be gone."""
    with suppress(OSError):
        os.write(1, text.encode() + b"\n")


def main(arguments: list[str] | None = None) -> NoReturn:
    """Guard the exciter that started this process; its one argument is the post as JSON."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    with suppress(ValueError, OSError):  # one that spins, where it should wait, must not keep the machine from others
        resource.setrlimit(resource.RLIMIT_RTTIME, (LONGEST_SPIN_US, LONGEST_SPIN_US))
    real_time()
    given: dict[str, Any] = json.loads((sys.argv[1:] if arguments is None else arguments)[0])
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    Guard(Post(**given)).run()
    os._exit(0)  # what is left of DDS may wait for others that are gone


if __name__ == "__main__":
    main()
