#!/usr/bin/env python3
"""Processor time and memory until a bag made to hurt is refused; exit status 1 where one takes over 2 s or 300 MiB.

.venv/bin/python bench/hostile.py
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "test" / "bags"))
from hostile_bags import HOSTILE, refusal

SECONDS, MEBIBYTES = 2.0, 300.0
"""What was asked of every hostile file."""


def main() -> int:
    """Print one row a bag."""
    failed = 0
    print("| bag | refused | s | MiB |\n| --- | --- | --- | --- |")
    for name, make in HOSTILE.items():
        with tempfile.TemporaryDirectory() as folder:
            said, seconds, mebibytes = refusal(make(Path(folder)))
        failed += not said or seconds > SECONDS or mebibytes > MEBIBYTES
        print(f"| {name} | {'yes' if said else 'NO'} | {seconds:.2f} | {mebibytes:.0f} |", flush=True)
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
