"""The job of a node that answers one call at a time: how far it is, how it ended, and how it is stopped."""

from __future__ import annotations

import threading
from collections.abc import Callable

STAGES = {"reading": (0.0, 0.1), "identifying": (0.1, 0.85), "explaining": (0.1, 0.85), "writing": (0.95, 0.05)}
"""Where each stage of one recording begins, and its share of the whole."""
TOGETHER = 0.2
"""Share of what is done with all recordings of a set after each has been read by itself."""
IDLE = "idle"


class JobProgress:
    """The share of a whole job that is done, from what its stages say of theirs: it never goes back."""

    def __init__(self, recordings: int = 1) -> None:
        self._recordings = max(1, recordings)
        self._names: list[str] = []
        self._together: list[str] = []
        self.share = 0.0

    def told(self, text: str, share: float) -> None:
        """A stage, by its words, has done this share of its work: `reading`, or in a set `reading NAME`."""
        stage, _, name = text.partition(" ")
        share = min(1.0, max(0.0, share))
        if stage in STAGES and not name.endswith(" again"):
            if name not in self._names:
                self._names.append(name)
            begin, part = STAGES[stage]
            done = (self._names.index(name) + begin + part * share) / self._recordings
            done = min(done, 1.0) * (1.0 - (TOGETHER if self._recordings > 1 else 0.0))
        else:
            if text not in self._together:
                self._together.append(text)
            steps = max(len(self._together), 2 * self._recordings)
            done = 1.0 - TOGETHER * (1.0 - (self._together.index(text) + share) / steps)
        self.share = max(self.share, done)


class Job:
    """One at a time; `changed` is called whenever there is something new to say of it."""

    def __init__(self, changed: Callable[[], None]) -> None:
        self._changed = changed
        self._lock = threading.Lock()
        self._progress = JobProgress()
        self._why = ""
        self.name = IDLE
        self.ended = ""
        """How the latest one ended: a verdict, or why there is none; empty before the first and during the next."""
        self.failed = self.stopped = False

    @property
    def busy(self) -> bool:
        """Whether one runs."""
        return self._lock.locked()

    @property
    def percent(self) -> int:
        """How much of it is done; of the latest one when none runs."""
        return int(100 * self._progress.share)

    def begin(self, name: str, recordings: int) -> bool:
        """Begin one over so many recordings; False while another runs."""
        if not self._lock.acquire(blocking=False):
            return False
        self._progress, self._why = JobProgress(recordings), ""
        self.name, self.ended, self.failed, self.stopped = name, "", False, False
        self._changed()
        return True

    def told(self, text: str, share: float) -> None:
        """Take what a stage says of its progress."""
        before = self.percent
        self._progress.told(text, share)
        if self.percent != before:
            self._changed()

    def stop(self, why: str) -> bool:
        """Ask it to stop; False when none runs."""
        self._why = why
        return self.busy

    def stopping(self) -> bool:
        """Whether it is to stop."""
        return bool(self._why)

    def end(self, how: str, *, failed: bool = False) -> None:
        """It has ended, with a verdict or, when it failed, because of what is said."""
        self.ended, self.failed, self.stopped = how, failed, failed and self.stopping()
        if not failed:
            self._progress.share = 1.0
        self.name = IDLE
        self._lock.release()
        self._changed()

    @property
    def why_stopped(self) -> str:
        """What it was asked to stop for."""
        return self._why
