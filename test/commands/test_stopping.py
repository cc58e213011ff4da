"""Signals end a command with one line and the shell's status, and leave nothing behind."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from flex_ident.stopping import SIGNALS, Stopped, stoppable, unbroken

BODY = """
import sys, time
from pathlib import Path
from flex_ident.commands.common import exit_status
from flex_ident.report.folder import renewed

def body():
    with renewed(Path(sys.argv[1]), ()) as aside:
        (aside / "result.json").write_text("half")
        print("writing", flush=True)
        if len(sys.argv) > 2:
            print("x" * 1_000_000)
        for _ in range(3000):  # a signal just before one long sleep would be heeded at its end
            time.sleep(0.01)
    return 0

sys.exit(exit_status("command", body))
"""


def started(*arguments: str, before: str = "") -> subprocess.Popen[bytes]:
    """A command that waits while it writes results."""
    code = f"import signal\n{before}\n{BODY}"
    process = subprocess.Popen(
        [sys.executable, "-c", code, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, bufsize=0
    )
    assert process.stdout is not None
    assert process.stdout.read(8) == b"writing\n"
    return process


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_a_signal_leaves_one_line_and_no_file(number: signal.Signals, tmp_path: Path) -> None:
    process = started(str(tmp_path))
    process.send_signal(number)
    process.send_signal(number)
    _, said = process.communicate(timeout=20.0)
    assert process.returncode == 128 + number
    assert said.decode() == f"command: stopped by {number.name}; what was not finished is not written.\n"
    assert os.listdir(tmp_path) == []


def test_a_reader_that_takes_nothing_is_not_waited_for(tmp_path: Path) -> None:
    process = started(str(tmp_path), "much")
    process.send_signal(signal.SIGTERM)
    assert process.wait(20.0) == 143
    assert os.listdir(tmp_path) == []
    process.communicate()


def test_a_hangup_that_is_ignored_stays_so(tmp_path: Path) -> None:
    process = started(str(tmp_path), before="signal.signal(signal.SIGHUP, signal.SIG_IGN)")
    process.send_signal(signal.SIGHUP)
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(0.3)
    process.send_signal(signal.SIGTERM)
    process.communicate(timeout=20.0)
    assert process.returncode == 143


def test_a_signal_waits_for_what_must_not_be_broken() -> None:
    done: list[str] = []

    def work() -> None:
        with unbroken():
            with unbroken():
                os.kill(os.getpid(), signal.SIGTERM)
            done.append("whole")
        done.append("not reached")

    before = {number: signal.getsignal(number) for number in SIGNALS}
    try:
        with stoppable(), pytest.raises(Stopped) as raised:
            work()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    assert done == ["whole"]
    assert raised.value.exit_status == 143


def test_handlers_are_those_of_before() -> None:
    before = [signal.getsignal(number) for number in SIGNALS]
    with stoppable():
        assert signal.getsignal(signal.SIGTERM) not in before
    assert [signal.getsignal(number) for number in SIGNALS] == before
