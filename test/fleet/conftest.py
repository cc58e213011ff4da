"""A fleet of three recordings, one of them broken, and what identify_bag says of the two others."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fleet_bags import broken_bag, small_bag


@pytest.fixture(scope="session")
def bags(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fleet") / "bags"
    small_bag(folder / "r1" / "monday", seed=1)
    small_bag(folder / "r2" / "monday", seed=2, inertia=2.2)
    broken_bag(folder / "r2" / "tuesday")
    return folder


@pytest.fixture(scope="session")
def expected(bags: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The content of result.json by robot, by identify_bag."""
    from flex_ident.commands.identify_bag import main

    found = {}
    for robot in ("r1", "r2"):
        out = tmp_path_factory.mktemp(robot)
        assert main([str(bags / robot / "monday"), "--rigid", "--quiet", "--no-plots", "--out", str(out)]) == 0
        found[robot] = json.loads((out / "result.json").read_text())
    return found


@pytest.fixture(scope="session")
def client() -> Iterator[Any]:
    """A Dask cluster of two local processes."""
    pytest.importorskip("distributed", reason="needs dask", exc_type=ImportError)
    pytest.importorskip("pyarrow", reason="needs pyarrow", exc_type=ImportError)
    from flex_ident.fleet.cluster import connected

    with connected(workers=2) as client:
        yield client
