"""Figure 3 of J: what one photodiode sees in a measurement cycle."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import AXES, MASTER, ROLES, SLAVE
from mocap_metrology.lighthouse.timing import CYCLE_S, SLAVE_OFFSET_S
from mocap_metrology.present.calibration.stations import COLOURS
from mocap_metrology.present.plot import figure
from mocap_metrology.present.plot.figure import GREY, INK, Keywords, Picture, panel_title
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Columns = Mapping[str, np.ndarray]
N_CYCLES = 4
ORDER = ((MASTER, 0), (MASTER, 1), (SLAVE, 0), (SLAVE, 1))  # station and axis of each cycle
SHORTEST_FLASH_S, NEAR_S = 45e-6, 40e-6
BETWEEN_US = 240.0  # of a flash's zoom: before and behind
MOST_TRIED = 400
ARROW: Keywords = {
    "arrowstyle": "<|-|>,head_width=0.14,head_length=0.3", "color": INK, "lw": 0.8,
    "shrinkA": 0, "shrinkB": 0,
}  # fmt: skip
TEXT: Keywords = {"size": figure.SMALL_PT, "ha": "center", "va": "bottom"}


class Sweep(NamedTuple):
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


class Signal(NamedTuple):
    """Four cycles of a diode: flashes (start, length, station) and sweeps."""

    diode: int
    flashes: list[tuple[float, float, int]]
    sweeps: list[Sweep]


def signal_of(pulses: Columns, sweeps: Columns) -> Signal:
    """The first four cycles in which a diode saw every flash and sweep, the master's azimuth first,
    and nothing else.

    pulses: `start_s`, `diode` and `length_us`; sweeps as in sweeps.parquet. Raises `Refusal` where
    no diode saw them all.
    """
    code = np.asarray(sweeps["cycle"], dtype=np.int64) * 4096 + np.asarray(sweeps["diode"])
    common = np.unique(code)  # first cycle and diode of four sweeps in `ORDER`, earliest first
    for k, (station, axis) in enumerate(ORDER):
        own = (np.asarray(sweeps["station"]) == station) & (np.asarray(sweeps["axis"]) == axis)
        common = np.intersect1d(common, code[own] - 4096 * k)
    for first in common[:MOST_TRIED]:
        hits = [int(np.flatnonzero(code == first + 4096 * k)[0]) for k in range(N_CYCLES)]
        diode = int(first % 4096)
        own = np.asarray(pulses["diode"]) == diode
        length = 1e-6 * np.asarray(pulses["length_us"])[own]
        start = np.asarray(pulses["start_s"], dtype=np.float64)[own]
        signal = _read(start, length, {k: np.asarray(v)[hits] for k, v in sweeps.items()}, diode)
        if signal is not None:
            return signal
    raise Refusal(
        "pulses: no diode saw all flashes and sweeps of four cycles; expected one for Figure 3 of J"
    )


def _read(start: np.ndarray, length: np.ndarray, hits: Columns, diode: int) -> Signal | None:
    """Four cycles of a diode from its pulses and its four sweeps, None where something is missing
    or too much."""
    begin = hits["time_s"] - (hits["angle_rad"] / np.pi + 0.5) * CYCLE_S  # of a station's cycle
    first = float(begin[0])  # of the master's cycle; cycles of the slave begin later
    near = (start > first - NEAR_S) & (start < first + N_CYCLES * CYCLE_S - NEAR_S)
    start, length = start[near], length[near]
    long = length > SHORTEST_FLASH_S
    if long.sum() != 2 * N_CYCLES or (~long).sum() != N_CYCLES:
        return None
    after = (start[long] - first + NEAR_S) % CYCLE_S
    of_slave = (after > SLAVE_OFFSET_S / 2).astype(int)
    flashes = list(zip(start[long].tolist(), length[long].tolist(), of_slave.tolist(), strict=True))
    sweeps = []
    for k, (station, axis) in enumerate(ORDER):
        own = [at for at, _, by in flashes if by == station and abs(at - begin[k]) < NEAR_S]
        at, width = float(start[~long][k]), float(length[~long][k])
        if len(own) != 1 or abs(at - hits["time_s"][k]) > NEAR_S:
            return None
        sweeps.append(Sweep(station, axis, own[0], at, width, float(hits["angle_rad"][k])))
    return Signal(diode, flashes, sweeps)


@figure.styled()
def signal_figure(signal: Signal, title: str, source: str) -> Picture:
    """J Figure 3: signal of a diode over four cycles, 33.3 ms, with Delta t of each sweep; below,
    a flash of each station and a sweep, magnified."""
    body = figure.new_figure(title, f"Diode {signal.diode}. {source}", 108.0)
    axes = body.subplot_mosaic(
        [["cycles", "cycles"], ["flashes", "sweep"]], height_ratios=[5, 3], width_ratios=[3, 2]
    )
    for one in axes.values():
        one.set(ylim=(0, 1.75), yticks=[0, 1], ylabel="Light")
        one.spines[["top", "right"]].set_visible(False)
    _draw_cycles(axes["cycles"], signal)
    _draw_flashes(axes["flashes"], signal)
    sweep, half = signal.sweeps[0], max(2.2e6 * signal.sweeps[0].length_s, 6.0)
    at = f"at {1e3 * (sweep.middle_s - signal.flashes[0][0]):.2f} ms"
    panel_title(axes["sweep"], "First sweep", at)
    axes["sweep"].set(xlim=(-half, half), xlabel="Time from its middle (µs)", ylabel="")
    _draw_light(axes["sweep"], -0.5e6 * sweep.length_s, 1e6 * sweep.length_s, sweep.station)
    axes["sweep"].plot([0, 0], [0, 1.0], color="white", lw=1.0, ls=(0, (2, 1)), zorder=4)
    words = f"{ROLES[sweep.station]}'s sweep\n{1e6 * sweep.length_s:.1f} µs"
    axes["sweep"].text(0, 1.06, words, color=COLOURS[sweep.station], **TEXT)
    figure.letters(axes.values())
    figure.legend_below(body, [axes["cycles"]])
    return Picture(body, captions.JANSEN[3])


def _draw_light(axes: Axes, start: float, length: float, station: int) -> None:
    """A pulse of light of a station; its edge makes a short one visible."""
    colour, name = COLOURS[station], f"light of the {ROLES[station]}"
    axes.broken_barh([(start, length)], (0, 1), color=colour, lw=0.9, zorder=3, label=name)


def _draw_cycles(axes: Axes, signal: Signal) -> None:
    panel_title(axes, "Four cycles")
    start_s, end_s = signal.flashes[0][0], N_CYCLES * CYCLE_S
    axes.set(xlim=(-0.5, 1e3 * end_s + 0.2), xlabel="Time from the master's flash (ms)")
    for start, length, station in signal.flashes:
        _draw_light(axes, 1e3 * (start - start_s), 1e3 * length, station)
    for k, sweep in enumerate(signal.sweeps):
        flash, middle = (1e3 * (v - start_s) for v in (sweep.flash_s, sweep.middle_s))
        _draw_light(axes, 1e3 * (sweep.start_s - start_s), 1e3 * sweep.length_s, sweep.station)
        axes.annotate("", (middle, 0.6), (flash, 0.6), arrowprops=ARROW, zorder=4)
        axes.text((flash + middle) / 2, 0.63, r"$\Delta t$", **TEXT)
        begin = 1e3 * k * CYCLE_S
        axes.axvline(begin, color=GREY, lw=0.5, ls=(0, (1, 2)), zorder=0)
        degrees = number(float(np.degrees(sweep.angle_rad)), 2, sign=True)
        angle = rf"$\{('theta', 'phi')[sweep.axis]}$ = {degrees}°"
        delta = rf"$\Delta t$ = {1e3 * sweep.delta_s:.3f} ms"
        words = f"{ROLES[sweep.station]}, {AXES[sweep.axis]}\n{delta}\n{angle}"
        axes.text(begin + 500 * CYCLE_S, 1.08, words, color=COLOURS[sweep.station], **TEXT)


def _draw_flashes(axes: Axes, signal: Signal) -> None:
    """The flashes of both stations at the first cycle."""
    panel_title(axes, "Flashes of the first cycle", "at 0 ms")
    (first, _, _), (second, longer, _) = signal.flashes[:2]
    end = 1e6 * (second + longer - first) + BETWEEN_US / 3
    axes.set(xlim=(-BETWEEN_US / 3, end), xlabel="Time from the master's flash (µs)")
    for start, length, station in signal.flashes[:2]:
        at = 1e6 * (start - first)
        _draw_light(axes, at, 1e6 * length, station)
        text = f"{ROLES[station]}'s flash\n{1e6 * length:.1f} µs"
        axes.text(at + 0.5e6 * length, 1.06, text, color=COLOURS[station], **TEXT)
    offset = 1e6 * (second - first)
    axes.annotate("", (offset, 1.03), (0.0, 1.03), arrowprops=ARROW, zorder=5)
    axes.text(offset / 2, 1.06, f"begins {offset:.1f} µs later", **TEXT)
