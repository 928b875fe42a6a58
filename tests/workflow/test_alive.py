"""One run at a time in a folder; a killed one keeps nobody out."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from mocap_workflow import alive
from mocap_workflow.faults import Faults
from running import command, environment, side_by_side

HOLD = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from mocap_workflow import alive
alive.take(Path(".snakemake"))
print("held", flush=True)
sys.stdin.read()
"""


def test_the_lock_dies_with_its_process_and_stale_locks_with_it(
    tmp_path: Path, root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    locks = tmp_path / ".snakemake/locks"
    locks.mkdir(parents=True)
    holder = subprocess.Popen(
        [sys.executable, "-c", HOLD, str(root / "workflow")],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert holder.stdout.readline() == "held\n"
        (locks / "0.input.lock").write_text("a\n")
        with pytest.raises(Faults, match=f"another run works here \\(process {holder.pid}\\)"):
            alive.take(Path(".snakemake"))
        assert (locks / "0.input.lock").exists()
    finally:
        holder.kill()
        holder.wait()
    assert alive.take(Path(".snakemake"))
    assert not list(locks.iterdir())


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ("--cores 2", True),
        ("--cores 2 tables --config seed=4", True),
        ("--touch --cores 1", True),
        ("-n", False),
        ("--dry-run --cores 2", False),
        ("--lint", False),
        ("--unlock", False),
        ("--report results/report.html", False),
        ("--report --report-after-run --cores 2", True),
        ("--rulegraph", False),
        ("--summary", False),
        ("--list-rules", False),
        ("--cores 2 --mode remote", False),
        ("--cores 2 --mode subprocess", False),
    ],
)
def test_who_takes_it(arguments: str, expected: bool, tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert alive.runs_jobs(["/usr/bin/snakemake", *arguments.split()]) is expected
    assert not alive.runs_jobs(["/usr/bin/pytest", *arguments.split()])


def test_kill_and_run_again(toy: Path, snakemake) -> None:
    (toy / "config/a.c3d").write_text("a waits: wait\n")
    start = command("--cores", "2", "tables")
    run = subprocess.Popen(
        start,
        cwd=toy,
        env=environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    try:
        until = time.monotonic() + 600  # it takes seconds, unless other work has the cores
        while not (toy / "waiting").exists() and time.monotonic() < until:
            assert run.poll() is None
            time.sleep(0.1)
        assert (toy / "waiting").exists()
        second, dry = side_by_side(
            lambda: snakemake(toy, "--cores", "2", "tables"), lambda: snakemake(toy, "-n")
        )
        assert dry.returncode == 0
        assert second.returncode == 1
        assert f"another run works here (process {run.pid})" in second.stdout
        assert list((toy / ".snakemake/locks").iterdir())
    finally:
        run.send_signal(signal.SIGKILL)
        run.wait()
        with contextlib.suppress(ProcessLookupError):
            os.killpg(run.pid, signal.SIGKILL)  # its orphaned job
    (toy / "go").touch()
    after = snakemake(toy, "--cores", "2", "tables")
    assert after.returncode == 0, after.stdout
    assert (toy / "results/tables/g_noise.csv").read_text() == "a waits: wait\nb is good\n"
