"""`explain_gap BAG`: where simulation and measurement disagree, what is missing, and how far the gap shrinks."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path

from flex_ident.commands.common import (
    REJECTED,
    add_output_options,
    add_settings,
    command_parser,
    exit_status,
    given_settings,
    output_folder,
    say_what_was_read,
    stage_bars,
)
from flex_ident.configuration.settings import GAP_SETTINGS, IDENTIFY_SETTINGS

PROG = "explain_gap"
SETTINGS = (*(s for s in IDENTIFY_SETTINGS if s.key not in ("method", "cutoff_sweep")), *GAP_SETTINGS)


def main(arguments: Sequence[str] | None = None) -> int:
    """The console script; returns the exit status."""
    return exit_status(PROG, lambda: _run(arguments))


def _run(arguments: Sequence[str] | None) -> int:
    parser = command_parser(PROG, "Finds where simulation and measurement disagree, and names what is missing.")
    parser.add_argument("bag", type=Path, metavar="BAG", help="rosbag2 folder, .mcap, .db3 or ROS 1 .bag")
    add_settings(parser, SETTINGS)
    parser.add_argument("--method", metavar="auto", default="auto", help="auto, the only method that explain_gap has")
    add_output_options(parser)
    given = parser.parse_args(arguments)
    values = given_settings(given, SETTINGS)
    from flex_ident.commands.gap_jobs import finished_explanation, gap_options
    from flex_ident.errors import UsageError
    from flex_ident.report.gap_table import gap_text
    from flex_ident.report.writing import GAP_REPORT, made_folder

    if given.method != "auto":
        raise UsageError(f"--method {given.method}: explain_gap knows only auto. identify_bag has the other methods.")
    if values["joint"] == "all":
        raise UsageError("--joint all: explain_gap takes one joint.")
    gap_options(values)
    if values["out"]:
        made_folder(Path(str(values["out"])).expanduser())
    quiet = bool(given.quiet or given.json)
    with stage_bars(shown=not quiet) as progress:
        done = finished_explanation(
            given.bag, values, lambda joint: output_folder(values, given.bag, joint),
            plots=not given.no_plots, progress=progress,
            read=say_what_was_read if not quiet else lambda _recording: None,
        )  # fmt: skip
    if given.json:
        json.dump(done.content, sys.stdout, allow_nan=False)
        print()
    elif not quiet:
        print(f"\n{gap_text(done.explanation)}")
        if done.simulator is not None:
            from flex_ident.report.simulator_table import simulator_text

            print(f"\n{simulator_text(done.simulator)}")
        print(f"\nwritten: {', '.join(str(p) for p in done.paths.values())}")
        if done.beside_result:
            kept = f"report.html is identify_bag's as before, this one is {GAP_REPORT}; " if not given.no_plots else ""
            print(f"the folder holds a result of identify_bag: {kept}model.yaml and parameters.yaml are now those of "
                  "the final model above.")  # fmt: skip
    return 0 if done.explanation.determined else REJECTED


if __name__ == "__main__":
    sys.exit(main())
