"""What a controller says of itself, and whether the commands that are meant for it are of its kind."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Controller:
    """One of ros2_control's by its parameters; what it does not have is None."""

    name: str
    joints: tuple[str, ...]
    """In the order in which it takes commands."""
    interface: str | None = None
    partial: bool | None = None
    """Whether a trajectory may name fewer joints than it has."""
    from_desired: bool | None = None
    """Whether a trajectory begins where the one before wanted the joint to be, and not where it was measured."""

    def completed(self, kind: str, joint: str, joints: list[str]) -> list[str]:
        """`command.joints`, filled in where it is empty: `kind` is `forward_command` or `joint_trajectory`."""
        alone = kind == "joint_trajectory" and self.partial
        return joints or ([joint] if alone else list(self.joints))

    def objection(self, kind: str, interface: str, joint: str, joints: list[str]) -> str:
        """Why it must not be sent such commands; empty when it may."""
        its, given = ", ".join(self.joints), ", ".join(joints)
        if joint not in self.joints:
            return f"{self.name} commands {its}, and not '{joint}': check joint and command.topic."
        if kind == "forward_command":
            if self.interface is not None and self.interface != interface:
                return (
                    f"{self.name} takes commands of {self.interface}, command.interface is {interface}: change that or "
                    "command.topic."
                )
            if joints and tuple(joints) != self.joints:
                return (
                    f"{self.name} takes commands for {its}, in that order, command.joints holds {given}: joints would "
                    "jump to each other's positions. Give them in its order, or leave command.joints empty."
                )
            return ""
        if unknown := [j for j in joints if j not in self.joints]:
            return f"{self.name} does not command {', '.join(unknown)} of command.joints, but {its}: correct them."
        missing = [j for j in self.joints if joints and j not in joints]
        if missing and self.partial is False:
            return (
                f"{self.name} rejects trajectories without all of its joints (allow_partial_joints_goal is false), "
                f"command.joints lacks {', '.join(missing)}: add them, or leave it empty."
            )
        return ""

    def advice(self, kind: str) -> str:
        """What about it makes the joint follow worse than it could; empty when nothing does."""
        if kind != "joint_trajectory" or self.from_desired is not False:
            return ""
        return (
            f"{self.name} begins each trajectory where the joint was measured (interpolate_from_desired_state is "
            "false): the joint lags, and its feedback is in the commands. Set it true."
        )
