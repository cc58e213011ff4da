"""Commands and the reference, sent tick by tick from a thread with a steady clock."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rclpy.node import Node
from sensor_msgs.msg import JointState

from flex_ident.commands.common import one_line
from flex_ident.excitation import Output
from flex_ident.excitation.guarding import Beat
from flex_ident.excitation.output import MOVING
from flex_ident.nodes.command_clock import CommandClock, Punctuality, RosTime
from flex_ident.nodes.command_messages import CommandMessages
from flex_ident.nodes.command_topic import CommandTopic
from flex_ident.nodes.joint_messages import ReferenceMessages

RAMP_S = 5.0
"""Time in which a joint that still moves when the node ends must have come to rest."""


class Commander:
    """Asks `step` at each tick what to command, publishes it with the reference, and has the reference recorded."""

    def __init__(
        self, node: Node, commands: CommandTopic, step: Callable[[float], Output],
        record: Callable[[str, bytes, int], None],
    ) -> None:  # fmt: skip
        self._commands, self._guard, self._step, self._record = commands, commands.guard, step, record
        self._publisher = node.create_publisher(JointState, "~/reference", 100)
        self.topic = str(self._publisher.topic_name)
        self._ros_time = RosTime(lambda: int(node.get_clock().now().nanoseconds))
        self._clock: CommandClock | None = None

    def start(self, commands: CommandMessages, joint: str, rate_hz: float) -> None:
        """Begin to tick."""
        self._guard.begin()
        self._joint = joint
        self._messages, self._references = commands, ReferenceMessages(joint)
        self._punctuality = Punctuality(rate_hz)
        self._clock = CommandClock(rate_hz, self._tick)
        self._clock.start()

    def _tick(self, now: float, late: float, skipped: int) -> bool:
        output = self._step(now)
        stamp = self._ros_time.at(now)
        moving = output.state in MOVING
        if output.command is not None and not (output.left and self._guard.lives):
            rows, (safe, others) = self._messages, output.safe
            self._commands.publish(rows.message(rows.row(self._joint, output.command, output.others)))
            row, standing = rows.row(self._joint, safe, others), (output.command, *output.others)
            beat = Beat(now, moving, output.lease_s if moving else 0.0, row, rows.joints)
            if output.hold is not None:
                beat = replace(beat, hold=output.hold, standing=standing, position=output.seen)
            self._guard.beat(beat)
        data = self._references.message(output, stamp)
        self._publisher.publish(data)
        self._record(self.topic, data, stamp)
        if output.state == "exciting":
            self._punctuality.add(now, late, skipped)
        return moving

    @property
    def ticking(self) -> bool:
        """Whether commands are being sent."""
        return self._clock is not None and self._clock.ticking

    @property
    def error(self) -> str:
        """Why the ticks have ended, when it was an error; else empty."""
        error = None if self._clock is None or self._clock.ticking else self._clock.error
        return f"commands cannot be published ({type(error).__name__}: {one_line(error)})" if error else ""

    def finish(self) -> str:
        """How punctual the commands were, once they are over; empty when there were none."""
        clock, self._clock = self._clock, None
        if clock is None:
            return ""
        return f"{self._punctuality}{', real-time priority' if clock.real_time and self._punctuality.known else ''}"

    def end(self) -> None:
        """Wait until the joint has come to rest, then tick no more."""
        if self._clock is not None:
            self._clock.join(RAMP_S)
            self._clock.stop()
