"""Two results of one joint are said to differ as often as chance says, and where one parameter moved."""

import numpy as np
from drawn import KEYS, members

from flex_ident.pooling.agreement import Agreement, agreement


def compared(rng: np.random.Generator, scatter: np.ndarray | None = None) -> Agreement:
    one, other = members(rng, 2, scatter=scatter)
    difference = np.array([other.value(k) - one.value(k) for k in KEYS])
    return agreement(KEYS, difference, one.covariance.of(KEYS) + other.covariance.of(KEYS))


def test_the_chance_is_one() -> None:
    rng = np.random.default_rng(31)
    chances = np.array([compared(rng).chance for _ in range(1000)])
    for level in (0.01, 0.1, 0.5):
        assert abs(np.mean(chances < level) - level) < 3.0 * np.sqrt(level * (1.0 - level) / 1000)


def test_a_stiffness_that_fell_is_found_and_named() -> None:
    rng = np.random.default_rng(32)
    fell = np.zeros((2, len(KEYS)))
    fell[1, KEYS.index("K")] = -0.05
    found = [compared(rng, fell) for _ in range(50)]
    assert sum(not f.agree for f in found) >= 49
    assert sum(f.farthest == "K" for f in found) >= 40


def test_directions_known_impossibly_well_do_not_count() -> None:
    covariance = np.array([[1.0, 1.0 - 1e-12], [1.0 - 1e-12, 1.0]])
    found = agreement(("a", "b"), np.array([0.5, 0.6]), covariance)
    assert found.freedom == 1
    assert found.agree
