"""Gaps that were filled before the export: they must be named and must not cause an event.

Recordings as in `events`, of white noise and a weak random walk. 2 % of the frames of marker 1 are
filled in its three coordinates by straight lines or by polynomials through eight samples on both
sides. Straight lines of 100 frames and cubic polynomials of 15 have all `--runs`, other fills a
fifth.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from benchmarks.sentences import Row, events
from benchmarks.sentences import _kinds as kinds
from mocap_metrology.noise.diagnosis.fills import filled_frames

KIND = kinds.total(kinds.white, kinds.walk(0.003))


def rows(n: int) -> Iterator[Row]:
    """Fills of each kind and length."""
    for how, size in product(("linear", "order 3", "order 5"), (15, 100)):
        all_of_them = (how, size) in (("linear", 100), ("order 3", 15))
        alarms, named = [], []
        for k in range(n if all_of_them else max(n // 5, 1)):
            position = events.recorded(KIND, [k])
            starts = kinds.bursts(np.random.default_rng([3, k]), events.N, size, 0.02)
            position[:3] = [kinds.fill(axis, starts, size, how) for axis in position[:3]]
            alarms.append(bool(events.found_in(position)[0]))
            mask = filled_frames(np.float32(position).reshape(2, 3, -1), events.STEP)
            share = mask.mean(axis=1)
            named.append(bool(0.015 < share[0] < 0.025 and share[1] == 0))
        case = f"2 % filled, {how}, bursts of {size}"
        yield events.row(case, "events", alarms, "<= 1 %")
        yield events.row(case, "gap_filled, 1.5 to 2.5 %", named, ">= 90 %")
