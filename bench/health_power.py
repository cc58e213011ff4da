"""What `flex_ident health` finds of changes that are there, and how often it names one that is not, on made-up rows.

    python bench/health_power.py --fleets 20

Each fleet is 200 joints of which ten have changed: stiffness by -5 %, backlash by +0.2 mrad, all friction by +15 %, one
kind a fleet; or none has. The rows are drawn, not identified: each result states what `identify_bag` does for a good
recording (K, JL and Jm to 0.15 %, K and JL together, friction to 1 %, backlash to 0.02 mrad) and lies off by that.
Between recordings of one joint each parameter scatters beyond it by `own` (friction by three times as much), and all
that carries force by one factor with `scale`: what temperature does to a torque constant. What real robots scatter by
is not known here.
"""

from __future__ import annotations

import argparse
import json
from datetime import UTC, datetime
from typing import Any

import numpy as np

from flex_ident.fleet.health import fleet_health
from flex_ident.fleet.rows import Row, common_row, result_row

TRUTH = {
    "Jm": 1.0, "K": 1e4, "JL": 2.0, "FVm": 8.0, "FSm": 4.0, "FV": 2.0, "FS": 1.0, "MX": 0.5, "MY": 3.0,
    "backlash.gap": 5e-4,
}  # fmt: skip
FRICTION = ("FVm", "FSm", "FV", "FS")
STATED = {"Jm": 1.5e-3, "K": 1.5e-3, "JL": 1.5e-3, **dict.fromkeys(FRICTION, 0.01), "MX": 0.01, "MY": 0.005}
GAP_STD = 2e-5
TOGETHER = 0.95
"""Correlation of the errors of K and JL: their ratio is the locked-motor frequency."""
CHANGES: dict[str, dict[str, float]] = {
    "K -5 %": {"K": 0.95}, "backlash +0.2 mrad": {"backlash.gap": 1.4},
    "friction +15 %": dict.fromkeys(FRICTION, 1.15), "nothing": {},
}  # fmt: skip
CAUSES = {
    "K -5 %": ("transmission", "gear_wear"), "backlash +0.2 mrad": ("gear_wear",), "friction +15 %": ("lubrication",)
}  # fmt: skip
JOINTS, CHANGED = 200, 10
START, DAY = datetime(2026, 1, 1, tzinfo=UTC).timestamp(), 86400.0


def rows_of(
    rng: np.random.Generator, factors: dict[str, float], before: int, after: int, own: float, scale: float
) -> list[Row]:
    """A fleet: `before` and `after` results of each joint, the first ten of which changed in between."""
    keys = list(TRUTH)
    std = np.array([GAP_STD if key == "backlash.gap" else STATED[key] * TRUTH[key] for key in keys])
    covariance = np.diag(std**2)
    k, j = keys.index("K"), keys.index("JL")
    covariance[k, j] = covariance[j, k] = TOGETHER * std[k] * std[j]
    root = np.linalg.cholesky(covariance)
    stored = {"keys": keys, "matrix": covariance.tolist(), "systematic": [0.0] * len(keys)}
    rows = []
    for joint in range(JOINTS):
        true = {key: value * float(np.exp(0.3 * rng.normal())) for key, value in TRUTH.items()}
        for i in range(before + after):
            common = 1.0 + scale * rng.normal()
            values = root @ rng.normal(size=len(keys))
            for n, key in enumerate(keys):
                size = true[key] if i < before or joint >= CHANGED else true[key] * factors.get(key, 1.0)
                if key == "backlash.gap":
                    size = true[key] + (2e-4 if key in factors and joint < CHANGED and i >= before else 0.0)
                    common_here = 1.0
                else:
                    common_here = common
                spread = own * (3.0 if key in FRICTION else 1.0)
                values[n] = size * common_here * (1.0 + spread * rng.normal()) + values[n] * true[key] / TRUTH[key]
            parameters = {
                key: {"value": float(values[n]), "std": float(std[n] * true[key] / TRUTH[key]), "unit": "SI",
                      "identifiable": True}
                for n, key in enumerate(keys)
            }  # fmt: skip
            ratio = np.array([true[key] / TRUTH[key] for key in keys])
            matrix = (covariance * np.outer(ratio, ratio)).tolist()
            content = {
                "joint": "joint", "sensors": "motor+link", "method": "auto", "verdict": "trusted",
                "parameters": parameters, "warnings": [], "covariance": {**stored, "matrix": matrix},
            }  # fmt: skip
            shared = common_row(
                robot=f"arm {joint}", bag=f"{joint}.{i}", sha256=f"{joint}.{i}", tag="", conditions={}, settings={}
            )  # fmt: skip
            rows.append(result_row(shared, content, start_time_s=START + 30 * DAY * i, seconds=1.0))
    return rows


def judged(content: dict[str, Any], kind: str, pairs: bool) -> tuple[int, int, int]:
    """Changed joints that are found, those of them with the right cause, and unchanged joints that are named."""
    named = {own["robot"] for own in content["to_confirm" if pairs else "changes"]}
    truly = {f"arm {joint}" for joint in range(CHANGED)} if CHANGES[kind] else set()
    found = named & truly
    causes = {own["robot"]: own["cause"] for own in content["joints"] if own.get("cause")}
    right = sum(causes.get(robot) in CAUSES.get(kind, ()) for robot in found)
    return len(found), right, len(named - truly)


def main() -> None:
    """Print a line for each number of results, scatter and change."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fleets", type=int, default=5)
    given = parser.parse_args()
    for before, after in ((1, 1), (1, 2), (3, 2), (3, 5)):
        for own, scale in ((0.0, 0.0), (0.003, 0.02), (0.01, 0.0), (0.02, 0.0)):
            line = []
            for kind, factors in CHANGES.items():
                total = np.zeros(3, dtype=int)
                alarmed = 0
                smallest: dict[str, Any] = {}
                for fleet in range(given.fleets):
                    rng = np.random.default_rng((before, after, int(1e4 * own), int(1e4 * scale), fleet))
                    rows = rows_of(rng, factors, before, after, own, scale)
                    content = json.loads(json.dumps(fleet_health(rows)))
                    counts = judged(content, kind, pairs=before + after == 2)
                    total += counts
                    alarmed += counts[2] > 0
                    smallest = content["smallest"]
                joints = given.fleets * CHANGED
                unchanged = given.fleets * (JOINTS - (CHANGED if factors else 0))
                part = f"{kind}: " + (f"{100 * total[0] / joints:.0f} % found, cause right {total[1]}/{total[0]}, "
                                      if factors else "")  # fmt: skip
                line.append(
                    f"{part}false {100 * total[2] / unchanged:.2f} % of joints, in {alarmed} of {given.fleets} fleets"
                )
            best = min((smallest[key]["median_percent"] for key in ("K", "K/JL") if key in smallest), default=np.nan)
            print(f"{before} + {after} results, scatter own {100 * own:g} %, scale {100 * scale:g} %; smallest change "
                  f"of K or K/JL that could be shown {best:.2g} %; " + "; ".join(line), flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
