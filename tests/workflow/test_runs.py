"""One run at a time in a folder of results; what a killed one left is cleared, and nothing else."""

import dataclasses
import json
import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil
import pytest
from mocap_workflow import runs
from running import command, environment
from snakemake.persistence.file import FilePersistence

from mocap_metrology.common.faults import Faults
from mocap_metrology.common.files import part_prefix, temporary_folder

PLAIN = command()[3:]
ROOT = Path(__file__).resolve().parents[2]
TABLE = "results/tables/g_noise.csv"  # of a and b, which suffice
OWN = f"mark of {os.getpid()}"  # tests may run beside this one
START = [sys.executable, str(ROOT / "workflow/run.py"), *PLAIN, "--cores", "2", TABLE]


@pytest.fixture
def sleeper() -> Iterator[subprocess.Popen]:
    """A process with the mark of a run, as a job that its death left alive."""
    marked = os.environ | {runs.MARK: OWN}
    process = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"], env=marked)
    yield process
    process.kill()
    process.wait()


@pytest.fixture
def left(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Folder of results, by a link, in which a run of another folder was killed; files by name."""
    monkeypatch.setenv(runs.MARK, OWN)
    killed, results = tmp_path / "killed", tmp_path / "disk/results"
    (results / "recordings").mkdir(parents=True)
    (killed / "results").parent.mkdir()
    (killed / "results").symlink_to(results)
    marks = FilePersistence(path=killed / ".snakemake")
    write(results)
    unnamed = temporary_folder(results / "recordings")
    files = {
        "temporary": Path(unnamed.name) / "twin.c3d",
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
    (results / "fit").mkdir()
    marks._mark_incomplete("results/fit", None)
    monkeypatch.setenv(runs.MARK, "")
    with unnamed:
        yield killed / "results", files


def write(results: Path, **other: object) -> None:
    """The record of a run of this host whose process is gone, or with other values."""
    folder = str(results.parents[1] / "killed")
    gone = runs.Run(socket.gethostname(), 2**22 + 1, 1.0, OWN, folder)
    (results / runs.CLAIM).write_text(json.dumps(dataclasses.asdict(gone) | other))


def there(files: dict[str, Path]) -> set[str]:
    return {name for name, path in files.items() if path.exists()}


def test_what_the_record_of_a_killed_run_names_is_cleared_and_nothing_else(
    left, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys, sleeper: subprocess.Popen
) -> None:
    """From another folder; its jobs are ended."""
    results, files = left
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    assert runs.claim(Path("../disk/results"))
    assert there(files) == files.keys() - {"temporary", "part", "long", "unfinished"}
    assert not (results / "fit").exists() and sleeper.poll() is not None
    assert "cleared what a killed run" in capsys.readouterr().err
    own = runs.read(results / runs.CLAIM)
    assert (own.pid, own.folder) == (os.getpid(), str(tmp_path / "elsewhere"))
    assert os.environ[runs.MARK] == own.mark and own.alive()
    assert not runs.claim(results)  # as a workflow that uses this one twice
    runs.ended(results / runs.CLAIM)
    assert not (results / runs.CLAIM).exists()
    assert not runs.claim(results)  # nothing is left
    runs.ended(results / runs.CLAIM)


@pytest.mark.parametrize("of", ["alive", "elsewhere"])
def test_results_of_another_run_are_not_touched(left, sleeper: subprocess.Popen, of: str) -> None:
    results, files = left
    process = psutil.Process(sleeper.pid)
    alive = {"pid": process.pid, "began_s": process.create_time()}
    write(results.resolve(), **alive if of == "alive" else {"host": "elsewhere"})
    before = (results / runs.CLAIM).read_text()
    with pytest.raises(Faults, match=f"^{results}: .* is active here .*; expected none"):
        runs.claim(results)
    assert (results / runs.CLAIM).read_text() == before
    assert there(files) == files.keys()
    assert sleeper.poll() is None
    if of == "elsewhere":  # the user states that it was killed
        assert runs.claim(results, unlocks=True)
        assert there(files) == files.keys() - {"temporary", "part", "long", "unfinished"}
        runs.ended(results / runs.CLAIM)


def test_a_later_process_of_the_same_number_is_not_the_run(left, sleeper) -> None:
    results, _ = left
    process = psutil.Process(sleeper.pid)
    write(results.resolve(), pid=process.pid, began_s=process.create_time() - 60, mark="another")
    assert runs.claim(results) and sleeper.poll() is None
    runs.ended(results / runs.CLAIM)


@pytest.mark.parametrize("text", ["", "[]", '{"pid": 1}'])
def test_what_is_no_record_says_nothing(left, text: str) -> None:
    results, files = left
    (results / runs.CLAIM).write_text(text)
    assert not runs.claim(results) and there(files) == files.keys()
    runs.ended(results / runs.CLAIM)


def test_a_killed_run_whose_results_were_deleted_is_known(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As its lock, which would refuse every later run, is in the working folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(runs.MARK, "")
    dies = "import os, pathlib; from mocap_workflow import runs; "
    dies += "runs.claim(pathlib.Path('results')); os.kill(os.getpid(), 9)"
    paths = environment() | {"PYTHONPATH": str(Path(runs.__file__).parents[1])}
    subprocess.run([sys.executable, "-c", dies], env=paths, check=False)
    shutil.rmtree("results")
    results = Path("results")
    assert not runs.claim(Path("other"))
    assert runs.claim(results)
    for record in (results / runs.CLAIM, Path("other") / runs.CLAIM):
        runs.ended(record)
    assert not any(path.is_file() for path in tmp_path.rglob("*"))


def until(condition: Callable[[], object], run: subprocess.Popen) -> None:
    """Wait for it, as long as a run works: seconds, unless other work has the cores."""
    end = time.monotonic() + 600
    while not condition() and time.monotonic() < end:
        assert run.poll() is None
        time.sleep(0.02)
    assert condition()


def start(toy: Path) -> subprocess.Popen:
    silent = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.Popen(START, cwd=toy, env=environment(), **silent)


def test_kill_and_run_again_twice_at_once(toy: Path, snakemake) -> None:
    """One of the two goes on and clears the lock, too. Where sheets are wrong nothing is: they are
    lines and status 1."""
    (toy / "config/a.c3d").write_text("a waits: wait\n")
    first, locks = start(toy), toy / ".snakemake/locks"
    try:
        until((toy / "waiting").exists, first)
        own = runs.read(toy / "results" / runs.CLAIM)
        assert own.pid == first.pid
    finally:
        first.kill()
        first.wait()
    assert list(locks.glob("*"))
    how = {"cwd": toy, "env": environment(), "stderr": subprocess.PIPE, "text": True}
    (toy / "config/mine.tsv").write_text(
        "recording\tpath\tmarkers\tgroup\na\tno.c3d\tA\tg\nb\tsimulate:U\t\tg\n"
    )
    (toy / "config/dumps.tsv").write_text("calibration\tsetup\n")
    named = ("--config", "recordings=config/mine.tsv", "calibrations=config/dumps.tsv")
    wrong = snakemake(toy, "--cores", "2", TABLE, *named)
    assert wrong.returncode == 1 and list(locks.glob("*"))
    assert wrong.stdout.splitlines()[-3:] == [
        'config/mine.tsv, row 2 (recording "a"), column path: "no.c3d"; '
        "expected a file (config/no.c3d does not exist)",
        'config/mine.tsv, row 3 (recording "b"), column path: "simulate:U"; '
        "expected simulate: and a twin of the file of twins (unknown; expected one of T)",
        "config/dumps.tsv: no column group, path, format; expected a header with it",
    ]
    assert "Traceback" not in wrong.stdout
    both = [subprocess.Popen(START, stdout=subprocess.DEVNULL, **how) for _ in range(2)]
    end = time.monotonic() + 600
    while all(run.poll() is None for run in both) and time.monotonic() < end:
        time.sleep(0.1)
    (toy / "go").touch()
    said = {run.returncode: err for run in both for err in [run.communicate(timeout=900)[1]]}
    assert said.keys() == {0, 1}, said
    assert "another run is active here" in said[1]
    assert f"cleared what a killed run (process {first.pid} in {toy}) left" in said[0]
    assert not runs.jobs_of(own.mark)
    assert (toy / TABLE).read_text() == "a waits: wait\nb is good\n"
    assert not (toy / "results" / runs.CLAIM).exists()


def test_of_two_runs_from_two_folders_the_second_is_refused(
    toy: Path, tmp_path_factory: pytest.TempPathFactory, snakemake
) -> None:
    """With other words for the folder of results. A dry run is not refused, and neither touches
    anything."""
    (toy / "config/a.c3d").write_text("a waits: wait\n")
    other = tmp_path_factory.mktemp("other")
    for name in ("profiles", "config"):
        (other / name).symlink_to(toy / name)
    (other / "linked").symlink_to(toy / "results")
    entry = ("-s", str(toy / "Snakefile"), "--cores", "1", "linked/tables/g_noise.csv")
    second = lambda *how: snakemake(other, *entry, "--config", "results=linked", *how)  # noqa: E731
    first = start(toy)
    try:
        until((toy / "waiting").exists, first)
        part = toy / "results/.part-mine"
        part.write_text("mine")
        dry, refused = second("-n"), second()
        assert (dry.returncode, refused.returncode) == (0, 1), dry.stdout
        lines = [line for line in refused.stdout.splitlines() if "another run" in line]
        assert len(lines) == 1 and f"(process {first.pid} in {toy})" in lines[0], refused.stdout
        assert (toy / "results/recordings/a/noise.csv").read_text() == "half\n"
    finally:
        (toy / "go").touch()
        assert first.wait(900) == 0
    assert (toy / TABLE).read_text() == "a waits: wait\nb is good\n"
    assert part.read_text() == "mine"
    assert not (toy / "results" / runs.CLAIM).exists()


def test_a_killed_unlock_is_typed_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Else the lock would refuse every later run."""
    (tmp_path / "snakemake.py").write_text(
        "import os, pathlib\n"
        "if not pathlib.Path('done').exists():\n"
        "    pathlib.Path('done').touch()\n"
        "    os.kill(os.getpid(), 9)\n"
        "pathlib.Path('unlocked').touch()\n"
    )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    runs.unlock()
    assert (tmp_path / "unlocked").exists()


def test_unlocking_goes_on_where_its_run_is_killed(tmp_path: Path) -> None:
    """It writes, and what it writes to must not have gone with the run."""
    (tmp_path / "snakemake.py").write_text(
        "import os, pathlib, sys, time\n"
        "os.kill(os.getppid(), 9)\n"
        "time.sleep(0.5)\n"
        "print('words', file=sys.stderr, flush=True)\n"
        "pathlib.Path('unlocked').touch()\n"
    )
    paths = os.pathsep.join([str(tmp_path), str(Path(runs.__file__).parents[1])])
    dies = [sys.executable, "-c", "from mocap_workflow import runs; runs.unlock()"]
    subprocess.run(dies, cwd=tmp_path, env=environment() | {"PYTHONPATH": paths}, check=False)
    end = time.monotonic() + 60
    while not (tmp_path / "unlocked").exists():
        assert time.monotonic() < end
        time.sleep(0.05)
