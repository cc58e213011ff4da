"""What surrounds a run: who listens, who else commands, what is known of the robot; and what forbids to move."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Description = Literal["absent", "announced", "volatile", "here"]
"""Nobody publishes it, it has yet to arrive, it is not kept for those who come later, or it is here."""


@dataclass(frozen=True)
class Surroundings:
    """What is seen around the exciter at one instant; texts are empty where nothing is wrong."""

    commands_topic: str
    states_topic: str
    description_topic: str = "/robot_description"
    listeners: int = 0
    """How many take the commands."""
    others: str = ""
    """Names of other nodes that may command the robot."""
    states_published: bool = False
    states_publishers: tuple[str, ...] = ()
    description: Description = "absent"
    description_required: bool = False
    open_limits: tuple[str, ...] = ()
    """Keys of limits that the parameters do not give."""
    limits_problem: str = ""
    controller_problem: str = ""
    """What the controller's own parameters say against the commands, or that they have yet to arrive."""
    guard_problem: str = ""
    """Why nobody would stop the joint if the exciter died."""
    records: bool = False
    """Whether what the robot says of itself is recorded, to be identified from."""
    recording_failure: str = ""

    def missing(self) -> str:
        """What has yet to appear before anything may move; empty when all is there."""
        return (
            self._missing_description()
            or self._missing_listener()
            or self.controller_problem
            or self.guard_problem
            or ("" if self.states_published else f"nobody publishes {self.states_topic}: does the robot's driver run?")
        )

    def _missing_description(self) -> str:
        topic, limits = self.description_topic, ", ".join(self.open_limits)
        if self.description == "here":
            return ""
        if self.description_required:
            return f"no {topic} has arrived, and limits.require_urdf is true."
        if self.description == "announced":
            return f"{topic} is announced and has not arrived yet: call again."
        if limits and self.description == "volatile":
            return (
                f"{topic} is published, but not kept for those who come later, and {limits} not given: give them, or "
                "have its publisher keep it (transient local)."
            )
        return f"no {topic} has arrived and {limits} not given: give them, or publish it." if limits else ""

    def _missing_listener(self) -> str:
        if self.listeners == 0:
            return f"nobody listens on {self.commands_topic}: is the controller active?"
        if self.others:
            return f"{self.others} publishes on {self.commands_topic} too: only one may command the robot."
        return ""

    def disturbance(self) -> str:
        """What ends a motion that goes on; empty when nothing does."""
        if self.recording_failure:
            return self.recording_failure
        if self.listeners == 0:
            return f"nobody listens on {self.commands_topic} any more"
        if self.others:
            return f"{self.others} publishes on {self.commands_topic} too"
        return self.guard_problem
