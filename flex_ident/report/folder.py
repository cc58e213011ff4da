"""Folders of results: found to be writable before anything is computed, and never with files of two runs in them.

Files are written aside, in a folder within the one that they are for, and take their places by renaming once all of
them are there: a run that fails leaves the results that were there as they were.
"""

from __future__ import annotations

import os
import shutil
import tempfile
import uuid
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote

from flex_ident.errors import ConfigurationError, UsageError
from flex_ident.parameters.documents import json_document
from flex_ident.recording import Recording
from flex_ident.stopping import unbroken

REPORT, GAP_REPORT = "report.html", "gap_report.html"
"""The page of the only result in a folder, and that of `explain_gap` beside the one of `identify_bag`."""
MODELS = ("parameters.yaml", "model.yaml")
PLOTS = ("signals.png", "torque.png", "frequency_response.png", "cutoff_sweep.png", "friction.png")
GAP_PLOTS = ("gap_steps.png", "gap_where.png", "gap_torque.png")
IDENTIFICATION = ("result.json", *PLOTS)
EXPLANATION = ("gap.json", GAP_REPORT, *GAP_PLOTS)
"""Files that belong to one kind of result alone; REPORT and MODELS are the latest one's."""
LONGEST_NAME = 80
MOST_FOLDERS = 10_000


def check_writable(folder: Path, what: str = "--out") -> None:
    """Find out whether the folder can be made and written, and leave no trace. Raises UsageError when it cannot."""
    missing = []
    try:
        at = folder
        while not at.exists() and at != at.parent:
            missing.append(at)
            at = at.parent
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise _unwritable(folder, error, what) from error
    finally:
        for made in missing:
            with suppress(OSError):
                made.rmdir()


def made_folder(folder: Path, what: str = "--out") -> Path:
    """The folder, made if missing. Raises UsageError when that cannot be, or nothing can be written into it."""
    check_writable(folder, what)
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _unwritable(folder: Path, error: OSError, what: str = "--out") -> UsageError:
    return UsageError(f"{what} {folder}: cannot be written ({error.strerror or error}).")


@contextmanager
def renewed(folder: Path, stale: tuple[str, ...]) -> Iterator[Path]:
    """A folder to write files into that then take their places in `folder`, where `stale` ones are removed.

    Nothing is changed in `folder` when the block raises; a signal comes before all files take their places or after.
    Raises UsageError when a file cannot be written.
    """
    made_folder(folder)
    aside: Path | None = None
    try:
        with unbroken():
            aside = Path(tempfile.mkdtemp(prefix=".flex_ident_", dir=folder))
        yield aside
        with unbroken(), _locked(folder):
            fresh = {p.name for p in aside.iterdir()}
            for name in stale:
                if name not in fresh:
                    (folder / name).unlink(missing_ok=True)
            for name in sorted(fresh):
                os.replace(aside / name, folder / name)
    except OSError as error:
        raise _unwritable(folder, error) from error
    finally:
        with unbroken():
            if aside is not None:
                shutil.rmtree(aside, ignore_errors=True)


def write_file(path: Path, content: bytes, what: str = "--out") -> None:
    """Write one file, at once or not at all: what stood there before stays until all of it is written.

    A pipe or a device is written to as it is. Raises UsageError when it cannot be written.
    """
    target = Path(os.path.realpath(path))
    try:
        if target.exists() and not target.is_file():
            target.write_bytes(content)
            return
        aside = target.with_name(f".flex_ident_{uuid.uuid4().hex}")
        with unbroken():
            try:
                aside.write_bytes(content)
                if target.exists():
                    shutil.copymode(target, aside)
                os.replace(aside, target)
            finally:
                aside.unlink(missing_ok=True)
    except OSError as error:
        raise _unwritable(path, error, what) from error


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Keep another run from moving its files into the folder meanwhile, where the system can lock a folder."""
    try:
        import fcntl
    except ImportError:
        yield
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        with suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def stored_content(folder: Path, name: str) -> dict[str, Any] | None:
    """The content of a `result.json` or `gap.json` in a folder; None where there is none that can be read."""
    try:
        content = json_document(folder / name)
    except ConfigurationError:
        return None
    return content if isinstance(content, dict) else None


def is_of(content: dict[str, Any] | None, recording: Recording) -> bool:
    """Whether a stored result is one of this recording: the same joint in the same bag."""
    if content is None or content.get("joint") != recording.joint:
        return False
    bag = content.get("bag")
    return isinstance(bag, dict) and bag.get("sha256") == recording.sha256


def beside(folder: Path, name: str, recording: Recording) -> bool:
    """Whether the folder holds the other kind of result, `name`, of the same recording: it stays."""
    return is_of(stored_content(folder, name), recording)


def own_folder(folder: Path, recording: Recording) -> Path:
    """The folder, or with a number behind its name, the first that holds no result of another bag or joint.

    A bag that was recorded anew in the same place is the same bag.
    """
    for number in range(1, MOST_FOLDERS):
        candidate = folder if number == 1 else folder.with_name(f"{folder.name}_{number}")
        found = [c for c in (stored_content(candidate, n) for n in ("result.json", "gap.json")) if c is not None]
        if all(is_of(c, recording) or _same_place(c, recording) for c in found):
            return candidate
    return folder


def _same_place(content: dict[str, Any], recording: Recording) -> bool:
    bag = content.get("bag")
    path = bag.get("path") if isinstance(bag, dict) else None
    same = isinstance(path, str) and Path(path).resolve() == Path(recording.path).resolve()
    return same and content.get("joint") == recording.joint


def folder_name(text: str) -> str:
    """A name for a folder or file from a joint's or bag's: itself where it can be, never another's, never a path.

    What is no letter, digit, `_`, `-`, `+` or `.` is written as %XX; so is a dot in front.
    """
    name = "".join(c if c.isalnum() or c in "_-+." else quote(c, safe="") for c in text) or "%"
    if name.startswith("."):
        name = f"%2E{name[1:]}"
    if len(name.encode()) > LONGEST_NAME:
        import hashlib

        name = f"{name[: LONGEST_NAME // 4]}%{hashlib.sha256(text.encode()).hexdigest()[:16]}"
    return name
