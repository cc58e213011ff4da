"""A test of nodes that fails as the machine pauses is played again, alone; one that fails on an idle one has failed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import suppress

import pytest
from busy import MachineBusyError, Witness, excuse
from turns import turn

RERUNS = 5


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Where pytest-rerunfailures is installed, a test that failed as the machine was busy gets other tries."""
    again = config.pluginmanager.hasplugin("rerunfailures")
    for item in items:
        if isinstance(item, pytest.Function) and item.get_closest_marker("ros"):
            item.fixturenames[:0] = ["own_turn", "witness"]
            if again:
                item.add_marker(pytest.mark.flaky(reruns=RERUNS, only_rerun=[MachineBusyError.__name__]))


@pytest.fixture(scope="session")
def witness() -> Iterator[Witness]:
    """A process that sees the machine pause."""
    made = Witness()
    yield made
    made.end()


@pytest.fixture
def own_turn(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A test plays beside those of other processes; its other tries have the machine for themselves."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    with turn(folder, alone=getattr(request.node, "execution_count", 1) > 1):
        yield


@pytest.fixture(autouse=True)
def ordinary_process() -> Iterator[None]:
    """A node that was made in this process has given it real-time priority and set variables: those after it inherit
    neither.
    """
    before = dict(os.environ)
    yield
    os.environ.clear()
    os.environ.update(before)
    with suppress(OSError, AttributeError):
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Tell a failure that the machine's pauses explain from any other."""
    witness = item.funcargs.get("witness") if isinstance(item, pytest.Function) else None
    if witness is not None:
        witness.forget()
    outcome = yield
    failure = outcome.excinfo and outcome.excinfo[1]
    if witness is not None and isinstance(failure, Exception):  # neither skipped nor interrupted
        why = excuse(str(failure), witness.forget())
        if why:
            outcome.force_exception(MachineBusyError(f"{why}: {failure}").with_traceback(failure.__traceback__))
