"""Standard output and standard error of a command, which never end its work: closed, or left by their reader."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO


class _Patient(io.FileIO):
    """A file descriptor that takes everything: after an error, which is noted, what is written goes nowhere."""

    def __init__(self, descriptor: int, failures: list[OSError]) -> None:
        super().__init__(descriptor, "wb", closefd=False)
        self._failures = failures
        self._lost = False

    def write(self, data: Any, /) -> int:
        if not self._lost:
            try:
                return super().write(data)
            except BlockingIOError:
                raise
            except OSError as error:
                self._lost = True
                if not isinstance(error, BrokenPipeError):
                    self._failures.append(error)
        return memoryview(data).nbytes


@contextmanager
def lasting_streams() -> Iterator[list[OSError]]:
    """Standard streams, within the block, to which writing raises nothing.

    A closed stream is led into nothing, and so is one whose reader left, as `head` does. What else went wrong with
    standard output is in the list: at most one error, and all of them once it is flushed.
    """
    _open_descriptors()
    before = sys.stdout, sys.stderr
    failures: list[OSError] = []
    sys.stdout = _lasting(before[0], sys.__stdout__, failures)
    sys.stderr = _lasting(before[1], sys.__stderr__, [])
    try:
        yield failures
    finally:
        for stream in (sys.stdout, sys.stderr):
            with suppress(OSError, ValueError):
                stream.flush()
        sys.stdout, sys.stderr = before


def _open_descriptors() -> None:
    """Lead closed standard descriptors into nothing: or the next file opened has one, and is written into."""
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # the lowest that is free: this one


def _lasting(stream: TextIO | None, original: TextIO | None, failures: list[OSError]) -> TextIO:
    """A stream with the encoding and buffering of `stream`; itself where someone put it in the original's place."""
    if stream is None:
        return open(os.devnull, "w", encoding="utf-8", errors="replace")
    if stream is not original or not isinstance(stream, io.TextIOWrapper):
        return stream
    with suppress(OSError, ValueError):
        stream.flush()
    return io.TextIOWrapper(
        io.BufferedWriter(_Patient(stream.fileno(), failures)), encoding=stream.encoding, errors=stream.errors,
        line_buffering=stream.line_buffering, write_through=stream.write_through,
    )  # fmt: skip
