"""How far a run is, and how long it will still take: a bar on a terminal, else a line at times."""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Protocol, TextIO

FIRST_S, EVERY_S = 10.0, 30.0  # of the lines
LEAST_JOBS, LEAST_S = 3, 5.0  # done, before the time that is left is estimated
SHOWN = 2  # running jobs


class Run:
    """Jobs that are done, run, or are to come, and how long each rule takes.

    `clock` gives seconds from any start.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self.clock = clock
        self.began_s = clock()
        self.done = self.total = 0
        self._to_come: Counter[str] = Counter()
        self._running: dict[int, tuple[str, str, float]] = {}  # rule, what it does, since when
        self._took: dict[str, list[float]] = {}

    def planned(self, jobs: Mapping[str, int]) -> None:
        """Jobs by rule; `total` among them."""
        self.began_s = self.clock()
        self._to_come = Counter({rule: n for rule, n in jobs.items() if rule != "total"})
        self.total = self._to_come.total()

    def started(self, job: int, rule: str, what: str) -> None:
        self._running[job] = rule, what, self.clock()
        self._to_come[rule] = max(self._to_come[rule] - 1, 0)

    def ended(self, job: int) -> None:
        """A job is done, or failed."""
        if job in self._running:
            rule, _, since = self._running.pop(job)
            self._took.setdefault(rule, []).append(self.clock() - since)

    def progressed(self, done: int, total: int) -> None:
        """Jobs done out of all; a checkpoint may add some."""
        self.done, self.total = done, total

    @property
    def doing(self) -> str:
        """What runs, the longest first."""
        running = sorted(self._running.values(), key=lambda one: one[2])
        shown = [what for _, what, _ in running[:SHOWN]]
        return ", ".join([*shown, f"{len(running) - SHOWN} more"] if running[SHOWN:] else shown)

    @property
    def left_s(self) -> float | None:
        """Time that is left: work to come, at the pace of the work that is done.

        A job counts as long as its rule took on average so far, or as all jobs did where none of
        its rule has ended. None until enough is done.
        """
        now = self.clock()
        ended = [s for times in self._took.values() for s in times]
        if len(ended) < LEAST_JOBS or now - self.began_s < LEAST_S:
            return None
        mean = sum(ended) / len(ended)
        means = {rule: sum(times) / len(times) for rule, times in self._took.items()}
        running = list(self._running.values())
        so_far = [now - since for _, _, since in running]
        whole = [means.get(rule, mean) for rule, _, _ in running]
        rest = [max(all_of_it - s, 0.0) for all_of_it, s in zip(whole, so_far, strict=True)]
        known = sum(n * means.get(rule, mean) for rule, n in self._to_come.items())
        more = max(self.total - self.done - len(running) - self._to_come.total(), 0)
        pace = (sum(ended) + sum(so_far)) / (now - self.began_s)
        return (known + more * mean + sum(rest)) / pace if pace > 0 else None

    def line(self) -> str:
        """`120 of 556 jobs done (22 %), about 9 min left: T40-10: noise model`."""
        share = f" ({100 * self.done // self.total} %)" if self.total else ""
        left = "" if self.left_s is None else f", about {duration(self.left_s)} left"
        doing = f"; now {self.doing}" if self.doing else ""
        return f"{self.done} of {jobs(self.total)} done{share}{left}{doing}"


def jobs(number: int) -> str:
    """`1 job`, `556 jobs`."""
    return f"{number} job{'' if number == 1 else 's'}"


def duration(seconds: float) -> str:
    """`40 s`, `9 min`, `1 h 20 min`; rounded as an estimate is."""
    if seconds < 90:
        return f"{max(round(seconds / 10), 1) * 10} s"
    minutes = round(seconds / 60)
    if minutes < 90:
        return f"{minutes} min"
    minutes = round(minutes, -1)
    return f"{minutes // 60} h {minutes % 60} min" if minutes % 60 else f"{minutes // 60} h"


class Display(Protocol):
    """Shows a run."""

    def show(self) -> None: ...
    def say(self, text: str) -> None: ...
    def close(self) -> None: ...


class Lines:
    """A line after ten seconds and then every half minute, while jobs run."""

    def __init__(
        self, run: Run, stream: TextIO, first_s: float = FIRST_S, every_s: float = EVERY_S
    ):
        self._run, self._stream = run, stream
        self._over = threading.Event()
        self._thread: threading.Thread | None = None
        self._pauses = first_s, every_s

    def show(self) -> None:
        """Begin, unless it has begun."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._write, daemon=True)
            self._thread.start()

    def _write(self) -> None:
        first, every = self._pauses
        pause = first
        while not self._over.wait(pause):
            self.say(f"{time.strftime('%H:%M:%S')} {self._run.line()}")
            pause = every

    def say(self, text: str) -> None:
        print(text, file=self._stream, flush=True)

    def close(self) -> None:
        self._over.set()
        if self._thread is not None:
            self._thread.join()


class Bar:
    """One line on a terminal that is drawn anew."""

    def __init__(self, run: Run, stream: TextIO):
        from rich.console import Console
        from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn

        self._run = run
        self._bar = Progress(
            SpinnerColumn(finished_text=" "),
            BarColumn(bar_width=20),
            TextColumn("{task.description}", markup=False),
            console=Console(file=stream, highlight=False),
            transient=True,
            refresh_per_second=2,
        )
        self._task = self._bar.add_task("", total=None)

    def show(self) -> None:
        """Draw it as the run is now."""
        self._bar.update(
            self._task,
            completed=self._run.done,
            total=self._run.total or None,
            description=self._run.line(),
        )
        self._bar.start()

    def say(self, text: str) -> None:
        self._bar.console.print(text, markup=False, soft_wrap=True)

    def close(self) -> None:
        self._bar.stop()
