"""Bursts that recur: whether events keep a period, and pulses too weak to be events."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mocap_metrology.noise.allan.confidence import mean_variance
from mocap_metrology.noise.diagnosis.events import Event
from mocap_metrology.noise.diagnosis.sides import Blocks
from mocap_metrology.noise.fit.spectral.gaps import bridged

RECURRING, REGULAR = 6, 0.1  # events that tell of a period; part of it that they may be off
LONGEST = 1 << 19  # frames that are looked at
PULSE_S, LEAST_PULSES, LEAST_PERIODS, HARMONICS, CLIPPED = 0.05, 1200, 8, 4, 9.0
OCTAVES = 16
SWINGS = 30.0  # times the median power around, of a line
LOUD = 4.0  # standard errors that a minute is louder than usual


def recurrence(events: Sequence[Event]) -> float:
    """Period in s at which events recur, NaN where they do not: the median distance, of which all
    distances are whole multiples within REGULAR, as some may not be seen. Of six events at random
    times that is so in 0.03 %."""
    times = np.array([event.time_s for event in events if event.kind == "burst"])
    if times.size < RECURRING:
        return math.nan
    apart = np.diff(np.sort(times))
    period = float(np.median(apart))
    whole = np.maximum(np.rint(apart / period), 1)
    period = float(apart.sum() / whole.sum())
    return period if np.all(np.abs(apart / period - whole) < REGULAR) else math.nan


def pulses(series: np.ndarray, rate_hz: float, chance: float) -> float:
    """Period in s of bursts that recur through the whole recording, which are no departure from
    what the recording shows otherwise and so no events; NaN where there are none.

    series: (n,) mm, NaN in gaps. Mean squares about a second's mean, of tenths of a second and
    clipped, have lines at a frequency and at its multiples; a level that swings has one alone.
    """
    from scipy.ndimage import maximum_filter1d, uniform_filter1d
    from scipy.signal import resample_poly

    start = max((series.size - LONGEST) // 2, 0)
    series = series[start : start + LONGEST]
    length = max(round(PULSE_S * rate_hz), 2)
    count = series.size // length
    if count < LEAST_PULSES or not np.isfinite(series).any():
        return math.nan
    known, values = np.isfinite(series), bridged(series)
    values = values - uniform_filter1d(values, round(rate_hz) | 1)
    squares = values**2
    squares[~known] = squares[known].mean()  # gaps may recur, too
    power = resample_poly(squares[: count * length], 1, length)  # no line folds
    power = np.minimum(power, CLIPPED * np.median(power))
    padded = 4 * count
    tapered = (power - power.mean()) * np.hanning(count)  # so that lines have no side lobes
    density = np.abs(np.fft.rfft(tapered, padded)) ** 2
    density = density / np.maximum(_level_near(density) / math.log(2), 1e-300)
    at = np.arange(4 * LEAST_PERIODS, density.size // (HARMONICS + 1))
    near_each = {k: maximum_filter1d(density, 2 * k + 1) for k in range(1, HARMONICS + 1)}
    each = np.stack([greatest[k * at] for k, greatest in near_each.items()])
    strong = (each > math.log(padded / chance)).sum(axis=0) >= HARMONICS - 1
    if not strong.any():
        return math.nan
    best = int(at[strong][np.argmax(each.sum(axis=0)[strong])])
    for part in (2, 3):  # of a multiple the lowest frequency
        slower = at[strong & (np.abs(part * at - best) <= HARMONICS * part)]
        if slower.size:
            best = int(slower[np.argmax(density[slower])])
    below = density[3 : round(0.75 * best)]
    if below.size and below.max() > each[0][at == best][0]:
        return math.nan  # a slower cycle, of which this is a part
    near = np.arange(HARMONICS * (best - 1), HARMONICS * (best + 1) + 1)
    period_s = HARMONICS * padded * length / rate_hz / float(near[np.argmax(density[near])])
    return math.nan if _swings(values, values.size / rate_hz / period_s) else period_s


def _swings(values: np.ndarray, cycles: float) -> bool:
    """Whether (n,) values have a line of half as many cycles, four at least, as its square has
    twice as many; or of so many, which of pulses has multiples as strong."""
    density = np.abs(np.fft.rfft(values * np.hanning(values.size))) ** 2

    def line(at: int) -> tuple[float, float]:
        """The line, and the median around."""
        reach = max(at // 20, 3)
        near = density[at - reach : at + reach + 1]
        return float(near.max()), float(np.median(density[at // 2 : at + 10 * reach + 1]))

    (half, around), (whole, near), (twice, _) = (line(round(k * cycles)) for k in (0.5, 1, 2))
    return half > SWINGS * around or whole > SWINGS * max(near, twice)


def recurring_bout(
    series: np.ndarray, rate_hz: float, chance: float, levels: Blocks
) -> tuple[float, float, float]:
    """Period, begin and end in s of bursts that recur in a part of the recording, NaN where there
    are none: in minutes in which the noise is surely louder than usual."""
    frames = max(round(PULSE_S * rate_hz), 2) * LEAST_PULSES
    known = levels.variance[np.isfinite(levels.variance)]
    usual = float(np.median(known)) if known.size else math.nan
    starts = range(0, series.size - frames + 1, frames // 4)
    loud = []
    for start in starts:
        level = levels.between(start / rate_hz, (start + frames) / rate_hz).variance
        above = level.mean() - usual if level.size > 1 else 0.0
        if above > 0 and above > LOUD * math.sqrt(mean_variance(level)):
            loud.append(start)
    chance /= max(len(loud), 1)
    periods = {s: pulses(series[s : s + frames], rate_hz, chance) for s in loud}
    periods = {start: period for start, period in periods.items() if math.isfinite(period)}
    if not periods:
        return math.nan, math.nan, math.nan
    ends = min(periods) / rate_hz, (max(periods) + frames) / rate_hz
    return float(np.median(list(periods.values()))), *ends


def _level_near(density: np.ndarray) -> np.ndarray:
    """Medians over an octave about each frequency: bursts at any times have a level of their own at
    the low ones."""
    edges = np.unique(np.geomspace(4, density.size, 8 * OCTAVES).astype(int))
    middles, medians = [], []
    for low, high in zip(edges[:-8], edges[8:], strict=True):  # two thirds of an octave, or more
        middles.append(math.sqrt(low * high))
        medians.append(float(np.median(density[low:high])))
    return np.interp(np.arange(density.size), middles, medians)
