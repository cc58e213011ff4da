"""Many recordings into the archive: what `flex_ident batch` does."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flex_ident.configuration.settings import Value
from flex_ident.errors import UsageError
from flex_ident.fleet.archive import Archive
from flex_ident.fleet.cluster import connected, cores, outcomes
from flex_ident.fleet.hashing import hash_of
from flex_ident.fleet.recordings import Found
from flex_ident.fleet.rows import ERROR
from flex_ident.fleet.work import Outcome, Work, archived, lost
from flex_ident.jobs.options import identify_options
from flex_ident.jobs.sets import refuse_of_one
from flex_ident.jobs.signals import names_in, signal_selection
from flex_ident.recording.names import at_home
from flex_ident.report.folder import check_writable

FILES = ("model", "type_file")
"""Settings that name files: what is in them is part of what was asked."""
KILLED = "its worker was killed each time (too little memory for this recording?)."


@dataclass(frozen=True)
class Batch:
    """What came out of all recordings."""

    outcomes: tuple[Outcome, ...]

    @property
    def there(self) -> int:
        """Recordings that were in the archive before."""
        return sum(own.there for own in self.outcomes)

    @property
    def verdicts(self) -> Counter[str]:
        """How many joints' results have each verdict."""
        return Counter(joint.verdict for own in self.outcomes for joint in own.joints)

    @property
    def exit_status(self) -> int:
        """0: all answered, none rejected; 3: none answered; 4: something has no answer, or is rejected."""
        verdicts = self.verdicts
        if set(verdicts) <= {ERROR}:
            return 3
        return 4 if verdicts[ERROR] or verdicts["rejected"] else 0


def batch(
    recordings: Sequence[Found],
    values: Mapping[str, Value],
    folder: Path,
    *,
    tag: str = "",
    scheduler: str = "",
    workers: int = 0,
    told: Callable[[Outcome], None] = lambda _outcome: None,
) -> Batch:
    """Identify what is not in the archive yet; `told` hears of each recording as it is done.

    Raises UsageError before anything is computed, and ClusterError when the cluster fails: what is finished by then is
    in the archive, and the same call goes on from there.
    """
    settings = asked(values)
    archive = Archive(at_home(folder).resolve())
    works = [Work(own.path, own.robot, tag, settings, archive.folder) for own in recordings]
    check_writable(archive.folder, "--archive")
    done: list[Outcome] = []
    with connected(scheduler, min(workers or cores(), len(works))) as client:
        archive.opened()
        for work, outcome in outcomes(client, archived, works):
            done.append(outcome if outcome is not None else lost(work, KILLED))
            told(done[-1])
    return Batch(tuple(done))


def asked(values: Mapping[str, Value]) -> dict[str, Any]:
    """The settings as every worker takes them: files by absolute path, with their hashes. Raises UsageError."""
    refuse_of_one(values)
    settings: dict[str, Any] = {k: v for k, v in values.items() if k not in ("out", "payload", "leave_out")}
    for key in FILES:
        paths = [at_home(name).resolve() for name in names_in(settings[key])]
        if paths:
            settings[key] = ",".join(map(str, paths))
            try:
                settings[f"{key}_sha256"] = hash_of(paths)
            except OSError as error:
                raise UsageError(f"{error.filename}: cannot be read ({error.strerror}).") from error
    signal_selection(settings)
    identify_options(settings)
    return settings
