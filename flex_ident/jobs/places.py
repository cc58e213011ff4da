"""Where the results of a job go, and what happens when they cannot go there."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from flex_ident.configuration.settings import Value
from flex_ident.errors import UsageError
from flex_ident.recording import Recording
from flex_ident.recording.names import at_home
from flex_ident.report.folder import check_writable, folder_name, own_folder

SUFFIXES = (".zstd", ".mcap", ".db3", ".bag")
DEFAULT = Path("flex_ident_results")
Folder = Callable[[str], Path | None]
"""The folder for the results of a joint, None for none."""


@dataclass(frozen=True)
class Place:
    """Where results go: `folder` says it for each joint.

    `shared`: the folder is named after bag and joint, so that another bag's results may be there: these go beside it.
    `needed`: a result that cannot be written is an error at once; else it is handed back with why it was not written.
    """

    folder: Folder
    shared: bool = True
    needed: bool = True

    def found(self, recording: Recording) -> tuple[Path | None, UsageError | None]:
        """The folder for this recording, and why it cannot be written. Raises UsageError when it is `needed`."""
        folder = self.folder(recording.joint)
        if folder is None:
            return None, None
        if self.shared:
            folder = own_folder(folder, recording)
        try:
            check_writable(folder)
        except UsageError as error:
            if self.needed:
                raise
            return None, error
        return folder, None


def place_of(values: Mapping[str, Value], bag: Path, *, many: bool = False, needed: bool = True) -> Place:
    """The place that `out` names, with the joint's name below it when there are several, or the default.

    Raises UsageError when `out` cannot be written and is `needed`.
    """
    if not values["out"]:
        return Place(lambda joint: DEFAULT / f"{bag_name(bag)}_{folder_name(joint)}", needed=needed)
    base = at_home(str(values["out"]))
    if needed:
        check_writable(base)
    return Place(lambda joint: base / folder_name(joint) if many else base, shared=False, needed=needed)


def bag_name(bag: Path) -> str:
    """The bag's name without what says its kind."""
    stem = bag.resolve().name
    for suffix in SUFFIXES:
        stem = stem.removesuffix(suffix)
    return folder_name(stem)
