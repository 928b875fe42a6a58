"""Combs of flashes: their period, the phases of the stations, a clock line through each, the slow
wander of the rotors about it, and the codes of the lengths.

What is received of a length lies anywhere in the 500 ticks below the longest flash of a code, and
the analogue front end adds up to 4 us to all flashes of a recording. Together that is more than one
step, so a length alone is ambiguous. But which rotor turns and which laser is off repeats each four
cycles: only the data bit is free, and its two lengths are two steps apart.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.decode.wander import wander
from mocap_metrology.lighthouse.records import Clock, Flashes
from mocap_metrology.lighthouse.timing import CODE_0_S, CODE_STEP_S, CYCLE_S, SLAVE_OFFSET_S

PERIOD_TOLERANCE = 0.01  # of the nominal period: farther off, none is sought
OFFSET_TOLERANCE_S = 100e-6  # of the slave's flash about its nominal place
EVENT_S = 42e-6  # late edges of dim diodes belong to the flash before; the other station is later
BIN_S = 25e-6
FEWEST_FLASHES = 12  # in a row, at which libsurvive believes a station; here in all
MEDIAN_OF = 9  # flashes of one rotor
# Codes without data bit, of a master's four cycles; a slave has the laser on where the master's is
# off, and a station alone has it always on.
TIME_SHARING = np.array([4, 5, 0, 1])
ALONE = np.array([0, 1, 0, 1])
SKIP = 4
BIAS_STEPS = (-1.5, 0.5)  # 500 ticks below to 0 above, and 4 us to either side: -1.38 to 0.38
USUAL_BIAS_STEPS = -0.25  # preferred where the lengths leave it open
DECIDED_STEPS = 0.7  # from one of the two lengths of the data bit; halfway is 1


def find_period(start_s: np.ndarray) -> float:
    """Period of the flashes in seconds, from starts of long pulses, rising.

    The densest 4 us among the differences over 1 to 4 cycles, each divided by its count; then
    medians of differences over ever longer lags. False pulses add differences anywhere, flashes at
    the period only. Raises `Refusal` where nothing repeats within 1 % of 8.333 ms.
    """
    events = start_s[np.diff(start_s, prepend=-1.0) > EVENT_S]
    lags = np.arange(1, 5)  # cycles
    parts = [_differences(events, k * CYCLE_S, k * PERIOD_TOLERANCE * CYCLE_S) / k for k in lags]
    near = np.sort(np.concatenate(parts))
    inside = np.searchsorted(near, near + 4e-6, side="right") - np.arange(near.size)
    by_chance = near.size * 4e-6 / (2 * PERIOD_TOLERANCE * CYCLE_S)
    if near.size == 0 or inside.max() < max(FEWEST_FLASHES - 2, 5 * by_chance):
        raise Refusal(
            f"{start_s.size} pulses are long enough for flashes but do not repeat every 8.333 ms "
            "+- 1 %; expected flashes of a base station (is the sample rate right?)"
        )
    first = int(np.argmax(inside))
    period = float(np.median(near[first : first + inside[first]]))
    for lag in (16, 128, 1024):
        apart = _differences(events, lag * period, 5e-6)
        if apart.size >= FEWEST_FLASHES:
            period = float(np.median(apart)) / lag
    return period


def _differences(times: np.ndarray, lag: float, tolerance: float) -> np.ndarray:
    """All differences t_j - t_i within the tolerance of the lag."""
    low = np.searchsorted(times, times + lag - tolerance)
    count = np.searchsorted(times, times + lag + tolerance, side="right") - low
    i = np.repeat(np.arange(times.size), count)
    j = np.arange(i.size) - np.repeat(np.cumsum(count) - count, count) + np.repeat(low, count)
    return times[j] - times[i]


def find_phases(start_s: np.ndarray, period_s: float) -> list[float]:
    """Times of a flash of each station, master first; one if only one is there.

    Cycles that hold a long pulse are counted by phase, even and odd ones apart, and the smaller
    counts: a station flashes in all cycles, while a sweep seen from so near that it is as long as a
    flash comes in even or in odd ones only. The other station is 416.67 us later or earlier.
    """
    cycle = np.floor(start_s / period_s).astype(np.int64)
    phase = start_s - cycle * period_s
    first = _peak(*_occupancy(phase, cycle, period_s), None)[0]
    turned = np.mod(phase - first + period_s / 2, period_s)  # first station now in the middle
    cycle = np.floor((start_s - first + period_s / 2) / period_s).astype(np.int64)
    score, edges = _occupancy(turned, cycle, period_s)
    middle = period_s / 2
    elsewhere = np.abs(edges - middle) > 2 * SLAVE_OFFSET_S
    least = max(FEWEST_FLASHES, 5 * float(score[elsewhere].mean()))
    both_sides = [_peak(score, edges, middle + sign * SLAVE_OFFSET_S) for sign in (-1, 1)]
    other = max(both_sides, key=lambda peak: peak[1])
    if other[1] < least:
        return [first]
    return sorted([first, first + other[0] - middle])


def _occupancy(
    phase: np.ndarray, cycle: np.ndarray, period_s: float
) -> tuple[np.ndarray, np.ndarray]:
    """Twice the smaller of even and odd cycles that hold a phase, in bins of 2 BIN_S each BIN_S;
    and the middles of the bins."""
    n_bins = int(np.ceil(period_s / BIN_S))
    number = np.unique((phase / BIN_S).astype(np.int64) * (cycle.max() + 1) + cycle)
    where, which = np.divmod(number, cycle.max() + 1)
    even = np.bincount(where[which % 2 == 0], minlength=n_bins)
    odd = np.bincount(where[which % 2 == 1], minlength=n_bins)
    even, odd = even + np.roll(even, -1), odd + np.roll(odd, -1)
    return 2.0 * np.minimum(even, odd), (np.arange(n_bins) + 1.0) * BIN_S


def _peak(score: np.ndarray, middles: np.ndarray, near: float | None) -> tuple[float, float]:
    """Phase and score of the highest bin, of all or of those about `near`."""
    if near is not None:
        score = np.where(np.abs(middles - near) <= OFFSET_TOLERANCE_S, score, -1.0)
    best = int(np.argmax(score))
    return float(middles[best]), float(score[best])


def fit_clock(cycle: np.ndarray, time_s: np.ndarray) -> tuple[Clock, np.ndarray]:
    """Line through the flashes of a station, and the flashes it is fitted to.

    Least squares, where flashes farther than 5 robust sigma, at least 2 us, are left out in turn.
    The edges are quantised at random, so n of them place the line sqrt(n) times better than one.
    """
    apart = np.median(np.diff(time_s) / np.diff(cycle)) if cycle.size > 1 else CYCLE_S
    level = float(np.median(time_s - apart * cycle))
    used = np.abs(time_s - level - apart * cycle) < 1e-3
    middle = float(cycle.mean())
    for _ in range(8):
        design = np.column_stack([np.ones(cycle.size), cycle - middle])
        (at_middle, slope), *_ = np.linalg.lstsq(design[used], time_s[used], rcond=None)
        residual = time_s - design @ (at_middle, slope)
        sigma = MAD_TO_SIGMA * np.median(np.abs(residual[used]))
        before, used = used, np.abs(residual) <= max(5 * sigma, 2e-6)
        if np.array_equal(before, used):
            break
    rms = float(np.sqrt(np.mean(residual[used] ** 2)))
    return Clock(float(at_middle - slope * middle), float(slope), rms), used


def drift(cycle: np.ndarray, residual: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Running median of the residuals of each rotor, between its flashes a straight line; (at,)."""
    result = np.zeros(at.size)
    for rotor in (0, 1):
        of_rotor, wanted = cycle % 2 == rotor, at % 2 == rotor
        if np.count_nonzero(of_rotor) >= MEDIAN_OF:
            middle = ndimage.median_filter(residual[of_rotor], MEDIAN_OF)
            result[wanted] = np.interp(at[wanted], cycle[of_rotor], middle)
    return result


def begin_of_cycles(
    flashes: Flashes, cycle: np.ndarray, time_s: Floats, resolution_s: float
) -> Floats:
    """When the given cycles of a station begin, seconds, as its rotors are at these times in them.

    The clock line, and where the rotors wander about it (`decode.wander`), by more than the
    resolution of the recording can feign, what they are late by. Each of the two rotors of a
    station is held by a loop of its own, and its flashes follow it: in a real recording the line
    leaves 1.4 to 2.2 us (0.5 to 0.8 mrad) that all diodes of a sweep share. Even and odd cycles are
    the two rotors.
    """
    clock = flashes.clock
    begin = clock.start(cycle)
    passed = (time_s - clock.epoch_s) / clock.cycle_s
    for rotor in (0, 1):
        of_rotor = flashes.cycle % 2 == rotor
        wanted = cycle % 2 == rotor
        if np.count_nonzero(of_rotor) < FEWEST_FLASHES or not wanted.any():
            continue
        residual = flashes.time_s[of_rotor] - clock.start(flashes.cycle[of_rotor])
        late, _ = wander(flashes.cycle[of_rotor] // 2, residual, resolution_s)
        begin[wanted] += late((passed[wanted] - rotor) / 2)
    return begin


def steps_of(length_s: np.ndarray) -> np.ndarray:
    """Lengths in steps of 500 ticks above the longest flash of code 0."""
    return (length_s - CODE_0_S) / CODE_STEP_S


def find_pattern(
    cycle: list[np.ndarray], length_s: list[np.ndarray]
) -> tuple[list[np.ndarray], list[float]]:
    """Pattern (code without data bit by cycle modulo 4) and bias in seconds of each station.

    cycle, length_s: of the flashes of one station, or of master and slave. Every possible pattern
    is held against all flashes, with the bias that lets most of them agree.
    """
    names = [np.roll(TIME_SHARING, -turn) for turn in range(4)]
    if len(cycle) == 1:
        candidates = [[name] for name in [*names, ALONE, ALONE[[1, 0, 3, 2]]]]
    else:
        candidates = [[name, name ^ SKIP] for name in names]
    steps = [steps_of(length) for length in length_s]
    fits = [
        [_fit_bias(y - p[c % 4]) for c, y, p in zip(cycle, steps, patterns, strict=True)]
        for patterns in candidates
    ]
    best = int(np.argmax([sum(score for score, _ in of_stations) for of_stations in fits]))
    return candidates[best], [bias * CODE_STEP_S for _, bias in fits[best]]


def _fit_bias(above: np.ndarray) -> tuple[float, float]:
    """Share of agreement and bias: steps above the pattern are the bias, or the bias + 2."""
    above = np.sort(above)
    bias = np.arange(BIAS_STEPS[0], BIAS_STEPS[1], 0.02)

    def within(reach: float) -> np.ndarray:
        short, long = (
            np.searchsorted(above, bias + data + reach)
            - np.searchsorted(above, bias + data - reach)
            for data in (0, 2)
        )
        return short + long

    score = (within(0.3) + within(0.1)) / (2 * max(above.size, 1))
    score = score - 0.01 * np.abs(bias - USUAL_BIAS_STEPS)  # decides where all bits are the same
    best = float(bias[np.argmax(score)])
    off = above - best
    off = off - 2 * (off > 1)
    near = off[np.abs(off) < 0.5]
    return float(score.max()), best + (float(np.median(near)) if near.size else 0.0)


def data_residual(cycle: np.ndarray, length_s: np.ndarray, pattern: np.ndarray) -> np.ndarray:
    """Steps between a length (bias subtracted) and the nearer of the two of its data bit."""
    above = steps_of(length_s) - pattern[cycle % 4]
    return above - 2 * (above > 1)


def codes_of(cycle: np.ndarray, length_s: np.ndarray, pattern: np.ndarray) -> np.ndarray:
    """Codes, int8; -1 where the length is as near to neither data bit."""
    above = steps_of(length_s) - pattern[cycle % 4]
    code = pattern[cycle % 4] + 2 * (above > 1)
    decided = np.abs(data_residual(cycle, length_s, pattern)) <= DECIDED_STEPS
    return np.where(decided, code, -1).astype(np.int8)


def pattern_of(cycle: np.ndarray, code: np.ndarray) -> np.ndarray:
    """Code without data bit by cycle modulo 4, voted by the codes of a recording; -1: none seen."""
    pattern = np.full(4, -1)
    known = code >= 0
    for turn in range(4):
        votes = np.bincount(code[known & (cycle % 4 == turn)] & ~2, minlength=8)
        if votes.any():
            pattern[turn] = int(np.argmax(votes))
    return pattern
