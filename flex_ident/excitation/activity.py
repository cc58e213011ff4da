"""Which controllers are active, by what a controller manager tells the diagnostics of them once a second."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

ACTIVE = "active"
STATUS, SUFFIX = "Controllers Activity", ".state"
"""How ros2_control ends the name of that status, and, in later versions, the keys in it."""
FRESH_S = 2.5
"""How long such a word counts."""


class Activity:
    """What was last heard of each controller, by its name without namespace.

    Robots may share the diagnostics: where one says that a controller of that name is active, nothing is known.
    """

    def __init__(self) -> None:
        self._active: dict[str, float] = {}
        self._other: dict[str, tuple[float, str]] = {}

    def hear(self, now: float, status: str, values: Mapping[str, str]) -> None:
        """Take a status of the diagnostics: its name, and its values by their keys."""
        if not status.endswith(STATUS):
            return
        for key, label in values.items():
            name = key.removesuffix(SUFFIX)
            if label == ACTIVE:
                self._active[name] = now
            else:
                self._other[name] = now, label

    def objection(self, now: float, controllers: Iterable[str]) -> str:
        """Which of the controllers, by their full names, is not active; empty when none is known not to be."""
        for full in controllers:
            name = full.rpartition("/")[2]
            heard, label = self._other.get(name, (-FRESH_S, ""))
            if now - heard < FRESH_S <= now - self._active.get(name, -FRESH_S):
                return f"{full} is {label}, as its controller manager says: activate it, then call again."
        return ""
