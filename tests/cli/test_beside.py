"""A function in a process beside the one that waits for it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mocap_metrology.cli import beside


def write_pid(path: Path) -> None:
    path.write_text(str(os.getpid()))


def broken(path: Path) -> None:
    raise IndexError(f"no {path}")


def nothing() -> None:
    pass


@pytest.mark.parametrize("forks", [beside.FORKS, False])
def test_a_function_in_another_process(forks: bool, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(beside, "FORKS", forks)
    with beside.beside(nothing, write_pid) as second:
        second.call(tmp_path / "pid")
        second.wait()
    assert (int((tmp_path / "pid").read_text()) != os.getpid()) == forks


@pytest.mark.skipif(not beside.FORKS, reason="no fork on this system")
def test_a_failure_is_raised_with_its_traceback() -> None:
    with (
        beside.beside(nothing, broken) as second,
        pytest.raises(RuntimeError, match=r"in broken\n(.*\n)*IndexError: no x"),
    ):
        second.call("x")
        second.wait()
    with (
        beside.beside(nothing, lambda: os._exit(3)) as second,
        pytest.raises(RuntimeError, match="process was ended"),
    ):
        second.call()
        second.wait()


@pytest.mark.skipif(not beside.FORKS, reason="no fork on this system")
def test_no_process_is_left_where_the_first_is_killed() -> None:
    code = (
        "import os, time\n"
        "from mocap_metrology.cli.beside import beside\n"
        "with beside(lambda: print(os.getpid(), flush=True), print):\n"
        "    time.sleep(60)\n"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as first:
        second = int(first.stdout.readline())
        first.send_signal(signal.SIGKILL)
        first.wait()
    for _ in range(100):
        state = Path(f"/proc/{second}/stat")
        if not state.exists() or state.read_text().split()[2] == "Z":
            return
        time.sleep(0.05)
    pytest.fail(f"process {second} is still there")
