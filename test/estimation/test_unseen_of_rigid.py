"""Rigid joints whose gear yields or loses a share of the load, in slow moves that do not show it."""

from __future__ import annotations

import numpy as np
import pytest

from flex_ident.estimation.identification import identify
from flex_ident.estimation.options import IdentifyOptions
from flex_ident.parameters import Identification
from flex_ident.recording import Floats, Recording

RATE_HZ, SECONDS = 200.0, 20.0
TRUTH = {"J": 2.2, "FV": 14.0, "FS": 7.5, "MX": 1.0, "MY": 4.0}
TIME = np.arange(0.0, SECONDS, 1.0 / RATE_HZ)


def moves(seed: int) -> Floats:
    """Point to point and back, rad: minimum jerk in a second each, a rest between."""
    random, goals = np.random.default_rng(seed), [0.0]
    while len(goals) < SECONDS / 1.25 + 2:
        goals.append(float(np.clip(goals[-1] + random.choice([-1.0, 1.0]) * random.uniform(0.3, 0.9), -1.0, 1.0)))
    at, s = np.floor(TIME / 1.25).astype(int), np.clip((TIME % 1.25) / 1.0, 0.0, 1.0)
    start, goal = np.array(goals)[at], np.array(goals)[at + 1]
    return np.asarray(start + (goal - start) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2))


def identified(seed: int, *, lost: float = 0.0, compliance: float = 0.0) -> Identification:
    """A joint in such moves behind a gear that loses a share, and yields by rad / (N m); at rest friction holds it."""
    q = moves(seed)
    v = np.gradient(q, 1.0 / RATE_HZ)
    link = q
    for _ in range(3):  # where the link is, to third order in the compliance
        a = np.gradient(np.gradient(link, 1.0 / RATE_HZ), 1.0 / RATE_HZ)
        load = TRUTH["J"] * a + 9.81 * (TRUTH["MX"] * np.cos(link) + TRUTH["MY"] * np.sin(link))
        link = q - compliance * load
    friction = TRUTH["FV"] * v + (TRUTH["FS"] + lost * np.abs(load)) * np.sign(v) * (np.abs(v) > 1e-9)
    random = np.random.default_rng(seed + 1000)
    read = q + 2e-6 * random.standard_normal(q.size)
    torque = load + friction + 0.3 * random.standard_normal(q.size)
    return identify(Recording("joint", RATE_HZ, read, torque), IdentifyOptions(rigid=True))


def worst(result: Identification) -> float:
    return max(
        abs(result.parameter(k).value - v) / result.parameter(k).std for k, v in TRUTH.items()
        if result.parameter(k).identifiable
    )  # fmt: skip


@pytest.mark.parametrize(
    ("seed", "gear"),
    [
        (1, {}), (2, {}), (3, {}), (3, {"lost": 0.015}), (5, {"lost": 0.015}), (1, {"compliance": 1.0 / 5000.0}),
        (5, {"compliance": 1.0 / 5000.0}),
    ],
)  # fmt: skip
def test_what_a_gear_does_unseen_is_in_the_intervals(seed: int, gear: dict[str, float]) -> None:
    """Trusted before, and up to twelve standard deviations off where there was a gear."""
    result = identified(seed, **gear)
    assert result.verdict in ("trusted", "doubtful")
    assert worst(result) < 3.0, [(p.key, p.value, p.std) for p in result.parameters]
    if not gear:
        assert result.verdict == "trusted"
        for key, percent in (("J", 3.0), ("FS", 3.0), ("MY", 2.0)):
            assert result.parameter(key).relative_std_percent < percent
