"""Where in a recording the markers were shaken, as by the seismic crump of S 3.5."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

LAG_S, WINDOW_S = 0.1, 0.5
TIMES = 2.0  # shaken: so many times the usual square of a movement over LAG_S


@dataclass(frozen=True)
class Shock:
    """Frames `start` to `stop` (exclusive) round the strongest shake, half a window early;
    `onset`: frame where it begins; `times`: its greatest mean square movement by the usual.
    """

    start: int
    onset: int
    stop: int
    times: float


def find_shock(series: Mapping[str, np.ndarray], frame_rate_hz: float) -> Shock | None:
    """The strongest shake of all series together, None where nothing ever moves.

    Squares of the movements over a tenth of a second, each series' by its own median, averaged over
    series and half a second; a shake lasts as long as that stays above twice its own median.
    """
    lag = max(round(LAG_S * frame_rate_hz), 1)
    window = max(round(WINDOW_S * frame_rate_hz), 1)
    total, count = 0.0, 0
    for values in series.values():
        moved = np.square(values[lag:] - values[:-lag])
        known = moved[np.isfinite(moved)]
        usual = float(np.median(known)) if known.size else 0.0
        if usual > 0:
            total, count = total + np.nan_to_num(moved / usual), count + 1
    if not count or total.size < 2 * window:
        return None
    level = np.convolve(total / count, np.full(window, 1 / window), mode="same")
    usual = float(np.median(level))
    peak = int(np.argmax(level))
    calm = np.flatnonzero(level <= TIMES * usual)
    place = int(np.searchsorted(calm, peak))
    start = int(calm[place - 1]) + 1 if place else 0
    stop = int(calm[place]) if place < calm.size else level.size
    onset = min(start + lag + window // 2, peak)
    return Shock(start, onset, max(stop, start + 1) + lag, float(level[peak] / usual))
