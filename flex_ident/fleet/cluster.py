"""Dask: one function over many items, on processes of this machine or on a cluster that is there.

A local worker is a process of one thread with one core's share of the memory. When a worker dies Dask gives its item to
another; an item whose workers keep dying is tried once more by itself, so that it is not blamed for its neighbour.
"""

from __future__ import annotations

import logging
import os
import signal
import threading
from asyncio import CancelledError
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from multiprocessing import resource_tracker
from typing import Any, TypeVar

from flex_ident.bags.extras import extra_module
from flex_ident.errors import FlexIdentError, UsageError
from flex_ident.fleet.archive import EXTRA, WHAT
from flex_ident.stopping import unbroken

Item = TypeVar("Item")
Result = TypeVar("Result")
ALONE = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
DEATHS = 1
"""Workers of this machine that an item may cost before it is tried by itself; a cluster has a setting of its own."""
CONNECT_S = 10.0
MEMORY = {
    "distributed.worker.memory.target": False, "distributed.worker.memory.spill": False,
    "distributed.worker.memory.pause": False, "distributed.worker.memory.terminate": 0.95,
}  # fmt: skip
"""A recording cannot be spilled to disk, and a paused worker waits for ever: it is ended when it takes too much."""
ANY_PORT = "127.0.0.1:0"
"""Of the scheduler's own page: two commands at a time do not meet."""
SILENT = 60
"""Above the highest level of logging."""


class ClusterError(FlexIdentError):
    """The cluster, and not a recording, failed."""


@contextmanager
def connected(address: str = "", workers: int = 0) -> Iterator[Any]:
    """A Dask client of the scheduler at `address`, or of a cluster of this machine with so many workers (0: its cores).

    Raises MissingExtraError without Dask, and UsageError when nothing answers at the address.
    """
    dask, distributed = (extra_module(name, EXTRA, WHAT) for name in ("dask", "distributed"))
    settings = {
        **MEMORY, "distributed.scheduler.allowed-failures": DEATHS,
        "distributed.nanny.pre-spawn-environ": {**dask.config.get("distributed.nanny.pre-spawn-environ", {}), **ALONE},
    }  # fmt: skip
    if address:
        _silence()
        try:
            client = distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise UsageError(f"--scheduler {address}: no Dask scheduler answers there.") from error
        with client:
            yield client
        return
    started = ExitStack()
    try:
        with unbroken():  # Dask cannot close a cluster that is half started
            started.enter_context(dask.config.set(settings))
            _start_tracker()
            cluster = started.enter_context(
                distributed.LocalCluster(
                    n_workers=workers or cores(), threads_per_worker=1, processes=True,
                    memory_limit=memory_share(distributed), dashboard_address=ANY_PORT, silence_logs=SILENT,
                )
            )  # fmt: skip
            client = started.enter_context(distributed.Client(cluster, set_as_default=False))
        yield client
    finally:
        with unbroken():
            started.close()


def _start_tracker() -> None:
    """Start the process that multiprocessing keeps account with so that it outlives a closing terminal.

    It ignores SIGINT and SIGTERM by itself; SIGHUP would end it before the workers, which then fill standard error.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        resource_tracker.ensure_running()
    finally:
        signal.signal(signal.SIGHUP, before)


def outcomes(client: Any, function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[tuple[Item, Any]]:
    """Each item with what the function says of it, or None where its workers died, in the order of completion.

    Raises ClusterError when the cluster goes away or cannot run the function.
    """
    again: list[Item] = []
    for item, result in _completed(client, function, items):
        if result is None:
            again.append(item)
        else:
            yield item, result
    for item in again:
        yield from _completed(client, function, [item])


def _completed(client: Any, function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[tuple[Item, Any]]:
    distributed = extra_module("distributed", EXTRA, WHAT)
    cancelled = distributed.client.FutureCancelledError
    futures = {client.submit(function, item, pure=False): item for item in items}
    for future in distributed.as_completed(list(futures), loop=client.loop):
        item = futures.pop(future)
        try:
            result = future.result()  # waits anew where it was lost with the worker that had it
        except distributed.KilledWorker:
            yield item, None
        except (CancelledError, cancelled) as error:
            raise ClusterError("the connection to the Dask scheduler is lost.") from error
        except Exception as error:
            text = " ".join(str(error).split())
            raise ClusterError(f"a Dask worker cannot do this ({type(error).__name__}: {text}).") from error
        else:
            yield item, result
        future.release()


def _silence() -> None:
    """Keep Dask from telling on standard error, with tracebacks, what is said in a line."""
    for name in list(logging.root.manager.loggerDict):
        if name.partition(".")[0] == "distributed":
            logging.getLogger(name).setLevel(SILENT)


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def memory_share(distributed: Any) -> int:
    """One core's share of the memory, bytes."""
    return int(distributed.system.MEMORY_LIMIT / max(1, os.cpu_count() or 1))
