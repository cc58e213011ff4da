"""How often the demo's truth lies in its own 95 % intervals: python bench/demo_seeds.py --seeds 20 [--live]

Without --live the recording is generated (the same plant, drive and noise, no DDS); with it the whole demo runs through
the nodes, a minute a seed.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path

from flex_ident.commands.demo import demonstrated
from flex_ident.virtual_joint import COBOT_JOINT

KEYS = ("K", "Jm", "JL")


def main() -> None:
    """Print a row for each seed and the number of seeds in which all three lie inside."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--live", action="store_true")
    given = parser.parse_args()
    good = 0
    for seed in range(given.seeds):
        with tempfile.TemporaryDirectory() as folder:
            demonstrated(Path(folder), seed=seed, live=given.live, quiet=True)
            [path] = Path(folder).rglob("result.json")
            parameters = json.loads(path.read_text())["parameters"]
        inside = {k: parameters[k]["ci95"][0] <= COBOT_JOINT.value(k) <= parameters[k]["ci95"][1] for k in KEYS}
        good += all(inside.values())
        print(f"seed {seed}: {inside}", flush=True)
    print(f"{good} of {given.seeds} seeds with K, Jm and JL inside their own 95 % intervals")


if __name__ == "__main__":
    main()
