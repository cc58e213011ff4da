"""`identify_bag BAG...`: one joint, or each, identified from a recording, or one joint from several."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from flex_ident.commands.common import (
    REJECTED,
    add_output_options,
    add_settings,
    command_parser,
    exit_status,
    given_settings,
    one_line,
    say_unwritten,
    say_what_was_read,
    stage_bars,
)
from flex_ident.configuration.settings import IDENTIFY_SETTINGS, SET_SETTINGS, Value
from flex_ident.errors import DataError, UsageError

PROG = "identify_bag"
EXAMPLES = (
    "identify_bag my_bag",
    "identify_bag my_bag --joint joint_2 --effort-scale 12.5   # effort in A, N m per A on the link side",
    "identify_bag my_bag --joint all --out results             # each joint that moves, in results/JOINT",
    "identify_bag my_bag --rigid --json                        # no spring; result.json on standard output",
    "identify_bag monday tuesday wednesday --out results       # one joint, recorded three times",
    "identify_bag bare loaded --payload loaded=5.0@0.40        # a known mass gives the effort's scale",
)
SETTINGS = tuple(
    replace(s, description=f"{s.description}; 'all' for each that moves") if s.key == "joint" else s
    for s in (*IDENTIFY_SETTINGS, *SET_SETTINGS)
)


def main(arguments: Sequence[str] | None = None) -> int:
    """The console script; returns the exit status."""
    return exit_status(PROG, lambda: _run(arguments))


def _run(arguments: Sequence[str] | None) -> int:
    parser = command_parser(
        PROG, "Identifies a joint's stiffness, inertia, friction and gravity from a recording.", EXAMPLES
    )
    parser.add_argument(
        "bag", type=Path, metavar="BAG", nargs="+",
        help="rosbag2 folder, .mcap, .db3 or ROS 1 .bag; several are one joint recorded several times",
    )  # fmt: skip
    add_settings(parser, SETTINGS)
    add_output_options(parser)
    given = parser.parse_args(arguments)
    values = given_settings(given, SETTINGS)
    if len(given.bag) > 1:
        return _together(given, values)
    [given.bag] = given.bag
    from flex_ident.jobs.joints import moving_joints
    from flex_ident.jobs.sets import refuse_of_one

    refuse_of_one(values)
    every = values["joint"] == "all"
    status = 0
    contents: list[dict[str, Any]] = []
    joints = moving_joints(given.bag) if every else [str(values["joint"])]
    for joint in joints:
        try:
            content, own = _identified(given, {**values, "joint": joint}, many=len(joints) > 1)
        except DataError as error:
            if not every:
                raise
            print(f"{PROG}: joint {joint}: {one_line(error)}", file=sys.stderr)
            status = max(status, error.exit_status)
            continue
        contents.append(content)
        status = max(status, own)
    if given.json:
        json.dump(contents if every else contents[0], sys.stdout, allow_nan=False)
        print()
    return status


def _identified(given: argparse.Namespace, values: Mapping[str, Value], *, many: bool) -> tuple[dict[str, Any], int]:
    """The content of one joint's `result.json`, after it was written and told, and the exit status."""
    from flex_ident.jobs.identifying import finished_identification
    from flex_ident.jobs.places import place_of
    from flex_ident.report.answers import answer_text
    from flex_ident.report.table import result_text

    quiet = bool(given.quiet or given.json)
    place = place_of(values, given.bag, many=many, needed=not given.json)
    with stage_bars(shown=not quiet) as progress:
        done = finished_identification(
            given.bag, values, place, plots=not given.no_plots, progress=progress,
            read=say_what_was_read if not quiet else lambda _recording: None,
        )  # fmt: skip
    if not quiet:
        answers = answer_text(done.result, done.recording)
        print(f"\n{result_text(done.result)}\n{answers}\n\nwritten: {', '.join(str(p) for p in done.paths.values())}")
    unwritten = say_unwritten(PROG, done.unwritten, asked_for=bool(values["out"]))
    return done.content, REJECTED if done.result.verdict == "rejected" else unwritten


def _together(given: argparse.Namespace, values: Mapping[str, Value]) -> int:
    """Several recordings of one joint as one."""
    from flex_ident.jobs.places import place_of
    from flex_ident.jobs.sets import set_name
    from flex_ident.jobs.several import finished_set
    from flex_ident.report.several_table import several_text

    if values["joint"] == "all":
        raise UsageError("--joint all: of several recordings one joint is identified: name it.")
    quiet = bool(given.quiet or given.json)
    place = replace(place_of(values, Path(set_name(given.bag)), needed=not given.json), shared=False)
    with stage_bars(shown=not quiet) as progress:
        done = finished_set(
            given.bag, values, place, plots=not given.no_plots, progress=progress,
            read=say_what_was_read if not quiet else lambda _recording: None,
        )  # fmt: skip
    if not quiet:
        print(f"\n{several_text(done.result)}\n\nwritten: {', '.join(str(p) for p in done.paths.values())}")
    if given.json:
        json.dump(done.content, sys.stdout, allow_nan=False)
        print()
    unwritten = say_unwritten(PROG, done.unwritten, asked_for=bool(values["out"]))
    return REJECTED if done.content["verdict"] == "rejected" else unwritten


if __name__ == "__main__":
    sys.exit(main())
