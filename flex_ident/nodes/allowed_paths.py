"""Paths given over the network stay inside the folders that the configuration allows."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flex_ident.errors import UsageError


def allowed_path(text: str, folders: Sequence[str], *, what: str) -> Path:
    """The path of a bag or file inside one of `folders`, links followed, all its files included.

    A relative path is taken in the first folder. Raises UsageError when it is empty or reaches outside.
    """
    if not text:
        raise UsageError(f"parameter '{what}' is empty: set it to a path inside {', '.join(folders)}.")
    try:
        roots = [Path(f).expanduser().resolve() for f in folders]
        path = Path(text).expanduser()
        resolved = (path if path.is_absolute() else roots[0] / path).resolve()
        inside = [resolved, *(p.resolve() for p in resolved.iterdir())] if resolved.is_dir() else [resolved]
    except (OSError, RuntimeError) as error:  # links in a circle, a name too long, a user that there is not
        raise UsageError(f"{what} '{text[:80]}' is no path that can be followed ({error}).") from error
    if not all(any(p.is_relative_to(root) for root in roots) for p in inside):
        raise UsageError(f"{what} '{text}' lies outside the folders allowed: {', '.join(map(str, roots))}.")
    return resolved


def refuse_outside(text: str, begun: str, *, what: str) -> None:
    """Refuse a folder to write to that lies outside the one that the node was started with, links followed.

    An empty `text` is nowhere, which is always allowed; an empty `begun` allows nothing else. Raises UsageError.
    """
    if not text:
        return
    try:
        inside = bool(begun) and _resolved(text).is_relative_to(_resolved(begun))
    except (OSError, RuntimeError) as error:
        raise UsageError(f"{what} '{text[:80]}' is no path that can be followed ({error}).") from error
    if not inside:
        allowed = f"inside '{begun}', with which the node was started" if begun else "empty, as the node was started"
        raise UsageError(f"{what} '{text[:80]}' is refused: at run time it must stay {allowed}.")


def _resolved(text: str) -> Path:
    return Path(text).expanduser().resolve()
