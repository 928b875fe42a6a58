"""Progress of the steps; several series are worked on at once."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import TextIO, TypeVar

from mocap_metrology.common.errors import printable
from mocap_metrology.common.parallel import in_turn

T = TypeVar("T")
R = TypeVar("R")

PAUSE_S = 3.0  # between lines about one step, where they do not overwrite each other


class Progress:
    """What the steps of a recording say of their progress: here nothing, one series at a time."""

    def step(self, what: str) -> None:
        """The next step begins."""

    def over(self, function: Callable[[T], R], items: Iterable[T], /) -> Iterable[R]:
        """The function of each item, in their order."""
        return in_turn(function, items)

    def later(self, write: Callable[[Path], None], path: Path) -> None:
        """Write, at the latest when `end` returns."""
        write(path)

    def end(self) -> None:
        """All that was begun is done, or given up after a failure."""


CALM = Progress()


class ProgressLines(Progress, logging.Handler):
    """Lines like `3/8 Allan deviations: 4 of 7 series` on `stream`; `workers` threads.

    On a terminal the line of a step is written anew, elsewhere there is one now and then. As a
    handler of a logger it shows warnings between them.
    """

    def __init__(self, stream: TextIO, n_steps: int, workers: int = 1):
        logging.Handler.__init__(self, logging.WARNING)
        self.stream, self.n_steps = stream, n_steps
        self.pool = ThreadPoolExecutor(workers)
        self._begun, self._what, self._last = 0, "", 0.0
        self._later: list[Future[None]] = []

    def step(self, what: str) -> None:
        """Say which step begins."""
        self._new_line()
        self._begun += 1
        self._what, self._last = f"{self._begun}/{self.n_steps} {what}", time.monotonic()
        self._write(self._what)

    def over(self, function: Callable[[T], R], items: Iterable[T], /) -> Iterator[R]:
        """Results of a function of each item, in order, in threads; slow work reports progress."""
        futures = [self.pool.submit(function, item) for item in items]
        for number, future in enumerate(futures, start=1):
            yield future.result()
            now, total = time.monotonic(), len(futures)
            late = now - self._last > PAUSE_S and number < total
            if self._what and (self.stream.isatty() or late):
                self._last = now
                self._write(f"{self._what}: {number} of {total} series")

    def later(self, write: Callable[[Path], None], path: Path) -> None:
        """Write a file beside the next steps; `end` waits for it, and raises what it raised."""
        self._later.append(self.pool.submit(write, path))

    def emit(self, record: logging.LogRecord) -> None:
        """A line of its own; on a terminal it replaces that of the step."""
        said = printable(record.getMessage())
        self._write(f"{said}\n" if self.stream.isatty() else said)

    def end(self) -> None:
        self.pool.shutdown(cancel_futures=True)
        for written in self._later:
            if not written.cancelled():
                written.result()
        self._new_line()

    def _new_line(self) -> None:
        if self._what and self.stream.isatty():
            self.stream.write("\n")
            self.stream.flush()
        self._what = ""

    def _write(self, text: str) -> None:
        again = self.stream.isatty()
        with suppress(BrokenPipeError):  # nobody listens any more
            self.stream.write(f"\r\x1b[K{text}" if again else f"{text}\n")
            self.stream.flush()
