"""Findings: what was found in a recording, by codes that other programs can rely on.

`diagnosis.json` and `verdict.json` list them under `findings`; the sentences are made from them.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

# Unit and meaning of `value`, by code; "" is a pure number
CODES = {
    "drift": ("mm/h", "slope of a straight line under the noise"),
    "warm_up": ("mm", "amplitude of an exponential approach, A_w; positive where it falls"),
    "random_walk": ("mm^2 Hz", "h_-2"),
    "moves": ("mm", "movement that the noise does not explain, within the horizon"),
    "low_pass": ("Hz", "cutoff of a low-pass filter that ran before the export"),
    "gap_filled": ("", "share of the frames that an interpolation filled"),
    "resolution_limited": ("mm", "step of the file, which exceeds the noise"),
    "heavy_tails": ("", "excess kurtosis of the differences of frames"),
    "level_changes": ("", "relative change of the level of the noise over the recording"),
    "line": ("Hz", "frequency of a periodic disturbance"),
    "event": ("s", "time of a disturbance, from the first frame"),
}


@dataclass(frozen=True)
class Finding:
    """One finding in one series (`x1`, ..., `L`; "" where it is of the whole recording).

    value: in the unit of its code (`CODES`); lower_95, upper_95: its 95 % interval, NaN where there
    is none.
    """

    code: str
    series: str
    value: float
    lower_95: float = math.nan
    upper_95: float = math.nan

    def __post_init__(self) -> None:
        if self.code not in CODES:
            raise ValueError(f"finding {self.code!r}, expected one of {', '.join(CODES)}")

    @property
    def unit(self) -> str:
        """Of value and interval."""
        return CODES[self.code][0]

    def as_dict(self) -> dict[str, Any]:
        """code, series, value, lower_95, upper_95, unit."""
        return asdict(self) | {"unit": self.unit}
