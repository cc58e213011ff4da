"""`explain_gap BAG...`: where simulation and measurement disagree, what is missing, and how far the gap shrinks."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from flex_ident.commands.common import (
    REJECTED,
    add_output_options,
    add_settings,
    command_parser,
    exit_status,
    given_settings,
    say_failed,
    say_unwritten,
    say_what_was_read,
    stage_bars,
)
from flex_ident.configuration.settings import GAP_SETTINGS, IDENTIFY_SETTINGS, SET_SETTINGS, Value

if TYPE_CHECKING:
    from flex_ident.jobs.explaining import FinishedExplanation
    from flex_ident.jobs.explaining_set import FinishedGapSet

PROG = "explain_gap"
EXAMPLES = (
    "explain_gap my_bag",
    "explain_gap my_bag --model results/model.yaml           # what that model lacks",
    "explain_gap my_bag --without MX,MY --out results/gap    # a base without gravity",
    "explain_gap my_bag --simulated my_simulators_bag        # what a simulator of the same motion has wrong",
    "explain_gap monday tuesday wednesday                    # one joint, recorded three times: what holds in all",
)
MODEL_TEXT = "a model.yaml: the base whose gap is sought; its parameters are identified again"
SETTINGS = (
    *(replace(s, description=MODEL_TEXT) if s.key == "model" else s
      for s in IDENTIFY_SETTINGS if s.key not in ("method", "cutoff_sweep")),
    *GAP_SETTINGS, *SET_SETTINGS,
)  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """The console script; returns the exit status."""
    return exit_status(PROG, lambda: _run(arguments))


def _run(arguments: Sequence[str] | None) -> int:
    text = "Finds where simulation and measurement disagree, and names what is missing."
    parser = command_parser(PROG, text, EXAMPLES)
    parser.add_argument(
        "bag", type=Path, metavar="BAG", nargs="+",
        help="rosbag2 folder, .mcap, .db3 or ROS 1 .bag; several are one joint recorded several times",
    )  # fmt: skip
    add_settings(parser, SETTINGS)
    parser.add_argument("--method", metavar="auto", default="auto", help="auto, the only method that explain_gap has")
    add_output_options(parser)
    given = parser.parse_args(arguments)
    values = given_settings(given, SETTINGS)
    from flex_ident.errors import UsageError
    from flex_ident.jobs.explaining import finished_explanation
    from flex_ident.jobs.options import gap_options
    from flex_ident.jobs.places import place_of
    from flex_ident.jobs.sets import refuse_of_one
    from flex_ident.report.folder import GAP_REPORT
    from flex_ident.report.gap_table import gap_text

    if given.method != "auto":
        raise UsageError(f"--method {given.method}: explain_gap knows only auto. identify_bag has the other methods.")
    if values["joint"] == "all":
        raise UsageError("--joint all: explain_gap takes one joint.")
    gap_options(values)
    if len(given.bag) > 1:
        return _together(given, values)
    [given.bag] = given.bag
    refuse_of_one(values)
    quiet = bool(given.quiet or given.json)
    place = place_of(values, given.bag, needed=not given.json)
    with stage_bars(shown=not quiet) as progress:
        done = finished_explanation(
            given.bag, values, place, plots=not given.no_plots, progress=progress,
            read=say_what_was_read if not quiet else lambda _recording: None,
        )  # fmt: skip
    if not quiet:
        _say(f"{gap_text(done.explanation)}\n{done.answers}", done)
        if done.beside_result:
            kept = f"report.html is identify_bag's as before, this one is {GAP_REPORT}; " if not given.no_plots else ""
            print(f"the folder holds a result of identify_bag: {kept}model.yaml and parameters.yaml are now those of "
                  "the final model above.")  # fmt: skip
    return _ended(given, values, done, rejected=not done.explanation.determined)


def _together(given: argparse.Namespace, values: Mapping[str, Value]) -> int:
    """Several recordings of one joint as one."""
    from flex_ident.jobs.explaining_set import finished_gap_set
    from flex_ident.jobs.places import place_of
    from flex_ident.jobs.sets import set_name
    from flex_ident.report.gap_set_table import gap_set_text

    quiet = bool(given.quiet or given.json)
    place = replace(place_of(values, Path(set_name(given.bag)), needed=not given.json), shared=False)
    with stage_bars(shown=not quiet) as progress:
        done = finished_gap_set(
            given.bag, values, place, plots=not given.no_plots, progress=progress,
            read=say_what_was_read if not quiet else lambda _recording: None,
        )  # fmt: skip
    if not quiet:
        _say(gap_set_text(done.result), done)
    return _ended(given, values, done, rejected=done.content["verdict"] == "rejected")


def _say(text: str, done: FinishedExplanation | FinishedGapSet) -> None:
    """What was found, what a simulator has wrong, and where the files are."""
    from flex_ident.report.simulator_table import simulator_text

    print(f"\n{text}")
    if done.simulator.gap is not None:
        print(f"\n{simulator_text(done.simulator.gap)}")
    print(f"\nwritten: {', '.join(str(p) for p in done.paths.values())}")


def _ended(
    given: argparse.Namespace, values: Mapping[str, Value], done: FinishedExplanation | FinishedGapSet, *,
    rejected: bool,
) -> int:  # fmt: skip
    """JSON where it is asked for, a line for each part that failed; the exit status."""
    if given.json:
        json.dump(done.content, sys.stdout, allow_nan=False)
        print()
    unwritten = say_unwritten(PROG, done.unwritten, asked_for=bool(values["out"]))
    failed = say_failed(PROG, done.simulator.failed)
    return REJECTED if rejected else max(unwritten, failed)


if __name__ == "__main__":
    sys.exit(main())
