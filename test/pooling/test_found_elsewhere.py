"""Whether an effect is the joint's, by what each recording says of it."""

import pytest

from flex_ident.pooling.effects import Heard, Said, dissenters, outcome_of


@pytest.mark.parametrize(
    ("found", "said", "outcome"),
    [
        ((True, True, True), ("confirms",) * 3, "accepted"),
        ((True, True, False), ("confirms", "confirms", "contradicts"), "accepted"),
        ((True, False, False), ("not_tried", "confirms", "cannot_tell"), "accepted"),
        ((True, False, False), ("not_tried", "contradicts", "confirms"), "contradicted"),
        ((True, False), ("not_tried", "cannot_tell"), "unconfirmed"),
        ((True, True), ("contradicts", "confirms"), "values_differ"),
        ((True, True), ("cannot_tell", "cannot_tell"), "unconfirmed"),
        ((True, True, False), ("cannot_tell", "cannot_tell", "cannot_tell"), "accepted"),
        ((True, True, False, False), ("cannot_tell",) * 4, "unconfirmed"),
    ],
)
def test_outcomes(found: tuple[bool, ...], said: tuple[Said, ...], outcome: str) -> None:
    heard = [Heard(own, other) for own, other in zip(found, said, strict=True)]
    assert outcome_of(heard) == outcome
    assert dissenters(heard) == [i for i, own in enumerate(said) if own == "contradicts"]


def test_what_is_of_a_recording_needs_no_other() -> None:
    assert outcome_of([Heard(True), Heard(False)], of_recording=True) == "accepted"
