"""`~` in the paths that users give."""

from pathlib import Path

import pytest

from flex_ident.recording.names import at_home


def test_a_path_at_home_is_found_and_one_of_nobody_stays_as_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/home/her")
    assert at_home("~/robot.urdf") == Path("/home/her/robot.urdf")
    assert at_home("~nobody_of_that_name/robot.urdf") == Path("~nobody_of_that_name/robot.urdf")
    assert at_home(Path("bags/elbow")) == Path("bags/elbow")
