"""zstd, lz4 and bz2, from whichever library is installed with rosbags; damaged data as far as it goes."""

from __future__ import annotations

import bz2
import importlib
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from flex_ident.errors import BagError

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
PIECE = 1 << 16


class _Frame(Protocol):
    """Decompresses one frame, piece by piece."""

    @property
    def eof(self) -> bool: ...

    @property
    def unused_data(self) -> bytes: ...

    def decompress(self, data: bytes, /) -> bytes: ...


def _zstd_frame() -> Callable[[], _Frame]:
    for name in ("compression.zstd", "backports.zstd"):
        try:
            frame: Callable[[], _Frame] = importlib.import_module(name).ZstdDecompressor
            return frame
        except ImportError:
            continue
    try:
        library = importlib.import_module("zstandard")
    except ImportError as error:
        raise BagError(
            "the bag is compressed with zstd and no zstd library is installed: pip install rosbags."
        ) from error
    return lambda: library.ZstdDecompressor().decompressobj()


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


def decompressed(data: memoryview | bytes, compression: str, size: int = 0) -> NDArray[np.uint8]:
    """The plain bytes (k,) of a chunk or message. Raises BagError when they are damaged.

    `size` is the length announced, 0 when it is not known.
    """
    if compression == "":
        return np.frombuffer(data, np.uint8)
    frame = _frame_of(compression)
    pieces, rest = [], bytes(data)
    while rest:
        part = frame()
        try:
            pieces.append(part.decompress(rest))
        except Exception as error:
            raise BagError(f"a {compression} chunk is damaged ({type(error).__name__}).") from error
        if not part.eof:
            raise BagError(f"a {compression} chunk is cut.")
        rest = part.unused_data
    plain = pieces[0] if len(pieces) == 1 else b"".join(pieces)
    if size and len(plain) != size:
        raise BagError(f"a {compression} chunk holds {len(plain)} bytes, {size} were announced.")
    return np.frombuffer(plain, np.uint8)


def salvaged(data: memoryview | bytes, compression: str) -> NDArray[np.uint8]:
    """The plain bytes (k,) in front of the place where a chunk is cut or damaged; none when there are none."""
    if compression == "":
        return np.frombuffer(data, np.uint8)
    plain = bytearray()
    try:
        part = _frame_of(compression)()
        for start in range(0, len(data), PIECE):
            plain += part.decompress(bytes(data[start : start + PIECE]))
            if part.eof:
                break
    except Exception:  # what the library raises at the damage: all before it is in `plain`
        pass
    return np.frombuffer(bytes(plain), np.uint8)


def decompress_file(source: Path, target: Path) -> bool:
    """Write the zstd-compressed file `source`, plain, to `target`; False when it was cut or damaged on the way.

    Needs no more memory than a piece of the file at a time. Raises BagError when nothing could be written.
    """
    frame = _zstd_frame()
    part, whole = frame(), False
    try:
        with source.open("rb") as packed, target.open("wb") as plain:
            while piece := packed.read(PIECE):
                while piece:
                    if whole:
                        part, whole = frame(), False
                    plain.write(part.decompress(piece))
                    whole = part.eof
                    piece = part.unused_data if whole else b""
    except OSError as error:
        raise BagError(f"{source}: cannot be decompressed to {target.parent} ({error.strerror}).") from error
    except Exception:  # what the library raises at the damage: all before it is written
        whole = False
    if not target.stat().st_size:
        raise BagError(f"{source}: the compressed file is damaged.")
    return whole


def _frame_of(compression: str) -> Callable[[], _Frame]:
    if compression not in _FRAMES:
        raise BagError(f"compression '{compression}' is not known: zstd, lz4 and bz2 are.")
    return _FRAMES[compression]()
