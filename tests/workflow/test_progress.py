"""What a run says to people: how far it is; why anything failed, once and last; Ctrl-C."""

import io
import logging
import os
import pty
import re
import select
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest
from mocap_workflow import runs
from running import environment
from snakemake_interface_logger_plugins.common import LogEvent

from snakemake_logger_plugin_mocap import LogHandler
from snakemake_logger_plugin_mocap.failures import why_failed
from snakemake_logger_plugin_mocap.progress import Lines, Run, duration


class Clock:
    """Seconds that pass when they are told to."""

    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


@pytest.fixture
def clock() -> Clock:
    return Clock()


def passed(run: Run, clock: Clock, rule: str, number: int, seconds: float) -> None:
    """A job that runs alone."""
    run.started(number, rule, f"{rule} {number}")
    clock.now_s += seconds
    run.ended(number)
    run.progressed(run.done + 1, run.total)


def test_time_left_is_that_of_the_rules_still_to_come(clock: Clock) -> None:
    """Ten long jobs after three short ones: at one job at a time 10 x 60 s, less what has run."""
    run = Run(clock)
    run.planned({"short": 4, "long": 11, "total": 15})
    assert run.left_s is None
    for number in range(3):
        passed(run, clock, "short", number, 2.0)
    assert run.left_s == pytest.approx(12 * 2.0)  # of the long ones nothing is known
    passed(run, clock, "long", 3, 60.0)
    assert run.left_s == pytest.approx(10 * 60 + 2)
    run.started(4, "long", "T40-10: noise")
    clock.now_s += 45
    assert run.left_s == pytest.approx(9 * 60 + 2 + 15)
    assert run.line() == "4 of 15 jobs done (26 %), about 9 min left; now T40-10: noise"


def test_two_jobs_at_once_take_half_the_time(clock: Clock) -> None:
    run = Run(clock)
    run.planned({"noise": 20, "total": 20})
    for pair in range(5):
        run.started(2 * pair, "noise", "a")
        run.started(2 * pair + 1, "noise", "b")
        clock.now_s += 10
        run.ended(2 * pair)
        run.ended(2 * pair + 1)
        run.progressed(2 * pair + 2, 20)
    assert run.left_s == pytest.approx(50)
    run.progressed(10, 40)  # a checkpoint has added twenty
    assert run.left_s == pytest.approx(150)


def test_durations_are_rounded_as_estimates_are() -> None:
    said = {3: "10 s", 44: "40 s", 89: "90 s", 100: "2 min", 540: "9 min", 5300: "88 min"}
    said |= {5460: "1 h 30 min", 7200: "2 h", 10_000: "2 h 50 min"}
    assert {seconds: duration(seconds) for seconds in said} == said


def test_lines_come_now_and_then_and_no_more_after_the_end(clock: Clock) -> None:
    stream, run = io.StringIO(), Run(clock)
    run.planned({"noise": 2, "total": 2})
    run.started(1, "noise", "T40-10: noise")
    lines = Lines(run, stream, 0.05, 0.1)
    lines.show()
    until = time.monotonic() + 20
    while stream.getvalue().count("\n") < 3 and time.monotonic() < until:
        time.sleep(0.01)
    lines.close()
    found = stream.getvalue().splitlines()
    assert len(found) >= 3
    pattern = r"\d\d:\d\d:\d\d 0 of 2 jobs done \(0 %\); now T40-10: noise"
    assert all(re.fullmatch(pattern, line) for line in found)
    time.sleep(0.3)
    assert stream.getvalue().splitlines() == found


@pytest.fixture
def handler(monkeypatch: pytest.MonkeyPatch) -> Callable[..., LogHandler]:
    monkeypatch.setenv("MOCAP_METROLOGY_REASONS_LATER", "")

    def made(**given: bool) -> LogHandler:
        names = ("dryrun", "verbose", "printshellcmds", "debug_dag", "stdout")
        return LogHandler(SimpleNamespace(**dict.fromkeys(names, False) | given), None)

    return made


def record(text: str | None = None, level: int = logging.INFO, **fields: object):
    made = logging.LogRecord("snakemake", level, "", 0, text, None, None)
    vars(made).update(fields)
    return made


PLAN = {"event": LogEvent.RUN_INFO, "stats": {"noise": 2, "total": 2}}
LOCKED = {"event": LogEvent.ERROR, "exception": "LockException"}
REMOVED, NOTHING = "Removing temporary output a.c3d.", "Nothing to be done (all are up to date)."


@pytest.mark.parametrize(
    ("given", "records", "said"),
    [
        ({}, [(REMOVED, {}), ("Job stats:", PLAN), ("unlock it", LOCKED)], ["2 jobs to do",
         "unlock it", "0 jobs done in 10 s"]),
        ({}, [(NOTHING, {})], ["Nothing to do: all results are up to date"]),
        ({}, [("Building DAG of jobs...", {}), ("Unlocked it.", {})], ["Unlocked it."]),
        ({"dryrun": True}, [(REMOVED, {})], [REMOVED]),
    ],
)  # fmt: skip
def test_of_what_snakemake_says_what_people_need(handler, capsys, given, records, said) -> None:
    own = handler(**given)
    assert (not own.has_formatter and not own.has_filter) or not given
    for text, fields in records:
        level = logging.ERROR if "exception" in fields else logging.INFO
        own.emit(record(text, level, **fields))
    own.close()
    assert capsys.readouterr().err.splitlines() == said


def test_a_job_that_was_killed_is_named_with_what_ended_it(handler, tmp_path: Path, capsys) -> None:
    own = handler()
    log = tmp_path / "A.log"
    log.write_text("12:00:00 INFO fitting\n")
    own.emit(record(event=LogEvent.RUN_INFO, stats={"noise": 1, "total": 1}))
    ended = "CalledProcessError in file x:\nCommand 'python y' died with <Signals.SIGKILL: 9>."
    own.emit(record(f"RuleException:\n{ended}", logging.ERROR, event=LogEvent.ERROR))
    fields = {"rule_name": "noise", "jobid": 1, "log": [str(log)]}
    own.emit(record("Error in rule noise", logging.ERROR, event=LogEvent.JOB_ERROR, **fields))
    own.close()
    assert capsys.readouterr().err.splitlines()[1:] == [
        "noise A ended: died with <Signals.SIGKILL: 9>: 12:00:00 INFO fitting",
        f"  log: {log}",
        "0 of 1 job done; what failed is above",
    ]


def test_a_crash_has_its_place_and_a_refusal_its_words(tmp_path: Path) -> None:
    log = tmp_path / "A.log"
    log.write_text("12:00:00 ERROR a.c3d: is empty\n")
    assert why_failed("check A", log) == ["check A: a.c3d: is empty"]
    trace = 'Traceback (most recent call last):\n  File "/x/fit.py", line 7, in fit\nValueError: no'
    log.write_text(f"12:00:00 ERROR ValueError: no (see {log})\n{trace}\n")
    crashed = ["fit A crashed: ValueError: no, in fit.py, line 7", f"  log: {log}"]
    assert why_failed("fit A", log) == crashed
    assert why_failed("fit A", tmp_path / "none.log")[0] == "fit A ended: without a message"


def test_ctrl_c_ends_all_in_one_line(root: Path, toy: Path) -> None:
    """Typed on a terminal, which sends it to the jobs, too."""
    (toy / "config/a.c3d").write_text("a waits: wait\n")
    process, terminal = pty.fork()
    if process == 0:
        os.chdir(toy)
        call = [sys.executable, str(root / "workflow/run.py"), "--cores", "2", "tables"]
        os.execve(call[0], call, environment())
    told, until = b"", time.monotonic() + 600
    typed = -1
    while time.monotonic() < until:
        if typed < 0 and (toy / "waiting").exists():
            typed = len(told)
            os.write(terminal, b"\x03")
        if select.select([terminal], [], [], 0.05)[0]:
            try:
                told += os.read(terminal, 65536)
            except OSError:
                break
    else:
        os.kill(process, signal.SIGKILL)
    _, status = os.waitpid(process, 0)
    assert os.waitstatus_to_exitcode(status) == -signal.SIGINT
    after = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]|\^C", "", told[typed:].decode())
    last = [line.rpartition("\r")[2].strip() for line in after.replace("\r\n", "\n").split("\n")]
    before = ("jobs done (", "jobs to do", "shared filesystem")  # may be on the way to the terminal
    said = [line for line in last if line and not any(words in line for words in before)]
    assert len(said) == 1 and said[0].startswith("Interrupted")
    assert "Traceback" not in told.decode()
    assert not (toy / "results" / runs.CLAIM).exists()
