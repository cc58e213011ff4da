"""Recordings of one day count once: which are of one, what their intervals cover, and who then disagrees."""

import numpy as np
import pytest
from drawn import KEYS, TRUTH, members

from flex_ident.notices import Code
from flex_ident.pooling.combining import pooled_all
from flex_ident.pooling.members import side_by_side
from flex_ident.pooling.sessions import session_means, sessions_of
from flex_ident.pooling.several import several
from flex_ident.pooling.thresholds import SESSION_S

HOUR, DATE = 3600.0, 1.7e9


def test_recordings_of_a_working_day_are_one_session_and_those_without_a_date_are_alone() -> None:
    hours = [0.0, 3.0, 11.9, 12.1, 24.0, 240.0, 241.0]
    assert sessions_of([DATE + HOUR * own for own in hours]) == (0, 0, 0, 1, 1, 2, 2)
    assert sessions_of([DATE + HOUR * own for own in reversed(hours)]) == (2, 2, 1, 1, 0, 0, 0)
    assert sessions_of([0.0, 12.5, DATE, 0.0, DATE + 60.0]) == (0, 2, 3, 1, 3)
    assert SESSION_S == 12 * HOUR


def test_the_mean_of_a_session_is_as_sure_as_what_scatters_within_sessions_allows() -> None:
    rng = np.random.default_rng(1)
    pulls = []
    for _ in range(300):
        sessions = np.repeat(np.arange(6), 3)
        values = rng.normal(0.0, 0.2, 18) + rng.normal(0.0, 0.1, 18)
        means, stds, weights = session_means(values, np.full(18, 0.1), sessions)
        assert np.bincount(sessions, weights) == pytest.approx(np.ones(6))
        pulls.append(means / stds)
    assert np.std(pulls) == pytest.approx(1.0, abs=0.12)


def covered(sessions: int, each: int, day: float, within: float, sets: int = 100) -> tuple[float, float, float]:
    """Least and most coverage of a parameter, percent, and how often somebody is said to disagree."""
    inside, apart = np.zeros(len(KEYS)), 0
    for seed in range(sets):
        rng = np.random.default_rng(seed)
        n = sessions * each
        scatter = np.repeat(day * rng.normal(size=(sessions, len(KEYS))), each, 0)
        scatter += within * rng.normal(size=(n, len(KEYS)))
        days = [10.0 * (i // each) + 0.02 * (i % each) for i in range(n)]
        found = several(members(rng, n, scatter=scatter, days=days))
        inside += [abs(own.value - true) <= own.half for own, true in zip(found.pooled, TRUTH, strict=True)]
        apart += bool(found.disagreements)
    return 100.0 * inside.min() / sets, 100.0 * inside.max() / sets, 100.0 * apart / sets


@pytest.mark.slow
@pytest.mark.parametrize(("sessions", "each"), [(2, 3), (3, 3), (5, 2)])
@pytest.mark.parametrize("day", [0.0, 0.03])
def test_intervals_over_days_cover(sessions: int, each: int, day: float) -> None:
    least, most, apart = covered(sessions, each, day, 0.003)
    assert least >= 84.0  # of eight parameters: 90 within two standard errors of 100 sets
    assert most <= 99.4 or day == 0.0
    assert apart <= 10.0


def test_few_days_are_said() -> None:
    rng = np.random.default_rng(4)
    one, two = ([0.0, 0.1, 0.2, 0.3], [0.0, 0.1, 5.0, 5.1])
    for days, sessions in ((one, 1.0), (two, 2.0)):
        [said] = [n for n in several(members(rng, 4, days=days)).notices if n.code is Code.FEW_SESSIONS]
        assert said.numbers == {"count": sessions, "recordings": 4.0}
    codes = [n.code for n in several(members(rng, 4, days=[0.0, 5.0, 10.0, 15.0])).notices]
    assert Code.FEW_SESSIONS not in codes


def test_without_dates_and_one_recording_a_day_nothing_is_different() -> None:
    rng = np.random.default_rng(5)
    scatter = 0.03 * rng.normal(size=(6, len(KEYS)))
    plain, dated = (
        pooled_all(side_by_side(members(np.random.default_rng(6), 6, scatter=scatter, days=days)))
        for days in (None, [5.0 * i for i in range(6)])
    )
    assert [own.half for own in plain] == [own.half for own in dated]
