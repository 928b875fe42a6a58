"""What a run of the workflow says to people: how far it is, what was refused, what failed, last.

A logger plugin of Snakemake: `logger: mocap` in a profile. What Snakemake says of its own work
(the plan of jobs, temporary files, its log) is in `.snakemake/log`; what a rule computes is in the
log of the rule. Dry-runs, `--verbose` and `--printshellcmds` show all, as Snakemake does.
"""

from __future__ import annotations

import os
import sys
import time
from logging import WARNING, LogRecord
from pathlib import Path

from snakemake_interface_logger_plugins.base import LogHandlerBase
from snakemake_interface_logger_plugins.common import LogEvent

from snakemake_logger_plugin_mocap.failures import why_failed
from snakemake_logger_plugin_mocap.progress import Bar, Display, Lines, Run, duration, jobs

LATER = "MOCAP_METROLOGY_REASONS_LATER"  # asks scripts to leave the reasons of failures to us
SAYS_WHY = ("gate",)  # rules that themselves say why they fail, as the last of all
INTERRUPTED = (
    "Terminating processes on user request",
    "Cancelling snakemake on user request",
)
NOTHING = "Nothing to be done"
OF_JOBS = ("At least one job did not complete", "Exiting because a job execution failed")
CHATTER = ("Building DAG of jobs", "Config file ", "host: ", "Using workflow specific profile")
PROCESS = "CalledProcessError"  # of a job, whose own log says why


class LogHandler(LogHandlerBase):
    """Progress while jobs run, then why any failed."""

    def __post_init__(self) -> None:
        settings = self.common_settings
        self._all = bool(
            settings.dryrun or settings.verbose or settings.printshellcmds or settings.debug_dag
        )
        self._stream = sys.stdout if settings.stdout else sys.stderr
        self._run = Run()
        self._shown: Display | None = None
        self._failed: list[str] = []
        self._said_why = self._interrupted = False
        self._unsaid: list[str] = []  # shown where no jobs are run, as with --lint or --unlock
        self._ended = ""  # how processes of jobs ended, as Snakemake says it
        if not self._all:
            os.environ[LATER] = "yes"

    def emit(self, record: LogRecord) -> None:
        """Take in what happened, and say what a person waits for."""
        if self._all:
            print(self.format(record), file=self._stream, flush=True)
            return
        try:
            self._take(record)
        except Exception:
            self.handleError(record)

    def _take(self, record: LogRecord) -> None:
        said = vars(record)
        match said.get("event"):
            case LogEvent.RUN_INFO:
                if self._shown is None:
                    self._unsaid.clear()
                    self._run.planned(said["stats"])
                    terminal = self._stream.isatty()
                    self._shown = (Bar if terminal else Lines)(self._run, self._stream)
                    self._say(f"{jobs(self._run.total)} to do")
                    self._shown.show()
            case LogEvent.JOB_INFO:
                what = said["rule_msg"] or said["rule_name"]
                self._run.started(said["jobid"], said["rule_name"], what)
                self._show()
            case LogEvent.JOB_FINISHED:
                self._run.ended(said["job_id"])
            case LogEvent.PROGRESS:
                self._run.progressed(said["done"], said["total"])
                self._show()
            case LogEvent.JOB_ERROR:
                self._job_failed(said)
            case LogEvent.ERROR | None:
                self._message(record)

    def _job_failed(self, said: dict[str, object]) -> None:
        rule, jobid, logs = str(said["rule_name"]), said["jobid"], said["log"]
        self._run.ended(int(str(jobid)))
        if rule in SAYS_WHY:
            self._said_why = True
            return
        log = Path(logs[0]) if isinstance(logs, list) and logs else None
        job = f"{rule} {log.stem}" if log and log.stem != rule else rule
        self._failed += why_failed(job, log, self._ended)

    def _message(self, record: LogRecord) -> None:
        """What Snakemake says in words: errors, but for those of jobs, which are said last."""
        text = record.getMessage()
        if any(start in text for start in INTERRUPTED):
            self._interrupted = True
        elif self._interrupted or any(start in text for start in OF_JOBS):
            pass
        elif PROCESS in text:
            self._ended = text
        elif text.startswith(NOTHING):
            self._say("Nothing to do: all results are up to date")
        elif record.levelno >= WARNING:
            self._unsaid.clear()
            self._say(text)
        elif not text.startswith(CHATTER):
            self._unsaid.append(text)

    def _say(self, text: str) -> None:
        if self._shown is None:
            print(text, file=self._stream, flush=True)
        else:
            self._shown.say(text)

    def _show(self) -> None:
        if self._shown is not None:
            self._shown.show()

    def close(self) -> None:
        """Say how it ended."""
        if self._shown is not None:
            self._shown.close()
            self._shown = None
            self._unsaid = self._last()
        for line in self._unsaid:
            self._say(line)
        self._unsaid = []
        super().close()

    def _last(self) -> list[str]:
        run = self._run
        if self._interrupted:
            return [f"Interrupted with {run.done} of {jobs(run.total)} done; the next run goes on"]
        if self._failed:
            return [*self._failed, f"{run.done} of {jobs(run.total)} done; what failed is above"]
        took = duration(time.monotonic() - run.began_s)
        return [] if self._said_why else [f"{jobs(run.done)} done in {took}"]

    @property
    def writes_to_stream(self) -> bool:
        """It takes the place of Snakemake's own lines."""
        return True

    @property
    def writes_to_file(self) -> bool:
        """Snakemake's own log is kept beside it."""
        return False

    @property
    def has_filter(self) -> bool:
        """Where all is shown, Snakemake's filter counts."""
        return not self._all

    @property
    def has_formatter(self) -> bool:
        """Where all is shown, it looks as Snakemake has it."""
        return not self._all

    @property
    def needs_rulegraph(self) -> bool:
        """It does not."""
        return False
