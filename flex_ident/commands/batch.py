"""`flex_ident batch PATTERN...`: many recordings into an archive."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flex_ident.commands.common import add_settings, given_settings, help_end, one_line
from flex_ident.configuration.settings import IDENTIFY_SETTINGS
from flex_ident.errors import UsageError
from flex_ident.recording.names import harmless, path_text
from flex_ident.stopping import Stopped

if TYPE_CHECKING:
    from flex_ident.fleet.running import Batch
    from flex_ident.fleet.work import Outcome

PROG = "flex_ident"
SETTINGS = tuple(s for s in IDENTIFY_SETTINGS if s.key not in ("out", "cutoff_sweep"))
EXAMPLES = (
    "flex_ident batch 'bags/**' --archive fleet",
    "flex_ident batch 'bags/{robot}/**' --archive fleet --tag acceptance   # the robot's name is in the path",
    "flex_ident batch 'bags/**' --archive fleet --scheduler tcp://10.0.0.5:8786",
)
STATUSES = """\
exit status:
  0  all recordings are answered, and no result is rejected
  2  wrong usage or configuration, or a library is missing
  3  none is answered, or the cluster cannot go on
  4  some have no answer, or a result is rejected"""
STOPPED = 130


def add_batch(parser: argparse.ArgumentParser) -> None:
    """The options of `flex_ident batch`, and what it runs."""
    parser.epilog = help_end(EXAMPLES, STATUSES)
    parser.add_argument(
        "patterns", nargs="+", metavar="PATTERN",
        help="bags, folders of bags, or patterns in quotes: ** is any number of folders, {robot} the robot's name",
    )  # fmt: skip
    parser.add_argument("--archive", type=Path, required=True, metavar="DIR", help="the folder of Parquet files")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write the archive as a table for a spreadsheet too")
    parser.add_argument("--tag", default="", metavar="TEXT", help="kept with each new result: a name for this campaign")
    parser.add_argument("--scheduler", default="", metavar="ADDRESS", help="of a Dask cluster; default: this machine")
    parser.add_argument("--workers", type=_count, default=0, metavar="N", help="processes here; default: one a core")
    parser.add_argument("--quiet", action="store_true", help="print nothing but what has no answer")
    add_settings(parser, SETTINGS)
    parser.set_defaults(function=_run)


def _count(text: str) -> int:
    """A number of workers from the command line. Raises ArgumentTypeError."""
    if not text.isdecimal() or not 1 <= int(text) <= 1024:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number from 1 to 1024")
    return int(text)


def _run(given: argparse.Namespace) -> int:
    from flex_ident.fleet.archive import Archive
    from flex_ident.fleet.cluster import ClusterError
    from flex_ident.fleet.recordings import found_recordings
    from flex_ident.fleet.running import batch

    if given.scheduler and given.workers:
        raise UsageError("--workers is of this machine: with --scheduler the cluster has its own.")
    values = {**given_settings(given, SETTINGS), "cutoff_sweep": False}
    archive = Archive(given.archive)
    recordings = found_recordings(given.patterns)
    try:
        with _bar(len(recordings), shown=not given.quiet) as bar:

            def told(outcome: Outcome) -> None:
                for line in (*unanswered_lines(outcome), *twin_lines(outcome)):
                    _say(line)
                bar(1)

            done = batch(
                recordings, values, given.archive, tag=given.tag, scheduler=given.scheduler, workers=given.workers,
                told=told,
            )  # fmt: skip
    except (KeyboardInterrupt, ClusterError) as error:
        why = one_line(error) if isinstance(error, ClusterError) else "stopped."
        _say(f"{PROG} batch: {why} What is finished is in {given.archive}; the same command goes on from there.")
        return error.exit_status if isinstance(error, (ClusterError, Stopped)) else STOPPED
    if given.csv is not None:
        archive.write_csv(given.csv)
    if not given.quiet:
        print(summary_text(done, given.archive))
    return done.exit_status


def unanswered_lines(outcome: Outcome) -> list[str]:
    """One line for each joint of a recording that has no result."""
    shown = path_text(outcome.bag)
    return [
        f"{PROG} batch: {_without_repeat(shown, joint.joint, joint.message)}"
        for joint in outcome.joints if joint.verdict == "error"
    ]  # fmt: skip


def twin_lines(outcome: Outcome) -> list[str]:
    """That a recording is in the archive under another place."""
    if outcome.twin is None:
        return []
    bag, robot = outcome.twin
    of_robot = f" of robot {harmless(robot)}" if robot else ""
    return [
        f"{PROG} batch: {path_text(outcome.bag)} is the same recording as {path_text(Path(bag))}: it counts once, as "
        f"that{of_robot}. Leave one of them out."
    ]


def _without_repeat(bag: str, joint: str, message: str) -> str:
    """The message behind the bag and joint that it is of, each once."""
    where = f"{bag}: joint {joint}" if joint else bag
    return message if not joint and message.startswith(bag) else f"{where}: {message.removeprefix(f'{bag}: ')}"


def summary_text(done: Batch, archive: Path) -> str:
    """How many recordings there are, were there before, and what their results are."""
    verdicts = ", ".join(
        f"{count} {'without an answer' if verdict == 'error' else verdict}"
        for verdict, count in sorted(done.verdicts.items())
    )
    count, new = len(done.outcomes), len(done.outcomes) - done.there
    recordings = "recording" if count == 1 else "recordings"
    return f"{count} {recordings}, {new} new, {done.there} there already; results: {verdicts}\nwritten: {archive}"


def _say(line: str) -> None:
    """A line on standard error, above the bar where there is one."""
    if sys.stderr.isatty():
        from tqdm import tqdm

        tqdm.write(line, file=sys.stderr)
    else:
        print(line, file=sys.stderr)


@contextmanager
def _bar(total: int, *, shown: bool) -> Iterator[Any]:
    """What counts recordings in a bar on a terminal."""
    if not shown or not sys.stderr.isatty():
        yield lambda _count: None
        return
    from tqdm import tqdm

    with tqdm(total=total, desc="identifying", unit="recording", file=sys.stderr, leave=False) as bar:
        yield bar.update
