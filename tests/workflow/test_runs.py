"""One run at a time in a folder; what a killed one left is cleared, and nothing else."""

from __future__ import annotations

import dataclasses
import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest
from mocap_workflow import runs
from running import command, environment
from snakemake.persistence.file import FilePersistence
from test_elsewhere import host_of

from mocap_metrology.common.faults import Faults
from mocap_metrology.common.files import part_prefix

PLAIN = command()[3:]
TABLE = "results/tables/g_noise.csv"  # of a and b, which suffice
OWN = f"mark of {os.getpid()}"  # tests may run beside this one


@pytest.fixture
def record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(runs.MARK, "")
    monkeypatch.setenv(runs.PLACE, str(tmp_path))
    path = tmp_path / runs.RECORD
    path.parent.mkdir()
    return path


@pytest.fixture
def sleeper() -> Iterator[subprocess.Popen]:
    """A process with the mark of a run, as a job that its death left alive."""
    marked = os.environ | {runs.MARK: OWN}
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"], env=marked)
    yield process
    process.kill()
    process.wait()


def write(record: Path, **other) -> None:
    """A run of this host whose process is gone, or with other values."""
    gone = runs.Run(socket.gethostname(), 2**22 + 1, 1.0, OWN, str(record.parent))
    record.write_text(json.dumps(dataclasses.asdict(gone) | other))


def unlocked(record: Path) -> bool:
    """Whether `clear` would have Snakemake's lock cleared."""
    asked = []
    runs.clear(lambda: asked.append("unlock") or True, record)
    return bool(asked)


def test_a_run_that_ends_leaves_nothing(record: Path) -> None:
    runs.began(record)
    own = runs.read(record)
    assert own.alive()
    assert own.pid == os.getpid()
    assert os.environ[runs.MARK] == own.mark
    runs.ended(record)
    assert not list(record.parent.iterdir())
    assert not unlocked(record)


def test_the_lock_of_a_process_that_is_gone_is_cleared_once(record: Path, capsys) -> None:
    write(record)
    assert unlocked(record)
    assert "left\n" in capsys.readouterr().err
    assert not unlocked(record)


def test_a_lock_that_stays_keeps_its_record(record: Path) -> None:
    write(record)
    with pytest.raises(Faults, match=r"the lock of the last run .* stays; run make again"):
        runs.clear(lambda: False, record)
    assert record.is_file()
    assert unlocked(record)


def test_a_run_that_is_alive_is_left_alone(record: Path, sleeper: subprocess.Popen) -> None:
    process = psutil.Process(sleeper.pid)
    write(record, pid=process.pid, began_s=process.create_time())
    before = record.read_text()
    with pytest.raises(Faults, match=f"another run is active here \\(process {process.pid}\\)"):
        unlocked(record)
    runs.began(record)
    runs.ended(record)
    assert record.read_text() == before
    assert sleeper.poll() is None


def test_a_later_process_of_the_same_number_is_not_the_run(
    record: Path, sleeper: subprocess.Popen
) -> None:
    process = psutil.Process(sleeper.pid)
    write(record, pid=process.pid, began_s=process.create_time() - 60, mark="of another")
    assert unlocked(record)
    assert sleeper.poll() is None


def test_jobs_of_a_killed_run_are_ended(record: Path, sleeper: subprocess.Popen, capsys) -> None:
    write(record)
    assert unlocked(record)
    assert sleeper.poll() is not None
    assert "1 processes of it were ended" in capsys.readouterr().err


def test_another_host_keeps_its_lock(record: Path, sleeper: subprocess.Popen, capsys) -> None:
    write(record, host="elsewhere")
    assert not unlocked(record)
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "a run of host elsewhere" in said
    assert said.endswith("snakemake --unlock\n")
    assert record.is_file()
    assert sleeper.poll() is None


@pytest.mark.parametrize("text", ["", "[]", '{"pid": 1}'])
def test_what_is_no_record_says_nothing(record: Path, text: str) -> None:
    record.write_text(text)
    assert not unlocked(record)


def test_kill_and_run_again(toy: Path, snakemake, root: Path) -> None:
    start = [sys.executable, str(root / "workflow/run.py"), *PLAIN, "--cores", "2", TABLE]
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    (toy / "config/a.c3d").write_text("a waits: wait\n")
    run = subprocess.Popen(start, cwd=toy, env=environment(), **silent)
    try:
        until = time.monotonic() + 600  # it takes seconds, unless other work has the cores
        while not (toy / "waiting").exists() and time.monotonic() < until:
            assert run.poll() is None
            time.sleep(0.1)
        assert (toy / "waiting").exists()
        own = runs.read(toy / runs.RECORD)
        assert own.pid == run.pid
    finally:
        run.kill()
        run.wait()
    assert own.jobs()
    how = {"cwd": toy, "env": environment(), "capture_output": True, "text": True, "timeout": 900}
    typed = snakemake(toy, "--cores", "2", TABLE)
    (toy / "config/a.c3d").write_text("a is well\n")
    after = subprocess.run(start, check=False, **how)
    assert typed.returncode == 1
    assert "LockException" in typed.stdout
    assert after.returncode == 0, after.stderr
    assert f"cleared what the last run (process {run.pid}) left" in after.stderr
    assert not own.jobs()
    assert (toy / TABLE).read_text() == "a is well\nb is good\n"
    assert not (toy / runs.RECORD).exists()


def test_kill_before_the_first_job_and_run_again(toy: Path, root: Path) -> None:
    start = [sys.executable, str(root / "workflow/run.py"), *PLAIN, "--cores", "2", TABLE]
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    run = subprocess.Popen(start, cwd=toy, env=environment(), **silent)
    try:
        until = time.monotonic() + 600
        while not list(toy.glob(".snakemake/locks/*")) and time.monotonic() < until:
            assert run.poll() is None
            time.sleep(0.01)
    finally:
        run.kill()
        run.wait()
    assert list(toy.glob(".snakemake/locks/*"))
    how = {"cwd": toy, "env": environment(), "capture_output": True, "text": True, "timeout": 900}
    refused = subprocess.run([*start, "--config", "hampel=0"], check=False, **how)
    assert refused.returncode == 1
    assert "hampel" in refused.stderr
    assert refused.stderr.endswith("stays; run make again\n")
    after = subprocess.run(start, check=False, **how)
    assert after.returncode == 0
    assert not (toy / runs.RECORD).exists()


def test_of_two_runs_at_once_after_a_kill_one_is_refused(toy: Path, root: Path) -> None:
    record, locks = toy / runs.RECORD, toy / ".snakemake/locks"
    locks.mkdir(parents=True)
    write(record)
    for kind in ("input", "output"):
        (locks / f"0.{kind}.lock").write_text(str(toy / "results"))
    start = [sys.executable, str(root / "workflow/run.py"), *PLAIN, "--cores", "1", TABLE]
    how = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    (toy / "config/a.c3d").write_text("a waits: wait\n")
    both = [subprocess.Popen(start, cwd=toy, env=environment(), **how) for _ in range(2)]
    until = time.monotonic() + 600
    while all(run.poll() is None for run in both) and time.monotonic() < until:
        time.sleep(0.1)
    (toy / "go").touch()
    said = {run.pid: run.communicate(timeout=900)[1] for run in both}
    assert sorted(run.returncode for run in both) == [0, 1], said
    refused = next(run.pid for run in both if run.returncode)
    assert "another run is active here" in said[refused]
    assert not record.exists()


@pytest.fixture
def left(tmp_path: Path) -> tuple[Path, dict[str, Path]]:
    """Folder of results, by a link, in which a run of another folder was killed; files by name."""
    killed, results = tmp_path / "killed", tmp_path / "disk/results"
    (results / "recordings").mkdir(parents=True)
    (killed / "results").parent.mkdir()
    (killed / "results").symlink_to(results)
    marks = FilePersistence(path=killed / ".snakemake")
    write(results / runs.CLAIM, folder=str(killed))
    write(killed / runs.RECORD, folder=str(killed))
    files = {
        "part": results / f"recordings/{part_prefix(OWN)}0-allan.parquet",
        "long": results / ("recordings/" + "a long name " * 18 + ".csv"),
        "unfinished": results / "recordings/a.csv",
        "finished": results / "recordings/b.csv",
        "own": results / "recordings/.part-list",
        "of another run": results / f"recordings/{part_prefix('another run')}0-psd.parquet",
        "outside": tmp_path / "recording.c3d",
    }
    for path in files.values():
        path.write_text("half")
    for name in ("long", "unfinished"):
        marks._mark_incomplete(f"results/recordings/{files[name].name}", None)
    marks._mark_incomplete(str(files["outside"]), None)
    return killed / "results", files


def there(files: dict[str, Path]) -> set[str]:
    return {name for name, path in files.items() if path.exists()}


def test_what_the_record_of_a_killed_run_names_is_cleared_and_nothing_else(
    left, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    results, files = left
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    runs.claim(Path("../disk/results"))
    assert there(files) == files.keys() - {"part", "long", "unfinished"}
    assert "cleared what a killed run" in capsys.readouterr().err
    own = runs.read(results / runs.CLAIM)
    assert (own.pid, own.folder) == (os.getpid(), str(tmp_path / "elsewhere"))
    runs.claim(results)  # as a workflow that uses this one twice
    runs.ended(results / runs.CLAIM)
    assert not (results / runs.CLAIM).exists()


@pytest.mark.parametrize("of", ["alive", "elsewhere"])
def test_results_of_another_run_are_not_touched(
    left, sleeper: subprocess.Popen, monkeypatch: pytest.MonkeyPatch, of: str
) -> None:
    results, files = left
    monkeypatch.chdir(results.parents[1])
    if of == "alive":
        process = psutil.Process(sleeper.pid)
        other = {"pid": process.pid, "began_s": process.create_time()}
    else:
        other = {"host": "elsewhere"}
    write(results / runs.CLAIM, **other)
    before = (results / runs.CLAIM).read_text()
    with pytest.raises(Faults, match=f"^{results}: .* is active here .*; expected none"):
        runs.claim(results)
    assert (results / runs.CLAIM).read_text() == before
    assert there(files) == files.keys()
    assert sleeper.poll() is None


def test_unlock_clears_what_a_run_of_another_host_left(left) -> None:
    results, files = left
    write(results / runs.CLAIM, host="elsewhere", folder=str(results.parent))
    write(results.parent / runs.RECORD, host="elsewhere", folder=str(results.parent))
    runs.claim(results, unlocks=True)
    assert there(files) == files.keys() - {"part", "long", "unfinished"}
    runs.ended(results / runs.CLAIM)


def test_marks_in_a_folder_that_is_locked_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    results, marks = Path("results"), FilePersistence(path=tmp_path / ".snakemake")
    (results / "fit").mkdir(parents=True)
    (results / "fit/z1.svg").write_text("half")
    for path in ("results/fit", "results/not begun.csv"):
        marks._mark_incomplete(path, None)
    lock = tmp_path / ".snakemake/locks/0.output.lock"
    lock.write_text("")
    assert not runs.clear_unfinished(results)
    lock.unlink()
    assert tmp_path / "results/fit" in runs.clear_unfinished(results)
    assert not list(results.iterdir())
    assert not marks._filter_incomplete_keys(["results/fit"])
    assert not runs.clear_unfinished(results)


def test_of_two_runs_from_two_folders_the_second_is_refused(
    toy: Path, tmp_path_factory: pytest.TempPathFactory, root: Path, snakemake
) -> None:
    """With other words for the folder of results; also of another workflow that uses this one. A
    dry run is not refused, and none of them touches anything."""
    (toy / "config/a.c3d").write_text("a waits: wait\n")
    other = tmp_path_factory.mktemp("other")
    for name in ("profiles", "config"):
        (other / name).symlink_to(toy / name)
    (other / "linked").symlink_to(toy / "results")
    where = {"results": str(toy / "results"), "sheet": "config/recordings.tsv"}
    (other / "Snakefile").write_text(host_of("tables/g_noise.csv", toy, **where))
    entry = ("-s", str(toy / "Snakefile"), "--cores", "1", "linked/tables/g_noise.csv")
    second = lambda *how: snakemake(other, *entry, "--config", "results=linked", *how)  # noqa: E731
    start = [sys.executable, str(root / "workflow/run.py"), *PLAIN, "--cores", "2", TABLE]
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    first = subprocess.Popen(start, cwd=toy, env=environment(), **silent)
    try:
        until = time.monotonic() + 600
        while not (toy / "waiting").exists() and time.monotonic() < until:
            assert first.poll() is None
            time.sleep(0.1)
        parts = [toy / f"results/.part-{name}" for name in ("mine", "0123456789ab-0-a.csv")]
        for path in parts:
            path.write_text("mine")
        dry, *refused = second("-n"), second(), snakemake(other, "--cores", "1"), second("--unlock")
        assert dry.returncode == 0, dry.stdout
        for run in refused:
            assert run.returncode == 1
            lines = [line for line in run.stdout.splitlines() if "another run" in line]
            assert len(lines) == 1 and f"(process {first.pid} in {toy})" in lines[0], run.stdout
        assert (toy / "results/recordings/a/noise.csv").read_text() == "half\n"
    finally:
        (toy / "go").touch()
        assert first.wait(900) == 0
    assert (toy / TABLE).read_text() == "a waits: wait\nb is good\n"
    assert all(path.read_text() == "mine" for path in parts)
    assert not (toy / "results" / runs.CLAIM).exists()


def test_a_deleted_result_is_made_again(toy: Path, snakemake) -> None:
    """Of a recording and a twin."""
    sheet = toy / "config/recordings.tsv"
    header, _, _, *rows = sheet.read_text().splitlines()
    sheet.write_text("\n".join([header, *rows]) + "\n")
    first = snakemake(toy, "--cores", "2", "tables")
    assert first.returncode == 0, first.stdout
    results = toy / "results"
    whole = {path: path.read_bytes() for path in results.glob("[rt]*/**/*.*") if path.is_file()}
    assert len(whole) == 7
    for path in whole:
        path.unlink()
    again = snakemake(toy, "--cores", "2", "tables")
    assert again.returncode == 0, again.stdout
    tables = {path: whole[path] for path in whole if path.parent.name == "tables"}
    assert {path: path.read_bytes() for path in tables} == tables
    assert "Nothing to be done" in snakemake(toy, "--cores", "2", "tables").stdout


def test_a_run_that_is_refused_leaves_no_record(toy: Path, root: Path) -> None:
    start = [sys.executable, str(root / "workflow/run.py"), *PLAIN, "--cores", "1"]
    how = {"cwd": toy, "env": environment(), "capture_output": True, "timeout": 900}
    assert subprocess.run([*start, "--config", "hampel=0"], check=False, **how).returncode == 1
    assert subprocess.run([*start, "--dry-run"], check=False, **how).returncode == 0
    assert not (toy / runs.RECORD).exists()
