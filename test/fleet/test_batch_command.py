"""`flex_ident batch` on a cluster: resumed, killed, with broken recordings and dying workers."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest
from fleet_bags import small_bag

from flex_ident.commands.flex_ident import main

pytest.importorskip("distributed", reason="needs dask", exc_type=ImportError)
pytest.importorskip("pyarrow", reason="needs pyarrow", exc_type=ImportError)
from flex_ident.fleet.archive import Archive
from flex_ident.fleet.cluster import outcomes
from flex_ident.fleet.running import Batch
from flex_ident.fleet.work import JointOutcome, Outcome


@pytest.mark.slow
def test_archive_holds_what_identify_bag_says_and_is_made_once(
    bags: Path, expected: dict[str, Any], client: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [
        "batch", f"{bags}/{{robot}}/**", "--archive", str(tmp_path / "fleet"), "--rigid", "--tag", "new",
        "--scheduler", client.scheduler.address,
    ]  # fmt: skip
    assert main([*given, "--csv", str(tmp_path / "fleet.csv")]) == 4
    said = capsys.readouterr()
    assert said.out.startswith("3 recordings, 3 new, 0 there already; results: 1 without an answer, 2 trusted\n")
    [line] = said.err.splitlines()
    assert line.startswith("flex_ident batch: ")
    assert "tuesday/x.mcap" in line
    rows = Archive(tmp_path / "fleet").rows()
    assert sorted((r["robot"], r["joint"], r["verdict"], r["tag"]) for r in rows) == [
        ("r1", "elbow", "trusted", "new"), ("r2", "", "error", "new"), ("r2", "elbow", "trusted", "new"),
    ]  # fmt: skip
    for row in (r for r in rows if r["verdict"] != "error"):
        assert json.loads(row["result"]) == expected[row["robot"]]
        assert row["J"] == expected[row["robot"]]["parameters"]["J"]["value"]
        assert row["J_std"] == expected[row["robot"]]["parameters"]["J"]["std"]
    assert len((tmp_path / "fleet.csv").read_text().splitlines()) == 4
    files = {p: p.stat().st_mtime_ns for p in (tmp_path / "fleet").iterdir()}
    assert len(files) == 3
    assert main(given) == 4
    assert "3 recordings, 0 new, 3 there already" in capsys.readouterr().out
    assert {p: p.stat().st_mtime_ns for p in (tmp_path / "fleet").iterdir()} == files


@pytest.mark.slow
def test_a_killed_command_goes_on_where_it_was(client: Any, tmp_path: Path) -> None:
    psutil = pytest.importorskip("psutil")
    for seed in range(2):
        small_bag(tmp_path / "bags" / f"run{seed}", seed=seed)
    fleet = tmp_path / "fleet"
    given = ["batch", str(tmp_path / "bags"), "--archive", str(fleet), "--rigid", "--quiet"]
    command = subprocess.Popen([sys.executable, "-m", "flex_ident.commands.flex_ident", *given, "--workers", "1"])
    try:
        until = time.monotonic() + 60.0
        while not list(fleet.glob("*.parquet")) and time.monotonic() < until:
            time.sleep(0.01)
        workers = psutil.Process(command.pid).children(recursive=True)
    finally:
        os.kill(command.pid, signal.SIGKILL)
        command.wait()
    assert workers
    assert not psutil.wait_procs(workers, timeout=20.0)[1]
    there = {p: p.stat().st_mtime_ns for p in fleet.glob("*.parquet")}
    assert there
    assert main([*given, "--scheduler", client.scheduler.address]) == 0
    rows = Archive(fleet).rows()
    assert len(list(fleet.glob("*.parquet"))) == len(rows) == 2
    assert {Path(r["bag"]).name for r in rows} == {"run0", "run1"}
    assert all(p.stat().st_mtime_ns == stamp for p, stamp in there.items())


STARTING = """
import sys
from distributed.nanny import Nanny
start = Nanny.instantiate
def told(nanny):
    print("starting", flush=True)
    return start(nanny)
Nanny.instantiate = told
from flex_ident.commands.flex_ident import main
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGTERM])
def test_a_signal_while_the_cluster_starts_leaves_one_line(number: signal.Signals, tmp_path: Path) -> None:
    small_bag(tmp_path / "bags" / "run", seed=0)
    given = ["batch", str(tmp_path / "bags"), "--archive", str(tmp_path / "fleet"), "--workers", "1"]
    command = subprocess.Popen(
        [sys.executable, "-c", STARTING, *given], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        start_new_session=True,
    )  # fmt: skip
    assert command.stdout is not None
    assert command.stdout.readline() == b"starting\n"
    os.killpg(command.pid, number)  # as a terminal that closes does
    _, said = command.communicate(timeout=60.0)
    assert command.returncode == 128 + number
    [line] = said.decode().splitlines()
    assert line.startswith("flex_ident batch: stopped. What is finished is in ")


def test_a_worker_that_dies_costs_its_own_item_only(client: Any) -> None:
    def doubled(number: int) -> int:
        if number == 3:
            import os
            import signal

            os.kill(os.getpid(), signal.SIGKILL)
        return 2 * number

    found = dict(outcomes(client, doubled, range(6)))
    assert found == {n: None if n == 3 else 2 * n for n in range(6)}


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (("--scheduler", "nonsense://x"), "--scheduler nonsense://x: no Dask scheduler answers there."),
        (("--scheduler", "tcp://x:1", "--workers", "2"), "--workers is of this machine"),
        (("--workers", "0"), "--workers"),
        (("--archive", "/proc/nothing"), "--archive /proc/nothing: cannot be written"),
        (("--effort-kind", "guessed"), "--effort-kind"),
        (("--model", "gone.yaml"), "gone.yaml"),
    ],
)
def test_wrong_usage_is_one_line(
    bags: Path, tmp_path: Path, arguments: tuple[str, ...], text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    archive = () if "--archive" in arguments else ("--archive", str(tmp_path / "fleet"))
    assert main(["batch", str(bags), *archive, *arguments]) == 2
    said = capsys.readouterr().err
    assert text in said
    assert len(said.splitlines()) == 1
    assert not (tmp_path / "fleet").exists()


@pytest.mark.parametrize("library", ["distributed", "pyarrow"])
def test_what_is_missing_is_said(
    bags: Path, tmp_path: Path, library: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    assert main(["batch", str(bags), "--archive", str(tmp_path / "fleet")]) == 2
    assert capsys.readouterr().err == (
        f"flex_ident: Archives of many recordings need {library}: pip install 'flex_ident[fleet]'.\n"
    )


@pytest.mark.parametrize(
    ("verdicts", "status"),
    [
        (("trusted", "doubtful"), 0), (("trusted", "rejected"), 4), (("trusted", "error"), 4), (("rejected",), 4),
        (("error", "error"), 3),
    ],
)  # fmt: skip
def test_exit_status_is_of_the_worst_that_matters(verdicts: tuple[str, ...], status: int) -> None:
    joints = tuple(JointOutcome("elbow", verdict, "") for verdict in verdicts)
    assert Batch((Outcome(Path("bag"), joints),)).exit_status == status
    assert Batch(tuple(Outcome(Path("bag"), (joint,)) for joint in joints)).exit_status == status
