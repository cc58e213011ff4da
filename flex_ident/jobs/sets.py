"""The recordings of a set: what each is called, which are left out, and where the results of each go."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Protocol, TypeVar

from flex_ident.configuration.settings import Value
from flex_ident.errors import DataError, UsageError
from flex_ident.jobs.places import Place, bag_name
from flex_ident.notices import Code, Notice
from flex_ident.recording import Recording
from flex_ident.report.folder import folder_name

Progress = Callable[[str, float], None]


class _Finished(Protocol):
    @property
    def recording(self) -> Recording: ...


Done = TypeVar("Done", bound=_Finished)
"""What a job makes of one recording, which it holds."""
SEPARATOR = ";"
"""Between the texts of a setting that may be given several times."""


def texts_of(value: object) -> list[str]:
    """The texts of a setting that may be given several times."""
    return [text.strip() for text in str(value).split(SEPARATOR) if text.strip()]


def recording_names(bags: Sequence[Path]) -> tuple[list[str], list[tuple[str, ...]]]:
    """The name of each recording in what is said, its bag's or where two are alike its path, and all that it goes by.

    Raises UsageError for a bag that is given twice.
    """
    short = [bag_name(bag) for bag in bags]
    resolved = [bag.resolve() for bag in bags]
    for bag, own in zip(bags, resolved, strict=True):
        if resolved.count(own) > 1:
            raise UsageError(f"{bag} is given twice: each recording counts once.")
    names = [name if short.count(name) == 1 else str(bag) for name, bag in zip(short, bags, strict=True)]
    known = [
        tuple(dict.fromkeys((name, str(bag), str(bag).rstrip("/"), *([bag.name] if short.count(own) == 1 else []))))
        for name, own, bag in zip(names, short, bags, strict=True)
    ]
    return names, known


def noted_copy(name: str, recording: Recording, others: Mapping[str, Recording]) -> Notice | None:
    """That a recording is the same file as one of the others, by its content, under another name; None where it is not:
    a copy would make an interval narrower that holds nothing new."""
    for other, known in others.items():
        if recording.sha256 and recording.sha256 == known.sha256 and recording.joint == known.joint:
            return Notice(Code.RECORDING_LEFT_OUT, name, texts={"case": "copy", "of": other})
    return None


def each_finished(
    bags: Sequence[Path], names: Sequence[str], asked: Collection[int], finished: Callable[[Path, str], Done]
) -> tuple[dict[int, Done], list[Notice], DataError | None]:
    """What `finished` makes of each recording and its name, by index; why others were left out, and the first error.

    Left out are those that were `asked` for, those that cannot be used, and copies.
    """
    done: dict[int, Done] = {}
    notices: list[Notice] = []
    first_error: DataError | None = None
    for i, (bag, name) in enumerate(zip(bags, names, strict=True)):
        if i in asked:
            notices.append(Notice(Code.RECORDING_LEFT_OUT, name, texts={"case": "asked"}))
            continue
        try:
            one = finished(bag, name)
        except DataError as error:
            first_error = first_error or error
            notices.append(Notice(Code.RECORDING_LEFT_OUT, name, texts={"case": "failed", "why": str(error)}))
            continue
        copied = noted_copy(name, one.recording, {names[j]: own.recording for j, own in done.items()})
        if copied is not None:
            notices.append(copied)
        else:
            done[i] = one
    return done, notices, first_error


def set_name(bags: Sequence[Path]) -> str:
    """What a folder for the set is called: by all of its recordings."""
    return folder_name("+".join(bag_name(bag) for bag in bags))


def refuse_of_one(values: Mapping[str, Value]) -> None:
    """Raises UsageError where what is of several recordings is asked of one."""
    for key, option in (("payload", "--payload"), ("leave_out", "--leave-out")):
        if values.get(key):
            raise UsageError(f"{option}: needs several recordings of the joint, and there is one.")


def left_out(texts: Sequence[str], names: Sequence[Sequence[str]]) -> set[int]:
    """Which recordings are to be left out. Raises UsageError for a name that is none of theirs."""
    found = set()
    for text in texts:
        meant = [i for i, known in enumerate(names) if text in known or text.rstrip("/") in known]
        if not meant:
            there = ", ".join(known[0] for known in names)
            raise UsageError(f"--leave-out {text}: is none of the recordings: {there}.")
        found.update(meant)
    return found


def one_folder(place: Place) -> Place:
    """The place with the folder of the joint that is asked for first, whatever its name is in other recordings."""
    found: list[Path | None] = []

    def folder(joint: str) -> Path | None:
        if not found:
            found.append(place.folder(joint))
        return found[0]

    return replace(place, folder=folder)


def below(place: Place, name: str) -> Place:
    """Where a recording's own result goes: a folder of its name below that of the set."""

    def folder(joint: str) -> Path | None:
        above = place.folder(joint)
        return None if above is None else above / folder_name(name)

    return Place(folder, shared=False, needed=place.needed)


def told_of(progress: Progress, name: str) -> Progress:
    """What tells the progress of one recording."""
    return lambda text, share: progress(f"{text} {name}", share)
