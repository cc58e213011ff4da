"""What is said of a topic that stops, thins out or loses messages, without ROS."""

import numpy as np
import pytest

from flex_ident.excitation.pace import Losses, Pace, Stillness


def said(pace: Pace, arrivals: np.ndarray, until: float) -> list[str]:
    """What is said when a topic is looked at ten times a second."""
    texts, k = [], 0
    for now in np.arange(0.0, until, 0.1):
        while k < len(arrivals) and arrivals[k] <= now:
            pace.arrived(arrivals[k])
            k += 1
        texts.append(pace.look(now))
    return [text for text in texts if text]


def test_a_steady_topic_is_not_mentioned() -> None:
    pace = Pace("/a", 0.0)
    assert said(pace, np.arange(0.5, 10.0, 0.002), 10.0) == []
    assert "at 500.0 Hz, longest gap 0.0" in pace.summary()


def test_a_topic_that_stops_and_comes_again_is_said_once_each() -> None:
    arrivals = np.concatenate([np.arange(0.0, 3.0, 0.01), np.arange(6.0, 9.0, 0.01)])
    pace = Pace("/a", 0.0)
    texts = said(pace, arrivals, 9.0)
    assert texts[:2] == ["/a has stopped", "/a comes again"]
    assert pace.longest_gap_s == pytest.approx(3.0, abs=0.05)


def test_a_topic_that_thins_out_is_said() -> None:
    arrivals = np.concatenate([np.arange(0.0, 3.0, 0.002), np.arange(3.0, 8.0, 0.1)])
    texts = said(Pace("/a", 0.0), arrivals, 8.0)
    assert len(texts) == 1
    assert texts[0].startswith("/a has thinned out from 50")
    assert texts[0].endswith(("to 9 Hz", "to 10 Hz"))


def test_a_topic_that_was_published_once_has_not_stopped() -> None:
    assert said(Pace("/a", 0.0), np.array([0.5]), 10.0) == []


def test_losses_are_counted_by_the_publishers_own_numbers() -> None:
    losses = Losses()
    for number in (7, 8, 9, 12, 13, 20):
        losses.count(number, 1)
    assert losses.lost == 2 + 6
    for number in (1, 2, 3):  # the publisher has been started anew
        losses.count(number, 1)
    assert losses.lost == 8


def test_two_publishers_are_told_apart() -> None:
    losses = Losses()
    for k in range(100):
        losses.count(1000 + k, 2)
        if k != 50:
            losses.count(5 + k, 2)
    assert losses.lost == 1


def frozen(contents: list[object]) -> list[str]:
    """What is said of a topic that says this, looked at ten times a second."""
    stillness = Stillness("/a")
    said = (stillness.look(0.1 * k, content) for k, content in enumerate(contents))
    return [text for text in said if text]


def test_a_topic_that_freezes_and_changes_again_is_said_once_each() -> None:
    said = frozen([*range(30), *[30] * 30, *range(31, 60)])
    assert said == ["/a has frozen: the same for 1.1 s, though messages come", "/a changes again"]


def test_what_changes_now_and_then_has_not_frozen() -> None:
    assert frozen([k // 5 for k in range(40)] + [8] * 40) == []
    assert frozen([k // 3 for k in range(300)]) == []
