"""One run at a time in a folder of results, and what a killed run left: its jobs, its lock, and
results that were not finished.

A run writes down who it is and removes this record when it ends: where the record stays and its
process is gone, the run was killed. There are two records. That of the folder of results refuses a
second run, from whatever folder it is started. That of the working folder is for Snakemake's lock,
a file there which outlives a killed run and refuses the next. Processes of another host are not
seen from here: there `snakemake --unlock` has the last word.
"""

from __future__ import annotations

import atexit
import base64
import contextlib
import fcntl
import json
import os
import shutil
import signal
import socket
import sys
import threading
import time
import uuid
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass
from functools import wraps
from pathlib import Path
from typing import Any, Protocol

import psutil

from mocap_metrology.common.errors import Damaged
from mocap_metrology.common.faults import Faults, stop
from mocap_metrology.common.files import RUN as MARK  # names the run in the environment of its jobs
from mocap_metrology.common.files import part_prefix, verify

RECORD = Path(".snakemake/run.json")  # in the working folder
CLAIM = ".run.json"  # in the folder of results
OWN_MARK = uuid.uuid4().hex
CLAIMED: set[Path] = set()  # records of this process in folders of results
PLACE = "MOCAP_METROLOGY_RECORD"  # path of the record, whatever folder Snakemake works in
SAME_S = 2.0  # what two readings of the start of one process may differ by, as the clock is set
HEARD = threading.Event()  # Ctrl-C
PATIENCE_S = 10.0  # for a job to end after the signal


@dataclass(frozen=True)
class Run:
    """Host and process of a run, when that began (s since 1970), the mark of its jobs, and its
    working folder."""

    host: str
    pid: int
    began_s: float
    mark: str
    folder: str

    def here(self) -> bool:
        return self.host == socket.gethostname()

    def alive(self) -> bool:
        """Whether its process, and no later one of the same number, works on this host."""
        with contextlib.suppress(psutil.Error):
            process = psutil.Process(self.pid)
            same = abs(process.create_time() - self.began_s) < SAME_S
            return bool(self.here() and same and process.status() != psutil.STATUS_ZOMBIE)
        return False

    def jobs(self) -> list[psutil.Process]:
        """Processes that carry its mark."""
        found = []
        for process in psutil.process_iter():
            with contextlib.suppress(psutil.Error):  # it ended, or is another user's
                if process.environ().get(MARK) == self.mark:
                    found.append(process)
        return found


def read(record: Path = RECORD) -> Run | None:
    """The run that a folder was left with; None where the last one ended, or what is there is no
    record."""
    try:
        return Run(**json.loads(record.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def began(record: Path = RECORD) -> None:
    """Record this process, and mark the jobs that it will start; a run that is alive stays."""
    other = read(record)
    if other is not None and other.alive():
        return
    os.environ[PLACE] = str(record.absolute())
    _write(record)
    ends_with_process(record)


def _write(record: Path) -> None:
    """Record this process, and mark the jobs that it will start."""
    process, host = psutil.Process(), socket.gethostname()
    run = Run(host, process.pid, process.create_time(), OWN_MARK, str(Path.cwd()))
    os.environ[MARK] = run.mark
    record.parent.mkdir(parents=True, exist_ok=True)
    part = record.with_suffix(f".{run.pid}")
    part.write_text(json.dumps(asdict(run)), encoding="utf-8")
    part.replace(record)


def ends_with_process(record: Path = RECORD) -> None:
    """Remove the record when this process, if it is the one of the record, ends by itself."""
    for path in {record.absolute(), Path(os.environ.get(PLACE, record)).absolute()}:
        atexit.register(ended, path)


def ended(record: Path = RECORD) -> None:
    """Remove the record of this process."""
    run = read(record)
    if run is not None and run.here() and run.pid == os.getpid():
        record.unlink(missing_ok=True)


@contextlib.contextmanager
def alone(record: Path = RECORD) -> Iterator[None]:
    """One process at a time: two that were started at once would both clear what a killed run
    left, the later one the lock and the record of the earlier."""
    with contextlib.ExitStack() as held:
        with contextlib.suppress(OSError):  # read-only, or a file system without locks
            record.parent.mkdir(parents=True, exist_ok=True)
            folder = os.open(record.parent, os.O_RDONLY)
            held.callback(os.close, folder)
            fcntl.flock(folder, fcntl.LOCK_EX)
        yield


def clear(unlock: Callable[[], bool], record: Path = RECORD) -> None:
    """End the jobs of a killed run of this host and clear its lock by `unlock` (True if it did);
    `Faults` if the run is alive, or if its lock stays: without its record the lock would refuse
    every later run. Messages are written to stderr."""
    run, folder = read(record), record.resolve().parents[1]
    if run is None:
        return
    process = f"process {run.pid}"
    if run.alive():
        raise Faults([f"{folder}: another run is active here ({process}); expected none"])
    if not run.here():
        print(
            f"{folder}: a run of host {run.host} ({process}) is active here or was killed; if "
            "Snakemake reports a lock and no run is active: snakemake --unlock",
            file=sys.stderr,
        )
        return
    jobs = _end(run)
    if not unlock():
        raise Faults([f"{folder}: the lock of the last run ({process}) stays; run make again"])
    record.unlink(missing_ok=True)
    ending = f"; {len(jobs)} processes of it were ended" if jobs else ""
    print(f"{folder}: cleared what the last run ({process}) left{ending}", file=sys.stderr)


def _end(run: Run) -> list[psutil.Process]:
    """End the jobs of a run; which they were."""
    jobs = run.jobs()
    for job in jobs:
        with contextlib.suppress(psutil.Error):
            job.terminate()
    for job in psutil.wait_procs(jobs, PATIENCE_S)[1]:
        with contextlib.suppress(psutil.Error):
            job.kill()
    psutil.wait_procs(jobs, PATIENCE_S)
    return jobs


def clear_damaged(checks: Iterable[Path]) -> None:
    """Remove damaged ones of the files that Snakemake's graph depends on; they are made anew."""
    for path in checks:
        try:
            verify(path)
        except Damaged as damaged:
            path.unlink(missing_ok=True)
            print(f"{path} is damaged: {damaged.what}; it is made anew", file=sys.stderr)


class Workflow(Protocol):
    """What is touched of Snakemake's."""

    execute: Callable[..., Any]
    delete_output: Callable[..., Any]
    unlock: Callable[..., Any]
    output_settings: Any

    @property
    def is_main_process(self) -> bool: ...


def claims(workflow: Workflow, results: Path) -> None:
    """Have Snakemake claim the folder of results before it plans what it will do there, and before
    `--unlock` and `--delete-all-output`. A dry run, a job and what only shows something
    (`--summary`, `--report`) claim and clear nothing."""

    def claimed(action: Callable[..., Any], unlocks: bool) -> Callable[..., Any]:
        @wraps(action)
        def act(*args: Any, **kwargs: Any) -> Any:
            if workflow.is_main_process and not workflow.output_settings.dryrun:
                try:
                    claim(results, unlocks)
                except Faults as faults:
                    stop(faults)
                clear_damaged(results.glob("*/*/check.json"))
            return action(*args, **kwargs)

        return act

    workflow.execute = claimed(workflow.execute, unlocks=False)
    workflow.delete_output = claimed(workflow.delete_output, unlocks=False)
    workflow.unlock = claimed(workflow.unlock, unlocks=True)


def claim(results: Path, unlocks: bool = False) -> None:
    """Record that this process alone writes to `results`, and clear what a killed run left there;
    `Faults`, and nothing is touched, if another run is active there or may be. `unlocks`: the user
    states that no run of another host is."""
    record, new = results.absolute() / CLAIM, not results.exists()
    with alone(record):
        other = read(record)
        if other is not None and other.pid == os.getpid() and other.alive():
            return
        if other is not None:
            _expect_dead(results, other, unlocks)
            _end(other)
        left = clear_unfinished(results, other)
        with contextlib.suppress(OSError):  # read-only: Snakemake will report it
            _write(record)
            CLAIMED.add(record)
            atexit.register(_leave, record, new)
    if other is not None and left:
        words = f"cleared what a killed run (process {other.pid} in {other.folder}) left"
        print(f"{results}: {words}", file=sys.stderr)


def _expect_dead(results: Path, other: Run, unlocks: bool) -> None:
    who = f"process {other.pid} in {other.folder}"
    if other.alive():
        raise Faults([f"{results}: another run is active here ({who}); expected none"])
    if not (other.here() or unlocks):
        what = f"a run of host {other.host} ({who}) is active here or was killed"
        raise Faults([f"{results}: {what}; expected none; if it was killed: snakemake --unlock"])


def _leave(record: Path, new: bool) -> None:
    """Remove the record of this process, and the folder if it is new and nothing was written."""
    ended(record)
    with contextlib.suppress(OSError):
        if new:
            record.parent.rmdir()


def clear_unfinished(results: Path, dead: Run | None = None) -> list[Path]:
    """Remove what jobs of a killed run were about to write; returns what is absent now.

    That is what Snakemake has marked as unfinished, in this working folder and in that of the
    `dead` run, and the `.part-*` files that bear the mark of that run.

    Call it before Snakemake builds its graph. Snakemake looks for the marks of unfinished jobs when
    it has built the graph for the first time, and then lacks all jobs behind a checkpoint: their
    results would pass for finished. Where the marks lie is a private part of Snakemake (9.27: the
    folder `incomplete`, the path in base64). Marks in a folder that is locked stay, as jobs may be
    at work.
    """
    unfinished: list[Path] = []
    folders = {Path.cwd(), *([Path(dead.folder)] if dead else [])}
    with contextlib.suppress(OSError):  # read-only: Snakemake will report it
        for folder in folders:
            if not _at_rest(folder, dead):
                continue
            marks = folder / RECORD.parent / "incomplete"
            for mark in _files(marks):
                path = _marked(mark.relative_to(marks))
                if path is not None and results.resolve() in (folder / path).resolve().parents:
                    unfinished.append(folder / path)
                    _remove(folder / path)
                    mark.unlink()
        for part in results.rglob(f"{part_prefix(dead.mark)}*") if dead else ():
            unfinished.append(part)
            _remove(part)
    return unfinished


def _at_rest(folder: Path, dead: Run | None) -> bool:
    """Whether no run is at work in a working folder, besides one that is known to be dead."""
    run, locks = read(folder / RECORD), folder / RECORD.parent / "locks"
    if run is not None and run.pid != os.getpid():
        return run == dead or (run.here() and not run.alive())
    return not (locks.is_dir() and any(locks.iterdir()))


def _files(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.is_file()]


def _marked(mark: Path) -> Path | None:
    """The result that a mark stands for: base64, cut into folders `@...` where it is long."""
    text = "".join([*(part.removeprefix("@") for part in mark.parts[:-1]), mark.name])
    try:
        return Path(base64.urlsafe_b64decode(text).decode())
    except ValueError:
        return None


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def ends_at_interrupt(record: Path = RECORD) -> None:
    """Have Ctrl-C end this run and its jobs without a traceback of any.

    A terminal sends it to all of them. What is blocked (before any thread is started) is blocked in
    jobs too, so a thread alone hears it: it raises KeyboardInterrupt in the main thread, by a
    signal that jobs do not get, and ends the jobs.
    """
    signal.signal(signal.SIGUSR1, signal.default_int_handler)
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    threading.Thread(target=_interrupted, args=(record,), daemon=True).start()


def _interrupted(record: Path) -> None:
    signal.sigwait({signal.SIGINT})
    HEARD.set()
    os.kill(os.getpid(), signal.SIGUSR1)
    while True:  # until this process has ended, as jobs may just have been started
        run = read(Path(os.environ.get(PLACE, record)))
        if run is not None:
            _end(run)
        time.sleep(0.2)


def ends_as_interrupted(record: Path = RECORD) -> None:
    """End by Ctrl-C, if it was that: what called this run, a shell or make, then ends too."""
    if HEARD.is_set():
        for path in {record.absolute(), Path(os.environ.get(PLACE, record)).absolute(), *CLAIMED}:
            ended(path)
        sys.stdout.flush()
        sys.stderr.flush()
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        os.kill(os.getpid(), signal.SIGINT)


class Scheduler(Protocol):
    """What is touched of Snakemake's."""

    job_rate_limiter: object


def without_rate_limit(scheduler: Scheduler) -> None:
    """Remove the limit of submissions a second of Snakemake's scheduler; `jobs` of a profile still
    limits how many there are.

    The one private part of Snakemake that is used. Version 9.27 has no option for it. For the limit
    it starts another timer at every look at the queue, each of which has the queue looked at again:
    in `make`, by the 410th of 556 jobs, 400 CPU s at `max-jobs-per-timespan: 100/2s` (twice as many
    looks at the default 100/1s), 14 % of what the whole takes without.
    """
    scheduler.job_rate_limiter = None
