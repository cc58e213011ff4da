"""Numeric variables of a MATLAB file of version 5, read in a process of its own.

scipy's reader is compiled, and damage in a file can crash it; a crash must not take the caller along. What it reads
goes to a NumPy archive: under `NAMES` the variables' dotted names, then an array each by its number.
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from flex_ident.recording.names import harmless

NAMES = "names"
DEEPEST = 16
START = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from flex_ident.formats.matlab_content import write_content; write_content(sys.argv[2], sys.argv[3])"
)


class MatlabContentError(Exception):
    """The file cannot be read; its text says what came in place of its data."""


def matlab_arrays(path: Path) -> dict[str, Any]:
    """Numeric arrays of the file, squeezed, by dotted name. Raises MatlabContentError when it is damaged."""
    with tempfile.TemporaryDirectory(prefix="flex_ident_") as folder:
        file = Path(folder) / "content.npz"
        done = subprocess.run(
            [sys.executable, "-c", START, json.dumps(sys.path), str(path), str(file)],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, check=False,
        )  # fmt: skip
        if done.returncode < 0:
            raise MatlabContentError(f"{signal.Signals(-done.returncode).name} in scipy's reader")
        if done.returncode or not file.exists():
            what = harmless(done.stdout.decode("utf-8", "replace").strip()) or "nothing"
            raise MatlabContentError(f"{what} where MATLAB's data should be")
        with np.load(file, allow_pickle=False) as archive:
            names = json.loads(str(archive[NAMES]))
            return {name: archive[str(number)] for number, name in enumerate(names)}


def write_content(path: str, file: str) -> None:
    """What the process does: put a MATLAB file's numeric arrays into an archive, or exit 1 and say the error's name."""
    import scipy.io

    arrays: dict[str, Any] = {}
    try:
        content: dict[str, Any] = scipy.io.loadmat(path, simplify_cells=True)
        _collect(arrays, {k: v for k, v in content.items() if not k.startswith("__")}, "", DEEPEST)
        numbered = {str(number): array for number, array in enumerate(arrays.values())}
        np.savez(file, **{NAMES: np.array(json.dumps(list(arrays)))}, **numbered)  # type: ignore[arg-type]
    except Exception as error:
        print(type(error).__name__)
        sys.exit(1)


def _collect(arrays: dict[str, Any], value: Any, path: str, levels: int) -> None:
    """Numeric arrays in structures within structures, by dotted path."""
    if isinstance(value, dict) and levels:
        for key, inner in value.items():
            _collect(arrays, inner, f"{path}.{harmless(key)}" if path else harmless(key), levels - 1)
    elif isinstance(value, np.ndarray) and value.dtype.kind in "bifu" and value.size > 1 and value.ndim <= 3:
        arrays[path] = np.squeeze(value)
