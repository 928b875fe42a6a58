"""Children that are forked once and judge one mutant after the other, with limits on each."""

import multiprocessing
import os
import resource
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

MEMORY = 6 << 30  # bytes of address space
FORK = multiprocessing.get_context("fork")


@dataclass
class _Child:
    process: BaseProcess
    pipe: Connection
    job: Any = None
    began_s: float = 0.0


def _serve(pipe: Connection, work: Callable[[Any], Any]) -> None:
    """In the child: results of jobs until there is none."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    silent = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silent, 1)
    os.dup2(silent, 2)
    while (job := pipe.recv()) is not None:
        pipe.send(work(job))
    pipe.close()


def _start(work: Callable[[Any], Any]) -> _Child:
    own, other = FORK.Pipe()
    process = FORK.Process(target=_serve, args=(other, work), daemon=True)
    process.start()
    other.close()
    return _Child(process, own)


def results(
    work: Callable[[Any], Any], jobs: Iterable[Any], workers: int = 2, limit_s: float = 20.0
) -> Iterator[tuple[Any, Any]]:
    """(job, result) as they come; the result of a child that dies is `crash`, of one that takes
    longer than `limit_s` is `hang`. Such a child is replaced."""
    waiting = iter(jobs)
    children = [_start(work) for _ in range(workers)]
    for child in children:
        _give(child, waiting)
    while busy := [child for child in children if child.job is not None]:
        ready = wait([child.pipe for child in busy], timeout=0.5)
        for child in busy:
            late = time.monotonic() - child.began_s > limit_s
            if child.pipe not in ready and not late:
                continue
            job = child.job
            try:
                yield job, child.pipe.recv() if child.pipe in ready else _ended(child, "hang")
            except EOFError:
                yield job, _ended(child, "crash")
            if not child.process.is_alive() or child.pipe.closed:
                new = _start(work)
                child.process, child.pipe = new.process, new.pipe
            _give(child, waiting)
    for child in children:
        child.pipe.close()
        child.process.join(1.0)
        child.process.kill()


def _ended(child: _Child, how: str) -> str:
    child.process.kill()
    child.process.join()
    child.pipe.close()
    return how


def _give(child: _Child, waiting: Iterator[Any]) -> None:
    child.job, child.began_s = next(waiting, None), time.monotonic()
    if child.job is not None:
        child.pipe.send(child.job)
