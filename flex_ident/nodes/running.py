"""How every node starts and ends: one line on standard error, an exit status, never a traceback."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from typing import Any, TypeVar

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from flex_ident.commands.common import one_line
from flex_ident.errors import FlexIdentError

N = TypeVar("N")


def run_node(
    name: str, make: Callable[[], N], run: Callable[[N], int], arguments: list[str] | None, *, own_signals: bool = False
) -> int:
    """Start rclpy, make the node and run it; `own_signals`: the node handles SIGINT and SIGTERM itself."""
    options = SignalHandlerOptions.NO if own_signals else SignalHandlerOptions.ALL
    try:
        rclpy.init(args=arguments, signal_handler_options=options)
        node = make()
    except FlexIdentError as error:
        return _failed(name, error, error.exit_status)
    except (ParameterException, ValueError, RuntimeError) as error:
        return _failed(name, error, 2)
    except Exception as error:
        return _failed(name, error, 2)
    try:
        return run(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        return 0
    except FlexIdentError as error:
        print(f"{name}: {one_line(error)}", file=sys.stderr)
        return error.exit_status
    except Exception as error:
        print(f"{name}: internal error ({type(error).__name__}: {one_line(error)}): please report it.", file=sys.stderr)
        return 3
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        rclpy.try_shutdown()


def quick_executor() -> Executor:
    """The executor that costs least: at 1 kHz rclpy's events executor takes half of the other's processor time."""
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:  # rclpy before 7.1.4
        return SingleThreadedExecutor()
    return EventsExecutor()


def _failed(name: str, error: BaseException, status: int) -> int:
    print(f"{name}: {one_line(error)}", file=sys.stderr)
    rclpy.try_shutdown()
    return status


def topic_type(node: Any, name: str) -> str:
    """The type of a topic that is there; empty when it is not."""
    for topic, types in node.get_topic_names_and_types():
        if topic == name and types:
            return str(types[0])
    return ""
