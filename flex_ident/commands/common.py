"""What all commands share: one-line errors, exit statuses, shared options, the progress bar."""

from __future__ import annotations

import argparse
import math
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from flex_ident import __version__
from flex_ident.commands.streams import lasting_streams
from flex_ident.configuration.settings import (
    GAP_SETTINGS,
    IDENTIFY_SETTINGS,
    IMPORT_SETTINGS,
    SET_SETTINGS,
    Setting,
    Value,
)
from flex_ident.errors import ConfigurationError, FlexIdentError, UsageError
from flex_ident.stopping import Stopped, stoppable

if TYPE_CHECKING:
    from flex_ident.recording import Recording

REJECTED = 4
"""Exit status of a result that must not be trusted."""


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, and whose options take values like -3@0.4, which look like an option."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """As argparse, values that begin with a minus and a digit joined to the option before them."""
        given = list(sys.argv[1:] if args is None else args)
        for i in range(len(given) - 1, 0, -1):
            option, value = str(given[i - 1]), str(given[i])
            if re.match(r"-\.?\d", value) and not _is_number(value) and re.fullmatch(r"--[\w-]+", option):
                given[i - 1 : i + 1] = [f"{option}={value}"]
        return super().parse_known_args(given, namespace)

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message}. See {self.prog} --help.")


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


EXIT_STATUSES = """\
exit status:
  0  done
  2  wrong usage or configuration, or an output that cannot be written
  3  the data cannot answer: no such topic or joint, no motion, too few samples, an unreadable bag
  4  done, but the result must not be trusted"""


def help_end(examples: Sequence[str], statuses: str = EXIT_STATUSES) -> str:
    """What `--help` says below the options: examples and exit statuses."""
    return "\n".join(["examples:", *(f"  {example}" for example in examples), "", statuses])


def command_parser(prog: str, description: str, examples: Sequence[str]) -> Parser:
    """A parser with `--version`, and with examples and exit statuses at the end of `--help`."""
    parser = Parser(
        prog=prog, description=description, epilog=help_end(examples), allow_abbrev=False,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    parser.add_argument("--version", action="version", version=f"flex_ident {__version__}")
    return parser


def exit_status(prog: str, body: Callable[[], int]) -> int:
    """Run a command's body; every failure becomes one line on standard error and its exit status.

    FLEX_IDENT_DEBUG=1 lets the traceback through, for developers. What cannot be printed does not end the work: a full
    disk behind standard output is told once the body is done; one that is closed, or whose reader left, is not.
    """
    with stoppable(), lasting_streams() as failures:
        try:
            status = _body_status(prog, body)
        except SystemExit:  # --help and --version
            if not failures:
                raise
            status = 0
        if failures:
            return _unprinted(prog, failures[0])
        return status


def _body_status(prog: str, body: Callable[[], int]) -> int:
    """The exit status of a body, after its failure, if any, was told."""
    try:
        try:
            return body()
        finally:
            sys.stdout.flush()
    except FlexIdentError as error:
        print(f"{prog}: {one_line(error)}", file=sys.stderr)
        return error.exit_status
    except KeyboardInterrupt as error:
        how = one_line(error) or "stopped"
        print(f"{prog}: {how}; what was not finished is not written.", file=sys.stderr)
        return error.exit_status if isinstance(error, Stopped) else 130
    except OSError as error:
        # Files that commands read and write are checked where they are; what is left is a disk that fills up meanwhile.
        return _unprinted(prog, error)
    except MemoryError:
        print(f"{prog}: not enough memory for this recording.", file=sys.stderr)
        return 3
    except Exception as error:
        if os.environ.get("FLEX_IDENT_DEBUG"):
            raise
        kind = type(error).__name__
        print(f"{prog}: internal error ({kind}: {one_line(error)}): please report it; FLEX_IDENT_DEBUG=1 shows where.",
              file=sys.stderr)  # fmt: skip
        return 3


def _unprinted(prog: str, error: OSError) -> int:
    """One line about a file, or standard output, that failed meanwhile; the exit status that it brings."""
    what = error.filename or "the output"
    print(f"{prog}: {what} cannot be read or written ({error.strerror or one_line(error)}).", file=sys.stderr)
    return 2


def one_line(error: BaseException) -> str:
    """The message of an error on one line."""
    return " ".join(str(error).split())


def add_settings(parser: argparse.ArgumentParser, settings: Sequence[Setting] = IDENTIFY_SETTINGS) -> None:
    """One option a setting, each None when not given, and `--config`."""
    parser.add_argument("--config", metavar="FILE", type=Path, help="YAML of settings; options win over it")
    for s in settings:
        if isinstance(s.default, bool):
            parser.add_argument(s.option, dest=s.key, action="store_true", default=None, help=s.description)
        else:
            shown = s.metavar or ("|".join(s.choices) if s.choices else s.key.upper())
            action = "append" if s.repeated else "store"
            parser.add_argument(s.option, dest=s.key, metavar=shown, default=None, action=action, help=s.description)


def add_output_options(parser: argparse.ArgumentParser) -> None:
    """`--json`, `--quiet` and `--no-plots`."""
    parser.add_argument("--json", action="store_true", help="the result, and nothing else, on standard output")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    parser.add_argument("--no-plots", action="store_true", help="write no plots and no report.html")


def given_settings(
    arguments: argparse.Namespace, settings: Sequence[Setting] = IDENTIFY_SETTINGS, *, node: str = "identifier"
) -> dict[str, Value]:
    """Defaults, then the configuration file, then the options. Raises ConfigurationError and UsageError."""
    values: dict[str, Value] = {s.key: s.default for s in settings}
    if arguments.config is not None:
        from flex_ident.configuration import read_settings

        values.update(read_settings(arguments.config, settings, node=node, others=KNOWN_KEYS))
    for s in settings:
        text = getattr(arguments, s.key)
        if text is not None:
            values[s.key] = _from_command_line(s, text)
    return values


KNOWN_KEYS = (
    "bag", "bag_directories", "output_directory", "use_sim_time", "health", "baseline",
    *(s.key for s in (*IDENTIFY_SETTINGS, *GAP_SETTINGS, *SET_SETTINGS, *IMPORT_SETTINGS)),
)  # fmt: skip
"""Keys that a file shared with the identifier node and other commands may hold."""


def seed_number(text: str) -> int:
    """A seed from the command line. Raises ArgumentTypeError."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number from 0 on")
    return int(text)


def finite_number(text: str) -> float:
    """A finite number from the command line. Raises ArgumentTypeError."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r}: expected a finite number")
    return value


def _from_command_line(setting: Setting, text: Any) -> Value:
    value = text
    if setting.repeated and any(setting.separator in own for own in text):
        raise UsageError(f"{setting.option} {text[0]!r}: give the option once for each, without '{setting.separator}'.")
    if isinstance(setting.default, float):
        try:
            value = float(text)
        except ValueError:
            raise UsageError(f"{setting.option} is {text!r}: expected {setting.range_text}.") from None
    try:
        return setting.checked(value, "command line")
    except ConfigurationError:
        raise UsageError(f"{setting.option} is {text!r}: expected {setting.range_text}.") from None


def say_unwritten(prog: str, why: UsageError | None, *, asked_for: bool) -> int:
    """One line on standard error where a result was not written; the exit status that it brings."""
    if why is None:
        return 0
    print(f"{prog}: {one_line(why)} The result is printed only.", file=sys.stderr)
    return why.exit_status if asked_for else 0


def say_failed(prog: str, why: FlexIdentError | None) -> int:
    """One line on standard error about a part that failed while the rest holds; the exit status that it brings."""
    if why is None:
        return 0
    print(f"{prog}: {one_line(why)}", file=sys.stderr)
    return why.exit_status


def say_what_was_read(recording: Recording) -> None:
    """Print which signals were taken and how each was sampled."""
    from flex_ident.report.table import percent_text

    for s in recording.sampling:
        print(f"{s.role.replace('_', ' ')}: {s.source} ({s.samples} samples at {s.rate_hz:.2f} Hz, "
              f"{s.clock} stamps, jitter {s.jitter_percent:.1f} %, {percent_text(s.lost_percent)} lost)")  # fmt: skip


@contextmanager
def stage_bars(*, shown: bool) -> Iterator[Callable[[str, float], None]]:
    """A function that takes a stage's name and its share done; a bar appears for what takes longer than a second."""
    if not shown or not sys.stderr.isatty():
        yield lambda _text, _share: None
        return
    from tqdm import tqdm

    form = "{desc}: {percentage:3.0f} %|{bar}| {elapsed}"
    bars: dict[str, Any] = {}

    def report(text: str, share: float) -> None:
        if text not in bars:
            for bar in bars.values():
                bar.close()
            bars[text] = tqdm(total=1.0, desc=text, delay=1.0, leave=False, bar_format=form, file=sys.stderr)
        bars[text].update(max(0.0, min(1.0, share) - bars[text].n))

    try:
        yield report
    finally:
        for bar in bars.values():
            bar.close()
