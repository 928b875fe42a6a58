"""Gaps that were filled before the export: they must be named and must not cause an event.

Recordings as in `events`, of white noise and a weak random walk. 2 % of the frames of marker 1 are
filled in its three coordinates by straight lines or by polynomials through eight samples on both
sides. Straight lines of 100 frames and cubic polynomials of 15 have all `--runs`, other fills a
fifth.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.sentences import _kinds as kinds
from benchmarks.sentences import events


def rows(n: int) -> list[tuple[Any, ...]]:
    """(case, statistic, runs, reach, at 8b8d0af, measured)."""
    from mocap_metrology.noise.diagnosis.fills import filled_frames

    told = []
    for how in ("linear", "order 3", "order 5"):
        for size in (15, 100):
            all_of_them = (how, size) in (("linear", 100), ("order 3", 15))
            alarms, named = [], []
            for k in range(n if all_of_them else max(n // 5, 1)):
                kind = kinds.total(kinds.white, kinds.walk(0.003))
                position = events.recorded(kind, [k])
                rng = np.random.default_rng([3, k])
                starts = kinds.bursts(rng, events.N, size, 0.02)
                for axis in range(3):
                    position[axis] = kinds.fill(position[axis], starts, size, how)
                alarms.append(bool(events.found_in(position)[0]))
                mask = filled_frames(np.float32(position).reshape(2, 3, -1), events.STEP)
                share = mask.mean(axis=1)
                named.append(bool(0.015 < share[0] < 0.025 and share[1] == 0))
            case = f"2 % filled, {how}, bursts of {size}"
            told.append(events.row(case, "events", alarms, "<= 1 %"))
            told.append(events.row(case, "gap_filled, 1.5 to 2.5 %", named, ">= 90 %"))
    return told
