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
from flex_ident.jobs.places import Place
from flex_ident.jobs.sets import below, each_finished, left_out, one_folder, recording_names, texts_of, told_of
from flex_ident.notices import Code, Notice
from flex_ident.parameters import Covariance, Identification
from flex_ident.parameters.current import in_amperes, is_current, notices_in_amperes, parameter_in_amperes
from flex_ident.parameters.prismatic import slides
from flex_ident.pooling.members import Member
from flex_ident.pooling.recorded_conditions import recorded_conditions
from flex_ident.pooling.several import Several, several
from flex_ident.pooling.torque_scale import Load
from flex_ident.recording import Recording
from flex_ident.report.sentences import sentence
from flex_ident.report.several_result import JoinedResult, several_content
from flex_ident.report.several_writing import write_several


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
    place = one_folder(place)
    names, known = recording_names(bags)
    loads = loads_in(texts_of(values.get("payload", "")), known)
    asked = left_out(texts_of(values.get("leave_out", "")), known)
    conditions = [run_conditions(bag) for bag in bags]

    def one(bag: Path, name: str) -> FinishedIdentification:
        return finished_identification(
            bag, values, below(place, name), plots=plots, read=read, raw_units=True, progress=told_of(progress, name)
        )

    done, notices, first_error = each_finished(bags, names, asked, one)
    results = {i: own.result for i, own in done.items()}
    used = usable(results, names, notices, first_error)
    joined = joined_result(
        [names[i] for i in used], [results[i] for i in used], [done[i].recording for i in used],
        [conditions[i] for i in used], None if loads is None else [loads[i] for i in used], notices,
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


def usable(
    results: Mapping[int, Identification], names: Sequence[str], notices: list[Notice], first_error: DataError | None
) -> list[int]:
    """The recordings that can be put together; why others cannot is added to `notices`.

    Those go that are rejected, or rigid where most have a spring. Raises DataError where fewer than two are left.
    """
    notices += [
        Notice(Code.RECORDING_LEFT_OUT, names[i], texts={"case": "rejected"})
        for i, own in results.items() if own.verdict == "rejected"
    ]  # fmt: skip
    good = [i for i, own in results.items() if own.verdict != "rejected"]
    rigid = [i for i in good if results[i].model.rigid]
    sprung = [i for i in good if i not in rigid]
    kept, other = (rigid, sprung) if len(rigid) > len(sprung) else (sprung, rigid)
    model = "flexible" if kept is rigid else "rigid"
    notices += [Notice(Code.RECORDING_LEFT_OUT, names[i], texts={"case": "other_model", "model": model}) for i in other]
    if len(kept) < 2:
        said = "; ".join(sentence(n).rstrip(".") for n in notices)
        raise DataError(f"{len(kept)} of {len(names)} recordings can be used, two are needed: {said}.") from first_error
    return kept


def joined_result(
    names: Sequence[str], results: Sequence[Identification], recordings: Sequence[Recording],
    conditions: Sequence[Mapping[str, float | str]], loads: Sequence[Load] | None, notices: Sequence[Notice],
) -> JoinedResult:  # fmt: skip
    """The results of a set's recordings as one, in units of the current where no known mass gives its scale."""
    current = any(is_current(own.notices) for own in results)
    members = [
        _member(name, result, {**own, **given, **_carried(loads, i)}, recording.start_time_s)
        for i, (name, result, recording, own, given) in enumerate(
            zip(names, results, recordings, recorded_conditions(recordings), conditions, strict=True)
        )
    ]
    found = several(members, loads, current=current, slides=any(map(slides, results)))
    found = _named(found, [*notices, *_joint_names(results)])
    if current and found.multiplied == 1.0:
        found = replace(
            found, parameters=tuple(parameter_in_amperes(p) for p in found.parameters),
            notices=notices_in_amperes(found.notices),
        )  # fmt: skip
    return JoinedResult(
        found, [in_amperes(own) if current else own for own in results], list(recordings), in_amperes=current,
        left_out=tuple(n for n in found.notices if n.code is Code.RECORDING_LEFT_OUT),
    )  # fmt: skip


def _member(name: str, result: Identification, conditions: Mapping[str, float | str], start_time_s: float) -> Member:
    covariance = result.covariance
    if covariance is None:  # a method that says nothing of how its parameters are uncertain together
        known = [p for p in result.parameters if 0.0 < p.std < float("inf")]
        covariance = joined_alone([p.key for p in known], [p.std for p in known])
    return Member(name, result.parameters, covariance, conditions, result.verdict, start_time_s)


def joined_alone(keys: Sequence[str], stds: Sequence[float]) -> Covariance:
    """The covariance of parameters each of which is uncertain by itself."""
    import numpy as np

    return Covariance(tuple(keys), np.diag(np.square(stds)), np.zeros(len(keys)))


def _carried(loads: Sequence[Load] | None, i: int) -> dict[str, float]:
    return {} if loads is None else {"payload": loads[i].mass}


def _joint_names(results: Sequence[Identification]) -> list[Notice]:
    joints = list(dict.fromkeys(own.joint for own in results))
    return [Notice(Code.JOINT_NAMES_DIFFER, texts={"joints": ", ".join(joints)})] if len(joints) > 1 else []


def _named(found: Several, notices: Sequence[Notice]) -> Several:
    """The same with more notices, and doubtful where one of them doubts."""
    doubts = any(n.severity != "info" for n in notices)
    verdict = "doubtful" if doubts and found.verdict == "trusted" else found.verdict
    return replace(found, verdict=verdict, notices=(*notices, *found.notices))
