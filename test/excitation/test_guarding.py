"""When a guard takes over, without processes."""

import pytest

from flex_ident.excitation.guarding import INSIST_S, REPEAT_S, Beat, Guarding

BEAT = Beat(100.0, True, 0.1, (0.0, 1.5), ("shoulder", "elbow"))


def test_a_beat_goes_over_the_pipe_as_it_is() -> None:
    assert Beat.read(BEAT.line()) == BEAT
    assert BEAT.line().endswith(b"\n")
    with pytest.raises(ValueError, match="Expecting"):
        Beat.read(b"[1.0, tr")


def test_while_beats_come_in_time_nothing_is_due() -> None:
    rules = Guarding()
    assert rules.due(99.0) is None
    rules.beat(BEAT)
    assert rules.due(100.09) is None
    assert rules.wait_s(100.04) == pytest.approx(0.06)
    assert not rules.finished(100.09)


def test_a_beat_that_does_not_come_in_time_is_taken_over_and_repeated() -> None:
    rules = Guarding()
    rules.beat(BEAT)
    assert rules.due(100.11) == BEAT
    assert rules.taken_over
    assert rules.due(100.11 + 0.5 * REPEAT_S) is None
    assert rules.due(100.11 + 1.1 * REPEAT_S) == BEAT
    assert rules.due(100.12 + INSIST_S) is None
    assert not rules.finished(200.0), "who stands still may come back"


def test_the_end_of_the_beats_is_taken_over_at_once() -> None:
    rules = Guarding()
    rules.beat(BEAT)
    rules.gone()
    assert rules.due(100.001) == BEAT
    assert not rules.finished(100.1)
    assert rules.finished(100.01 + INSIST_S)


def test_a_beat_that_was_sent_long_ago_is_none() -> None:
    rules = Guarding()
    rules.beat(BEAT)
    assert rules.due(101.0) == BEAT


def test_who_comes_back_commands_again() -> None:
    rules = Guarding()
    rules.beat(BEAT)
    assert rules.due(100.2) == BEAT
    rules.beat(Beat(100.3, True, 0.1, (0.0, 0.0)))
    assert not rules.taken_over
    assert rules.due(100.35) is None


def test_nothing_is_due_when_nothing_moves() -> None:
    rules = Guarding()
    rules.beat(Beat(100.0, False, 0.0, (0.0,)))
    assert rules.due(200.0) is None
    rules.gone()
    assert rules.due(200.0) is None
    assert rules.finished(200.0)
