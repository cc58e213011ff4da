"""kill -9 of a worker and of the whole command in mid-run, over and over: nothing is lost, nothing is there twice."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from fleet_bags import small_bag

pytest.importorskip("distributed", reason="needs dask", exc_type=ImportError)
pytest.importorskip("pyarrow", reason="needs pyarrow", exc_type=ImportError)
from flex_ident.configuration.settings import IDENTIFY_SETTINGS
from flex_ident.fleet.archive import Archive
from flex_ident.fleet.running import asked
from flex_ident.fleet.work import Work, archived

psutil = pytest.importorskip("psutil")
BAGS = 6
VALUES = {s.key: s.default for s in IDENTIFY_SETTINGS} | {"rigid": True}
pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def many(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("many") / "bags"
    for seed in range(BAGS):
        small_bag(folder / f"run{seed}", seed=seed, inertia=2.0 + 0.1 * seed)
    return folder


@pytest.fixture(scope="module")
def undisturbed(many: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The parameters of each recording, by its name, one after the other in this process."""
    folder = tmp_path_factory.mktemp("undisturbed")
    for bag in sorted(many.iterdir()):
        archived(Work(bag, "", "", asked(VALUES), folder))
    return contents(folder)


def contents(folder: Path) -> dict[str, Any]:
    """What the archive says of each recording; each is there once."""
    rows = Archive(folder).rows()
    names = [Path(row["bag"]).name for row in rows]
    assert sorted(names) == sorted(set(names))
    return {name: json.loads(row["result"])["parameters"] for name, row in zip(names, rows, strict=True)}


def started(many: Path, folder: Path) -> subprocess.Popen[bytes]:
    given = ["batch", str(many), "--archive", str(folder), "--rigid", "--quiet", "--workers", "2"]
    return subprocess.Popen([sys.executable, "-m", "flex_ident.commands.flex_ident", *given])


def wait_for(folder: Path, count: int, command: subprocess.Popen[bytes]) -> None:
    until = time.monotonic() + 120.0
    while len(list(folder.glob("*.parquet"))) < count and command.poll() is None and time.monotonic() < until:
        time.sleep(0.005)


def workers_of(command: subprocess.Popen[bytes]) -> list[Any]:
    """The worker processes, not what keeps their books."""
    below = psutil.Process(command.pid).children(recursive=True)
    return [p for p in below if "spawn_main" in " ".join(p.cmdline())]


def test_workers_killed_one_after_the_other_cost_nothing(
    many: Path, undisturbed: dict[str, Any], tmp_path: Path
) -> None:
    command = started(many, tmp_path / "fleet")
    killed = 0
    try:
        for count in (1, 3):
            wait_for(tmp_path / "fleet", count, command)
            if command.poll() is None and (found := workers_of(command)):
                found[0].send_signal(signal.SIGKILL)
                killed += 1
        status = command.wait(timeout=240.0)
    finally:
        command.kill()
    assert killed
    assert status == 0
    assert contents(tmp_path / "fleet") == undisturbed


@pytest.mark.campaign
def test_the_command_killed_again_and_again_goes_on(many: Path, undisturbed: dict[str, Any], tmp_path: Path) -> None:
    fleet, there = tmp_path / "fleet", dict[Path, int]()
    for count in (1, 2, 4):
        command = started(many, fleet)
        wait_for(fleet, count, command)
        own = psutil.Process(command.pid).children(recursive=True) if command.poll() is None else []
        command.kill()
        command.wait()
        assert not psutil.wait_procs(own, timeout=60.0)[1]
        now = {p: p.stat().st_mtime_ns for p in fleet.glob("*.parquet")}
        assert there.items() <= now.items()
        there = now
    assert there
    assert started(many, fleet).wait(timeout=240.0) == 0
    now = {p: p.stat().st_mtime_ns for p in fleet.glob("*.parquet")}
    assert there.items() <= now.items()
    assert contents(fleet) == undisturbed
