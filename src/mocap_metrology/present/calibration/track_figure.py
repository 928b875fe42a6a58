"""The picture of a tracked receiver: its path, and how sure its poses are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.present.calibration.angle_figure import draw_angles
from mocap_metrology.present.calibration.track_table import deviations_mm, jitter, lengths, settled
from mocap_metrology.present.calibration.views import NAMES as AXIS_NAMES
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.plot.figure import (
    BAND,
    FAINT,
    INK,
    LOOKS,
    SMALL_PT,
    Keywords,
    Picture,
    legend_below,
    letters,
    log_axis,
    new_figure,
    panel_title,
    styled,
    words_picture,
)
from mocap_metrology.present.tables import Record
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import significant

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

Columns = Mapping[str, np.ndarray]
CURVES: dict[str, tuple[str, Keywords]] = {
    "total": ("all, with optics and board", {"color": INK, "lw": 1.2}),
    "calibration": (
        "error of the calibration",
        {"color": LOOKS["y"].colour, "lw": 1.1, "ls": (0, (5, 1.6))},
    ),
    "noise": ("noise of the hits", {"color": LOOKS["x"].colour, "lw": 0.8}),
}
NAMES = {"mm": "Position (mm)", "deg": "Rotation (°)"}
PLACES: list[Any] = [["path", "far"], ["place", "place"], ["mm", "mm"], ["deg", "deg"]]
HEIGHT_MM = 195.0
ROWS = (64, 48, 40, 40)  # round: with others the last digits of the layout vary between runs
DENSE = 2000  # poses; more are an image in an SVG
SPREAD = 0.08  # of the path's extent, left free on each side


@styled()
def track_figure(
    name: str,
    twin: str | None,
    track: Columns,
    origin: Record,
    allan: Columns,
    noise: Record,
) -> Picture:
    """One page: path from above coloured by its standard deviation, the same against the distance,
    position over time, standard deviations of position and of rotation over time.

    Of a board at rest, Allan deviations of its angles (`allan`, `noise`: of its allan.parquet) take
    the place of the path. Where there is no track, words state why.
    """
    kind = f"simulated stand-in (twin) {twin}" if twin else "measured"
    other = origin.get("tracked_with")
    whose = f"of {other}" if other else "of this recording's own calibration"
    source = f"Source: {kind}. Stations {whose}; frame of the master."
    title = f"{name}: tracked receiver"
    if not np.isfinite(track["x_mm"]).any():
        why = origin.get("reason") or "no moment with a pose"
        return words_picture(f"No path of the receiver: {why}.", title, source)
    body = new_figure(title, source, HEIGHT_MM)
    axes = body.subplot_mosaic(PLACES, height_ratios=ROWS)
    at_rest = bool(noise.get("rotors"))
    if at_rest:
        draw_angles(axes["path"], allan, noise, "azimuth")
        draw_angles(axes["far"], allan, noise, "elevation")
    else:
        _draw_path(body, axes["path"], track)
        _draw_distance(axes["far"], track)
    remark = _draw_place(axes["place"], track, bool(origin.get("still")))
    for unit in NAMES:
        _draw_deviations(axes[unit], track, unit)
    for one in (axes["place"], axes["mm"]):
        one.tick_params(labelbottom=False)
    axes["deg"].set_xlabel("Time (s)")
    drawn = [axes[key] for key in ("path", "far", "place", "mm", "deg")]
    letters(drawn)
    legend_below(body, drawn)
    above = captions.TRACK_AT_REST if at_rest else captions.TRACK_PATH
    return Picture(body, f"{above} {captions.TRACK} {remark}".strip())


def _draw_path(body: SubFigure, axes: Axes, track: Columns) -> None:
    """y against x on one scale, axes as in the calibration's figure; colour: total sd."""
    from matplotlib.ticker import MaxNLocator

    panel_title(axes, "Path from above")
    x, y = track["x_mm"] / 1e3, track["y_mm"] / 1e3
    kind = "total" if np.isfinite(track["sd_x_mm"]).any() else "noise"
    sd, good = lengths(track, kind, "mm"), settled(track)
    low, high = sd[good].min(), sd[good].max()
    how: Keywords = {"s": 7.0, "lw": 0, "cmap": "cividis", "rasterized": x.size > DENSE}
    dots = axes.scatter(x, y, c=sd, vmin=low, vmax=max(high, 1.001 * low), **how)
    middle = [(v[good].max() + v[good].min()) / 2 for v in (x, y)]
    half = max(np.ptp(v[good]) for v in (x, y)) * (0.5 + SPREAD) + 1e-4
    across, up = ((m - half, m + half) for m in middle)
    axes.set(xlim=across, ylim=up)
    axes.set_aspect("equal")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(3, steps=[1, 2, 5, 10]))
    axes.set(xlabel=AXIS_NAMES[0], ylabel=AXIS_NAMES[1])
    bar = body.colorbar(dots, cax=axes.inset_axes((1.07, 0.05, 0.04, 0.88)))
    bar.ax.set_title("mm", fontsize=SMALL_PT, fontweight="normal", loc="center")
    bar.outline.set_visible(False)


def _draw_distance(axes: Axes, track: Columns) -> None:
    """Standard deviations of position against the distance from the master."""
    far = np.sqrt(sum((track[f"{axis}_mm"] / 1e3) ** 2 for axis in "xyz"))
    values = {kind: lengths(track, kind, "mm") for kind in CURVES}
    for kind, (_, look) in CURVES.items():
        how: Keywords = {"ls": "", "marker": ".", "ms": 2.0, "mew": 0, "alpha": 0.6}
        axes.plot(far, values[kind], **how, color=look["color"], rasterized=far.size > DENSE)
    log_axis(axes, "y", log_limits(values.values()))
    good = far[settled(track)]
    room = 0.05 * np.ptp(good) + 1e-4
    panel_title(axes, "Position against distance")
    axes.set(xlim=(good.min() - room, good.max() + room))
    axes.locator_params(axis="x", nbins=4)
    axes.set(xlabel="Distance from the master (m)", ylabel="Standard deviation (mm)")


def _draw_place(axes: Axes, track: Columns, still: bool) -> str:
    """Position about its mean over time, at rest with the noise that is to be expected; moments
    that one station sees shaded. Returns a sentence on a board at rest."""
    time, off = track["time_s"], deviations_mm(track)
    unit, scale, remark, sentence = "m", 1e-3, "", ""
    if still:
        unit, scale = "mm", 1.0
        mm, deg = jitter(track)
        remark = f"jitter {significant(mm, 2)} mm, {significant(deg, 2)}°"
        noise = np.sqrt(np.nanmean(lengths(track, "noise", "mm") ** 2))
        sentence = (
            f"The board was at rest: (c) shows jitter of {significant(mm, 2)} mm, the noise of the"
            f" hits makes {significant(float(noise), 2)} mm (both lengths of vectors)."
        )
    for k, (name, look) in enumerate(LOOKS.items()):
        own: Keywords = {"color": look.colour, "ls": look.dashes, "lw": 0.9}
        axes.plot(time, scale * off[:, k], label=f"{name}, about its mean", **own)
        if still:
            sd = track[f"sd_noise_{name}_mm"]
            axes.fill_between(time, -sd, sd, color=look.colour, **BAND)
    shown = scale * off[settled(track)]
    room = 0.1 * np.ptp(shown) + 1e-6
    axes.set(ylim=(shown.min() - room, shown.max() + room))
    _shade_one_station(axes, track)
    panel_title(axes, "Position", remark)
    axes.set(xlim=(time[0], time[-1]), ylabel=f"Position ({unit})")
    return sentence


def _draw_deviations(axes: Axes, track: Columns, unit: str) -> None:
    """Standard deviations over time: three curves."""
    time = track["time_s"]
    values = {kind: lengths(track, kind, unit) for kind in CURVES}
    for kind, (label, look) in CURVES.items():
        axes.plot(time, values[kind], label=label, **look)
    log_axis(axes, "y", log_limits(values.values()))
    _shade_one_station(axes, track)
    panel_title(axes, f"Standard deviation of {NAMES[unit].split(' ')[0].lower()}")
    axes.set(xlim=(time[0], time[-1]), ylabel=NAMES[unit])


def _shade_one_station(axes: Axes, track: Columns) -> None:
    """Moments that one station alone sees."""
    one = (track["n_hits_master"] > 0) ^ (track["n_hits_slave"] > 0)
    if one.any():
        how: Keywords = {"color": FAINT, "lw": 0, "zorder": 0, "label": "one station sees it"}
        across = axes.get_xaxis_transform()
        axes.fill_between(track["time_s"], 0, 1, where=one, transform=across, step="mid", **how)
