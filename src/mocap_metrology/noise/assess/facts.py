"""What a verdict goes by: thresholds, facts of a recording, and the checks of one against the
other."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

SHORT = 0.9  # a recording of less than this of the horizon does not reach it
NO_MODEL = "there is no noise model"


@dataclass(frozen=True)
class Thresholds:
    """Named as in the configuration: `good_x` is the most (of durations and markers the least)
    that is good, `usable_x` that is usable. misfit: the best word with a noise model that does not
    fit. Shares of missing frames and of outliers are of all frames of a coordinate."""

    good_mm: float = 0.1
    usable_mm: float = 0.25
    good_drift_mm: float = 0.35
    usable_drift_mm: float = 0.85
    good_missing: float = 0.01
    usable_missing: float = 0.1
    good_outliers: float = 0.01
    usable_outliers: float = 0.05
    good_duration_s: float = 60.0
    good_markers: int = 2
    misfit: str = "usable"


@dataclass(frozen=True)
class Facts:
    """Of a recording: duration and horizon actually reached, s; number of markers; by coordinate
    the share of missing frames, and of outliers beyond what clean noise would have. labels: of the
    markers, in order, where they are known. asked_s: horizon that was asked for, if longer.
    n_frames: of the recording, where that is known. findings: of the diagnosis, as in its JSON
    (`Finding.as_dict`)."""

    duration_s: float
    horizon_s: float
    n_markers: int
    missing: Mapping[str, float]
    outliers: Mapping[str, float]
    labels: Sequence[str] = ()
    asked_s: float = 0.0
    n_frames: float = math.inf
    findings: Sequence[Mapping[str, Any]] = ()

    def found(self, code: str) -> dict[str, float]:
        """Values of the findings of a code by series."""
        own = (one for one in self.findings if one["code"] == code)
        return {one["series"]: float(one["value"] or math.nan) for one in own}

    @property
    def short(self) -> bool:
        """Whether the horizon that was asked for is out of reach."""
        return self.horizon_s < SHORT * self.asked_s


@dataclass(frozen=True)
class Check:
    """One check. word: the best a verdict can have with it; threshold: key of the configuration
    that holds `limit`; value, limit in `unit`; sentence: for a reader."""

    threshold: str
    series: str
    quantity: str
    value: float | str
    limit: float | str
    unit: str
    word: str
    sentence: str

    def as_row(self) -> dict[str, Any]:
        """For JSON, without the word."""
        row = asdict(self)
        return {k: row[k] for k in ("threshold", "series", "quantity", "value", "limit", "unit")}
