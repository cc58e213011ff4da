"""Several recordings of one joint, each identified by itself, then as one: from bags to a folder."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from flex_ident.bags.run_file import run_conditions
from flex_ident.configuration.settings import Value
from flex_ident.errors import DataError, UsageError
from flex_ident.jobs.identifying import FinishedIdentification, Progress, finished_identification
from flex_ident.jobs.payloads import loads_in
from flex_ident.jobs.places import Place, bag_name
from flex_ident.notices import Code, Notice
from flex_ident.parameters import Covariance, Identification
from flex_ident.parameters.current import in_amperes, is_current, notices_in_amperes, parameter_in_amperes
from flex_ident.parameters.prismatic import slides
from flex_ident.pooling.members import Member
from flex_ident.pooling.recorded_conditions import recorded_conditions
from flex_ident.pooling.several import Several, several
from flex_ident.pooling.torque_scale import Load
from flex_ident.recording import Recording
from flex_ident.report.folder import folder_name
from flex_ident.report.several_result import JoinedResult, several_content
from flex_ident.report.several_writing import write_several

SEPARATOR = ";"
"""Between the texts of a setting that may be given several times."""


@dataclass(frozen=True)
class FinishedSet:
    """The recordings together, `result.json`'s content, and the files written, or why they were not."""

    result: JoinedResult
    content: dict[str, Any]
    paths: Mapping[str, Path]
    unwritten: UsageError | None = None


def finished_set(
    bags: Sequence[Path],
    values: Mapping[str, Value],
    place: Place,
    *,
    plots: bool = True,
    progress: Progress = lambda _text, _share: None,
    read: Callable[[Recording], None] = lambda _recording: None,
) -> FinishedSet:
    """Identify each recording by itself, put them together, write. Each one's own result goes into a folder below.

    A recording that cannot be identified, or is rejected, is left out and named. Raises FlexIdentError; before anything
    is computed for wrong usage, and where fewer than two recordings can be used.
    """
    place = _one_folder(place)
    names, known = recording_names(bags)
    loads = loads_in(texts_of(values.get("payload", "")), known)
    asked = left_out(texts_of(values.get("leave_out", "")), known)
    conditions = [run_conditions(bag) for bag in bags]
    done: dict[int, FinishedIdentification] = {}
    notices: list[Notice] = []
    first_error: DataError | None = None
    for i, (bag, name) in enumerate(zip(bags, names, strict=True)):
        if i in asked:
            notices.append(Notice(Code.RECORDING_LEFT_OUT, name, texts={"case": "asked"}))
            continue
        try:
            done[i] = finished_identification(
                bag, values, _below(place, name), plots=plots, read=read, raw_units=True,
                progress=_told_of(progress, name),
            )  # fmt: skip
        except DataError as error:
            first_error = first_error or error
            notices.append(Notice(Code.RECORDING_LEFT_OUT, name, texts={"case": "failed", "why": str(error)}))
    used, others = _of_one_kind(done, names)
    notices += others
    if len(used) < 2:
        why = f" {first_error}" if first_error is not None else ""
        said = ", ".join(n.subject for n in notices)
        raise DataError(
            f"{len(used)} of {len(bags)} recordings can be used, two are needed (left out: {said}).{why}"
        ) from first_error
    current = any(is_current(done[i].result.notices) for i in used)
    known_conditions = recorded_conditions([done[i].recording for i in used])
    members = [
        _member(names[i], done[i].result, {**own, **conditions[i], **_carried(loads, i)})
        for i, own in zip(used, known_conditions, strict=True)
    ]
    found = several(
        members, None if loads is None else [loads[i] for i in used], current=current,
        slides=any(slides(done[i].result) for i in used),
    )  # fmt: skip
    found = _named(found, [*notices, *_joint_names([done[i] for i in used])])
    if current and found.multiplied == 1.0:
        found = replace(
            found, parameters=tuple(parameter_in_amperes(p) for p in found.parameters),
            notices=notices_in_amperes(found.notices),
        )  # fmt: skip
    joined = JoinedResult(
        found, [in_amperes(done[i].result) if current else done[i].result for i in used],
        [done[i].recording for i in used], in_amperes=current,
        left_out=tuple(n for n in found.notices if n.code is Code.RECORDING_LEFT_OUT),
    )  # fmt: skip
    folder, unwritten = place.found(done[used[0]].recording)
    paths: Mapping[str, Path] = {}
    if folder is not None:
        try:
            paths = write_several(joined, folder, plots=plots)
        except UsageError as error:
            if place.needed:
                raise
            unwritten = error
    return FinishedSet(joined, several_content(joined), paths, unwritten)


def _told_of(progress: Progress, name: str) -> Progress:
    """What tells the progress of one recording."""
    return lambda text, share: progress(f"{text} {name}", share)


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


def _one_folder(place: Place) -> Place:
    """The place with the folder of the joint that is asked for first, whatever its name is in other recordings."""
    found: list[Path | None] = []

    def folder(joint: str) -> Path | None:
        if not found:
            found.append(place.folder(joint))
        return found[0]

    return replace(place, folder=folder)


def _below(place: Place, name: str) -> Place:
    """Where a recording's own result goes: a folder of its name below that of the set."""

    def folder(joint: str) -> Path | None:
        above = place.folder(joint)
        return None if above is None else above / folder_name(name)

    return Place(folder, shared=False, needed=place.needed)


def _of_one_kind(done: Mapping[int, FinishedIdentification], names: Sequence[str]) -> tuple[list[int], list[Notice]]:
    """The recordings that can be put together, and why others cannot: rejected, or rigid where most have a spring."""
    notices = [
        Notice(Code.RECORDING_LEFT_OUT, names[i], texts={"case": "rejected"})
        for i, own in done.items() if own.result.verdict == "rejected"
    ]  # fmt: skip
    good = [i for i, own in done.items() if own.result.verdict != "rejected"]
    rigid = [i for i in good if done[i].result.model.rigid]
    sprung = [i for i in good if i not in rigid]
    kept, other = (rigid, sprung) if len(rigid) > len(sprung) else (sprung, rigid)
    model = "flexible" if kept is rigid else "rigid"
    notices += [Notice(Code.RECORDING_LEFT_OUT, names[i], texts={"case": "other_model", "model": model}) for i in other]
    return kept, notices


def _member(name: str, result: Identification, conditions: Mapping[str, float | str]) -> Member:
    covariance = result.covariance
    if covariance is None:  # a method that says nothing of how its parameters are uncertain together
        known = [p for p in result.parameters if 0.0 < p.std < float("inf")]
        covariance = joined_alone([p.key for p in known], [p.std for p in known])
    return Member(name, result.parameters, covariance, conditions, result.verdict)


def joined_alone(keys: Sequence[str], stds: Sequence[float]) -> Covariance:
    """The covariance of parameters each of which is uncertain by itself."""
    import numpy as np

    return Covariance(tuple(keys), np.diag(np.square(stds)), np.zeros(len(keys)))


def _carried(loads: Sequence[Load] | None, i: int) -> dict[str, float]:
    return {} if loads is None else {"payload": loads[i].mass}


def _joint_names(done: Sequence[FinishedIdentification]) -> list[Notice]:
    joints = list(dict.fromkeys(own.result.joint for own in done))
    return [Notice(Code.JOINT_NAMES_DIFFER, texts={"joints": ", ".join(joints)})] if len(joints) > 1 else []


def _named(found: Several, notices: Sequence[Notice]) -> Several:
    """The same with more notices, and doubtful where one of them doubts."""
    doubts = any(n.severity != "info" for n in notices)
    verdict = "doubtful" if doubts and found.verdict == "trusted" else found.verdict
    return replace(found, verdict=verdict, notices=(*notices, *found.notices))
