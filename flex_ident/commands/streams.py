"""Standard output and standard error of a command, which never end its work: closed, left by their reader, or unable to
show a character.
"""

from __future__ import annotations

import codecs
import io
import os
import select
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO

from flex_ident.errors import UsageError
from flex_ident.stopping import stopped

PLAIN = {
    "±": "+-", "×": "x", "·": "*", "°": "deg", "²": "^2", "³": "^3", "−": "-", "–": "-", "…": "...", "→": "->",
    "≤": "<=", "≥": ">=", "≈": "~", "µ": "u", "’": "'", "σ": "sigma", "√": "sqrt",
}  # fmt: skip
"""What stands for a character that an encoding lacks."""
PLAINLY = "flex_ident_plainly"
"""The name by which Python knows `_plainly`."""


READY_S = 0.2
"""Time, s, that a reader has to take what is left when a signal has ended the work."""


class _Patient(io.FileIO):
    """A file descriptor that takes everything: after an error, which is noted, what is written goes nowhere.

    Once a signal has ended the work, a reader that takes nothing is not waited for.
    """

    def __init__(self, descriptor: int, failures: list[OSError]) -> None:
        super().__init__(descriptor, "wb", closefd=False)
        self._failures = failures
        self._lost = False

    def write(self, data: Any, /) -> int:
        if stopped() and not select.select([], [self], [], READY_S)[1]:
            self._lost = True
        if not self._lost:
            try:
                return super().write(memoryview(data)[: select.PIPE_BUF] if stopped() else data)
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
    standard output is in the list: at most one error, and all of them once it is flushed. Characters that a stream's
    encoding lacks are replaced.
    """
    codecs.register_error(PLAINLY, _plainly)
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


def refuse_unprintable(text: str) -> None:
    """Raise UsageError where standard output cannot show a document as it is: nothing stands in for what it lacks."""
    encoding = sys.stdout.encoding or "utf-8"
    try:
        text.encode(encoding)
    except UnicodeEncodeError as error:
        character = _plain(text[error.start])
        raise UsageError(f"standard output, in {encoding}, lacks the character {character}: use --out FILE.") from error


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
        return open(os.devnull, "w", encoding="utf-8", errors=PLAINLY)
    if stream is not original or not isinstance(stream, io.TextIOWrapper):
        return stream
    with suppress(OSError, ValueError):
        stream.flush()
    return io.TextIOWrapper(
        io.BufferedWriter(_Patient(stream.fileno(), failures)), encoding=stream.encoding, errors=PLAINLY,
        line_buffering=stream.line_buffering, write_through=stream.write_through,
    )  # fmt: skip


def _plainly(error: UnicodeError) -> tuple[str | bytes, int]:
    r"""What stands for characters that cannot be encoded: PLAIN's, else `\xff` and the like."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_plain(c) for c in error.object[error.start : error.end]), error.end


def _plain(character: str) -> str:
    if "\udc80" <= character <= "\udcff":  # a byte of a path that is not UTF-8
        return f"\\x{ord(character) - 0xDC00:02x}"
    return PLAIN.get(character) or character.encode("ascii", "backslashreplace").decode("ascii")
