"""Compiled functions and their cache."""

import pytest

from flex_ident.simulation import compiled
from flex_ident.simulation.kernel import simulated_link


def test_a_cache_is_of_all_the_sources() -> None:
    """A term that is put in moves the indices in every compiled function, also in files that stay as they are."""
    if not compiled.COMPILED:
        pytest.skip("needs numba")
    index = simulated_link._cache._cache_file  # type: ignore[attr-defined]
    assert index._source_stamp[1] == compiled.sources()
