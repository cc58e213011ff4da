"""How every node runs and ends: help, one line on standard error, an exit status, never a traceback."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TypeVar

import rclpy
from rclpy.executors import Executor, ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from flex_ident.commands.common import one_line
from flex_ident.errors import FlexIdentError
from flex_ident.nodes.parameter_files import refuse_what_is_no_file
from flex_ident.nodes.starting import SIGNALS, asked, note_signals
from flex_ident.nodes.usage import Usage, help_wanted

N = TypeVar("N", bound=Node)
LOOK_S = 0.1


def run_node(
    usage: Usage, make: Callable[[], N], run: Callable[[N, Sequence[str]], int], arguments: list[str] | None
) -> int:
    """Start rclpy, make the node and run it until it ends or finds the name of a signal in the list it is given."""
    name = usage.node
    if help_wanted(sys.argv[1:] if arguments is None else arguments):
        print(usage)
        return 0
    before = note_signals()
    try:
        refuse_what_is_no_file(arguments)
        rclpy.init(args=arguments, signal_handler_options=SignalHandlerOptions.NO)
        node = make()
    except Exception as error:  # rclpy's own errors are about arguments and parameters
        _complain(name, error)
        rclpy.try_shutdown()
        for number, handler in before.items():
            signal.signal(number, handler)
        return error.exit_status if isinstance(error, FlexIdentError) else 2
    try:
        return run(node, asked)
    except ExternalShutdownException:
        return 0
    except FlexIdentError as error:
        _complain(name, error)
        return error.exit_status
    except Exception as error:
        on_stderr(f"{name}: internal error ({type(error).__name__}: {one_line(error)}): please report it.")
        return 3
    finally:
        for number in SIGNALS:
            signal.signal(number, signal.SIG_IGN)
        node.destroy_node()  # or Fast DDS takes it down while the process exits: one in thirty died of that, under load
        rclpy.try_shutdown()


def spin(executor: Executor, asked: Sequence[str]) -> None:
    """Serve the executor's nodes until a signal asks to end, or rclpy is shut down."""
    while not asked and executor.context.ok():
        executor.spin_once(timeout_sec=LOOK_S)


def _complain(name: str, error: BaseException) -> None:
    """One line, the node's name once in front."""
    on_stderr(f"{name}: {one_line(error).removeprefix(f'{name}: ')}")


def on_stderr(line: str) -> None:
    """A line on standard error, if anybody reads there: a node ends as it should where nobody does."""
    with suppress(OSError, ValueError):
        print(line, file=sys.stderr, flush=True)
