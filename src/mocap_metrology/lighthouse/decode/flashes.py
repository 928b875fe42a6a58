"""Pulses -> flashes of each station: when, how long, and what code.

Flashes are found as combs: long pulses that come each 8.333 ms, at two phases 416.67 us apart if
two stations are there. So a false or merged pulse cannot shift a cycle, a missed one leaves a hole,
and a station that is blocked most of the time is still distinguished from the other.

Pulses -> hits: which laser of which station swept which diode, when and at what angle. Each sweep
is timed from the flash of the station that emits it, by the clock of that station and never by a
single edge. A station sweeps in the cycles that its codes do not skip; the code without its data
bit repeats each four cycles, so sweeps are found where flashes were missed.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.types import Integers
from mocap_metrology.lighthouse.decode.comb import (
    DECIDED_STEPS,
    FEWEST_FLASHES,
    begin_of_cycles,
    codes_of,
    data_residual,
    drift,
    find_pattern,
    find_period,
    find_phases,
    fit_clock,
    pattern_of,
)
from mocap_metrology.lighthouse.records import Clock, Flashes, Hits, Pulses, is_new
from mocap_metrology.lighthouse.timing import CODE_STEP_S, CYCLE_S, TICKS_PER_S, axis_of, skip_of

SHORTEST_S = 2250 / TICKS_PER_S
LONGEST_S = 200e-6
REACH_S = 60e-6  # of a comb before its line is known
LARGEST_DRIFT = 2e-3  # of the clock; rotors hold 300 ppm, quartz better
MOST_OUTSIDE = 0.1  # of the long pulses, before the first flash or after the last one
LATE_S = 30e-6  # dim diodes rise late
LONGEST_GAP = 240  # cycles, 2 s: a board may be hidden so long
PIECE = 48  # cycles, in which codes show their turn
LEAST_RUN = 0.1  # of the longest run of flashes
FIRST_S, LAST_S = 1222e-6, 6777e-6  # 4000 us +- 60 deg after the own flash
LONGEST_SWEEP_S = 40e-6
WIDTH_GATE = (0.25, 3.0)  # of the median width in the sweep
ENOUGH_S = 1e-6  # two samples of 2 MHz: a pulse of a far sweep is no wider
FLASH_S = 30e-6  # reach of a flash after its cycle begins
FATES = ("no_sweep", "too_long", "second_on_diode", "width", "flash", "hit")
NO_SWEEP, TOO_LONG, SECOND, WIDTH, FLASH, HIT = range(len(FATES))


def find_flashes(pulses: Pulses) -> list[Flashes]:
    """Flashes of master and slave, or of the one station that is seen, which then counts as master.

    Cycles have one number for both stations, from 0. The time of a flash is the lower quartile of
    the edges on all diodes: dim ones rise late, and a single early one may be false. They fall with
    the flash, so codes are of lengths from its begin by the clock to the end (`_lengths`).
    Raises `Refusal` where there are no flashes.
    """
    long = _long(pulses)
    if np.count_nonzero(long) < FEWEST_FLASHES:
        raise Refusal(
            f"no flashes: {np.count_nonzero(long)} of {pulses.start_s.size} pulses are longer "
            f"than {1e6 * SHORTEST_S:.1f} us; expected flashes of a base station every 8.333 ms"
        )
    start, length, diode = (x[long] for x in (pulses.start_s, pulses.length_s, pulses.diode))
    period = find_period(start)
    if abs(period / CYCLE_S - 1) > LARGEST_DRIFT:
        raise Refusal(
            f"flashes come every {1e3 * period:.4f} ms; expected {1e3 * CYCLE_S:.4f} ms within "
            f"{100 * LARGEST_DRIFT:g} % (is the sample rate right?)"
        )
    phases = find_phases(start, period)
    combs = _number([_comb(start, length, diode, at, period) for at in phases])
    seen = [comb.over_diodes() for comb in combs]
    patterns, biases = find_pattern([comb.cycle for comb in combs], seen)
    flashes = list[Flashes]()
    for comb, length_s, pattern, bias in zip(combs, seen, patterns, biases, strict=True):
        codes = codes_of(comb.cycle, _lengths(comb, pattern, bias), pattern)
        of_flash = comb.cycle.astype(np.int32), comb.time, length_s - bias, codes
        flashes.append(Flashes(len(flashes), comb.clock, *of_flash))
    return flashes


def _long(pulses: Pulses) -> np.ndarray:
    """Which pulses are as long as flashes."""
    return (pulses.length_s >= SHORTEST_S) & (pulses.length_s <= LONGEST_S)


def expect_unbroken(pulses: Pulses, flashes: list[Flashes], name: str) -> None:
    """Refuse a recording in which samples are missing: a part of the flashes, before the first or
    after the last that fit the clocks, does not, or the codes of a piece have another turn."""
    start = pulses.start_s[_long(pulses)]
    begin, end = (f(one.time_s[k] for one in flashes) for f, k in ((min, 0), (max, -1)))
    odd = {f"before {begin:.3f} s": start < begin, f"after {end:.3f} s": start > end}
    odd = {where: share for where, row in odd.items() if (share := row.mean()) > MOST_OUTSIDE}
    for where, share in (odd or _out_of_turn(flashes)).items():
        raise Refusal(
            f"{name}: about {share:.0%} of the flashes, {where}, do not fit the others: samples"
            " were lost or added there; expected each once"
        )


def _out_of_turn(flashes: list[Flashes]) -> dict[str, float]:
    """Share of the pieces of the recording whose flashes keep the clocks but have their codes in
    other ones of four cycles than most, as where whole cycles were lost; by when."""

    def pattern(rows: list[np.ndarray]) -> list[np.ndarray]:
        cycles = [one.cycle[row] for one, row in zip(flashes, rows, strict=True)]
        lengths = [one.length_s[row] for one, row in zip(flashes, rows, strict=True)]
        return find_pattern(cycles, lengths)[0]

    most = pattern([np.full(one.cycle.size, True) for one in flashes])
    odd, pieces = list[int](), range(max(int(one.cycle[-1]) for one in flashes) // PIECE + 1)
    for piece in pieces:
        rows = [one.cycle // PIECE == piece for one in flashes]
        rows = [row & (row.sum() >= FEWEST_FLASHES) for row in rows]
        if any(row.any() for row in rows) and not np.array_equal(pattern(rows), most):
            odd.append(piece)
    begin, end = (PIECE * CYCLE_S * k for k in ((odd[0], odd[-1] + 1) if odd else (0, 0)))
    return {f"between {begin:.1f} and {end:.1f} s": len(odd) / len(pieces)} if odd else {}


def within_flashes(pulses: Pulses, flashes: list[Flashes]) -> tuple[Pulses, list[Flashes]]:
    """Pulses between the first and last flash of a station, a cycle more at either end, from then
    on; and their flashes.

    A device sends what its memory still holds from before, seconds or minutes ago: pulses by the
    hundred, then nothing, then the recording. Flashes count where a comb has `FEWEST_FLASHES` of
    them without a gap of `LONGEST_GAP` cycles.
    """
    runs = []
    for one in flashes:
        ends = np.flatnonzero(np.diff(one.cycle) > LONGEST_GAP) + 1
        runs += [run for run in np.split(one.time_s, ends) if run.size >= FEWEST_FLASHES]
    longest = max((run.size for run in runs), default=0)
    runs = [run for run in runs if run.size >= LEAST_RUN * longest]
    if not runs:
        return pulses, flashes
    begin = max(min(run[0] for run in runs) - CYCLE_S, 0.0)
    end = max(run[-1] for run in runs) + CYCLE_S
    within = (pulses.start_s >= begin) & (pulses.start_s <= end)
    told = (
        f"{np.count_nonzero(~within)} pulses before or after the stations' flashes ignored, of"
        f" {pulses.duration_s:.4g} s in total: are they old data in the device's memory, or did its"
        " clock jump?",
    )
    sensors = pulses.inertial
    inside = replace(
        pulses,
        inertial=sensors and replace(sensors, time_s=sensors.time_s - begin),
        start_s=pulses.start_s[within] - begin,
        length_s=pulses.length_s[within],
        diode=pulses.diode[within],
        duration_s=min(end, pulses.duration_s) - begin,
        notes=pulses.notes + told * (not within.all()),
    )
    return inside, find_flashes(inside)


@dataclass(frozen=True)
class _Comb:
    """Pulses of the flashes of one station; those of flash k begin at first[k]."""

    length: np.ndarray
    after: np.ndarray  # from the begin of the cycle by the clock to the edge
    diode: np.ndarray
    first: np.ndarray
    cycle: np.ndarray  # of each flash
    time: np.ndarray
    clock: Clock

    @property
    def count(self) -> np.ndarray:
        """Diodes that saw each flash."""
        return np.diff(self.first, append=self.length.size)

    @property
    def flash(self) -> np.ndarray:
        """Which flash each pulse is of."""
        return np.repeat(np.arange(self.first.size), self.count)

    def over_diodes(self) -> np.ndarray:
        """Upper median of the lengths of the pulses of each flash: of two, the longer."""
        ranked = self.length[np.lexsort((self.length, self.flash))]
        return ranked[self.first + self.count // 2]


def _comb(
    start: np.ndarray, length: np.ndarray, diode: np.ndarray, at: float, period: float
) -> _Comb:
    """Pulses about a comb through `at`; then about its line and the drift of the rotors."""
    cycle = np.round((start - at) / period).astype(np.int64)
    inside = np.abs(start - at - cycle * period) <= REACH_S
    _, flash_cycle, time = _events(start[inside], cycle[inside])
    clock = _clock(flash_cycle, time)
    for _ in range(2):
        off = time - clock.start(flash_cycle)
        spread = MAD_TO_SIGMA * np.median(np.abs(off - drift(flash_cycle, off, flash_cycle)))
        tolerance = float(np.clip(6 * spread, 2e-6, 10e-6))
        cycle = np.round((start - clock.epoch_s) / clock.cycle_s).astype(np.int64)
        late = start - clock.start(cycle) - drift(flash_cycle, off, cycle)
        inside = (late >= -tolerance) & (late <= LATE_S)
        _, flash_cycle, flash_late = _events(late[inside], cycle[inside])
        inside &= np.isin(cycle, flash_cycle[flash_late <= tolerance])
        first, flash_cycle, time = _events(start[inside], cycle[inside])
        clock = _clock(flash_cycle, time)
    after = (start - clock.start(cycle))[inside]
    return _Comb(length[inside], after, diode[inside], first, flash_cycle, time, clock)


def _clock(cycle: np.ndarray, time: np.ndarray) -> Clock:
    """The line of a comb, refused where there is none."""
    if time.size >= FEWEST_FLASHES:
        clock, _ = fit_clock(cycle, time)
        if clock.cycle_s > 0:
            return clock
    raise Refusal(
        "flashes are not evenly spaced; expected one of a base station every "
        f"{1e3 * CYCLE_S:.3f} ms (is the sample rate right?)"
    )


def _events(start: np.ndarray, cycle: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Pulses by cycle (both rising): first pulse, cycle, and lower quartile of the starts."""
    first = np.flatnonzero(is_new(cycle))
    count = np.diff(first, append=cycle.size)
    return first, cycle[first], start[first + (count - 1) // 4]


def _number(combs: list[_Comb]) -> list[_Comb]:
    """Cycles from 0, the first one any flash of which can be in the recording."""
    master, last = combs[0].clock, combs[-1].clock
    behind = last.epoch_s - master.epoch_s
    shift = int(np.ceil((-behind - 10e-6 * (len(combs) - 1) - master.epoch_s) / master.cycle_s))
    clocks = [replace(one.clock, epoch_s=float(one.clock.start(shift))) for one in combs]
    pairs = zip(combs, clocks, strict=True)
    return [replace(one, cycle=one.cycle - shift, clock=clock) for one, clock in pairs]


def _lengths(comb: _Comb, pattern: np.ndarray, bias: float) -> np.ndarray:
    """Length of each flash, bias subtracted: upper median over the diodes.

    Dim diodes rise late and fall in time, so a length is taken to the end of a pulse: from the
    clock, or, where the ends keep no time with it, from the first edge of the flash. A pulse into
    which other light runs ends late, mostly where no code ends; it speaks only where no other does.
    """
    ends, cycle = comb.length + comb.after - bias, np.repeat(comb.cycle, comb.count)

    def off(length: np.ndarray) -> np.ndarray:
        return data_residual(cycle, length, pattern) * CODE_STEP_S

    by_clock = ends - drift(comb.cycle, comb.time - comb.clock.start(comb.cycle), cycle)
    for _ in range(3):
        late = replace(comb, length=off(by_clock)).over_diodes()
        by_clock = by_clock - drift(comb.cycle, late, cycle)
    ways = [by_clock, ends - np.minimum.reduceat(comb.after, comb.first)[comb.flash]]
    length = min(ways, key=lambda way: np.quantile(np.abs(off(way)), 0.9))
    for diode in np.unique(comb.diode):
        of_diode = comb.diode == diode
        if np.count_nonzero(of_diode) >= FEWEST_FLASHES:
            length[of_diode] -= np.median(off(length)[of_diode])
    good = np.abs(off(length)) <= DECIDED_STEPS * CODE_STEP_S
    good |= ~np.logical_or.reduceat(good, comb.first)[comb.flash]
    first = np.flatnonzero(is_new(comb.flash[good]))
    return replace(comb, length=length[good], diode=comb.diode[good], first=first).over_diodes()


def find_hits(pulses: Pulses, flashes: list[Flashes]) -> tuple[Hits, dict[str, list[int]]]:
    """Hits of all stations, by time, and how many pulses went where, a count for each diode.

    Report: `hit`, `flash` (begins with a flash of a station), and what was dropped: `too_long` for
    a sweep and no flash, `no_sweep` outside the window 1222..6777 us of a station that sweeps,
    `second_on_diode` (a reflection: of two pulses on a diode in a sweep the longer
    stays, the direct light being the stronger), `width` out of [0.25, 3] times the median of its
    sweep (none of 1 us is too short: so wide does a diode appear at 4 m).
    """
    fate = np.full(pulses.start_s.size, NO_SWEEP, np.int8)
    fate[pulses.length_s > LONGEST_SWEEP_S] = TOO_LONG
    for one in flashes:
        cycle = np.round((pulses.start_s - one.clock.epoch_s) / one.clock.cycle_s)
        late = np.abs(pulses.start_s - one.clock.start(cycle))
        fate[(late <= FLASH_S) & (pulses.length_s > LONGEST_SWEEP_S)] = FLASH
    middle = pulses.start_s + 0.5 * pulses.length_s
    hits = Hits.joined([_sweeps_of(pulses, middle, one, fate) for one in flashes])
    hits = hits.take(np.argsort(hits.time_s, kind="stable"))
    return hits, counts_of(FATES, fate, pulses.diode, pulses.n_diodes)


def counts_of(
    names: tuple[str, ...], fate: np.ndarray, diode: np.ndarray, n_diodes: int
) -> dict[str, list[int]]:
    """How many pulses went where, a count for each diode; fate: index of the name."""
    number = fate.astype(np.int64) * n_diodes + diode
    count = np.bincount(number, minlength=len(names) * n_diodes).reshape(len(names), -1)
    return dict(zip(names, count.tolist(), strict=True))


def _sweeps_of(pulses: Pulses, middle: np.ndarray, flashes: Flashes, fate: np.ndarray) -> Hits:
    """Hits of one station; marks in `fate` why others were dropped."""
    clock = flashes.clock
    pattern = pattern_of(flashes.cycle, flashes.code)
    cycle = np.floor((middle - clock.epoch_s - FIRST_S) / clock.cycle_s).astype(np.int64)
    code = pattern[cycle % 4]
    after = middle - clock.start(cycle)
    inside = (after <= LAST_S) & (code >= 0) & (skip_of(code) == 0)
    inside &= pulses.length_s <= LONGEST_SWEEP_S
    chosen = _longest_of_each(np.flatnonzero(inside), cycle, pulses, fate)
    chosen = _gate_width(chosen, cycle, pulses, fate)
    fate[chosen] = HIT
    cycle, code, middle = cycle[chosen], code[chosen], middle[chosen]
    begin = begin_of_cycles(flashes, cycle, middle, pulses.resolution_s)
    angle_rad = np.pi * (middle - begin) / clock.cycle_s - 0.5 * np.pi
    whole = np.full(chosen.size, flashes.station), axis_of(code), cycle, pulses.diode[chosen]
    hits = Hits.of(*whole, time_s=middle, angle_rad=angle_rad)
    return replace(hits, width_s=pulses.length_s[chosen])


def _longest_of_each(
    chosen: np.ndarray, cycle: np.ndarray, pulses: Pulses, fate: np.ndarray
) -> np.ndarray:
    """The longest pulse of each diode in each sweep."""
    order = np.lexsort((-pulses.length_s[chosen], pulses.diode[chosen], cycle[chosen]))
    chosen = chosen[order]
    first = is_new(cycle[chosen], pulses.diode[chosen])
    fate[chosen[~first]] = SECOND
    return chosen[first]


def _gate_width(chosen: Integers, cycle: np.ndarray, pulses: Pulses, fate: np.ndarray) -> Integers:
    """Drop pulses far narrower or wider than the median of their sweep, of three or more."""
    if not chosen.size:
        return chosen
    width, sweep = pulses.length_s[chosen], np.cumsum(is_new(cycle[chosen])) - 1
    count = np.bincount(sweep)
    median = np.asarray(ndimage.median(width, sweep, np.arange(count.size)))[sweep]
    count = count[sweep]
    low = np.minimum(WIDTH_GATE[0] * median, ENOUGH_S * (1 - 1e-6))
    high = np.maximum(WIDTH_GATE[1] * median, 2 * ENOUGH_S)
    good = (count < 3) | ((width >= low) & (width <= high))
    fate[chosen[~good]] = WIDTH
    return chosen[good]
