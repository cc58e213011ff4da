"""What an archive costs: bags a second in one process, and by `flex_ident batch` with one worker and with two.

    python bench/fleet.py --bags 8

The bags are of rigid virtual joints (10 s, 200 Hz), which take half a second each: the overhead shows. Run nothing
beside it.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from flex_ident.bags.virtual import write_virtual_bag
from flex_ident.configuration.settings import IDENTIFY_SETTINGS
from flex_ident.fleet.recordings import found_recordings
from flex_ident.fleet.running import batch
from flex_ident.jobs.identifying import finished_identification
from flex_ident.jobs.places import Place
from flex_ident.parameters import JointModel
from flex_ident.virtual_joint import Experiment

EXPERIMENT = Experiment(duration_s=10.0, sample_rate_hz=200.0)
VALUES = {**{s.key: s.default for s in IDENTIFY_SETTINGS}, "rigid": True}


def seconds(run: Callable[[], object]) -> float:
    """How long it takes, s."""
    began = time.perf_counter()
    run()
    return time.perf_counter() - began


def main() -> None:
    """Print a line for each way."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bags", type=int, default=8)
    count = parser.parse_args().bags
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
        print(f"one process, a loop: {alone:.1f} s, {alone / count:.2f} s a bag")
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
