"""Standard streams that are closed, full, left by their reader: the work is done, and the status is the result's."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

BODY = """
import sys
from pathlib import Path
from flex_ident.commands.common import exit_status

def body():
    print("before the result", flush=True)
    print("a warning", file=sys.stderr, flush=True)
    print("more " * 10_000)
    sys.stdout.write("told")
    Path(sys.argv[1]).write_text("written")
    return 4

sys.exit(exit_status("command", body))
"""


def shell(line: str, folder: Path, **environment: str) -> subprocess.CompletedProcess[bytes]:
    """What bash makes of a line in which `work FILE` is a command that prints, then writes FILE, with status 4."""
    script = folder / "body.py"
    script.write_text(BODY, encoding="utf-8")
    work = f'set -o pipefail; work() {{ "{sys.executable}" "{script}" "$@"; }}; '
    tools = f'flex_ident() {{ "{sys.executable}" -m flex_ident.commands.flex_ident "$@"; }}; '
    given = {**os.environ, **environment}
    return subprocess.run(
        ["bash", "-c", work + tools + line], cwd=folder, env=given, capture_output=True, timeout=60, check=False
    )


@pytest.mark.parametrize(
    "line",
    [
        "work file >&-", "work file 2>&-", "work file <&- >&- 2>&-", "work file | true", "work file | head -1",
        "work file 2>&1 | true", "work file 2> /dev/full",
    ],
)  # fmt: skip
def test_the_work_is_done_and_the_status_is_the_results(line: str, tmp_path: Path) -> None:
    done = shell(line, tmp_path)
    assert done.returncode == 4
    assert (tmp_path / "file").read_text() == "written"
    assert done.stderr in (b"", b"a warning\n")


def test_nothing_of_standard_error_is_on_standard_output(tmp_path: Path) -> None:
    done = shell("work file 2>&-", tmp_path)
    assert done.stdout == b"before the result\n" + b"more " * 10_000 + b"\ntold"


@pytest.mark.skipif(not os.access("/dev/full", os.W_OK), reason="needs /dev/full")
def test_a_full_disk_behind_standard_output_is_told_when_the_work_is_done(tmp_path: Path) -> None:
    done = shell("work file > /dev/full", tmp_path)
    assert done.returncode == 2
    assert (tmp_path / "file").read_text() == "written"
    full = b"command: the output cannot be read or written (No space left on device).\n"
    assert done.stderr == b"a warning\n" + full


@pytest.mark.parametrize(
    "arguments",
    ["codes", "--help", "design-filter --first-mode 3.9", pytest.param("effects", marks=pytest.mark.slow)],
)
@pytest.mark.parametrize("streams", [">&-", "| head -1 > /dev/null", "| true"])
def test_subcommands_end_quietly(arguments: str, streams: str, tmp_path: Path) -> None:
    done = shell(f"flex_ident {arguments} {streams}", tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


@pytest.mark.parametrize("streams", [">&-", "| true"])
def test_an_error_is_told_without_standard_output(streams: str, tmp_path: Path) -> None:
    done = shell(f"flex_ident check-bag nowhere {streams}", tmp_path)
    assert (done.returncode, done.stderr) == (3, b"flex_ident: nowhere: no such file or folder.\n")


def test_a_file_never_takes_the_place_of_a_closed_stream(tmp_path: Path) -> None:
    code = "from pathlib import Path; from flex_ident.commands.common import exit_status; import os; " \
           "exit_status('p', lambda: [open('file', 'w'), os.write(1, b'lost')][0].fileno() > 2 and 0)"  # fmt: skip
    shell(f'"{sys.executable}" -c "{code}" >&-', tmp_path)
    assert (tmp_path / "file").read_bytes() == b""
