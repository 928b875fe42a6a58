"""Figure 3 of J: what one photodiode sees in a measurement cycle."""

from __future__ import annotations

import numpy as np

from mocap_metrology.lighthouse.assess.signal import N_CYCLES, Signal
from mocap_metrology.lighthouse.records import AXES, ROLES
from mocap_metrology.lighthouse.timing import CYCLE_S
from mocap_metrology.present.calibration.stations import COLOURS
from mocap_metrology.present.plot import figure
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import number

BETWEEN_US = 240.0  # of a flash's zoom: before and behind
ARROW: figure.Keywords = {
    "arrowstyle": "<|-|>,head_width=0.14,head_length=0.3", "color": figure.INK, "lw": 0.8,
    "shrinkA": 0, "shrinkB": 0,
}  # fmt: skip
TEXT: figure.Keywords = {"size": figure.SMALL_PT, "ha": "center", "va": "bottom"}


@figure.styled()
def signal_figure(signal: Signal, title: str, source: str) -> figure.Picture:
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
    figure.panel_title(axes["sweep"], "First sweep", at)
    axes["sweep"].set(xlim=(-half, half), xlabel="Time from its middle (µs)", ylabel="")
    _draw_light(axes["sweep"], -0.5e6 * sweep.length_s, 1e6 * sweep.length_s, sweep.station)
    axes["sweep"].plot([0, 0], [0, 1.0], color="white", lw=1.0, ls=(0, (2, 1)), zorder=4)
    words = f"{ROLES[sweep.station]}'s sweep\n{1e6 * sweep.length_s:.1f} µs"
    axes["sweep"].text(0, 1.06, words, color=COLOURS[sweep.station], **TEXT)
    figure.letters(axes.values())
    return figure.finished(body, [axes["cycles"]], captions.JANSEN[3])


def _draw_light(axes: figure.Axes, start: float, length: float, station: int) -> None:
    """A pulse of light of a station; its edge makes a short one visible."""
    colour, name = COLOURS[station], f"light of the {ROLES[station]}"
    axes.broken_barh([(start, length)], (0, 1), color=colour, lw=0.9, zorder=3, label=name)


def _draw_cycles(axes: figure.Axes, signal: Signal) -> None:
    figure.panel_title(axes, "Four cycles")
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
        axes.axvline(begin, color=figure.GREY, lw=0.5, ls=(0, (1, 2)), zorder=0)
        degrees = number(float(np.degrees(sweep.angle_rad)), 2, sign=True)
        angle = rf"$\{('theta', 'phi')[sweep.axis]}$ = {degrees}°"
        delta = rf"$\Delta t$ = {1e3 * sweep.delta_s:.3f} ms"
        words = f"{ROLES[sweep.station]}, {AXES[sweep.axis]}\n{delta}\n{angle}"
        axes.text(begin + 500 * CYCLE_S, 1.08, words, color=COLOURS[sweep.station], **TEXT)


def _draw_flashes(axes: figure.Axes, signal: Signal) -> None:
    figure.panel_title(axes, "Flashes of the first cycle", "at 0 ms")
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
