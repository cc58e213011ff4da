"""Progress of the identifier's jobs: it never goes back, and how a job ends is said."""

from itertools import pairwise

import pytest

from flex_ident.likelihood.cores import WorkStoppedError, mapped, stopped_when
from flex_ident.nodes.job import IDLE, Job, JobProgress

ONE = [
    ("reading", 0.5), ("reading", 1.0), ("explaining", 0.02), ("explaining", 0.2), ("explaining", 0.8),
    ("explaining", 0.02), ("explaining", 1.0), ("writing", 0.0), ("writing", 1.0),
]  # fmt: skip
SET = [
    *((f"{stage} {name}", share) for name in ("a", "b") for stage, share in ONE[:-2]),
    ("trying the others' effects on a", 0.0), ("trying the others' effects on a", 1.0),
    ("trying the others' effects on b", 0.0), ("trying the others' effects on b", 1.0),
    ("explaining a again", 0.0), ("explaining a again", 1.0),
    ("explaining b again", 0.0), ("explaining b again", 1.0),
]  # fmt: skip


@pytest.mark.parametrize(("stages", "recordings"), [(ONE, 1), (SET, 2)], ids=["one", "set"])
def test_progress_never_goes_back_and_is_whole_at_the_end_only(
    stages: list[tuple[str, float]], recordings: int
) -> None:
    progress = JobProgress(recordings)
    shares = []
    for text, share in stages:
        progress.told(text, share)
        shares.append(progress.share)
    assert all(b >= a for a, b in pairwise(shares))
    assert shares[1] < 0.15
    assert shares[-3] < 1.0
    assert shares[-1] == pytest.approx(1.0)


def test_one_at_a_time_and_how_it_ended() -> None:
    said: list[tuple[str, int, str]] = []
    job = Job(lambda: said.append((job.name, job.percent, job.ended)))
    assert not job.stop("nobody")
    assert job.begin("identify", 1)
    assert not job.begin("explain_gap", 1)
    job.told("reading", 1.0)
    job.end("trusted")
    assert said == [("identify", 0, ""), ("identify", 10, ""), (IDLE, 100, "trusted")]
    assert job.begin("identify", 1)
    assert not job.stopping(), "what was asked before is over"
    assert job.stop("cancelled")
    job.end("stopped: cancelled.", failed=True)
    assert job.stopped
    assert not job.busy


def test_work_stops_where_it_is_asked_to_and_nothing_catches_that() -> None:
    asked = False

    def work() -> None:
        nonlocal asked
        try:
            assert mapped(abs, [-1, 2], samples=1) == [1, 2]
            asked = True
            mapped(abs, [-1], samples=1)
        except Exception as error:
            raise AssertionError from error

    with stopped_when(lambda: asked), pytest.raises(WorkStoppedError):
        work()
    assert mapped(abs, [-3], samples=1) == [3]
