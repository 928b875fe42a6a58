"""Figure 3 of J: what one photodiode sees in a measurement cycle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import AXES, MASTER, ROLES, SLAVE
from mocap_metrology.lighthouse.timing import CYCLE_S, SLAVE_OFFSET_S
from mocap_metrology.present.calibration.views import COLOURS
from mocap_metrology.present.plot.figure import (
    GREY,
    INK,
    SMALL_PT,
    Keywords,
    Picture,
    legend_below,
    letters,
    new_figure,
    panel_title,
    styled,
)
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Columns = Mapping[str, np.ndarray]
N_CYCLES = 4
ORDER = ((MASTER, 0), (MASTER, 1), (SLAVE, 0), (SLAVE, 1))  # station and axis of each cycle
SHORTEST_FLASH_S, NEAR_S = 45e-6, 40e-6
BEFORE_S, AFTER_S = 0.5e-3, 0.2e-3  # shown round the four cycles
BETWEEN_US = 240.0  # of a flash's zoom: before and behind
MOST_TRIED = 400


@dataclass(frozen=True)
class Sweep:
    """A sweep on the diode; times from the beginning of the recording, s."""

    station: int
    axis: int
    flash_s: float  # of the station that sweeps
    start_s: float
    length_s: float
    angle_rad: float

    @property
    def middle_s(self) -> float:
        return self.start_s + self.length_s / 2

    @property
    def delta_s(self) -> float:
        """From the flash to the middle of the sweep: Delta t of J."""
        return self.middle_s - self.flash_s


@dataclass(frozen=True)
class Signal:
    """Four cycles of a diode: flashes (start, length, station) and sweeps."""

    diode: int
    start_s: float
    flashes: tuple[tuple[float, float, int], ...]
    sweeps: tuple[Sweep, ...]


def signal_of(pulses: Columns, sweeps: Columns) -> Signal:
    """The first four cycles in which a diode saw every flash and sweep, the master's azimuth first,
    and nothing else.

    pulses: `start_s`, `diode` and `length_s` or `length_us`; sweeps as in sweeps.parquet. Raises
    `Refusal` where no diode saw them all.
    """
    start = np.asarray(pulses["start_s"], dtype=np.float64)
    length = pulses["length_s"] if "length_s" in pulses else 1e-6 * pulses["length_us"]
    own = {d: np.asarray(pulses["diode"]) == d for d in np.unique(sweeps["diode"])}
    for cycle, diode in _candidates(sweeps)[:MOST_TRIED]:
        found = _read(start[own[diode]], np.asarray(length)[own[diode]], sweeps, cycle, diode)
        if found is not None:
            return found
    raise Refusal(
        "pulses: no diode saw all flashes and sweeps of four cycles; expected one for Figure 3 of J"
    )


def _candidates(sweeps: Columns) -> np.ndarray:
    """(n, 2) first cycle and diode of four sweeps in the order of `ORDER`, earliest first."""
    code = np.asarray(sweeps["cycle"], dtype=np.int64) * 4096 + np.asarray(sweeps["diode"])
    common = None
    for k, (station, axis) in enumerate(ORDER):
        own = (np.asarray(sweeps["station"]) == station) & (np.asarray(sweeps["axis"]) == axis)
        shifted = code[own] - 4096 * k
        common = shifted if common is None else np.intersect1d(common, shifted)
    codes = np.unique(np.zeros(0, np.int64) if common is None else common)
    return np.column_stack([codes // 4096, codes % 4096])


def _read(
    start: np.ndarray, length: np.ndarray, sweeps: Columns, cycle: int, diode: int
) -> Signal | None:
    """Four cycles of a diode from its pulses, None where something is missing or too much."""
    hits = [_hit(sweeps, cycle + k, diode) for k in range(N_CYCLES)]
    begin = [_begin(sweeps, row) for row in hits]
    first = begin[0]  # of the master's cycle; cycles of the slave begin later
    near = (start > first - NEAR_S) & (start < first + N_CYCLES * CYCLE_S - NEAR_S)
    start, length = start[near], length[near]
    is_flash = length > SHORTEST_FLASH_S
    if is_flash.sum() != 2 * N_CYCLES or (~is_flash).sum() != N_CYCLES:
        return None
    flashes = []
    for at, long in zip(start[is_flash], length[is_flash], strict=True):
        after = (at - first + NEAR_S) % CYCLE_S
        flashes.append((float(at), float(long), int(after > SLAVE_OFFSET_S / 2)))
    found = []
    for k, (station, axis) in enumerate(ORDER):
        own = [at for at, _, by in flashes if by == station and abs(at - begin[k]) < NEAR_S]
        hit = np.flatnonzero(~is_flash)[k]
        if len(own) != 1 or abs(start[hit] - sweeps["time_s"][hits[k]]) > NEAR_S:
            return None
        angle = float(sweeps["angle_rad"][hits[k]])
        found.append(Sweep(station, axis, own[0], float(start[hit]), float(length[hit]), angle))
    return Signal(int(diode), flashes[0][0], tuple(flashes), tuple(found))


def _hit(sweeps: Columns, cycle: int, diode: int) -> int:
    own = (np.asarray(sweeps["cycle"]) == cycle) & (np.asarray(sweeps["diode"]) == diode)
    return int(np.flatnonzero(own)[0])


def _begin(sweeps: Columns, row: int) -> float:
    """Begin of the station's cycle: angle = pi (time - begin) / cycle - pi/2."""
    return float(sweeps["time_s"][row] - (sweeps["angle_rad"][row] / np.pi + 0.5) * CYCLE_S)


ARROW: Keywords = {
    "arrowstyle": "<|-|>,head_width=0.14,head_length=0.3", "color": INK, "lw": 0.8,
    "shrinkA": 0, "shrinkB": 0,
}  # fmt: skip
TEXT: Keywords = {"size": SMALL_PT, "ha": "center", "va": "bottom"}


@styled()
def signal_figure(signal: Signal, title: str, source: str) -> Picture:
    """J Figure 3: signal of a diode over four cycles, 33.3 ms, with Delta t of each sweep; below,
    a flash of each station and a sweep, magnified."""
    body = new_figure(title, f"Diode {signal.diode}. {source}", 108.0)
    axes = body.subplot_mosaic(
        [["cycles", "cycles"], ["flashes", "sweep"]], height_ratios=[5, 3], width_ratios=[3, 2]
    )
    for one in axes.values():
        one.set(ylim=(0, 1.75), yticks=[0, 1], ylabel="Light")
        one.spines[["top", "right"]].set_visible(False)
    _cycles(axes["cycles"], signal)
    _flashes(axes["flashes"], signal)
    _one_sweep(axes["sweep"], signal.sweeps[0])
    at = f"at {1e3 * (signal.sweeps[0].middle_s - signal.start_s):.2f} ms"
    panel_title(axes["sweep"], "First sweep", at)
    letters(axes.values())
    legend_below(body, [axes["cycles"]])
    return Picture(body, captions.JANSEN[3])


def _light(axes: Axes, start: float, length: float, station: int) -> None:
    """A pulse of light of a station; its edge makes a short one visible."""
    colour, name = COLOURS[station], f"light of the {ROLES[station]}"
    axes.broken_barh([(start, length)], (0, 1), color=colour, lw=0.9, zorder=3, label=name)


def _cycles(axes: Axes, signal: Signal) -> None:
    panel_title(axes, "Four cycles")
    end = N_CYCLES * CYCLE_S + AFTER_S
    axes.set(xlim=(-1e3 * BEFORE_S, 1e3 * end), xlabel="Time from the master's flash (ms)")
    for start, length, station in signal.flashes:
        _light(axes, 1e3 * (start - signal.start_s), 1e3 * length, station)
    for k, sweep in enumerate(signal.sweeps):
        flash, middle = (1e3 * (v - signal.start_s) for v in (sweep.flash_s, sweep.middle_s))
        _light(axes, 1e3 * (sweep.start_s - signal.start_s), 1e3 * sweep.length_s, sweep.station)
        axes.annotate("", (middle, 0.6), (flash, 0.6), arrowprops=ARROW, zorder=4)
        axes.text((flash + middle) / 2, 0.63, r"$\Delta t$", **TEXT)
        begin = 1e3 * k * CYCLE_S
        axes.axvline(begin, color=GREY, lw=0.5, ls=(0, (1, 2)), zorder=0)
        degrees = number(float(np.degrees(sweep.angle_rad)), 2, sign=True)
        angle = rf"$\{('theta', 'phi')[sweep.axis]}$ = {degrees}°"
        delta = rf"$\Delta t$ = {1e3 * sweep.delta_s:.3f} ms"
        words = f"{ROLES[sweep.station]}, {AXES[sweep.axis]}\n{delta}\n{angle}"
        axes.text(begin + 500 * CYCLE_S, 1.08, words, color=COLOURS[sweep.station], **TEXT)


def _flashes(axes: Axes, signal: Signal) -> None:
    """The flashes of both stations at the first cycle."""
    panel_title(axes, "Flashes of the first cycle", "at 0 ms")
    (first, _, _), (second, longer, _) = signal.flashes[:2]
    end = 1e6 * (second + longer - first) + BETWEEN_US / 3
    axes.set(xlim=(-BETWEEN_US / 3, end), xlabel="Time from the master's flash (µs)")
    for start, length, station in signal.flashes[:2]:
        at = 1e6 * (start - first)
        _light(axes, at, 1e6 * length, station)
        text = f"{ROLES[station]}'s flash\n{1e6 * length:.1f} µs"
        axes.text(at + 0.5e6 * length, 1.06, text, color=COLOURS[station], **TEXT)
    offset = 1e6 * (second - first)
    axes.annotate("", (offset, 1.03), (0.0, 1.03), arrowprops=ARROW, zorder=5)
    axes.text(offset / 2, 1.06, f"begins {offset:.1f} µs later", **TEXT)


def _one_sweep(axes: Axes, sweep: Sweep) -> None:
    """The first sweep; its middle is what Delta t ends at."""
    half = max(2.2e6 * sweep.length_s, 6.0)
    axes.set(xlim=(-half, half), xlabel="Time from its middle (µs)", ylabel="")
    _light(axes, -0.5e6 * sweep.length_s, 1e6 * sweep.length_s, sweep.station)
    axes.plot([0, 0], [0, 1.0], color="white", lw=1.0, ls=(0, (2, 1)), zorder=4)
    text = f"{ROLES[sweep.station]}'s sweep\n{1e6 * sweep.length_s:.1f} µs"
    axes.text(0, 1.06, text, color=COLOURS[sweep.station], **TEXT)
