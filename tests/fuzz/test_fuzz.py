"""A short run of the fuzzing, and the harness itself: a child that hangs or dies is an outcome."""

import os
import signal
import time

import numpy as np
import pytest

from . import kinds, pool
from .__main__ import EQUAL, OTHER, REFUSED, WRONG, jobs_of, judged, run, sound_files

SEED = 2026


@pytest.fixture(scope="module")
def known() -> dict[str, kinds.Kind]:
    return kinds.every()


def test_sound_files_are_read(known) -> None:
    """Those that are damaged later, and all readable ones by other people."""
    assert sound_files(known, workers=2) == []


def test_no_mutant_is_read_wrongly(known) -> None:
    table, listed = run(known, jobs_of(known, 800, 500, SEED), workers=2)
    wrong = [(*job, *why) for job, outcome, *why in listed if outcome in WRONG]
    assert wrong == []
    found = sum(table.values(), start=type(table["c3d float"])())
    assert found.total() > 1300
    assert min(found[EQUAL], found[REFUSED], found[OTHER]) > 60


def work(job: int) -> int:
    if job == 3:
        time.sleep(60)
    if job == 4:
        os.kill(os.getpid(), signal.SIGKILL)
    if job == 5:
        raise MemoryError
    return 2 * job


def test_a_child_that_hangs_or_dies_is_replaced() -> None:
    found = dict(pool.results(work, range(8), workers=2, limit_s=1.0))
    assert found == {0: 0, 1: 2, 2: 4, 3: "hang", 4: "crash", 5: "crash", 6: 12, 7: 14}


def test_a_wrong_reader_is_noticed(known) -> None:
    """Of readers that are off by a frame, off by a factor, too strict, or broken."""
    kind = known["c3d float"]
    shifted = np.roll(kind.strict(kind.base)["position_mm"], 1, axis=2)

    def raises(path):
        raise ZeroDivisionError

    def refuses(path):
        raise kinds.Refusal("never")

    sound = kind.strict(kind.base)
    assert judged(kind, kind.base, lambda path: sound)[0] == EQUAL
    assert judged(kind, kind.base, lambda path: sound | {"position_mm": shifted})[0] == WRONG[1]
    scaled = sound | {"position_mm": 1e-3 * sound["position_mm"]}
    assert judged(kind, kind.base, lambda path: scaled)[0] == WRONG[1]
    assert judged(kind, kind.base, refuses)[0] == WRONG[0]
    assert judged(kind, kind.base, raises)[0] == WRONG[2]
    assert judged(kind, kind.base[:600], refuses)[0] == REFUSED
