"""zstd, lz4 and bz2, from whichever library is installed with rosbags; damaged data as far as it goes.

What expands is bounded: a chunk or message by what its header announces and by `LARGEST`, a bag by a `Budget`. A
small file cannot fill the memory, the disk or an hour.
"""

from __future__ import annotations

import bz2
import importlib
from collections.abc import Callable, Iterable, Iterator
from typing import BinaryIO, Protocol

import numpy as np
from numpy.typing import NDArray

from flex_ident.errors import BagError

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
PIECE = 1 << 16
"""Bytes of compressed data that are looked at together."""
EXPANDED = 4 << 20
"""Plain bytes that are taken out at once."""
LARGEST = 112 << 20
"""Plain bytes of one chunk or message, at most."""
FREE, RATIO = 128 << 20, 200
"""Plain bytes of a bag, at most: so many, and so many for each compressed byte. Joint states shrink by 3 to 100."""
WASTE_RATIO = 10
"""The same for plain bytes of a bag that turn out to be no messages."""
FRAMES, FRAME_BYTES = 64, 4096
"""Frames in one piece of data, at most: so many, and one for so many bytes of it."""
WINDOW_LOG = 27
"""Memory that a zstd frame may ask for, as a power of two: 128 MiB, zstd's own limit without --long."""
SMALL = 1024
"""Compressed bytes given at once to a library that cannot be told when to stop: 32 MiB of plain ones at most."""


class _Frame(Protocol):
    """Decompresses one frame, piece by piece: no more than `max_length` bytes at a time."""

    @property
    def eof(self) -> bool: ...

    @property
    def needs_input(self) -> bool: ...

    @property
    def unused_data(self) -> bytes | None: ...

    def decompress(self, data: bytes, /, max_length: int) -> bytes: ...


class Budget:
    """What a bag may still expand to."""

    def __init__(self) -> None:
        self._left, self._waste = FREE, FREE

    def earn(self, packed: int) -> None:
        """Allow for `packed` further compressed bytes."""
        self._left += RATIO * packed
        self._waste += WASTE_RATIO * packed

    def waste(self, plain: int) -> None:
        """Note `plain` bytes that were no messages. Raises TooMuchError when they are too many."""
        self._waste -= plain
        if self._waste < 0:
            raise TooMuchError(f"and those before it expand to over {FREE >> 20} MiB of what are no messages.")

    def check(self, announced: int) -> None:
        """Raises BagError when so many bytes are announced as the bag may not expand to."""
        if announced > min(LARGEST, self._left):
            raise BagError(f"a chunk announces {announced} bytes: {min(LARGEST, max(0, self._left))} may be read.")

    def spend(self, plain: int) -> None:
        """Take `plain` bytes off. Raises TooMuchError, naming the limit, when there are not as many left."""
        self._left -= plain
        if self._left < 0:
            raise TooMuchError(
                f"expands to over {RATIO} times its size and {FREE >> 20} MiB: this is no recording. Decompress it "
                "yourself, if you trust it."
            )


class TooMuchError(BagError):
    """Compressed data that expands beyond every measure."""


class _CutError(Exception):
    """The compressed data ends before its end."""


def decompressed(
    data: memoryview | bytes, compression: str, size: int | None = None, budget: Budget | None = None
) -> NDArray[np.uint8]:
    """The plain bytes (k,) of a chunk or message. Raises BagError when they are damaged or too many.

    `size` is the length announced, None when it is not known.
    """
    if compression == "":
        return np.frombuffer(data, np.uint8)
    budget = budget or Budget()
    budget.earn(len(data))
    budget.check(size or 0)
    most = LARGEST if size is None else size
    plain = bytearray()
    try:
        for piece in _expanded([bytes(data)], compression, size if size is not None and size <= EXPANDED else EXPANDED):
            budget.spend(len(piece))
            if not plain and len(piece) == size:
                plain = piece  # type: ignore[assignment]  # all of it: no need for a copy
                continue
            plain += piece
            if len(plain) > most:
                raise BagError(f"a {compression} chunk holds more than the {most} bytes announced.")
    except _CutError as error:
        raise BagError(f"a {compression} chunk is cut.") from error
    except TooMuchError:
        raise
    except BagError:
        budget.waste(len(plain))
        raise
    if size is not None and len(plain) != size:
        budget.waste(len(plain))
        raise BagError(f"a {compression} chunk holds {len(plain)} bytes, {size} were announced.")
    return np.frombuffer(plain, np.uint8)


def salvaged(
    data: memoryview | bytes, compression: str, size: int | None = None, budget: Budget | None = None
) -> NDArray[np.uint8]:
    """The plain bytes (k,) in front of the place where a chunk is cut or damaged; none when there are none."""
    if compression == "":
        return np.frombuffer(data, np.uint8)
    most = LARGEST if size is None else min(size, LARGEST)
    budget = budget or Budget()
    budget.earn(len(data))
    plain = bytearray()
    try:
        for piece in _expanded(_pieces(data), compression, EXPANDED):
            budget.spend(len(piece))
            plain += piece[: most - len(plain)]
            if len(plain) >= most:
                break
    except (_CutError, BagError):  # all in front of the damage is in `plain`
        pass
    return np.frombuffer(plain, np.uint8)


def decompress_file(source: BinaryIO, target: BinaryIO) -> bool:
    """Write the zstd-compressed file `source`, plain, to `target`; False when it was cut or damaged on the way.

    Needs no more memory than a piece of the file at a time. Raises TooMuchError, and OSError when the disk is full.
    """
    budget = Budget()

    def packed() -> Iterator[bytes]:
        while piece := source.read(PIECE):
            budget.earn(len(piece))
            yield piece

    try:
        for plain in _expanded(packed(), "zstd", EXPANDED):
            budget.spend(len(plain))
            target.write(plain)
    except TooMuchError:
        raise
    except (_CutError, BagError):
        return False
    return True


def _pieces(data: memoryview | bytes) -> Iterator[bytes]:
    return (bytes(data[start : start + PIECE]) for start in range(0, len(data), PIECE))


def _expanded(pieces: Iterable[bytes], compression: str, most: int) -> Iterator[bytes]:
    """The plain bytes of all frames in a row, `most` at a time. Raises BagError at damage, _CutError at a cut."""
    new_frame = _frame_of(compression)
    frame, begun, frames, packed = new_frame(), False, 0, 0
    for piece in pieces:
        packed += len(piece)
        while piece or (begun and not frame.needs_input):
            if not begun:
                frames += 1
                if frames > FRAMES + packed // FRAME_BYTES:
                    raise TooMuchError(f"holds {frames} {compression} frames in {packed} bytes: this is no recording.")
                frame, begun = new_frame(), True
            try:
                plain = frame.decompress(piece, max_length=max(1, most))
            except Exception as error:
                raise BagError(f"a {compression} chunk is damaged ({type(error).__name__}).") from error
            piece = b""
            if plain:
                yield plain
            if frame.eof:
                piece, begun = frame.unused_data or b"", False
    if begun:
        raise _CutError


class _ZstandardFrame:
    """The library `zstandard`, which cannot be told how much to give: fed in small pieces instead."""

    def __init__(self, part: _Frame) -> None:
        self._part, self._rest, self.unused_data = part, b"", b""

    @property
    def eof(self) -> bool:
        return self._part.eof

    @property
    def needs_input(self) -> bool:
        return not self._rest

    def decompress(self, data: bytes, /, max_length: int) -> bytes:
        rest = self._rest + data
        plain: bytes = self._part.decompress(rest[:SMALL])  # type: ignore[call-arg]
        self._rest = rest[SMALL:]
        if self._part.eof:
            self.unused_data, self._rest = (self._part.unused_data or b"") + self._rest, b""
        return plain


def _zstd_frame() -> Callable[[], _Frame]:
    for name in ("compression.zstd", "backports.zstd"):
        try:
            library = importlib.import_module(name)
        except ImportError:
            continue
        options = {library.DecompressionParameter.window_log_max: WINDOW_LOG}
        return lambda: library.ZstdDecompressor(options=options)
    try:
        library = importlib.import_module("zstandard")
    except ImportError as error:
        raise BagError(
            "the bag is compressed with zstd and no zstd library is installed: pip install rosbags."
        ) from error
    return lambda: _ZstandardFrame(library.ZstdDecompressor(max_window_size=1 << WINDOW_LOG).decompressobj())


def _lz4_frame() -> Callable[[], _Frame]:
    try:
        frame: Callable[[], _Frame] = importlib.import_module("lz4.frame").LZ4FrameDecompressor
    except ImportError as error:
        raise BagError("the bag is compressed with lz4 and no lz4 library is installed: pip install lz4.") from error
    return frame


_FRAMES: dict[str, Callable[[], Callable[[], _Frame]]] = {
    "zstd": _zstd_frame,
    "lz4": _lz4_frame,
    "bz2": lambda: lambda: bz2.BZ2Decompressor(),
}


def _frame_of(compression: str) -> Callable[[], _Frame]:
    if compression not in _FRAMES:
        raise BagError(f"compression {compression[:20]!r} is not known: zstd, lz4 and bz2 are.")
    return _FRAMES[compression]()
