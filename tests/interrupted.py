"""Interrupted work: after kills, full disks and damage a plain rerun gives the undisturbed results.

    make test-interrupted ARGS="--runs 30 --kills 7 --seed 1 --folder build/interrupted"

Each run works on its own copy of the inputs of small_run.py, without the papers' tables, so that a
run takes less than a minute. It is disturbed several times and then
typed again (`python workflow/run.py`, as `make` does) until nothing disturbs it. Its results are
compared, file by file and byte by byte, with those of a run without disturbance. Runs that are in
`outcomes.tsv` of the folder are not repeated, so a study can be continued; each has its own seed.
"""

import argparse
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import psutil
import small_run
from running import environment

ROOT = small_run.ROOT
COMMAND = [sys.executable, str(ROOT / "workflow/run.py"), "--workflow-profile"]
COMMAND += [str(ROOT / "profiles/ci"), "--cores", "2", *small_run.arguments()]
PAUSE_S = 0.05  # between two looks at a run
ENOUGH_S = 120  # for a second run to be refused
FILE_LIMIT = 60_000  # bytes: larger results cannot be written, as on a full disk
COLUMNS = ("run", "disturbances", "status", "missing", "different", "seconds")


def write_inputs(folder: Path) -> Path:
    """The inputs of small_run.py as groups of their own; returns the folder."""
    for sheet in small_run.write_inputs(folder).glob("*.tsv"):
        text = sheet.read_text(encoding="utf-8")
        sheet.write_text(re.sub("skurowski2019|jansen2019", "hall", text), encoding="utf-8")
    return folder


def start(folder: Path, limit: int | None = None) -> subprocess.Popen:
    """Type the command in a folder, in a session of its own."""

    def limited() -> None:
        if limit:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    with (folder / "output.txt").open("a") as output:
        return subprocess.Popen(
            COMMAND,
            **{"cwd": folder, "env": environment(), "stdin": subprocess.DEVNULL},
            **{"stdout": output, "stderr": output, "preexec_fn": limited},
            start_new_session=True,
        )


def jobs(run: subprocess.Popen) -> list[psutil.Process]:
    """Processes that a run has started."""
    with suppress(psutil.Error):
        return psutil.Process(run.pid).children(recursive=True)
    return []


def kill(processes: list[psutil.Process]) -> None:
    for process in processes:
        with suppress(psutil.Error):
            process.kill()


# Disturbances. Each gets a folder, a random state, and the longest time until it strikes, and
# returns whether the run still worked then.


def kill_snakemake(folder: Path, chance: random.Random, within_s: float) -> bool:
    """SIGKILL for Snakemake alone; its jobs work on."""
    run = start(folder)
    struck = works(run, chance.uniform(0, within_s))
    run.kill()
    run.wait()
    return struck


def kill_a_job(folder: Path, chance: random.Random, within_s: float) -> bool:
    """SIGKILL for one job; Snakemake ends by itself."""
    run = start(folder)
    works(run, chance.uniform(0, within_s))
    while run.poll() is None and not (working := jobs(run)):
        time.sleep(PAUSE_S)
    if struck := run.poll() is None:
        kill([chance.choice(working)])
    run.wait()
    return struck


def kill_all(folder: Path, chance: random.Random, within_s: float) -> bool:
    """SIGKILL for Snakemake and its jobs at once, as when the power fails."""
    run = start(folder)
    struck = works(run, chance.uniform(0, within_s))
    working = jobs(run)
    run.kill()
    kill(working)
    run.wait()
    return struck


def fill_disk(folder: Path, chance: random.Random, within_s: float) -> bool:
    """No large result can be written for a while."""
    run = start(folder, FILE_LIMIT)
    struck = works(run, chance.uniform(0, within_s))
    run.kill()
    run.wait()
    return struck


def start_twice(folder: Path, chance: random.Random, within_s: float) -> bool:
    """A second run of the same folder, or into its results from another one, is refused while the
    first works."""
    other = folder
    if chance.random() < 0.5:
        other = write_inputs(folder / "elsewhere")
        (folder / "results").mkdir(exist_ok=True)
        (other / "results").unlink(missing_ok=True)
        (other / "results").symlink_to(folder / "results")
    run = start(folder)
    struck = works(run, chance.uniform(0, within_s / 2))
    second = start(other)
    for _ in range(round(ENOUGH_S / PAUSE_S)):
        statuses = [one.poll() for one in (run, second)]
        if statuses != [None, None]:
            break
        time.sleep(PAUSE_S)
    assert statuses != [None, None], f"{folder}: two runs at once"
    works(run, chance.uniform(0, within_s / 2))
    for one in (run, second):
        one.send_signal(signal.SIGKILL)
        one.wait()
    return struck


def damage(folder: Path, chance: random.Random, within_s: float) -> bool:
    """A bit of one result is flipped, and half of the other results are deleted."""
    files = [path for path in (folder / "results").rglob("*") if path.is_file()]
    tables = [path for path in files if path.suffix in (".parquet", ".csv", ".json")]
    if not tables:
        return False
    for path in chance.sample(sorted(files), len(files) // 2):
        path.unlink()
    left = sorted(path for path in tables if path.is_file() and path.stat().st_size)
    if left:
        path = chance.choice(left)
        content = bytearray(path.read_bytes())
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        with path.open("r+b") as stream:  # the same file, as damage leaves its attributes
            stream.write(content)
    return True


DISTURBANCES: tuple[Callable[[Path, random.Random, float], bool], ...] = (
    *(kill_snakemake, kill_snakemake, kill_a_job, kill_a_job, kill_all),
    *(fill_disk, start_twice, damage),
)


def works(run: subprocess.Popen, seconds: float) -> bool:
    """Whether a run still works after so long."""
    with suppress(subprocess.TimeoutExpired):
        run.wait(seconds)
    return run.poll() is None


def to_the_end(folder: Path, most: int = 1) -> tuple[int, float]:
    """Status of the last of at most so many plain runs, and seconds of the last."""
    for _ in range(most):
        began = time.monotonic()
        run = start(folder)
        status = run.wait()
        seconds = time.monotonic() - began
        if status == 0:
            break
    return status, seconds


def outcome(folder: Path, reference: Path, kills: int, seed: str, lasts_s: float) -> list[object]:
    """Disturb a run `kills` times, let it end, and compare: a row of outcomes.tsv.

    All disturbances together take about as long as an undisturbed run, so that they strike at any
    part of the work; those that came after its end do not count.

    A damaged result that a job finds is removed by it, and the next run makes it anew: so the last
    plain run may be typed twice.
    """
    chance, done = random.Random(seed), []
    write_inputs(folder)
    for _ in range(kills):
        disturb = chance.choice(DISTURBANCES)
        if disturb(folder, chance, 3 * lasts_s / kills):
            done.append(disturb.__name__)
    status, seconds = to_the_end(folder, most=1 + done.count("damage"))
    lines = small_run.differences(reference / "results", folder / "results")
    missing = sum("missing" in line for line in lines)
    for line in lines:
        print(f"  {folder.name}: {line}", flush=True)
    names = ";".join(done)
    return [folder.name, names, status, missing, len(lines) - missing, round(seconds)]


def main() -> int:
    parser = argparse.ArgumentParser(prog="python tests/interrupted.py", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--runs", type=int, default=30)
    parser.add_argument("--kills", type=int, default=7, help="disturbances of each run")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--folder", type=Path, help="working folder; continued if it exists")
    given = parser.parse_args()
    folder = (given.folder or Path(tempfile.mkdtemp(prefix="interrupted-"))).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    table, reference = folder / "outcomes.tsv", write_inputs(folder / "reference")
    shutil.rmtree(reference / "results", ignore_errors=True)
    status, lasts_s = to_the_end(reference)
    assert status == 0, f"{reference}/output.txt"
    print(f"{folder}: an undisturbed run takes {lasts_s:.0f} s", flush=True)
    if not table.exists():
        table.write_text("\t".join(COLUMNS) + "\n")
    for k in range(given.runs):
        name = f"{given.seed}-{k}"
        if any(line.startswith(f"{name}\t") for line in table.read_text().splitlines()):
            continue
        shutil.rmtree(folder / name, ignore_errors=True)
        row = outcome(folder / name, reference, given.kills, name, lasts_s)
        with table.open("a") as stream:
            stream.write("\t".join(map(str, row)) + "\n")
        print(*row, flush=True)
    rows = [line.split("\t") for line in table.read_text().splitlines()[1:]]
    failed, missing, different = (sum(int(row[k] != "0") for row in rows) for k in (2, 3, 4))
    count = sum(len(row[1].split(";")) for row in rows)
    print(f"{len(rows)} runs, {count} disturbances; runs that failed: {failed},")
    print(f"with missing results: {missing}, with different results: {different}")
    return int(bool(failed or missing or different))


if __name__ == "__main__":
    sys.exit(main())
