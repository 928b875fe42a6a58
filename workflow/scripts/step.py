"""What every script does around its work: a log, one thread, failures in one line, its cost.

    from step import step

    with step(snakemake) as log:
        from mocap_metrology.common import hampel
        log.info("cleaning")

Import what is heavy inside, so that its failures reach the log too. Information goes to the log,
warnings and errors to the log and the terminal, and so do results (RESULT). The reason
of a failure is written to the log alone if the run reports it at the end.
"""

from __future__ import annotations

import gc
import logging
import os
import resource
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

RESULT = logging.INFO + 5
LATER = "MOCAP_METROLOGY_REASONS_LATER"  # set by a run that itself reports why steps fail
OF_THE_END = {"of_the_end": True}  # of what the run itself reports
CLEARED = "\r\x1b[K"  # clears the progress bar, on a terminal

signal.signal(signal.SIGINT, signal.SIG_DFL)  # Ctrl-C ends a job without a traceback
if FORKS := os.environ.pop("MOCAP_METROLOGY_FORKS", ""):  # set by a run, see forks.py
    from mocap_workflow import forks

    forks.hand_over(FORKS)
KIBIBYTE = 1 if sys.platform == "linux" else 1024  # in units of the peak of memory
gc.set_threshold(100_000, 50, 100)  # a step ends before there is much to collect
logging.addLevelName(RESULT, "RESULT")

# One thread, so that no result depends on --cores; read by the libraries when they are imported.
for _pool in ("OMP", "OPENBLAS", "MKL", "NUMEXPR", "VECLIB_MAXIMUM", "NUMBA"):
    os.environ[f"{_pool}_NUM_THREADS"] = "1"


def refusal_of(error: Exception, snakemake: Any, folder: Path) -> Exception:
    """What check.json states of a row whose check failed, also logged: a `Refusal` as it is; of an
    unforeseen exception a refusal that names the log with its traceback, so that the other rows go
    on. What the computer lacks (memory, disk) is no fault of the row and is raised again. folder:
    of results, where those of an earlier input are removed."""
    from mocap_metrology.common.errors import Refusal, one_line
    from mocap_metrology.common.files import empty_folder

    log = logging.getLogger("mocap_metrology")
    if not isinstance(error, Refusal):
        if isinstance(error, MemoryError | OSError):
            raise error
        log.error("unforeseen", exc_info=error, extra=OF_THE_END)
        what = one_line(f"{type(error).__name__}: {error}")
        error = Refusal(f"its check crashed: {what} (traceback: {snakemake.log[0]})")
    log.info("%s", error)
    empty_folder(folder)
    return error


@contextmanager
def step(snakemake: Any, prefix: str | None = None) -> Iterator[logging.Logger]:
    """Send all output to the rule's log; end a refusal or a crash with one line and status 1.

    An input of the results that is damaged is removed first, so that a plain run makes it anew: the
    rule that made it can, and jobs that read it now fail as this one does.

    `prefix` begins each line on the terminal, by default the rule and its wildcards.
    """
    from mocap_metrology.common.errors import Damaged, Refusal, is_full, one_line
    from mocap_metrology.common.files import verify

    began_s = time.perf_counter()
    results = Path(snakemake.config["results"])
    path = Path(snakemake.log[0])
    path.parent.mkdir(parents=True, exist_ok=True)
    with _redirected(path) as terminal:
        log = _logger(terminal, _job(snakemake) if prefix is None else prefix)
        try:
            for read in snakemake.input:
                if _inside(read, results):
                    verify(read)
            yield log
            cost = results / "benchmarks" / path.relative_to(results / "logs")
            _write_cost(cost.with_suffix(".tsv"), time.perf_counter() - began_s)
        except Damaged as damaged:
            remedy = "delete it and"
            if _inside(damaged.path, results):  # and no recording of a user
                damaged.path.unlink(missing_ok=True)
                remedy = "it was removed;"
            words = f"{damaged.path} is damaged: {damaged.what}; {remedy} run again to make it anew"
            log.error("%s", words, extra=OF_THE_END)
            sys.exit(1)
        except Refusal as refusal:
            log.error("%s", refusal, extra=OF_THE_END)
            sys.exit(1)
        except Exception as error:
            if is_full(error):
                words = f"{error.strerror}; free some there, then run again"
                log.error("%s: %s", results, words, extra=OF_THE_END)
                sys.exit(1)
            what = one_line(f"{type(error).__name__}: {error}")
            log.error("%s (see %s)", what, path, exc_info=True, extra=OF_THE_END)
            sys.exit(1)


def _write_cost(path: Path, time_s: float) -> None:
    """Time, peak of memory (MB) and CPU time (s) of this job. Snakemake's own `benchmark` looks
    at a job twice a second, which takes a twentieth of a run, and sees nothing of a short one."""
    from mocap_metrology.common.files import write_text

    used = resource.getrusage(resource.RUSAGE_SELF)
    megabytes = used.ru_maxrss / KIBIBYTE / 1024
    cost = time_s, megabytes, used.ru_utime + used.ru_stime
    values = "\t".join(f"{value:.2f}" for value in cost)
    write_text(path, f"s\tmax_rss\tcpu_time\n{values}\n")


def _inside(path: str | Path, folder: Path) -> bool:
    return Path(path).resolve().is_relative_to(folder.resolve())


def _job(snakemake: Any) -> str:
    return " ".join((snakemake.rule, *map(str, dict(snakemake.wildcards.items()).values()))) + ": "


class _OneLine(logging.Formatter):
    """A line for the terminal: no time, no traceback."""

    def __init__(self, prefix: str, before: str):
        super().__init__()
        self.prefix, self.before = prefix, before

    def format(self, record: logging.LogRecord) -> str:
        from mocap_metrology.common.errors import one_line

        warning = "warning: " if record.levelno == logging.WARNING else ""
        return f"{self.before}{warning}{self.prefix}{one_line(record.getMessage())}"


def _logger(terminal: int, prefix: str) -> logging.Logger:
    log = logging.getLogger("mocap_metrology")
    to_file = logging.StreamHandler()  # sys.stderr, by now the log
    to_file.setFormatter(logging.Formatter("%(asctime)s %(levelname)s %(message)s", "%H:%M:%S"))
    to_terminal = logging.StreamHandler(os.fdopen(terminal, "w", encoding="utf-8", closefd=False))
    to_terminal.setLevel(RESULT)
    to_terminal.setFormatter(_OneLine(prefix, CLEARED if os.isatty(terminal) else ""))
    if os.environ.get(LATER):
        to_terminal.addFilter(lambda record: not hasattr(record, "of_the_end"))
    log.handlers = [to_file, to_terminal]
    log.setLevel(logging.INFO)
    log.propagate = False
    return log


@contextmanager
def _redirected(path: Path) -> Iterator[int]:
    """Point file descriptors 1 and 2 at the log, so that C libraries' lines land there too."""
    sys.stdout.flush()
    sys.stderr.flush()
    saved = os.dup(1), os.dup(2)
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND, 0o666)
    os.dup2(handle, 1)
    os.dup2(handle, 2)
    os.close(handle)
    try:
        yield saved[1]
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        for number, old in enumerate(saved, start=1):
            os.dup2(old, number)
            os.close(old)
