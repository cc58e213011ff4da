"""Which recordings a pattern means, and whose they are."""

from pathlib import Path

import pytest

from flex_ident.errors import UsageError
from flex_ident.fleet.recordings import found_recordings


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for file in (
        "arm1/2026/run/metadata.yaml", "arm1/2026/run/run_0.mcap", "arm1/cut/cut_0.db3", "arm1/cut/cut_1.db3",
        "arm2/loose/a.mcap", "arm2/loose/b.mcap.zstd", "arm2/notes.txt", "arm[3]/old.bag",
    ):  # fmt: skip
        path = tmp_path / "bags" / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(b"")
    monkeypatch.chdir(tmp_path)
    return tmp_path / "bags"


ALL = {
    "arm1/2026/run": "arm1", "arm1/cut": "arm1", "arm2/loose/a.mcap": "arm2", "arm2/loose/b.mcap.zstd": "arm2",
    "arm[3]/old.bag": "arm[3]",
}  # fmt: skip


@pytest.mark.parametrize("pattern", ["bags/**", "bags", "bags/", "bags/**/*", "*/**"])
def test_every_bag_once(tree: Path, pattern: str) -> None:
    assert {str(f.path.relative_to(tree)) for f in found_recordings([pattern])} == set(ALL)


def test_robots_are_in_the_path(tree: Path) -> None:
    for pattern in ("bags/{robot}/**", f"{tree}/{{robot}}/**", "b*s/{robot}/**"):
        assert {str(f.path.relative_to(tree)): f.robot for f in found_recordings([pattern])} == ALL
    assert {f.robot for f in found_recordings(["bags/arm{robot}/**"])} == {"1", "2", "[3]"}
    assert {f.robot for f in found_recordings(["bags/**"])} == {""}


def test_what_a_shell_makes_of_a_pattern(tree: Path) -> None:
    given = [str(p) for p in tree.rglob("*") if p.is_file() and p.suffix != ".txt"]
    assert {str(f.path.relative_to(tree)) for f in found_recordings(given)} == set(ALL)
    assert [f.path.name for f in found_recordings(["bags/arm[3]/old.bag", "bags/arm[3]"])] == ["old.bag"]


@pytest.mark.parametrize("pattern", ["bags/arm9/**", "nothing", "bags/arm2/notes.txt"])
def test_a_pattern_without_a_recording_is_refused(tree: Path, pattern: str) -> None:
    with pytest.raises(UsageError, match="no recording there"):
        found_recordings(["bags/**", pattern])
