"""Messages of a topic counted by the names of joints in them."""

from __future__ import annotations

from collections import Counter

from flex_ident.errors import SignalError

FEW_ALIKE, RARE = 3, 0.01
"""Messages of the same names, in number and in share of all, up to which they are taken as damaged."""
MOST_NAMES = 1 << 14
"""Names of joints in a topic, at most: each counts once for each set or order of names that it stands in."""


class UnlikelyTopicError(SignalError):
    """A topic of which each message could be read, and all of them together are no robot's."""


class Namings:
    """How many messages of `topic` held which names."""

    def __init__(self, topic: str) -> None:
        self._topic = topic
        self._messages: Counter[tuple[str, ...]] = Counter()
        self._names = 0

    def count(self, names: tuple[str, ...], messages: int) -> None:
        """Take in messages of these names. Raises UnlikelyTopicError when there are too many names."""
        if names not in self._messages:
            self._names += len(names)
            if self._names > MOST_NAMES:
                raise UnlikelyTopicError(
                    f"{self._topic} has over {MOST_NAMES} names of joints, or of few in ever new order: this is no "
                    "robot: name another topic with --motor-position."
                )
        self._messages[names] += messages

    @property
    def misnamed(self) -> int:
        """Messages whose names hardly any other message holds: damaged ones, and no second publisher's."""
        total = self._messages.total()
        return sum(n for n in self._messages.values() if n <= FEW_ALIKE and n < RARE * total)
