"""`flex_ident SUBCOMMAND`: demo, design-filter, reproduce-paper, check-bag, import, batch, compare, export, codes..."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from flex_ident.commands.batch import EXAMPLES as BATCH_EXAMPLES
from flex_ident.commands.batch import add_batch
from flex_ident.commands.common import (
    add_settings,
    command_parser,
    exit_status,
    finite_number,
    given_settings,
    help_end,
    seed_number,
)
from flex_ident.commands.health import EXAMPLES as HEALTH_EXAMPLES
from flex_ident.commands.health import add_health
from flex_ident.commands.streams import refuse_unprintable
from flex_ident.configuration.settings import IDENTIFY_SETTINGS, IMPORT_SETTINGS
from flex_ident.errors import UsageError

PROG = "flex_ident"
SIGNAL_KEYS = (
    "joint", "motor_position", "link_position", "effort", "reference", "type_file", "effort_scale", "gear_ratio",
    "sensors",
)  # fmt: skip
SIGNAL_SETTINGS = tuple(s for s in IDENTIFY_SETTINGS if s.key in SIGNAL_KEYS)
"""What says where the signals of a joint are."""


RESULT_TEXT = "result.json, gap.json or a folder that holds one; result.json where both are there"
EXAMPLES = {
    "all": ("flex_ident demo", "flex_ident check-bag my_bag", "flex_ident SUBCOMMAND --help"),
    "demo": ("flex_ident demo", "flex_ident demo --without-ros --seed 3 --out results/demo"),
    "design-filter": ("flex_ident design-filter --first-mode 3.9 --sample-rate 350.87 --figure figure_1.png",),
    "reproduce-paper": ("flex_ident reproduce-paper --out results/paper",),
    "check-bag": ("flex_ident check-bag my_bag", "flex_ident check-bag my_bag --joint joint_2"),
    "import": (
        "flex_ident import log.csv --out my_bag",
        "flex_ident import log.mat --out my_bag --time t --position q[1] --effort tau[1]",
        "flex_ident import log.txt --out my_bag --rate 500 --position column_1..column_6 --effort column_7..column_12",
        "flex_ident import dataset --out my_bag --episode 3 --position-scale 0.0174533   # LeRobot, degrees",
    ),
    "batch": BATCH_EXAMPLES,
    "health": HEALTH_EXAMPLES,
    "compare": ("flex_ident compare results/monday results/friday", "flex_ident compare a/result.json a/gap.json"),
    "export": ("flex_ident export results/elbow --to mujoco --out elbow.xml", "flex_ident export a/gap.json --to csv"),
    "effects": ("flex_ident effects",),
    "codes": ("flex_ident codes", "flex_ident codes --markdown > docs/codes.md"),
}
"""What `--help` shows, by subcommand."""


def main(arguments: Sequence[str] | None = None) -> int:
    """The console script; returns the exit status."""
    return exit_status(PROG, lambda: _run(arguments))


def _run(arguments: Sequence[str] | None) -> int:
    parser = command_parser(
        PROG, "Filter design, the paper's experiment, bags, results and the catalogue of effects.", EXAMPLES["all"]
    )
    sub = parser.add_subparsers(dest="subcommand", metavar="SUBCOMMAND", required=True)
    _demo(_added(sub, "demo", "a whole run on the virtual joint: excite, record, identify, report"))
    _design_filter(_added(sub, "design-filter", "eqs. 22 to 29: cutoff and sampling rate from the first mode"))
    _reproduce_paper(_added(sub, "reproduce-paper", "section 4 of the paper: Tables 1 to 3, Figures 1 and 2"))
    _check_bag(_added(sub, "check-bag", "what a bag holds and whether a joint can be identified from it"))
    _import(_added(sub, "import", "a CSV, MATLAB, HDF5, NumPy or Parquet file or a LeRobot dataset as a bag"))
    add_batch(_added(sub, "batch", "many recordings, in parallel here or on a Dask cluster, into an archive"))
    add_health(_added(sub, "health", "what has changed since the baseline, joint by joint; exit status 4 if any"))
    _compare(_added(sub, "compare", "results side by side, with the differences that are beyond chance"))
    _export(_added(sub, "export", "a result as URDF dynamics, MuJoCo XML, YAML or CSV"))
    _effects(_added(sub, "effects", "the catalogue of effects"))
    _codes(_added(sub, "codes", "every code that a warning may have, what it means and what to do"))
    given = parser.parse_args(arguments)
    status: int = given.function(given)
    return status


def _added(sub: Any, name: str, text: str) -> argparse.ArgumentParser:
    """A subcommand's parser, with what it does, examples and exit statuses in its `--help`."""
    parser: argparse.ArgumentParser = sub.add_parser(
        name, help=text, description=f"{text[:1].upper()}{text[1:]}.", epilog=help_end(EXAMPLES[name]),
        allow_abbrev=False, formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    return parser


def _demo(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--out", type=Path, default=Path("flex_ident_results") / "demo", metavar="DIR",
        help="where recording and report go; default ./flex_ident_results/demo",
    )  # fmt: skip
    parser.add_argument("--seed", type=seed_number, default=0, metavar="N", help="of the sensors' noise; default 0")
    parser.add_argument("--without-ros", action="store_true", help="generate the recording instead of live nodes")
    parser.add_argument("--quiet", action="store_true", help="print only truth beside estimate")

    def run(given: argparse.Namespace) -> int:
        from flex_ident.commands.demo import demonstrated

        return demonstrated(given.out, seed=given.seed, live=not given.without_ros, quiet=given.quiet)

    parser.set_defaults(function=run)


def _design_filter(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--first-mode", type=finite_number, required=True, metavar="HZ", help="the first natural frequency of the joint"
    )
    parser.add_argument(
        "--derivatives", type=int, default=2, choices=(2, 4), help="highest derivative; 2: eq. 13, 4: eq. 18"
    )
    parser.add_argument("--order", type=int, metavar="M", help="Butterworth order of one pass; default 4 or 6")
    parser.add_argument(
        "--sample-rate", type=finite_number, metavar="HZ", help="of the recording; default: that of eq. 29"
    )
    parser.add_argument(
        "--edge-gain", type=finite_number, default=math.sqrt(0.5), metavar="A_C",
        help="what is left of the signal at the edge of the bandwidth (eq. 27); default 0.707, -3 dB",
    )  # fmt: skip
    parser.add_argument(
        "--ratio", type=finite_number, default=1.0, metavar="R_C",
        help="the low-pass' share of the distortion there over that of the differences; default 1",
    )  # fmt: skip
    parser.add_argument(
        "--decimation", type=int, metavar="N", help="keep every N-th sample; default: as in section 4 of the paper"
    )
    parser.add_argument("--figure", type=Path, metavar="PNG", help="draw Figure 1")

    def run(given: argparse.Namespace) -> int:
        from flex_ident.commands.design_filter import design_filter

        text = design_filter(
            given.first_mode, derivative_order=given.derivatives, order=given.order, sample_rate_hz=given.sample_rate,
            edge_gain=given.edge_gain, ratio=given.ratio, decimation=given.decimation, figure=given.figure,
        )  # fmt: skip
        print(text)
        return 0

    parser.set_defaults(function=run)


def _reproduce_paper(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--out", type=Path, default=Path("flex_ident_results") / "paper", metavar="DIR",
        help="where the figures go; default ./flex_ident_results/paper",
    )  # fmt: skip
    parser.add_argument("--seed", type=seed_number, default=0, metavar="N", help="of the sensors' noise; default 0")

    def run(given: argparse.Namespace) -> int:
        from flex_ident.commands.reproduce_paper import reproduced_paper

        print(reproduced_paper(given.out, seed=given.seed))
        return 0

    parser.set_defaults(function=run)


def _check_bag(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("bag", type=Path, metavar="BAG", help="rosbag2 folder, .mcap, .db3 or ROS 1 .bag")
    add_settings(parser, SIGNAL_SETTINGS)

    def run(given: argparse.Namespace) -> int:
        from flex_ident.commands.check_bag import bag_check
        from flex_ident.jobs.signals import signal_selection

        text, error = bag_check(given.bag, signal_selection(given_settings(given, SIGNAL_SETTINGS)))
        print(text)
        if error is not None:
            raise error
        return 0

    parser.set_defaults(function=run)


def _import(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "files",
        type=Path,
        nargs="+",
        metavar="FILE",
        help="the table, or the folder of a LeRobot dataset; several files are one table, column beside column",
    )
    parser.add_argument("--out", type=Path, required=True, metavar="BAG", help="the rosbag2 to write (MCAP)")
    add_settings(parser, IMPORT_SETTINGS)

    def run(given: argparse.Namespace) -> int:
        from flex_ident.formats import imported

        done = imported(given.files, given.out, given_settings(given, IMPORT_SETTINGS))
        print("\n".join([*done.lines, f"written: {given.out}"]))
        return 0

    parser.set_defaults(function=run)


def _compare(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "results",
        type=Path,
        nargs="+",
        metavar="RESULT",
        help=RESULT_TEXT,
    )

    def run(given: argparse.Namespace) -> int:
        from flex_ident.report.comparison import compared

        if len(given.results) < 2:
            raise UsageError("compare needs two results or more.")
        print(compared(given.results))
        return 0

    parser.set_defaults(function=run)


def _export(parser: argparse.ArgumentParser) -> None:
    from flex_ident.report.export.formats import FORMATS

    parser.add_argument(
        "result",
        type=Path,
        metavar="RESULT",
        help=RESULT_TEXT,
    )
    parser.add_argument("--to", required=True, choices=FORMATS, help="the format")
    parser.add_argument("--out", type=Path, metavar="FILE", help="default: standard output")

    def run(given: argparse.Namespace) -> int:
        from flex_ident.report.export import exported
        from flex_ident.report.folder import write_file

        text = exported(given.result, given.to)
        if given.out is None:
            refuse_unprintable(text)
            print(text)
        else:
            write_file(given.out, f"{text}\n".encode())
        return 0

    parser.set_defaults(function=run)


def _effects(parser: argparse.ArgumentParser) -> None:
    def run(given: argparse.Namespace) -> int:
        from flex_ident.commands.effects_catalogue import catalogue_text

        print(catalogue_text())
        return 0

    parser.set_defaults(function=run)


def _codes(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--markdown", action="store_true", help="as docs/codes.md")

    def run(given: argparse.Namespace) -> int:
        from flex_ident.report.codes import codes_page, codes_text

        print(codes_page().rstrip() if given.markdown else codes_text())
        return 0

    parser.set_defaults(function=run)


if __name__ == "__main__":
    sys.exit(main())
