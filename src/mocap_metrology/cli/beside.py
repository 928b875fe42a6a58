"""A function called in a process beside this one, so that two processors share the work."""

from __future__ import annotations

import gc
import multiprocessing
import signal
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import Connection
from typing import Any

FORKS = sys.platform == "linux"  # elsewhere libraries of the system may not survive a fork


class Beside:
    """Calls a function once; where there is no fork, in this process."""

    def __init__(self, function: Callable[..., object], connection: Connection | None):
        self._function, self._connection = function, connection

    def call(self, *arguments: Any) -> None:
        """Begin; the arguments are sent by pickle."""
        if self._connection is None:
            self._function(*arguments)
        else:
            self._connection.send(arguments)

    def wait(self) -> None:
        """Until it returned; raises RuntimeError with its traceback if it failed."""
        if self._connection is None:
            return
        try:
            failure = self._connection.recv()
        except EOFError:
            failure = "the process was ended"
        if failure:
            raise RuntimeError(failure)


@contextmanager
def beside(prepare: Callable[[], object], function: Callable[..., object]) -> Iterator[Beside]:
    """A `Beside` of the function; its process calls `prepare` at once and ends with the block."""
    if not FORKS:
        yield Beside(function, None)
        return
    how = multiprocessing.get_context("fork")
    own, other = how.Pipe()
    process = how.Process(target=_serve, args=(own, other, prepare, function), daemon=True)
    process.start()
    other.close()
    try:
        with own:
            yield Beside(function, own)
    finally:
        process.terminate()
        process.join()


def _serve(
    own: Connection,
    other: Connection,
    prepare: Callable[[], object],
    function: Callable[..., object],
) -> None:
    gc.disable()  # this process ends soon
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the process that waits
    own.close()  # so that its end is seen here, however it comes
    try:
        prepare()
        function(*other.recv())
        failure = ""
    except EOFError:
        return
    except Exception as error:
        failure = "".join(traceback.format_exception(error))
    other.send(failure)
