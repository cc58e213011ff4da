"""`identify_bag BAG`: one joint, or each, identified from a recording."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
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
    output_folder,
    say_what_was_read,
    stage_bars,
)
from flex_ident.configuration.settings import Value
from flex_ident.errors import DataError, ExcitationError

PROG = "identify_bag"


def main(arguments: Sequence[str] | None = None) -> int:
    """The console script; returns the exit status."""
    return exit_status(PROG, lambda: _run(arguments))


def _run(arguments: Sequence[str] | None) -> int:
    parser = command_parser(PROG, "Identifies a joint's stiffness, inertia, friction and gravity from a recording.")
    parser.add_argument("bag", type=Path, metavar="BAG", help="rosbag2 folder, .mcap, .db3 or ROS 1 .bag")
    add_settings(parser)
    add_output_options(parser)
    given = parser.parse_args(arguments)
    values = given_settings(given)
    bag: Path = given.bag
    every = values["joint"] == "all"
    quiet = bool(given.quiet or given.json)
    status = 0
    contents: list[dict[str, Any]] = []
    joints = _joints(bag) if every else [str(values["joint"])]
    for joint in joints:
        own = {**values, "joint": joint}
        try:
            content = _identified(bag, own, quiet=quiet, plots=not given.no_plots, many=len(joints) > 1)
        except DataError as error:
            if not every:
                raise
            print(f"{PROG}: joint {joint}: {one_line(error)}", file=sys.stderr)
            status = max(status, error.exit_status)
            continue
        contents.append(content)
        status = max(status, REJECTED if content["verdict"] == "rejected" else 0)
    if given.json:
        json.dump(contents if every else contents[0], sys.stdout, allow_nan=False)
        print()
    return status


def _joints(bag: Path) -> list[str]:
    """Every joint that moves. Raises BagError and ExcitationError."""
    from flex_ident.bags.reading import STILL, joint_motions

    names = [m.name for m in joint_motions(bag) if not m.link and m.range > STILL]
    if not names:
        raise ExcitationError(f"{bag}: no joint moved. Record while a joint follows a chirp.")
    return list(dict.fromkeys(names))


def _identified(bag: Path, values: Mapping[str, Value], *, quiet: bool, plots: bool, many: bool) -> dict[str, Any]:
    """The content of one joint's `result.json`, after it was written and told."""
    from flex_ident.commands.jobs import finished_identification
    from flex_ident.report.table import result_text
    from flex_ident.report.writing import made_folder

    if values["out"]:
        made_folder(Path(str(values["out"])).expanduser())

    with stage_bars(shown=not quiet) as progress:
        done = finished_identification(
            bag, values, lambda joint: output_folder(values, bag, joint, many=many),
            plots=plots, progress=progress, read=say_what_was_read if not quiet else lambda _recording: None,
        )  # fmt: skip
    if not quiet:
        print(f"\n{result_text(done.result)}\n\nwritten: {', '.join(str(p) for p in done.paths.values())}")
    return done.content


if __name__ == "__main__":
    sys.exit(main())
