"""`flex_ident health ARCHIVE`: what has changed since the baseline, joint by joint."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from flex_ident.commands.common import help_end

CHANGED = 4
"""Exit status where something has changed."""
EXAMPLES = (
    "flex_ident health fleet",
    "flex_ident health fleet --baseline 2026-03-31   # against all recordings up to that day",
    "flex_ident health fleet --baseline acceptance --json",
    "flex_ident health fleet --out health            # a page with each joint's series",
)
STATUSES = """\
exit status:
  0  nothing has changed
  2  wrong usage, or a library is missing
  3  nothing can be compared, or there is no archive
  4  something has changed"""


def add_health(parser: argparse.ArgumentParser) -> None:
    """The options of `flex_ident health`, and what it runs."""
    parser.epilog = help_end(EXAMPLES, STATUSES)
    parser.add_argument("archive", type=Path, metavar="ARCHIVE", help="the folder that flex_ident batch wrote")
    parser.add_argument(
        "--baseline", default="", metavar="DATE|TAG",
        help="recordings up to a day (YYYY-MM-DD), or results of a batch --tag; default: the first three sessions",
    )  # fmt: skip
    parser.add_argument("--json", action="store_true", help="the result, and nothing else, on standard output")
    parser.add_argument("--out", type=Path, metavar="DIR", help="write report.html and health.json there")
    parser.set_defaults(function=_run)


def _run(given: argparse.Namespace) -> int:
    from flex_ident.fleet.archive import Archive
    from flex_ident.fleet.health import COLUMNS, fleet_health
    from flex_ident.report.folder import check_writable
    from flex_ident.report.health_table import health_text, worded

    if given.out is not None:
        check_writable(given.out)
    content = fleet_health(Archive(given.archive).rows(COLUMNS), given.baseline)
    print(json.dumps(worded(content), allow_nan=False) if given.json else health_text(content))
    if given.out is not None:
        from flex_ident.report.health_report import write_health

        paths = write_health(content, given.out)
        if not given.json:
            print(f"\nwritten: {', '.join(str(path) for path in paths.values())}")
    return CHANGED if content["changes"] else 0
