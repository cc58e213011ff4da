"""NumPy files that announce or unpack to more than they hold are refused before memory is asked for."""

import io
import tracemalloc
import zipfile
from pathlib import Path

import numpy as np
import pytest

from flex_ident.errors import SignalError
from flex_ident.formats.numpy_files import NumpyFile


def array_file(announced: int, held: int) -> bytes:
    """A `.npy` whose header announces so many numbers, and that holds `held` zero bytes."""
    head = io.BytesIO()
    np.lib.format.write_array_header_1_0(head, {"descr": "<f8", "fortran_order": False, "shape": (announced,)})
    return head.getvalue() + bytes(held)


def refused(path: Path, match: str) -> None:
    tracemalloc.start()
    try:
        with pytest.raises(SignalError, match=match):
            NumpyFile(path)
        assert tracemalloc.get_traced_memory()[1] < 8 << 20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("announced", [20, 1 << 24, 1 << 40, 1 << 62])
def test_a_header_that_announces_more_than_there_is_says_so(announced: int, tmp_path: Path) -> None:
    content = array_file(announced, 100)
    (tmp_path / "a.npy").write_bytes(content)
    refused(tmp_path / "a.npy", r"a\.npy: announces .* bytes of numbers and holds 100: it is cut")
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("t.npy", content)
    refused(tmp_path / "a.npz", r"a\.npz: t: announces .* bytes of numbers and holds 100: it is cut")


def test_zeros_that_unpack_without_end_are_refused(tmp_path: Path) -> None:
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("t.npy", array_file(6 << 20, 48 << 20))
    refused(tmp_path / "a.npz", r"bytes unpack to 5\.03e\+07, over 200 times as many")


def test_a_long_recording_that_packs_well_is_read(tmp_path: Path) -> None:
    rows = 200_000
    np.savez_compressed(tmp_path / "a.npz", time=0.002 * np.arange(rows), q=np.zeros(rows), tau=np.ones(rows))
    assert NumpyFile(tmp_path / "a.npz").read(["q"])["q"].size == rows
