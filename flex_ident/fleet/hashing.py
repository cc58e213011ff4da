"""Files hashed piece by piece, and nothing but regular files: a pipe would be waited for, a device never ends."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path

from flex_ident.parameters.documents import opened_file

PIECE = 1 << 20
"""Bytes that are read at a time."""


def hash_of(paths: Sequence[Path], start: bytes = b"") -> str:
    """SHA-256 of `start` and the bytes of all files, those below a folder in the order of their paths.

    Raises OSError, with the name of the file, for what is no file or cannot be read.
    """
    digest = hashlib.sha256(start)
    for path in paths:
        for file in sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]:
            try:
                with opened_file(file) as opened:
                    while piece := opened.read(PIECE):
                        digest.update(piece)
            except OSError as error:
                raise OSError(error.errno, error.strerror, str(file)) from error
    return digest.hexdigest()
