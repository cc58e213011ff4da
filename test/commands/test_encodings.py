"""A terminal that lacks characters: plain ones stand for them, and the status is the result's."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from flex_ident.report import schemas

BODY = r"""
import sys
from flex_ident.commands.common import exit_status

def body():
    print("K 1.0 \xb1 0.1, \u2265 2\u03c3, Gelenk \xe4, \u6f22, path \udcff")
    print("delay \xb1 1", file=sys.stderr)
    return 4

sys.exit(exit_status("command", body))
"""


SHOWN = {
    "ascii": (rb"K 1.0 +- 0.1, >= 2sigma, Gelenk \xe4, \u6f22, path \xff", b"delay +- 1"),
    "latin-1": (b"K 1.0 \xb1 0.1, >= 2sigma, Gelenk \xe4, \\u6f22, path \\xff", b"delay \xb1 1"),
    "utf-8": ("K 1.0 ± 0.1, ≥ 2σ, Gelenk ä, \u6f22, path \\xff".encode(), "delay ± 1".encode()),
}
"""The lines of BODY by encoding."""


@pytest.mark.parametrize(
    ("environment", "encoding"),
    [
        ({"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}, "ascii"),
        *(({"PYTHONIOENCODING": encoding}, encoding) for encoding in SHOWN),
    ],
)
def test_what_an_encoding_lacks_is_said_plainly(environment: dict[str, str], encoding: str) -> None:
    kept = {k: v for k, v in os.environ.items() if k not in ("PYTHONIOENCODING", "PYTHONUTF8", "LC_ALL")}
    done = subprocess.run(
        [sys.executable, "-c", BODY], env={**kept, **environment}, capture_output=True, timeout=60, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (4, *(line + b"\n" for line in SHOWN[encoding]))


def test_an_export_is_exact_or_refused(tmp_path: Path) -> None:
    file = tmp_path / "result.json"
    mass = {"value": 1.0, "std": 0.1, "unit": "kg m^2", "identifiable": True}
    content = {
        "schema": schemas.RESULT, "joint": "Gelenk ä", "sensors": "motor", "method": "rigid", "verdict": "trusted",
        "parameters": {"J": mass, "FV": {**mass, "unit": "N m s/rad"}, "FS": {**mass, "unit": "N m"}},
    }  # fmt: skip
    file.write_text(json.dumps(content))
    command = [sys.executable, "-m", "flex_ident.commands.flex_ident", "export", str(file), "--to", "urdf"]
    given = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, env=given, capture_output=True, timeout=60, check=False)
    assert (done.returncode, done.stdout) == (2, b"")
    assert done.stderr.count(b"\n") == 1
    assert b"--out FILE" in done.stderr
