"""Any table, by what is in it and not by its name."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from flex_ident.errors import SignalError, UsageError
from flex_ident.formats import hdf5_files, matlab_files, numpy_files, parquet_files
from flex_ident.formats.csv_files import CsvFile
from flex_ident.formats.lerobot_datasets import is_lerobot, lerobot_episode
from flex_ident.formats.tables import SideBySide, Table
from flex_ident.parameters.documents import opened_file
from flex_ident.recording.names import path_text

BAGS = (b"\x89MCAP0\r\n", b"SQLite format 3\x00", b"#ROSBAG V2.0\n")
HEAD = hdf5_files.USER_BLOCK + len(hdf5_files.MAGIC)


def opened_table(path: Path, episode: int | None = None) -> Table:
    """The table at `path`. Raises SignalError, MissingExtraError, and UsageError for a bag or a wrong episode."""
    shown = path_text(path)
    if not path.exists():
        raise SignalError(f"{shown}: no such file or folder.")
    if path.is_dir():
        if is_lerobot(path):
            return lerobot_episode(path, episode)
        if (path / "metadata.yaml").exists():
            raise UsageError(f"{shown}: is a bag already: identify_bag reads it as it is.")
        raise SignalError(f"{shown}: is a folder, and no LeRobot dataset (it has no meta/info.json).")
    if episode is not None:
        raise UsageError(f"--episode is of LeRobot datasets: {shown} is one file.")
    head = _head(path, shown)
    if head.startswith(BAGS):
        raise UsageError(f"{shown}: is a bag already: identify_bag reads it as it is.")
    if hdf5_files.MAGIC in (head[: len(hdf5_files.MAGIC)], head[hdf5_files.USER_BLOCK :]):
        return hdf5_files.Hdf5File(path)
    if head.startswith(matlab_files.MAGIC):
        return matlab_files.MatlabFile(path)
    if head.startswith(parquet_files.MAGIC):
        return parquet_files.ParquetFiles([path], shown)
    if head.startswith(numpy_files.MAGICS):
        return numpy_files.NumpyFile(path)
    if b"\0" in head:
        raise SignalError(f"{shown}: is no table that is known: expected CSV, MATLAB, HDF5, NumPy, Parquet or LeRobot.")
    return CsvFile(path)


def opened_tables(paths: Sequence[Path], episode: int | None = None) -> Table:
    """One table, or several side by side. Raises likewise."""
    if len(paths) == 1:
        return opened_table(paths[0], episode)
    return SideBySide({path.stem: opened_table(path, episode) for path in paths}, len(paths))


def _head(path: Path, shown: str) -> bytes:
    try:
        with opened_file(path) as file:
            return file.read(HEAD)
    except OSError as error:
        raise SignalError(f"{shown}: cannot be read ({error.strerror}).") from error
