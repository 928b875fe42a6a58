"""One run at a time in a folder of results, and what a killed run left: its jobs, its lock, and
results that were not finished.

A run writes down in the folder of results who it is, and beside the lock of Snakemake, which stays
where results are deleted; it removes both records when it ends. Where one stays and its process is
gone, the run was killed. Processes of another host are not seen from here: there `snakemake
--unlock` has the last word.
"""

from __future__ import annotations

import atexit
import base64
import contextlib
import hashlib
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import uuid
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from functools import wraps
from pathlib import Path
from typing import Any

import psutil

from mocap_metrology.common.errors import Damaged
from mocap_metrology.common.faults import Faults, stop
from mocap_metrology.common.files import RUN as MARK  # names the run in the environment of its jobs
from mocap_metrology.common.files import part_prefix, verify
from mocap_metrology.common.paths import locked

CLAIM = ".run.json"  # in the folder of results
OWN_MARK = uuid.uuid4().hex
CLAIMED: set[Path] = set()  # records of this process
SAME_S = 2.0  # what two readings of the start of one process may differ by, as the clock is set
HEARD = threading.Event()  # Ctrl-C
TRIES = 3
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


def _second(record: Path, folder: Path) -> Path:
    """Where the record stands in the working folder, too."""
    name = hashlib.sha256(os.fsencode(record.resolve())).hexdigest()
    return folder / f".snakemake/run-{name[:16]}.json"


def read(record: Path) -> Run | None:
    """The run that a folder was left with; None where the last one ended, or what is there is no
    record."""
    try:
        return Run(**json.loads(record.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError):
        return None


def jobs_of(mark: str) -> list[psutil.Process]:
    """Processes that carry the mark of a run."""
    jobs = []
    for process in psutil.process_iter():
        with contextlib.suppress(psutil.Error):  # it ended, or is another user's
            if process.environ().get(MARK) == mark and process.pid != os.getpid():
                jobs.append(process)
    return jobs


def end_jobs(mark: str) -> None:
    """End the jobs of a run."""
    jobs = jobs_of(mark)
    for job in jobs:
        with contextlib.suppress(psutil.Error):
            job.terminate()
    for job in psutil.wait_procs(jobs, PATIENCE_S)[1]:
        with contextlib.suppress(psutil.Error):
            job.kill()
    psutil.wait_procs(jobs, PATIENCE_S)


def claims(workflow: Any, results: Path, beside: Callable[[Path], Iterable[str]]) -> None:
    """Have Snakemake claim the folder of results before it plans what it will do there, and before
    `--unlock` and `--delete-all-output`. A dry run, a job and what only shows something
    (`--summary`, `--report`) claim and clear nothing. workflow: Snakemake's."""

    def claimed(action: Callable[..., Any], unlocks: bool) -> Callable[..., Any]:
        @wraps(action)
        def act(*args: Any, **kwargs: Any) -> Any:
            if workflow.is_main_process and not workflow.output_settings.dryrun:
                try:
                    if claim(results, unlocks) and not unlocks:
                        unlock()
                except Faults as faults:
                    stop(faults)
                clear_damaged(results, beside)
            return action(*args, **kwargs)

        return act

    workflow.execute = claimed(workflow.execute, unlocks=False)
    workflow.delete_output = claimed(workflow.delete_output, unlocks=False)
    workflow.unlock = claimed(workflow.unlock, unlocks=True)


def claim(results: Path, unlocks: bool = False) -> bool:
    """Record that this process alone writes to `results`, and clear what a killed run left there;
    whether there was one. `Faults`, and nothing is touched, if another run is active there or may
    be. unlocks: the user states that no run of another host is."""
    record, new = results.absolute() / CLAIM, not results.exists()
    with locked(record.parent):  # as two may start at once after a kill
        other = read(record) or read(_second(record, Path.cwd()))
        if other is not None and other.mark == os.environ.get(MARK) and other.alive():
            return False  # this run, or its call of `snakemake --unlock`
        if other is not None:
            _expect_dead(results, other, unlocks)
            end_jobs(other.mark)
            clear_unfinished(results, other)
        with contextlib.suppress(OSError):  # read-only: Snakemake will report it
            _write(record)
            CLAIMED.add(record)
            atexit.register(_leave, record, new)
    if other is not None:
        words = f"cleared what a killed run (process {other.pid} in {other.folder}) left"
        print(f"{results}: {words}", file=sys.stderr)
    return other is not None


def _expect_dead(results: Path, other: Run, unlocks: bool) -> None:
    who = f"process {other.pid} in {other.folder}"
    if other.alive():
        raise Faults([f"{results}: another run is active here ({who}); expected none"])
    if not (other.here() or unlocks):
        what = f"a run of host {other.host} ({who}) is active here or was killed"
        raise Faults([f"{results}: {what}; expected none; if it was killed: snakemake --unlock"])


def _write(record: Path) -> None:
    """Record this process, and mark the jobs that it will start."""
    process, host = psutil.Process(), socket.gethostname()
    run = Run(host, process.pid, process.create_time(), OWN_MARK, str(Path.cwd()))
    os.environ[MARK] = run.mark
    for path in (record, _second(record, Path.cwd())):
        path.parent.mkdir(exist_ok=True)
        part = path.with_suffix(f".{run.pid}")
        part.write_text(json.dumps(asdict(run)), encoding="utf-8")
        part.replace(path)


def ended(record: Path) -> None:
    """Remove the records of this process."""
    for path in (record, _second(record, Path.cwd())):
        run = read(path)
        if run is not None and run.here() and run.pid == os.getpid():
            path.unlink(missing_ok=True)


def _leave(record: Path, new: bool) -> None:
    """Remove the record of this process, and the folder if it is new and nothing was written."""
    ended(record)
    with contextlib.suppress(OSError):
        if new:
            record.parent.rmdir()


def unlock() -> None:
    """Have Snakemake clear the lock of a killed run, which would refuse this one and all later."""
    command = [sys.executable, "-m", "snakemake", "--unlock", *sys.argv[1:]]
    with tempfile.TemporaryFile("w+") as words:  # no pipe, which would break if this run is killed
        for _ in range(TRIES):  # it may be killed itself
            done = subprocess.run(command, stdout=words, stderr=words, check=False)
            if done.returncode >= 0:
                break
        if done.returncode:
            words.seek(0)
            sys.stderr.write(words.read())


def clear_unfinished(results: Path, dead: Run) -> None:
    """Remove what jobs of a killed run were about to write: what Snakemake has marked as
    unfinished in its working folder, and the `.part-*` files that bear its mark.

    `--rerun-incomplete` is not enough: Snakemake looks for the marks of unfinished jobs when it has
    built the graph for the first time, and then lacks all jobs behind a checkpoint: their results
    would pass for finished. Where the marks lie is a private part of Snakemake (9.27: the folder
    `incomplete`, the path in base64, cut into folders `@...` where it is long).
    """
    folder = Path(dead.folder)
    marks = folder / ".snakemake/incomplete"
    with contextlib.suppress(OSError):  # read-only: Snakemake will report it
        for mark in [path for path in marks.rglob("*") if path.is_file()]:
            text = "".join(part.removeprefix("@") for part in mark.relative_to(marks).parts)
            try:
                path = folder / base64.urlsafe_b64decode(text).decode()
            except ValueError:
                continue
            if results.resolve() in path.resolve().parents:
                _remove(path)
                mark.unlink()
        for part in results.rglob(f"{part_prefix(dead.mark)}*"):
            _remove(part)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def clear_damaged(results: Path, beside: Callable[[Path], Iterable[str]]) -> None:
    """Remove checks, on which Snakemake's graph depends, that are damaged, or `beside` which one of
    these files of the same job is missing; they are made anew.

    Else Snakemake (9.27) makes nothing that waits for such a check, and ends as if all were there.
    """
    for path in results.glob("*/*/check.json"):
        lost = [name for name in beside(path) if not (path.parent / name).exists()]
        try:
            verify(path)
            if lost:
                path.unlink()
                print(f"{path.parent / lost[0]} is missing; it is made anew", file=sys.stderr)
        except Damaged as damaged:
            path.unlink(missing_ok=True)
            print(f"{path} is damaged: {damaged.what}; it is made anew", file=sys.stderr)


def ends_at_interrupt() -> None:
    """Have Ctrl-C end this run and its jobs without a traceback of any.

    A terminal sends it to all of them. What is blocked (before any thread is started) is blocked in
    jobs too, so a thread alone hears it: it raises KeyboardInterrupt in the main thread, by a
    signal that jobs do not get, and ends the jobs.
    """
    signal.signal(signal.SIGUSR1, signal.default_int_handler)
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    threading.Thread(target=_interrupted, daemon=True).start()


def _interrupted() -> None:
    signal.sigwait({signal.SIGINT})
    HEARD.set()
    os.kill(os.getpid(), signal.SIGUSR1)
    while True:  # until this process has ended, as jobs may just have been started
        end_jobs(OWN_MARK)
        time.sleep(0.2)


def ends_as_interrupted() -> None:
    """End by Ctrl-C, if it was that: what called this run, a shell or make, then ends too."""
    if HEARD.is_set():
        for path in CLAIMED:
            ended(path)
        sys.stdout.flush()
        sys.stderr.flush()
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        os.kill(os.getpid(), signal.SIGINT)


def without_rate_limit(scheduler: Any) -> None:
    """Remove the limit of submissions a second of Snakemake's scheduler; `jobs` of a profile still
    limits how many there are.

    Version 9.27 has no option for it. For the limit it starts another timer at every look at the
    queue, each of which has the queue looked at again: 14 % of the time of `make`.
    """
    scheduler.job_rate_limiter = None
