"""`identify_bag BAG`: one joint, or each, identified from a recording."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from flex_ident.commands.common import (
    REJECTED,
    add_output_options,
    add_settings,
    command_parser,
    exit_status,
    given_settings,
    output_folder,
    stage_bars,
)
from flex_ident.configuration.settings import Value

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
    joints = _joints(bag, str(values["joint"]))
    quiet = bool(given.quiet or given.json)
    status = 0
    for joint in joints:
        own = {**values, "joint": joint}
        status = max(
            status,
            _identified(bag, own, quiet=quiet, plots=not given.no_plots, as_json=given.json, many=len(joints) > 1),
        )
    return status


def _joints(bag: Path, joint: str) -> list[str]:
    if joint != "all":
        return [joint]
    from flex_ident.bags.reading import STILL, joint_motions
    from flex_ident.errors import ExcitationError

    names = [m.name for m in joint_motions(bag) if not m.link and m.range > STILL]
    if not names:
        raise ExcitationError(f"{bag}: no joint moved. Record while a joint follows a chirp.")
    return names


def _identified(bag: Path, values: Mapping[str, Value], *, quiet: bool, plots: bool, as_json: bool, many: bool) -> int:
    from flex_ident.commands.jobs import finished_identification
    from flex_ident.recording import Recording
    from flex_ident.report.table import result_text
    from flex_ident.report.writing import made_folder

    if values["out"]:
        made_folder(Path(str(values["out"])).expanduser())

    def say_what_was_read(recording: Recording) -> None:
        for s in recording.sampling if not quiet else ():
            print(f"{s.role.replace('_', ' ')}: {s.source} ({s.samples} samples at {s.rate_hz:.2f} Hz, "
                  f"{s.clock} stamps, jitter {s.jitter_percent:.1f} %, {s.lost_percent:.2g} % lost)")  # fmt: skip

    with stage_bars(shown=not quiet) as progress:
        done = finished_identification(
            bag, values, lambda joint: output_folder(values, bag, joint, many=many),
            plots=plots, progress=progress, read=say_what_was_read,
        )  # fmt: skip
    if as_json:
        json.dump(done.content, sys.stdout, allow_nan=False)
        print()
    elif not quiet:
        print(f"\n{result_text(done.result)}\n\nwritten: {', '.join(str(p) for p in done.paths.values())}")
    return REJECTED if done.result.verdict == "rejected" else 0


if __name__ == "__main__":
    sys.exit(main())
