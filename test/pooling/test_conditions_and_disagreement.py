"""A condition is named where it is at work and hardly ever elsewhere; one that disagrees is found, chance is not."""

import numpy as np
import pytest
from drawn import KEYS, members

from flex_ident.pooling.combining import pooled_all
from flex_ident.pooling.conditions import Cause, causes
from flex_ident.pooling.disagreement import disagreements
from flex_ident.pooling.members import side_by_side

CONDITIONS = ("amplitude", "mean position", "speed", "duration", "payload", "temperature", "gain", "date")
FOLLOWING = np.array([0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0])
"""Which of the parameters scatter, by 3 %."""


def drawn_set(rng: np.random.Generator, driver: str | None, count: int = 10) -> tuple[tuple[Cause, ...], bool]:
    """The causes found, and whether a recording is said to disagree."""
    table = rng.normal(size=(count, len(CONDITIONS)))
    table[:, CONDITIONS.index("payload")] = rng.permutation(np.arange(count) % 2)
    if driver is None:
        scatter = rng.normal(0.0, 0.03, (count, 8)) * FOLLOWING
    else:
        column = table[:, CONDITIONS.index(driver)]
        scatter = 0.03 * ((column - column.mean()) / column.std())[:, None] * FOLLOWING
    conditions = [dict(zip(CONDITIONS, map(float, row), strict=True)) for row in table]
    given = side_by_side(members(rng, count, scatter=scatter))
    found = causes(given, pooled_all(given), conditions)
    return found, bool(disagreements(given, {c.key for c in found}))


@pytest.mark.parametrize("driver", ["amplitude", "payload", "temperature", "gain"])
def test_the_condition_that_drives_the_scatter_is_named(driver: str) -> None:
    rng = np.random.default_rng(11)
    right = 0
    for _ in range(20):
        found, _ = drawn_set(rng, driver)
        right += {c.condition for c in found} == {driver} and {"K"} <= {c.key for c in found}
    assert right >= 18


@pytest.mark.slow
def test_no_condition_is_named_and_nobody_disagrees_where_nothing_is_at_work() -> None:
    rng = np.random.default_rng(12)
    runs = [drawn_set(rng, None) for _ in range(100)]
    assert sum(bool(found) for found, _ in runs) <= 9  # 5 expected
    assert sum(apart for _, apart in runs) <= 5


def test_a_slope_and_a_text_and_what_cannot_be_told_apart() -> None:
    rng = np.random.default_rng(13)
    warm = np.linspace(20.0, 40.0, 8)
    scatter = np.outer(0.002 * (warm - 30.0), np.eye(len(KEYS))[KEYS.index("K")])
    conditions = [
        {"temperature": t, "hour": t / 2.0 + 0.1 * rng.normal(), "drive": "b" if t > 30.0 else "a"} for t in warm
    ]
    given = side_by_side(members(rng, 8, scatter=scatter))
    [found] = causes(given, pooled_all(given), conditions)  # type: ignore[arg-type]
    assert found.key == "K"
    assert found.condition in ("temperature", "hour")
    assert set(found.alike) | {found.condition} == {"temperature", "hour"}
    assert found.slope == pytest.approx(20.0 if found.condition == "temperature" else 40.0, rel=0.15)
    kinds = [{"drive": "old" if i % 2 else "new"} for i in range(8)]
    scatter = np.outer([0.0, 0.05] * 4, np.eye(len(KEYS))[KEYS.index("K")])
    given = side_by_side(members(rng, 8, scatter=scatter))
    [found] = causes(given, pooled_all(given), kinds)
    assert (found.condition, found.key) == ("drive", "K")


def test_few_recordings_name_no_condition() -> None:
    rng = np.random.default_rng(14)
    found, _ = drawn_set(rng, "amplitude", count=4)
    assert found == ()


def test_a_recording_that_disagrees_is_named_first() -> None:
    rng = np.random.default_rng(15)
    hits = 0
    for _ in range(50):
        scatter = rng.normal(0.0, 0.01, (8, 8)) * FOLLOWING
        scatter[3, KEYS.index("K")] += 0.2
        found = disagreements(side_by_side(members(rng, 8, scatter=scatter)))
        hits += bool(found) and (found[0].index, found[0].key) == (3, "K")
    assert hits >= 45
