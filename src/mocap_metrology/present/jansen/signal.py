"""Figure 3 of J: what one photodiode sees while both stations flash and sweep once each way."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import AXES, MASTER, ROLES, SLAVE
from mocap_metrology.lighthouse.timing import CYCLE_S, SLAVE_OFFSET_S
from mocap_metrology.present.calibration.space import COLOURS
from mocap_metrology.present.drawing.legend import ROW_MM, Entry, strip
from mocap_metrology.present.drawing.linear import linear_axis, number
from mocap_metrology.present.drawing.style import (
    GREY,
    INK,
    MARGIN_MM,
    SMALL_PT,
    WIDTH_MM,
    blank_sheet,
    label_axes,
    size_mm,
    styled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

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
    codes = np.unique(common)
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


@styled()
def signal_figure(signal: Signal, title: str, note: str = "") -> Figure:
    """J Figure 3: signal of a diode over four cycles, 33.3 ms, with Delta t of each sweep; below,
    a flash of each station and a sweep, magnified."""
    sheet = blank_sheet(ROW_MM + 97.5, title, f"Diode {signal.diode}. {note}".strip())
    strip(sheet, MARGIN_MM, 0.5, WIDTH_MM, [
        Entry("light of the master", patch={"color": COLOURS[MASTER]}),
        Entry("light of the slave", patch={"color": COLOURS[SLAVE]}),
    ])  # fmt: skip
    top = sheet.axes(12.0, ROW_MM + 12, WIDTH_MM - 15.0, 42.0)
    _overview(top, signal)
    below = ROW_MM + 12 + 42.0 + 10.0
    flash = sheet.axes(12.0, below, 84.0, 22.0)
    _flashes(flash, signal)
    sweep = sheet.axes(12.0 + 84.0 + 17.0, below, WIDTH_MM - 3.0 - 113.0, 22.0)
    _one_sweep(sweep, signal)
    middle = signal.sweeps[0].middle_s - signal.start_s
    for axes, place in ((flash, 0.2e-3), (sweep, middle)):
        _magnify(top, axes, 1e3 * place)
    return sheet.figure


def _light(axes: Axes, start: float, length: float, station: int, width: float = 0.9) -> None:
    how = {"color": COLOURS[station], "lw": width, "zorder": 3, "joinstyle": "miter"}
    axes.fill_between([start, start + length], 0, 1, **how)


def _levels(axes: Axes) -> None:
    axes.set_ylim(0, 1.0)
    axes.set_yticks([0, 1])
    axes.spines[["top", "right"]].set_visible(False)


def _overview(axes: Axes, signal: Signal) -> None:
    end = N_CYCLES * CYCLE_S + AFTER_S
    linear_axis(axes, "x", (-1e3 * BEFORE_S, 1e3 * end), 14)
    _levels(axes)
    label_axes(axes, y="Light", y_mm=7.0)
    axes.set_ylim(0, 1.88)
    axes.spines[["top"]].set_visible(True)
    axes.xaxis.tick_top()
    axes.set_xlabel("Time from the master's flash (ms)", va="center")
    axes.xaxis.set_label_coords(0.5, 1 + 7.0 / size_mm(axes)[1])
    for start, length, station in signal.flashes:
        _light(axes, 1e3 * (start - signal.start_s), 1e3 * length, station, 0.6)
    for k, sweep in enumerate(signal.sweeps):
        colour = COLOURS[sweep.station]
        flash, middle = (1e3 * (v - signal.start_s) for v in (sweep.flash_s, sweep.middle_s))
        _light(axes, 1e3 * (sweep.start_s - signal.start_s), 1e3 * sweep.length_s, sweep.station)
        arrow = {"arrowstyle": "<|-|>,head_width=0.14,head_length=0.3", "color": INK, "lw": 0.8}
        arrow |= {"shrinkA": 0, "shrinkB": 0}
        axes.annotate("", (middle, 0.62), (flash, 0.62), arrowprops=arrow, zorder=4)
        how = {"size": SMALL_PT, "ha": "center", "va": "bottom", "zorder": 4}
        axes.text((flash + middle) / 2 + 0.2, 0.66, "Δt", **how)
        begin = 1e3 * k * CYCLE_S
        centre = begin + 1e3 * CYCLE_S / 2
        degrees = number(float(np.degrees(sweep.angle_rad)), 2, sign=True)
        angle = f"{'θφ'[sweep.axis]} = {degrees}°"
        title = f"{ROLES[sweep.station]}, {AXES[sweep.axis]}"
        axes.text(centre, 1.66, title, color=colour, weight="bold", **how)
        axes.text(centre, 1.42, f"Δt = {1e3 * sweep.delta_s:.3f} ms", color=colour, **how)
        axes.text(centre, 1.18, angle, color=colour, **how)
        axes.axvline(begin, color=GREY, lw=0.5, ls=(0, (1, 2)), zorder=0)


def _flashes(axes: Axes, signal: Signal) -> None:
    """The flashes of both stations at the first cycle."""
    from matplotlib.patheffects import withStroke

    (first, long, _), (second, longer, _) = signal.flashes[:2]
    end = 1e6 * (second + longer - first) + BETWEEN_US / 3
    linear_axis(axes, "x", (-BETWEEN_US / 3, end), 8)
    _levels(axes)
    axes.set_ylim(0, 1.75)
    label_axes(axes, x="Time from the master's flash (µs)", y="Light", x_mm=7.0, y_mm=7.0)
    for start, length, station in signal.flashes[:2]:
        at = 1e6 * (start - first)
        _light(axes, at, 1e6 * length, station)
        how = {"size": SMALL_PT, "ha": "center", "va": "bottom", "color": COLOURS[station]}
        text = f"{ROLES[station]}'s flash\n{1e6 * length:.1f} µs"
        axes.text(at + 0.5e6 * length, 1.06, text, linespacing=1.25, **how)
    arrow = {"arrowstyle": "<|-|>,head_width=0.14,head_length=0.3", "color": INK, "lw": 0.8}
    arrow |= {"shrinkA": 0, "shrinkB": 0}
    offset = 1e6 * (second - first)
    arrow["path_effects"] = [withStroke(linewidth=2.4, foreground="white")]
    axes.annotate("", (offset, 0.42), (0.0, 0.42), arrowprops=arrow, zorder=5)
    middle = (offset + 1e6 * long) / 2
    how = {"size": SMALL_PT, "ha": "center", "va": "bottom"}
    axes.text(middle, 0.48, f"begins {offset:.1f} µs later", **how)


def _one_sweep(axes: Axes, signal: Signal) -> None:
    """The first sweep; its middle is what Delta t ends at."""
    sweep = signal.sweeps[0]
    half = max(2.2e6 * sweep.length_s, 6.0)
    linear_axis(axes, "x", (-half, half), 6)
    _levels(axes)
    axes.set_ylim(0, 1.75)
    label_axes(axes, x="Time from its middle (µs)", x_mm=7.0)
    _light(axes, -0.5e6 * sweep.length_s, 1e6 * sweep.length_s, sweep.station)
    axes.plot([0, 0], [0, 1.0], color="white", lw=1.0, ls=(0, (2, 1)), zorder=4)
    text = f"{ROLES[sweep.station]}'s sweep\n{1e6 * sweep.length_s:.1f} µs"
    how = {"size": SMALL_PT, "ha": "center", "va": "bottom", "color": COLOURS[sweep.station]}
    axes.text(0, 1.06, text, linespacing=1.25, **how)


def _magnify(above: Axes, below: Axes, place: float) -> None:
    """Lines from a place in the overview to both upper corners of its magnification."""
    from matplotlib.patches import ConnectionPatch

    for corner in (0.0, 1.0):
        line = ConnectionPatch(
            (place, 0.0), (corner, 1.0), above.get_xaxis_transform(), below.transAxes,
            color=GREY, lw=0.6, ls=(0, (4, 2)),
        )  # fmt: skip
        above.figure.add_artist(line)
