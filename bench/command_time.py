"""Whole commands on 60 s at 1 kHz, cold and warm: python bench/command_time.py

Cold: nothing compiled is cached (`NUMBA_CACHE_DIR` is empty), as once after an installation. Each figure is the wall
time of a fresh process, plots and report included; the bag is read from the disk's cache.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from flex_ident.bags.virtual import write_virtual_bag
from flex_ident.virtual_joint import JOINTS, Experiment, MeasurementChain

COMMANDS = {
    "identify_bag --sensors motor": ("identify_bag", "--sensors", "motor"),
    "identify_bag --sensors motor+link": ("identify_bag", "--sensors", "motor+link"),
    "explain_gap --sensors motor": ("explain_gap", "--sensors", "motor"),
    "explain_gap --sensors motor+link": ("explain_gap", "--sensors", "motor+link"),
}
DONE = (0, 4)


def seconds(command: tuple[str, ...], bag: Path, folder: Path) -> float:
    """Wall time, s, of one command as a process of its own."""
    name, *options = command
    start = time.perf_counter()
    ended = subprocess.run(
        [Path(sys.executable).parent / name, bag, *options, "--quiet", "--out", folder / "out"],
        env={**os.environ, "NUMBA_CACHE_DIR": str(folder / "compiled")}, check=False, capture_output=True, text=True,
    )  # fmt: skip
    if ended.returncode not in DONE:
        sys.exit(f"{name} ended with {ended.returncode}: {ended.stderr.strip()}")
    return time.perf_counter() - start


def main() -> None:
    """A row for each command and joint."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--joints", default="paper,cobot")
    parser.add_argument("--effect", default="", help="hide one: backlash, joint_damping")
    given = parser.parse_args()
    hidden = {"backlash": {"gap": 6e-4}, "joint_damping": {"damping": 3.0}}
    print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}\n")
    print("| command | joint | cold, s | warm, s |\n| --- | --- | --- | --- |")
    for joint in given.joints.split(","):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            model = JOINTS[joint]
            if given.effect:
                model = model.with_effect(given.effect, hidden[given.effect])
            bag = folder / "bag"
            chain = MeasurementChain(torque_noise=0.01, jitter=0.05, lost=0.002)
            write_virtual_bag(bag, model, Experiment(duration_s=60.0, sample_rate_hz=1000.0), chain)
            for text, command in COMMANDS.items():
                cold = seconds(command, bag, folder) if text == next(iter(COMMANDS)) else None
                warm = seconds(command, bag, folder)
                print(f"| {text} | {joint} | {'' if cold is None else f'{cold:.1f}'} | {warm:.1f} |", flush=True)


if __name__ == "__main__":
    main()
