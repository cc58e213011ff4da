"""What `explain_gap` says of three recordings of one joint: an effect in all of them, in one alone, or in none.

    python bench/gap_sets.py --sets 4 --out gap_sets.jsonl

The recordings are of `virtual_joint`, a plant that shares nothing with the simulation of the method, with both
encoders: amplitude, sweep, starting position and noise differ between them, and the effect's size by 3 %. In a third of
the sets the effect is in all, in a third in one alone (something of that recording, not of the joint), in a third in
none. Each set is a line of FILE; lines that are there are not made again. A set takes minutes.
"""

from __future__ import annotations

import argparse
import json
import os
import time
from pathlib import Path
from typing import Any

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np  # noqa: E402

from flex_ident.gap import GapOptions, explain  # noqa: E402
from flex_ident.jobs.explaining_set import SecondStage  # noqa: E402
from flex_ident.virtual_joint import COBOT_JOINT, Experiment, MeasurementChain  # noqa: E402
from flex_ident.virtual_joint.run import virtual_recording  # noqa: E402

EFFECTS: dict[str, dict[str, float]] = {
    "backlash": {"gap": 5e-4},
    "viscous_nonlinearity": {"coefficient": 4.0},
    "torque_ripple": {"amplitude": 2.0, "cycles_per_turn": 60.0, "phase": 0.5},
    "joint_damping": {"damping": 3.0},
    "nonlinear_stiffness": {"cubic": 2e8},
}
SIZED = ("gap", "coefficient", "amplitude", "damping", "cubic")
WHERE = ("all", "one", "none")
SCATTER = 0.03


def set_line(seed: int, index: int) -> dict[str, Any]:
    """One set of three recordings: what was hidden where, and what came out."""
    rng = np.random.default_rng((seed, index))
    effect, where = list(EFFECTS)[index % len(EFFECTS)], WHERE[index % len(WHERE)]
    odd = int(rng.integers(3))
    recordings = []
    for i in range(3):
        model = COBOT_JOINT
        if where == "all" or (where == "one" and i == odd):
            factor = 1.0 + SCATTER * rng.normal()
            own = {k: v * factor if k in SIZED else v for k, v in EFFECTS[effect].items()}
            model = COBOT_JOINT.with_effect(effect, own)
        experiment = Experiment(
            duration_s=20.0, sample_rate_hz=500.0, amplitude=float(rng.uniform(0.08, 0.14)),
            end_frequency_hz=float(rng.uniform(22.0, 32.0)), start=float(rng.uniform(-0.3, 0.3)),
        )  # fmt: skip
        chain = MeasurementChain(torque_noise=float(rng.uniform(0.005, 0.02)), jitter=0.02)
        recordings.append(virtual_recording(model, experiment, chain, seed=int(rng.integers(1 << 30))))
    options = GapOptions(sensors="motor+link")
    began = time.perf_counter()
    explanations = [explain(own, options) for own in recordings]
    first = time.perf_counter() - began
    stage = SecondStage(["a", "b", "c"], recordings, explanations, options, lambda _text, _share: None)
    effects, gaps, finals = stage.found()
    return {
        "index": index, "effect": effect, "where": where, "odd": "abc"[odd] if where == "one" else "",
        "own": [[f.effect for f in own.findings] for own in explanations],
        "accepted": [own.proposal.effect for own in effects if own.outcome == "accepted"],
        "refused": {own.proposal.effect: own.outcome for own in effects if own.outcome != "accepted"},
        "said": {own.proposal.effect: [h.said for h in own.heard] for own in effects},
        "gaps": [[g.before, g.after, g.floor] for g in gaps],
        "left": [bool(own.unexplained) for own in finals],
        "seconds": [first, time.perf_counter() - began - first],
    }  # fmt: skip


def main() -> None:
    """Parse, run what is missing, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sets", type=int, default=4)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("gap_sets.jsonl"))
    given = parser.parse_args()
    lines = [json.loads(text) for text in given.out.read_text().splitlines()] if given.out.exists() else []
    with given.out.open("a") as file:
        for index in range(len(lines), given.sets):
            line = set_line(given.seed, index)
            lines.append(line)
            file.write(json.dumps(line) + "\n")
            file.flush()
            print(json.dumps(line), flush=True)
    for where in WHERE:
        own = [line for line in lines if line["where"] == where]
        right = sum(line["accepted"] == ([line["effect"]] if where == "all" else []) for line in own)
        print(f"effect in {where}: right in {right} of {len(own)} sets")


if __name__ == "__main__":
    main()
