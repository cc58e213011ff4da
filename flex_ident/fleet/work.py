"""One recording: hashed, looked up, identified joint by joint, archived. This is what a worker runs."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from flex_ident.bags.run_file import run_conditions
from flex_ident.bags.storage import Bag
from flex_ident.errors import BagError, FlexIdentError
from flex_ident.fleet.archive import Archive
from flex_ident.fleet.hashing import hash_of
from flex_ident.fleet.rows import ERROR, Row, common_row, error_row, result_row
from flex_ident.jobs.identifying import finished_identification
from flex_ident.jobs.joints import moving_joints
from flex_ident.jobs.places import Place
from flex_ident.recording.names import harmless

ROBOT = "robot"
"""The condition in a bag's run file that names its robot."""
UNREADABLE = b"unreadable"
"""What the hash of a recording that cannot be opened begins with."""
NOWHERE = Place(lambda _joint: None, needed=False)


@dataclass(frozen=True)
class Work:
    """A recording to be identified with `settings` and archived in a folder that all workers see."""

    bag: Path
    robot: str
    tag: str
    settings: Mapping[str, Any]
    archive: Path


@dataclass(frozen=True)
class JointOutcome:
    """What came out for one joint; `message` where there is no result."""

    joint: str
    verdict: str
    message: str


@dataclass(frozen=True)
class Outcome:
    """What is in the archive of one recording, and whether it was there before.

    `twin`: another place where the same recording lies, under which it is in the archive, and that one's robot.
    """

    bag: Path
    joints: tuple[JointOutcome, ...]
    there: bool = False
    twin: tuple[str, str] | None = None


def archived(work: Work) -> Outcome:
    """The recording's outcome, after its rows are in the archive. Raises MissingExtraError and OSError of the archive.

    What is there already is not done again, unless what went wrong then may not go wrong now.
    """
    archive = Archive(work.archive)
    sha256 = content_hash(work.bag)
    file = archive.file_of(sha256, work.settings)
    rows = archive.rows_in(file)
    if rows and not any(row["again"] for row in rows):
        placed = [_placed(row, work) for row in rows]
        if placed != rows:
            archive.write(file, placed)
        twin = (placed[0]["bag"], placed[0]["robot"]) if placed[0]["bag"] != str(work.bag) else None
        return replace(_outcome(work, placed, there=True), twin=twin)
    rows = list(_rows(work, sha256))
    archive.write(file, rows)
    return _outcome(work, rows)


def _placed(row: Row, work: Work) -> Row:
    """A row with the place and robot of the recording as it lies now; as it is where it still lies at its old place.

    A robot that the recording itself names stays, and so does one of which this pattern says nothing.
    """
    bag, robot = str(work.bag), row["robot"]
    if row["bag"] != bag and Path(row["bag"]).exists():
        return row
    named = json.loads(row["conditions"] or "{}").get(ROBOT)
    return {**row, "bag": bag, "robot": robot if named or not work.robot else work.robot}


def lost(work: Work, message: str) -> Outcome:
    """The outcome of a recording whose worker did not live to say one, after its row is in the archive.

    A result that was archived before its worker died stays.
    """
    archive = Archive(work.archive)
    sha256 = content_hash(work.bag)
    file = archive.file_of(sha256, work.settings)
    rows = archive.rows_in(file)
    if not rows or any(row["again"] for row in rows):
        rows = [error_row(_common(work, sha256, {}), _joint(work), message, again=True)]
        archive.write(file, rows)
    return _outcome(work, rows)


def content_hash(path: Path) -> str:
    """The recording's hash as in `result.json`; of a bag that cannot be opened that of its files, or of its path."""
    try:
        with Bag(path) as bag:
            return bag.sha256()
    except (FlexIdentError, OSError):
        pass
    try:
        return hash_of([path], UNREADABLE)
    except OSError:
        return hashlib.sha256(UNREADABLE + str(path).encode("utf-8", "surrogateescape")).hexdigest()


def _rows(work: Work, sha256: str) -> Iterator[Row]:
    conditions: Mapping[str, float | str] = {}
    try:
        conditions = run_conditions(work.bag)
        joints = _joints(work)
    except Exception as error:
        yield error_row(_common(work, sha256, conditions), _joint(work), *_what(error), again=_passes(error))
        return
    common = _common(work, sha256, conditions)
    for joint in joints:
        began = time.perf_counter()
        try:
            done = finished_identification(work.bag, {**work.settings, "joint": joint}, NOWHERE, plots=False)
            if done.recording.sha256 != sha256:
                raise ChangedError("the recording changed while it was read: is it being written?")
        except Exception as error:
            seconds = time.perf_counter() - began
            yield error_row(common, joint or _joint(work), *_what(error), seconds=seconds, again=_passes(error))
            continue
        yield result_row(
            common, done.content, start_time_s=done.recording.start_time_s, seconds=time.perf_counter() - began
        )


class ChangedError(BagError):
    """A recording's files are not those that were there a moment ago."""


def _joints(work: Work) -> list[str]:
    """The joints asked for: the one that is named, else each that moves, else what `identify_bag` takes unasked."""
    asked = str(work.settings["joint"])
    if asked not in ("", "all"):
        return [asked]
    try:
        moving = moving_joints(work.bag)
    except FlexIdentError:
        if asked:
            raise
        return [""]
    return moving if asked or len(moving) > 1 else [""]


def _joint(work: Work) -> str:
    asked = str(work.settings["joint"])
    return "" if asked == "all" else asked


def _common(work: Work, sha256: str, conditions: Mapping[str, float | str]) -> Row:
    return common_row(
        robot=str(conditions.get(ROBOT, work.robot)), bag=str(work.bag), sha256=sha256, tag=work.tag,
        conditions=conditions, settings=work.settings,
    )  # fmt: skip


def _what(error: Exception) -> tuple[str]:
    """What went wrong, on one line."""
    text = harmless(" ".join(str(error).split()))
    if isinstance(error, FlexIdentError):
        return (text,)
    if isinstance(error, MemoryError):
        return ("not enough memory for this recording.",)
    return (f"internal error ({type(error).__name__}: {text}): please report it.",)


def _passes(error: Exception) -> bool:
    """Whether the same recording may be answered another time."""
    return isinstance(error, (MemoryError, OSError, ChangedError))


def _outcome(work: Work, rows: list[Row], *, there: bool = False) -> Outcome:
    joints = tuple(JointOutcome(row["joint"] or "", row["verdict"], row["message"] or "") for row in rows)
    return Outcome(work.bag, joints, there)


def answered(outcome: Outcome) -> bool:
    """Whether any joint of the recording has a result."""
    return any(own.verdict != ERROR for own in outcome.joints)
