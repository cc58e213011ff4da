"""What an archive costs: bags a second in one process, and by `flex_ident batch` with one worker and with two; and how
long `flex_ident health` takes on an archive of many rows.

    python bench/fleet.py --bags 8
    python bench/fleet.py --rows 10000

The bags are of rigid virtual joints (10 s, 200 Hz), which take half a second each: the overhead shows. The rows are
made up, one file each as `batch` writes them: 100 robots of ten joints, nine parameters each, ten results a joint, with
a result of the size that `identify_bag` writes. Run nothing beside it: the load of the machine is printed.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numpy as np

from flex_ident.bags.virtual import write_virtual_bag
from flex_ident.configuration.settings import IDENTIFY_SETTINGS
from flex_ident.fleet.archive import Archive
from flex_ident.fleet.recordings import found_recordings
from flex_ident.fleet.rows import common_row, result_row
from flex_ident.fleet.running import batch
from flex_ident.jobs.identifying import finished_identification
from flex_ident.jobs.places import Place
from flex_ident.parameters import JointModel
from flex_ident.virtual_joint import Experiment

EXPERIMENT = Experiment(duration_s=10.0, sample_rate_hz=200.0)
TRUTH = {"Jm": 1.0, "K": 1e4, "JL": 2.0, "FVm": 8.0, "FSm": 4.0, "FV": 2.0, "FS": 1.0, "MX": 0.5, "MY": 3.0}
RESULT_CHARACTERS = 8000
VALUES = {**{s.key: s.default for s in IDENTIFY_SETTINGS}, "rigid": True}


def seconds(run: Callable[[], object]) -> float:
    """How long it takes, s."""
    began = time.perf_counter()
    run()
    return time.perf_counter() - began


def made_up_archive(folder: Path, rows: int) -> None:
    """An archive of so many rows, a file each."""
    rng, archive = np.random.default_rng(1), Archive(folder).opened()
    padding = "x" * RESULT_CHARACTERS
    for i in range(rows):
        robot, joint, number = i % 100, i // 100 % 10, i // 1000
        sha256 = hashlib.sha256(str(i).encode()).hexdigest()
        parameters = {
            key: {"value": true * float(rng.normal(1.0, 0.02)), "std": 0.005 * true, "unit": "SI", "identifiable": True}
            for key, true in TRUTH.items()
        }  # fmt: skip
        content = {
            "joint": f"joint_{joint}", "sensors": "motor+link", "method": "auto", "verdict": "trusted",
            "parameters": parameters, "warnings": [], "padding": padding,
        }  # fmt: skip
        common = common_row(
            robot=f"arm {robot}", bag=f"bag {i}", sha256=sha256, tag="", conditions={}, settings={}
        )  # fmt: skip
        row = result_row(common, content, start_time_s=1.7e9 + 2.6e6 * number + i, seconds=1.0)
        archive.write(archive.file_of(sha256, {}), [row])


def health_seconds(count: int) -> None:
    """Print how long health takes over an archive of so many rows, whole commands in processes of their own."""
    with tempfile.TemporaryDirectory() as name:
        with patch("os.fsync"):  # of what is made up nothing can be lost
            made_up_archive(Path(name), count)
        command = [sys.executable, "-m", "flex_ident.commands.flex_ident", "health", name]
        for form in (["--json"], ["--json"], ["--out", str(Path(name) / "page")]):  # the first gathers the rows
            took = seconds(lambda form=form: subprocess.run([*command, *form], stdout=subprocess.DEVNULL))
            print(f"health over {count} rows in as many files, {form[0]}: {took:.1f} s (load {os.getloadavg()[0]:.1f})")


def main() -> None:
    """Print a line for each way."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bags", type=int, default=8)
    parser.add_argument("--rows", type=int, default=0)
    given = parser.parse_args()
    if given.rows:
        health_seconds(given.rows)
        return
    count = given.bags
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for seed in range(count):
            model = JointModel({"J": 2.0, "FV": 3.0, "FS": 1.0, "offset": 0.0}, joint="elbow")
            (folder / "bags").mkdir(exist_ok=True)
            write_virtual_bag(folder / "bags" / f"run{seed}", model, EXPERIMENT, seed=seed)
        bags = found_recordings([str(folder / "bags")])

        def one_process() -> None:
            for bag in bags:
                finished_identification(bag.path, VALUES, Place(lambda _joint: None, needed=False), plots=False)

        one_process()  # what is compiled is compiled
        alone = seconds(one_process)
        print(f"load {os.getloadavg()[0]:.1f}; one process, a loop: {alone:.1f} s, {alone / count:.2f} s a bag")
        for workers in (1, 2):
            archive = folder / f"fleet{workers}"
            run = partial(batch, bags, VALUES, archive, workers=workers)
            took, again = seconds(run), seconds(run)
            own = took - again
            print(
                f"batch, {workers} worker(s): {took:.1f} s, {again:.1f} s of it start and hashes (a second run); "
                f"{own / count:.2f} s a bag beyond that, {alone / own:.2f} times as fast as the loop"
            )


if __name__ == "__main__":
    main()
