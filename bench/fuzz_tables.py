"""More cases of `fuzz_bags.py`: tables that `flex_ident import` reads, definitions of messages, and run files."""

from __future__ import annotations

import io
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
from fuzz_mutations import mutated, mutated_text

ROWS = 400
RUN_FILE_TEXT = "conditions:\n  amplitude_rad: 0.3\n  payload: 'none'\n  temperature_c: 31.5\ncomment: first run\n"
TYPE = "my_msgs/msg/Drive"


def _columns() -> dict[str, np.ndarray]:
    time = np.arange(ROWS) / 200.0
    return {"time": time, "elbow_position": 0.3 * np.sin(4.0 * time), "elbow_effort": 5.0 * np.cos(4.0 * time)}


def csv_table() -> bytes:
    columns = _columns()
    rows = zip(*columns.values(), strict=True)
    return "\n".join([",".join(columns), *(",".join(f"{v:.9g}" for v in row) for row in rows)]).encode()


def npz_table() -> bytes:
    file = io.BytesIO()
    np.savez_compressed(file, **_columns())
    return file.getvalue()


def npy_table() -> bytes:
    file = io.BytesIO()
    np.save(file, np.stack(list(_columns().values()), axis=1))
    return file.getvalue()


def matlab_table() -> bytes:
    from scipy.io import savemat

    file = io.BytesIO()
    savemat(file, {name: column[:, None] for name, column in _columns().items()})
    return file.getvalue()


def hdf5_table(user_block: int = 0, **storage: str) -> bytes:
    import h5py

    file = io.BytesIO()
    with h5py.File(file, "w", userblock_size=user_block) as content:
        for name, column in _columns().items():
            content.create_dataset(f"log/{name}", data=column[None] if user_block else column, **storage)
    return file.getvalue()


def matlab_73_table() -> bytes:
    head = b"MATLAB 7.3 MAT-file, Platform: GLNXA64"
    return head + hdf5_table(512)[len(head) :]


def parquet_table() -> bytes:
    import pyarrow
    import pyarrow.parquet

    file = io.BytesIO()
    columns = _columns()
    lists = [[float(value), 0.5] for value in columns["elbow_position"]]
    pyarrow.parquet.write_table(pyarrow.table({**columns, "observation.state": lists}), file)
    return file.getvalue()


TABLES: dict[str, Callable[[], bytes]] = {
    "table.csv": csv_table, "table.npz": npz_table, "table.npy": npy_table, "table.mat": matlab_table,
    "table.h5": hdf5_table, "packed.h5": lambda: hdf5_table(compression="gzip"), "table_73.mat": matlab_73_table,
    "table.parquet": parquet_table,
}  # fmt: skip
EPISODE = "LeRobot"
KINDS = (*TABLES, EPISODE, "definition", "run file")
INFORMATION = {
    "codebase_version": "v2.1", "fps": 200, "total_episodes": 1,
    "features": {"observation.state": {"dtype": "float32", "shape": [2], "names": {"motors": ["elbow", "wrist"]}}},
}  # fmt: skip


def damaged_table(kind: str, folder: Path, random: np.random.Generator) -> str:
    """Import a damaged table; the damage's name."""
    from flex_ident.configuration import IMPORT_SETTINGS
    from flex_ident.formats.importing import imported

    data = TABLES[kind]()
    if kind == "table.csv" and random.random() < 0.5:
        text, way = mutated_text(data.decode(), random)
        data = text.encode("utf-8", errors="surrogateescape")
    else:
        data, way = mutated(data, random)
    file = folder / kind
    file.write_bytes(data)
    values = {own.key: own.default for own in IMPORT_SETTINGS}
    if kind == "table.npy":
        values |= {"import.time": "column.0", "import.position": "column.1", "import.effort": "column.2"}
    imported(file, folder / "bag", values)
    return way


def damaged_episode(folder: Path, random: np.random.Generator) -> str:
    """Import the one episode of a LeRobot dataset, of which one file is damaged; the damage's name."""
    from flex_ident.configuration import IMPORT_SETTINGS
    from flex_ident.formats.importing import imported

    file, description = folder / "set/data/chunk-000/episode_000000.parquet", folder / "set/meta/info.json"
    for own in (file, description):
        own.parent.mkdir(parents=True)
    file.write_bytes(parquet_table())
    description.write_text(json.dumps(INFORMATION, indent=1))
    if random.random() < 0.5:
        data, way = mutated(file.read_bytes(), random)
        file.write_bytes(data)
    else:
        text, way = mutated_text(description.read_text(), random)
        description.write_text(text, encoding="utf-8", errors="surrogateescape")
    values = {own.key: own.default for own in IMPORT_SETTINGS}
    values |= {"import.position": "observation.state.elbow", "import.effort": "elbow_effort"}
    imported(folder / "set", folder / "bag", values)
    return way


def damaged_definition(folder: Path, random: np.random.Generator) -> str:
    """Read a bag whose messages a damaged .msg file defines; the damage's name."""
    from test_other_messages import KNOWN_TYPES, ODRIVE, ODRIVE_PLACES, odrive_bag

    from flex_ident.bags.reading import read_recording
    from flex_ident.bags.selection import SignalSelection

    text, way = mutated_text(KNOWN_TYPES[ODRIVE][0], random)
    file = folder / "Drive.msg"
    file.write_text(text, encoding="utf-8", errors="surrogateescape")
    read_recording(odrive_bag(folder, TYPE), SignalSelection(type_files=(str(file),), **ODRIVE_PLACES))
    return way


def damaged_run_file(folder: Path, random: np.random.Generator) -> str:
    """Read a damaged file of a run's conditions; the damage's name."""
    from flex_ident.bags.run_file import RUN_FILE, run_conditions

    text, way = mutated_text(RUN_FILE_TEXT, random)
    (folder / RUN_FILE).write_text(text, encoding="utf-8", errors="surrogateescape")
    run_conditions(folder)
    return way


def damaged(kind: str, folder: Path, random: np.random.Generator) -> str:
    """Damage a file of one of KINDS and read it; the damage's name."""
    if kind in TABLES:
        return damaged_table(kind, folder, random)
    if kind == EPISODE:
        return damaged_episode(folder, random)
    return damaged_definition(folder, random) if kind == "definition" else damaged_run_file(folder, random)
