"""How both paths disagree, what each board pose leaves over, and what each diode saw."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.common.words import three
from mocap_metrology.lighthouse.records import MASTER, ROLES, SLAVE
from mocap_metrology.present.calibration.data import (
    Agreement,
    CalibrationFiles,
    residuals_urad,
    seen_shares,
    thinned,
)
from mocap_metrology.present.calibration.space import COLOURS, MIRRORED
from mocap_metrology.present.drawing.decades import decade_axis, log_limits
from mocap_metrology.present.drawing.linear import linear_axis, number
from mocap_metrology.present.drawing.style import (
    BODY_PT,
    FAINT,
    GREY,
    INK,
    POINT_MM,
    SMALL_PT,
    head,
    label_axes,
    size_mm,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from mocap_metrology.lighthouse.calibrate.board_pose import Path

DENSE = 500  # so many dots are an image in an SVG
DEAD, SELDOM = 0.01, 0.5  # share of sweeps seen; SELDOM of the median diode's
MOST_MARKS = 300


def nothing(axes: Axes, why: str) -> None:
    """Empty axes with the reason."""
    axes.set(xticks=[], yticks=[])
    axes.set_facecolor("#f4f4f4")
    how = {"transform": axes.transAxes, "ha": "center", "va": "center", "color": GREY}
    axes.text(0.5, 0.5, why, size=SMALL_PT, **how)


def draw_disagreement(axes: Axes, both: Agreement | None, duration_s: float, why: str) -> None:
    """Distance between both paths over time; mirrored moments and those of one station marked."""
    title = "c  Both paths apart"
    if both is None or not both.time_s.size:
        head(axes, title)
        nothing(axes, why)
        return
    value = np.maximum(both.apart_mm, 1e-3)
    median, most = np.median(value), np.percentile(value, 95)
    head(axes, title, f"median {median:.2g}, 95 %: {most:.2g} mm")
    linear_axis(axes, "x", (0.0, duration_s), 10)
    decade_axis(axes, "y", log_limits([np.maximum(value, median / 300)], 2.0), size_mm(axes)[1])
    axes.tick_params(labelbottom=False)
    label_axes(axes, y="Distance (mm)", y_mm=12.5)
    _dots(axes, both.time_s, value, "#4d4d4d", "o")
    axes.axhline(median, color=INK, lw=0.7, ls=(0, (5, 2)))
    turned = np.flatnonzero(both.mirrored)
    if turned.size:
        turned = turned[thinned(turned.size, MOST_MARKS)]
        axes.plot(both.time_s[turned], value[turned], ls="", zorder=4, **MIRRORED)
    for station, at in enumerate((0.97, 0.92)):
        alone = both.alone_s[station]
        if alone.size:
            how = {"color": COLOURS[station], "ls": "", "marker": "|", "ms": 3.0, "mew": 0.5}
            level = np.full(alone.size, at)
            line = axes.plot(alone, level, transform=axes.get_xaxis_transform(), **how)[0]
            line.set_rasterized(alone.size > DENSE)


def draw_residuals(
    axes: Axes, paths: tuple[Path, Path] | None, duration_s: float, why: str, expected_urad: float
) -> None:
    """sqrt(epsilon / n_angles) of each board pose over time, both stations, and the noise of one
    angle to expect."""
    title = "d  Single board poses"
    if paths is None:
        head(axes, title)
        nothing(axes, why)
        return
    values = [residuals_urad(path) for path in paths]
    medians = [three(float(f"{np.median(v):.2g}")) for v in values]
    head(axes, title, f"medians {', '.join(medians)} µrad")
    shown = [np.maximum(v, np.median(v) / 100) for v in values]
    linear_axis(axes, "x", (0.0, duration_s), 10)
    limits = log_limits([*shown, np.array([1.5 * expected_urad])])
    decade_axis(axes, "y", limits, size_mm(axes)[1])
    label_axes(axes, "Time (s)", "Residual (µrad)", x_mm=7.0, y_mm=12.5)
    for station in (SLAVE, MASTER):
        _dots(axes, paths[station].time_s, shown[station], COLOURS[station], "os"[station])
    axes.axhline(expected_urad, color=INK, lw=0.8, ls=(0, (1, 1.5)))
    text = f"noise of an angle to expect: {expected_urad:.0f} µrad"
    how = {"size": SMALL_PT, "ha": "right", "va": "bottom", "zorder": 5}
    axes.text(0.99 * duration_s, 1.03 * expected_urad, text, **how)


def _dots(axes: Axes, x: np.ndarray, y: np.ndarray, colour: str, marker: str) -> None:
    few = thinned(x.size, 4000)
    how = {"color": colour, "marker": marker, "ls": "", "markersize": 1.5, "mew": 0, "alpha": 0.7}
    axes.plot(x[few], y[few], rasterized=x.size > DENSE, **how)


def draw_diodes(axes: Axes, given: CalibrationFiles, station: int, labels: bool) -> None:
    """Share of the station's sweeps that each diode saw, a bar a diode; dead ones crossed."""
    n = len(given.board)
    share = 100 * seen_shares(given.sweeps, station, n)
    dead, seldom = faint_diodes(share / 100)
    bar = {"lw": 0.72 * size_mm(axes)[0] / POINT_MM / (n + 0.6), "color": COLOURS[station]}
    usual = np.setdiff1d(np.arange(n), seldom)
    axes.vlines(usual, 0, share[usual], **bar)
    axes.vlines(seldom, 0, share[seldom], alpha=0.5, **bar)
    cross = {"marker": "x", "color": INK, "ls": "", "markersize": 3.5, "mew": 1.1}
    axes.plot(dead, np.full(dead.size, 9.0), **cross)
    linear_axis(axes, "y", (0.0, 105.0), 2)
    axes.set_xlim(-0.8, n - 0.2)
    step = 4 if n > 16 else 2
    axes.set_xticks(range(0, n, step))
    axes.tick_params(axis="x", length=2, labelbottom=labels)
    if labels:
        label_axes(axes, x="Diode (from 0)", x_mm=7.0)
    told = _told("dead", dead) + _told("seldom", seldom) or ["all alive"]
    told = ["no sweep seen"] if dead.size == n else told
    how = {"transform": axes.transAxes, "size": SMALL_PT, "va": "bottom"}
    bold = {"weight": "bold"} | how
    if station == MASTER:
        axes.text(0, 1.04, "e  Diodes", **bold | {"size": BODY_PT})
    at = 0.36 if station == MASTER else 0.0
    axes.text(at, 1.04, ROLES[station], color=COLOURS[station], **bold)
    axes.text(1, 1.04, ", ".join(told), color=GREY, ha="right", **how)
    label_axes(axes, y="Seen (%)", y_mm=12.5)
    axes.axhline(100, color=FAINT, lw=0.6, zorder=0)


def faint_diodes(share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the dead diodes, and of those that see less than half of what the others do."""
    dead = share < DEAD
    usual = np.median(share[~dead]) if (~dead).any() else 0.0
    return np.flatnonzero(dead), np.flatnonzero(~dead & (share < SELDOM * usual))


def _told(word: str, diodes: np.ndarray) -> list[str]:
    if not diodes.size:
        return []
    if diodes.size > 3:  # a solid board is seen from one side
        return [f"{word}: {number(diodes.size)} diodes"]
    return [f"{word}: {', '.join(map(str, diodes))}"]
