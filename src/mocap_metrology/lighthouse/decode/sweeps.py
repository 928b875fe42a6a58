"""Pulses -> hits: which laser of which station swept which diode, when and at what angle.

Each sweep is timed from the flash of the station that emits it, by the clock of that station and
never by a single edge. A station sweeps in the cycles that its codes do not skip; the code without
its data bit repeats each four cycles, so sweeps are found where flashes were missed.
"""

from __future__ import annotations

import numpy as np

from mocap_metrology.common.types import Integers
from mocap_metrology.lighthouse.decode.comb import begin_of_cycles, pattern_of
from mocap_metrology.lighthouse.records import Flashes, Hits, Pulses
from mocap_metrology.lighthouse.timing import axis_of, skip_of

FIRST_S, LAST_S = 1222e-6, 6777e-6  # 4000 us +- 60 deg after the own flash
LONGEST_S = 40e-6
WIDTH_GATE = (0.25, 3.0)  # of the median width in the sweep
ENOUGH_S = 1e-6  # two samples of 2 MHz: a pulse of a far sweep is no wider
FLASH_S = 30e-6  # reach of a flash after its cycle begins
FATES = ("no_sweep", "too_long", "second_on_diode", "width", "flash", "hit")
NO_SWEEP, TOO_LONG, SECOND, WIDTH, FLASH, HIT = range(len(FATES))


def find_hits(pulses: Pulses, flashes: list[Flashes]) -> tuple[Hits, dict[str, list[int]]]:
    """Hits of all stations, by time, and how many pulses went where, a count for each diode.

    Report: `hit`, `flash` (begins with a flash of a station), and what was dropped: `too_long` for
    a sweep and no flash, `no_sweep` outside the window 1222..6777 us of a station that sweeps,
    `second_on_diode` (a reflection: of two pulses on a diode in a sweep the longer
    stays, the direct light being the stronger), `width` out of [0.25, 3] times the median of its
    sweep.

    A pulse is as wide as a diode appears, aperture / (377 rad/s range): two samples at 4 m. So no
    pulse of 1 us or more is too short.
    """
    fate = np.full(pulses.start_s.size, NO_SWEEP, np.int8)
    fate[pulses.length_s > LONGEST_S] = TOO_LONG
    for one in flashes:
        cycle = np.round((pulses.start_s - one.clock.epoch_s) / one.clock.cycle_s)
        late = np.abs(pulses.start_s - one.clock.start(cycle))
        fate[(late <= FLASH_S) & (pulses.length_s > LONGEST_S)] = FLASH
    middle = pulses.start_s + 0.5 * pulses.length_s
    parts = [_sweeps_of(pulses, middle, one, fate) for one in flashes]
    hits = Hits(*(np.concatenate(column) for column in zip(*parts, strict=True)))
    hits = hits.take(np.argsort(hits.time_s, kind="stable"))
    return hits, counts_of(FATES, fate, pulses.diode, pulses.n_diodes)


def counts_of(
    names: tuple[str, ...], fate: np.ndarray, diode: np.ndarray, n_diodes: int
) -> dict[str, list[int]]:
    """How many pulses went where, a count for each diode; fate: index of the name."""
    number = fate.astype(np.int64) * n_diodes + diode
    count = np.bincount(number, minlength=len(names) * n_diodes).reshape(len(names), -1)
    return dict(zip(names, count.tolist(), strict=True))


def _sweeps_of(
    pulses: Pulses, middle: np.ndarray, flashes: Flashes, fate: np.ndarray
) -> tuple[np.ndarray, ...]:
    """Columns of the hits of one station; marks in `fate` why others were dropped."""
    clock = flashes.clock
    pattern = pattern_of(flashes.cycle, flashes.code)
    cycle = np.floor((middle - clock.epoch_s - FIRST_S) / clock.cycle_s).astype(np.int64)
    code = pattern[cycle % 4]
    after = middle - clock.start(cycle)
    inside = (after <= LAST_S) & (code >= 0) & (skip_of(code) == 0) & (pulses.length_s <= LONGEST_S)
    chosen = np.flatnonzero(inside)
    chosen = _longest_of_each(chosen, cycle, pulses, fate)
    chosen = _gate_width(chosen, cycle, pulses, fate)
    fate[chosen] = HIT
    cycle, code, middle = cycle[chosen], code[chosen], middle[chosen]
    begin = begin_of_cycles(flashes, cycle, middle, pulses.resolution_s)
    return (
        np.full(chosen.size, flashes.station, np.int8),
        axis_of(code).astype(np.int8),
        cycle.astype(np.int32),
        pulses.diode[chosen].astype(np.int16),
        middle,
        np.pi * (middle - begin) / clock.cycle_s - 0.5 * np.pi,
        pulses.length_s[chosen],
    )


def _longest_of_each(
    chosen: np.ndarray, cycle: np.ndarray, pulses: Pulses, fate: np.ndarray
) -> np.ndarray:
    """The longest pulse of each diode in each sweep."""
    order = np.lexsort((-pulses.length_s[chosen], pulses.diode[chosen], cycle[chosen]))
    chosen = chosen[order]
    again = (np.diff(cycle[chosen], prepend=-1) == 0) & (
        np.diff(pulses.diode[chosen].astype(np.int64), prepend=-1) == 0
    )
    fate[chosen[again]] = SECOND
    return chosen[~again]


def _gate_width(chosen: Integers, cycle: np.ndarray, pulses: Pulses, fate: np.ndarray) -> Integers:
    """Drop pulses far narrower or wider than the median of their sweep, of three or more."""
    if not chosen.size:
        return chosen
    first = np.flatnonzero(np.diff(cycle[chosen], prepend=cycle[chosen[0]] - 1))
    count = np.diff(first, append=chosen.size)
    width = pulses.length_s[chosen]
    ranked = width[np.lexsort((width, cycle[chosen]))]
    median = 0.5 * (ranked[first + (count - 1) // 2] + ranked[first + count // 2])
    median, count = np.repeat(median, count), np.repeat(count, count)
    low = np.minimum(WIDTH_GATE[0] * median, ENOUGH_S * (1 - 1e-6))
    high = np.maximum(WIDTH_GATE[1] * median, 2 * ENOUGH_S)
    good = (count < 3) | ((width >= low) & (width <= high))
    fate[chosen[~good]] = WIDTH
    return chosen[good]
