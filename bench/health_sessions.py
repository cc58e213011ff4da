"""Health of fleets whose recordings share what a day does: false alarms, and what is found, session by session.

    python bench/health_sessions.py --fleets 20

The rows are drawn, as those of `health_power.py`. Three recordings a session, half an hour apart, sessions a month
apart; each parameter of a joint deviates by `day` from session to session (friction by three times as much) and by a
quarter of that within one; all that carries force by `scale` from session to session by one factor. What a day does is
each joint's own, or shared by a robot's joints, or by the whole fleet. In fleets where something changed it is one
joint: stiffness by -5 %, or all friction by +15 %.
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np
from health_power import DAY, FRICTION, START, STATED, TRUTH

from flex_ident.errors import DataError
from flex_ident.fleet.health import fleet_health
from flex_ident.fleet.rows import Row, common_row, result_row

KEYS = tuple(key for key in TRUTH if key in STATED)
OWN = np.array([3.0 if key in FRICTION else 1.0 for key in KEYS])
CHANGES = {"nothing": {}, "K -5 %": {"K": 0.95}, "friction +15 %": dict.fromkeys(FRICTION, 1.15)}


def rows_of(
    rng: np.random.Generator, factors: dict[str, float], *, robots: int, joints: int, before: int, after: int,
    each: int = 3, day: float = 0.01, scale: float = 0.0, shared: str = "joint",
) -> list[Row]:  # fmt: skip
    """A fleet; joint 0 of robot 0 changed by `factors` behind session `before`."""
    days: dict[tuple[int, ...], Any] = {}
    rows = []
    for robot, joint in np.ndindex(robots, joints):
        true = np.array([TRUTH[key] for key in KEYS]) * np.exp(0.3 * rng.normal(size=len(KEYS)))
        std = np.array([STATED[key] for key in KEYS]) * true
        group = {"joint": (robot, joint), "robot": (robot,), "fleet": ()}[shared]
        if group not in days:
            n = before + after
            days[group] = day * OWN * rng.normal(size=(n, len(KEYS))) + scale * rng.normal(size=(n, 1))
        for session, i in np.ndindex(before + after, each):
            own = np.array([factors.get(key, 1.0) for key in KEYS])
            step = own if session >= before and robot == joint == 0 else 1.0
            noise = 0.25 * day * OWN * rng.normal(size=len(KEYS))
            values = true * step * (1.0 + days[group][session] + noise) + std * rng.normal(size=len(KEYS))
            parameters = {
                key: {"value": float(v), "std": float(s), "unit": "SI", "identifiable": True}
                for key, v, s in zip(KEYS, values, std, strict=True)
            }
            content = {
                "joint": f"joint {joint}", "sensors": "motor+link", "method": "auto", "verdict": "trusted",
                "parameters": parameters, "warnings": [],
                "covariance": {"keys": list(KEYS), "matrix": np.diag(std**2).tolist()},
            }  # fmt: skip
            sha256 = f"{robot}.{joint}.{session}.{i}"
            common = common_row(
                robot=f"arm {robot}", bag=sha256, sha256=sha256, tag="", conditions={}, settings={}
            )  # fmt: skip
            at = START + 30.0 * DAY * session + 1800.0 * i
            rows.append(result_row(common, content, start_time_s=at, seconds=1.0))
    return rows


def counted(kind: str, fleets: int, seed: int = 0, **fleet: Any) -> dict[str, int]:
    """Over so many fleets: in how many the change is found or listed to confirm, another is named, none can be told."""
    total = dict.fromkeys(("found", "to confirm", "false", "cannot tell"), 0)
    for i in range(fleets):
        rows = rows_of(np.random.default_rng((seed, i)), CHANGES[kind], **fleet)
        try:
            content = fleet_health(rows)
        except DataError:
            total["cannot tell"] += 1
            continue
        named, waiting = ({(own["robot"], own["joint"]) for own in content[part]} for part in ("changes", "to_confirm"))
        truly = {("arm 0", "joint 0")} if CHANGES[kind] else set()
        total["found"] += bool(named & truly)
        total["to confirm"] += bool(waiting & truly) and not named & truly
        total["false"] += bool(named - truly)
    return total


def main() -> None:
    """Print a line for each kind of fleet."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fleets", type=int, default=20)
    given = parser.parse_args()
    for robots, joints in ((1, 6), (6, 6)):
        for before, after in ((1, 1), (1, 2), (2, 2), (3, 3), (3, 6)):
            for shared in ("joint", "robot", "fleet"):
                for day, scale in ((0.0, 0.0), (0.003, 0.02), (0.01, 0.0)):
                    if shared != "joint" and day == 0.0:
                        continue
                    fleet = {"robots": robots, "joints": joints, "before": before, "after": after, "day": day,
                             "scale": scale, "shared": shared}  # fmt: skip
                    kinds = CHANGES if shared == "joint" else ["nothing"]
                    said = [
                        f"{kind}: "
                        + ", ".join(f"{k} {n}" for k, n in counted(kind, given.fleets, **fleet).items() if n)
                        for kind in kinds
                    ]
                    print(f"{robots} x {joints} joints, {before} + {after} sessions of 3, day {100 * day:g} %, scale "
                          f"{100 * scale:g} %, of the {shared}; of {given.fleets}: {'; '.join(said)}",
                          flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
