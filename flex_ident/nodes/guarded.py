"""The exciter's side of its guard: it starts the process, sends heartbeats and hears what the guard has to say."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import suppress
from dataclasses import asdict

from rclpy.utilities import get_rmw_implementation_identifier

from flex_ident.excitation.guarding import Beat
from flex_ident.nodes.guard import READY, TAKEN, WATCH, Post
from flex_ident.nodes.transports import without_shared_memory


class GuardProcess:
    """A guard in a session of its own, so that what ends the exciter does not end it."""

    def __init__(self, post: Post) -> None:
        command = [sys.executable, "-m", "flex_ident.nodes.guard", json.dumps(asdict(post))]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, start_new_session=True, bufsize=0,
            env=without_shared_memory(os.environ, get_rmw_implementation_identifier()),
        )  # fmt: skip
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._beats, self._answers = self._process.stdin.fileno(), self._process.stdout.fileno()
        os.set_blocking(self._beats, False)
        os.set_blocking(self._answers, False)
        self.mark = ""
        """By which DDS knows its publisher; empty until it is ready."""
        self._ready = False
        self._listeners, self._hears, self._watches = 0, False, False
        self._taken = False
        self._deaf = False

    @property
    def pid(self) -> int:
        """The process."""
        return self._process.pid

    def __str__(self) -> str:
        return f"process {self.pid} stops the joint should this node die"

    def beat(self, beat: Beat) -> None:
        """Send a heartbeat; never waits."""
        self._tell(beat.line())

    def watch(self) -> None:
        """Have it listen to the joint states, from which it is to hold joints."""
        if not self._watches:
            self._tell(WATCH + b"\n")
            self._watches = not self._deaf

    def _tell(self, line: bytes) -> None:
        try:
            os.write(self._beats, line)
            self._deaf = False
        except BlockingIOError:
            self._deaf = True
        except OSError:
            pass  # it has died, which is seen when the node looks for it

    @property
    def lives(self) -> bool:
        """Whether the process is there."""
        return self._process.poll() is None

    def begin(self) -> None:
        """Forget what it did in the motion before."""
        self._listen()
        self._taken = False

    def problem(self, *, moving: bool, listeners: int, feedback: bool) -> str:
        """Why it would not stop the joint, or of one that moves, that it has; empty while it guards.

        `listeners`: how many take the exciter's commands, all of whom must take the guard's; `feedback`: whether it
        needs the joint states.
        """
        if feedback:
            self.watch()
        self._listen()
        status = self._process.poll()
        if status is not None:
            return f"the guard, which stops the joint should this node die, has ended (status {status})"
        if self._deaf:
            return "the guard, which stops the joint should this node die, takes no heartbeats"
        if self._taken and moving:
            return "the guard has stopped the joint, as no heartbeat came: is the machine too busy?"
        if not self._ready or (not moving and self._listeners < listeners):
            return "the guard, which stops the joint should this node die, is not ready: call again"
        if feedback and not moving and not self._hears:
            return "the guard, which stops the joint should this node die, hears no joint states yet: call again"
        return ""

    def _listen(self) -> None:
        with suppress(BlockingIOError):
            for line in os.read(self._answers, 4096).decode(errors="replace").splitlines():
                self._taken = self._taken or line == TAKEN
                if line.startswith(READY):
                    listeners, hears, *mark = line.removeprefix(READY).split()
                    self._listeners, self._hears, self.mark = int(listeners), hears == "1", "".join(mark)
                self._ready = line.startswith(READY) or (self._ready and line == TAKEN)

    def end(self) -> None:
        """Send no more heartbeats: it ends, at once when nothing moves."""
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                stream.close()
