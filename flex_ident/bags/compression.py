"""zstd and lz4, from whichever library is installed with rosbags."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flex_ident.errors import BagError


def _zstd() -> Callable[[bytes], bytes]:
    for name in ("compression.zstd", "backports.zstd"):
        try:
            decompress: Callable[[bytes], bytes] = importlib.import_module(name).decompress
            return decompress
        except ImportError:
            continue
    try:
        library = importlib.import_module("zstandard")
    except ImportError as error:
        raise BagError(
            "the bag is compressed with zstd and no zstd library is installed: pip install rosbags."
        ) from error
    return lambda data: library.ZstdDecompressor().decompressobj().decompress(data)


def decompressed(data: memoryview, compression: str, size: int) -> NDArray[np.uint8]:
    """The decompressed bytes (k,) of a chunk or message. Raises BagError when they are damaged.

    `size` is the length announced, 0 when it is not known.
    """
    if compression == "":
        return np.frombuffer(data, np.uint8)
    try:
        if compression == "zstd":
            plain = _zstd()(bytes(data))
        elif compression == "lz4":
            plain = importlib.import_module("lz4.frame").decompress(bytes(data))
        else:
            raise BagError(f"compression '{compression}' is not known: zstd and lz4 are.")
    except BagError:
        raise
    except Exception as error:
        raise BagError(f"a {compression} chunk is damaged ({type(error).__name__}).") from error
    if size and len(plain) != size:
        raise BagError(f"a {compression} chunk holds {len(plain)} bytes, {size} were announced.")
    return np.frombuffer(plain, np.uint8)


def decompress_file(source: Path, target: Path) -> None:
    """Write the zstd-compressed file `source`, plain, to `target`. Raises BagError."""
    try:
        target.write_bytes(_zstd()(source.read_bytes()))
    except BagError:
        raise
    except Exception as error:
        raise BagError(f"{source}: the compressed file is damaged ({type(error).__name__}).") from error
