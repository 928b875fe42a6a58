"""Rows of the table of Allan deviations of a group."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.common.types import Row
from mocap_metrology.noise.assess.uncertainty import lowest

FIRST = ("tau_1_s", "adev_1_mm")
MINIMUM = ("adev_min_mm", "tau_min_s", "adev_min_lower_mm", "adev_min_upper_mm")
CHOSEN_TAUS_S = (0.1, 1.0, 10.0, 100.0, 1000.0)


def allan_summary(
    recording: str, source: str, columns: Mapping[str, np.ndarray], expected: Sequence[str]
) -> list[Row]:
    """One row a series of allan_masked.parquet: its first tau, chosen tau, and the minimum.

    The value at a chosen tau is that of the nearest tau computed, within 10 %, else empty; a series
    of `expected` without a single value has a row of empty cells.
    """
    rows = []
    overlapping = columns["estimator"] == "oadev"
    for series in expected:
        pick = overlapping & (columns["series"] == series)
        tau, adev = columns["tau_s"][pick], columns["adev_mm"][pick]
        lower, upper = columns["adev_lower_mm"][pick], columns["adev_upper_mm"][pick]
        row: Row = {"recording": recording, "source": source, "series": series}
        row |= {"tau_1_s": tau[0], "adev_1_mm": adev[0]} if tau.size else dict.fromkeys(FIRST)
        for wanted in CHOSEN_TAUS_S:
            k = int(np.abs(np.log(tau / wanted)).argmin()) if tau.size else -1
            near = k >= 0 and abs(tau[k] / wanted - 1) < 0.1
            row[f"adev_{wanted:g}s_mm"] = adev[k] if near else math.nan
        best, _ = lowest(adev, columns["edf"][pick])
        least = [None if best is None else values[best] for values in (adev, tau, lower, upper)]
        rows.append(row | dict(zip(MINIMUM, least, strict=True)))
    return rows
