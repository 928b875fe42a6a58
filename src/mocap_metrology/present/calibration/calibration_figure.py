"""The picture a lab looks at after a calibration: where the stations are, and how sure that is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.lighthouse.records import MASTER, ROLES, SLAVE
from mocap_metrology.present.calibration import views
from mocap_metrology.present.calibration.calibration_files import (
    Agreement,
    CalibrationFiles,
    agreement,
    pose_of,
    residuals_urad,
    seen_shares,
    thinned,
)
from mocap_metrology.present.calibration.pose_text import draw_text, expected_urad, text_height
from mocap_metrology.present.calibration.views import COLOURS, MIRRORED
from mocap_metrology.present.drawing.axes import decade_axis, linear_axis, log_limits
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    BODY_PT,
    FAINT,
    GREY,
    INK,
    MARGIN_MM,
    POINT_MM,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    Sheet,
    blank_sheet,
    head,
    label_axes,
    size_mm,
    styled,
)
from mocap_metrology.present.text.numbers import number, two

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from mocap_metrology.lighthouse.records import Path

DENSE = 500  # so many dots are an image in an SVG
DEAD, SELDOM = 0.01, 0.5  # share of sweeps seen; SELDOM of the median diode's
MOST_MARKS = 300


def nothing(axes: Axes, why: str) -> None:
    """Empty axes with the reason."""
    axes.set(xticks=[], yticks=[])
    axes.set_facecolor("#f4f4f4")
    how: Keywords = {"transform": axes.transAxes, "ha": "center", "va": "center", "color": GREY}
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
            how: Keywords = {
                "color": COLOURS[station],
                "ls": "",
                "marker": "|",
                "ms": 3.0,
                "mew": 0.5,
            }
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
    medians = [two(float(np.median(v))) for v in values]
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
    how: Keywords = {"size": SMALL_PT, "ha": "right", "va": "bottom", "zorder": 5}
    axes.text(0.99 * duration_s, 1.03 * expected_urad, text, **how)


def _dots(axes: Axes, x: np.ndarray, y: np.ndarray, colour: str, marker: str) -> None:
    few = thinned(x.size, 4000)
    how: Keywords = {
        "color": colour,
        "marker": marker,
        "ls": "",
        "markersize": 1.5,
        "mew": 0,
        "alpha": 0.7,
    }
    axes.plot(x[few], y[few], rasterized=x.size > DENSE, **how)


def draw_diodes(axes: Axes, given: CalibrationFiles, station: int, labels: bool) -> None:
    """Share of the station's sweeps that each diode saw, a bar a diode; dead ones crossed."""
    n = len(given.board)
    share = 100 * seen_shares(given.sweeps, station, n)
    dead, seldom = faint_diodes(share / 100)
    bar: Keywords = {
        "lw": 0.72 * size_mm(axes)[0] / POINT_MM / (n + 0.6),
        "color": COLOURS[station],
    }
    usual = np.setdiff1d(np.arange(n), seldom)
    axes.vlines(usual, 0, share[usual], **bar)
    axes.vlines(seldom, 0, share[seldom], alpha=0.5, **bar)
    cross: Keywords = {"marker": "x", "color": INK, "ls": "", "markersize": 3.5, "mew": 1.1}
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
    how: Keywords = {"transform": axes.transAxes, "size": SMALL_PT, "va": "bottom"}
    bold: Keywords = {"weight": "bold"} | how
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


LEFT_MM, RIGHT_MM = 16.5, 2.5
VIEW_MM = 67.0, 58.0
CLOSE_MM = 55.5, 37.0
TIME_LEFT_MM, TIME_MM = 93.0, 37.4
DIODES_MM, GAP_MM = 12.5, 5.0
HEAD_MM, LABELS_MM = 5.5, 10.5

Paths = tuple["Path", "Path"]


@styled()
def calibration_figure(given: CalibrationFiles, title: str = "", note: str = "") -> Figure:
    """One page of a calibration: verdict and pose in numbers; stations and path from above and from
    the right; both paths after the chosen pose, near and over time; residuals; diodes.

    Where the board stood still or no pose was found, panels say why they are empty.
    """
    width = WIDTH_MM - 2 * MARGIN_MM
    paths, scenery = _seen(given)
    frame = views.Frame.around(scenery, *VIEW_MM)
    key = _entries(scenery, frame, paths is not None)
    text_mm, key_mm = text_height(given, width), strip_height(key, width)
    views_top = text_mm + key_mm + 3.0 + HEAD_MM
    below_top = views_top + VIEW_MM[1] + LABELS_MM + HEAD_MM
    height = below_top + CLOSE_MM[1] + LABELS_MM + HEAD_MM + 2 * DIODES_MM + GAP_MM + LABELS_MM
    kind = "simulated" if given.twin else "measured"
    said = f"{given.simulated} The frame is that of the master. {note}".strip()
    sheet = blank_sheet(height, title or f"{given.name}: calibration ({kind})", said)
    draw_text(sheet, MARGIN_MM, 0.5, width, given)
    strip(sheet, MARGIN_MM, text_mm + 1.0, width, key)
    _views(sheet, views_top, scenery, frame)
    why = _why_empty(given, paths)
    still = given.chosen is not None and given.chosen["stage"] == "static"
    _close_up(sheet, below_top, scenery, still, why)
    _diodes(sheet, below_top + CLOSE_MM[1] + LABELS_MM + HEAD_MM, given)
    box = WIDTH_MM - TIME_LEFT_MM - RIGHT_MM, TIME_MM
    axes = sheet.axes(TIME_LEFT_MM, below_top, *box)
    draw_disagreement(axes, scenery.both, given.duration_s, why)
    axes = sheet.axes(TIME_LEFT_MM, below_top + TIME_MM + HEAD_MM, *box)
    draw_residuals(axes, paths, given.duration_s, why, expected_urad(given.pose))
    return sheet.figure


def _seen(given: CalibrationFiles) -> tuple[Paths | None, views.Scenery]:
    """Paths of the chosen estimate, and what the views show."""
    entry = given.chosen
    if entry is None:
        every = (given.paths(*kind) for kind in given.kinds)
        paths = next((found for found in every if found), None)
        alone = None if paths is None else paths[MASTER].t_m
        return paths, views.Scenery(None, None, given.reference, None, alone)
    paths, pose = given.paths(entry["estimator"], entry["optics"]), pose_of(entry)
    known = entry.get("covariance")
    covariance = None if known is None else np.array(known, dtype=np.float64)
    if covariance is not None and not np.isfinite(covariance).all():
        covariance = None
    both = None if paths is None else agreement(paths, pose)
    if both is not None and not both.time_s.size:
        both = None
    alone = paths[MASTER].t_m if paths is not None and both is None else None
    return paths, views.Scenery(pose, covariance, given.reference, both, alone)


def _why_empty(given: CalibrationFiles, paths: Paths | None) -> str:
    if paths is not None:
        return "No moment with a pose from both stations"
    if given.chosen is None:
        return "No pose of the slave: verdict failed"
    still = given.chosen["stage"] == "static"
    return "The board was at rest: no path" if still else "No board poses of this estimate"


def _entries(scenery: views.Scenery, frame: views.Frame, moved: bool) -> list[Entry]:
    entries = []
    if moved or scenery.alone_m is not None:
        entries.append(Entry("board as the master sees it", line=views.PATHS[MASTER]))
    if scenery.both is not None:
        entries.append(Entry("as the slave does, after R and t", line=views.PATHS[SLAVE]))
    fan = {"color": views.COLOURS[MASTER], "alpha": 0.15, "lw": 0}
    entries.append(Entry("120° in view", patch=fan))
    if scenery.slave is not None and scenery.covariance is not None:
        scale = views.ellipse_scale(scenery.covariance, frame.per_mm)
        times = f", drawn {scale} times as large" if scale > 1 else ""
        dot = {"marker": "o", "markerfacecolor": "none", "color": INK, "markersize": 6}
        entries.append(Entry(f"1 σ of the slave's place{times}", dot=dot))
    if scenery.reference is not None:
        entries.append(Entry("reference", dot=views.REFERENCE))
    if scenery.both is not None and scenery.both.mirrored.any():
        entries.append(Entry("mirrored pose of one station", dot=views.MIRRORED))
    if scenery.both is not None and any(len(alone) for alone in scenery.both.alone_s):
        dot = {"marker": "|", "color": views.COLOURS[MASTER], "markersize": 5}
        entries.append(Entry("seen by this station alone", dot=dot))
    return entries


def _views(sheet: Sheet, top: float, scenery: views.Scenery, frame: views.Frame) -> None:
    lefts = LEFT_MM, WIDTH_MM - RIGHT_MM - VIEW_MM[0]
    remarks = "distances in space", "same scale"
    both = views.ABOVE, views.RIGHT
    for left, view, remark in zip(lefts, both, remarks, strict=True):
        axes = sheet.axes(left, top, *VIEW_MM)
        views.draw_view(axes, scenery, frame, view)
        title = "a  Stations from above" if view == views.ABOVE else "Stations from the right"
        head(axes, title, remark)


def _close_up(sheet: Sheet, top: float, scenery: views.Scenery, still: bool, why: str) -> None:
    axes = sheet.axes(LEFT_MM, top, *CLOSE_MM)
    view = views.draw_closeup(axes, scenery, still)
    if view is None:
        nothing(axes, why)
    title = "b  Board at rest" if still else "b  Path of the board"
    head(axes, title, "" if view is None else views.view_name(view))


def _diodes(sheet: Sheet, top: float, given: CalibrationFiles) -> None:
    for station in (MASTER, SLAVE):
        at = top + station * (DIODES_MM + GAP_MM)
        axes = sheet.axes(LEFT_MM, at, CLOSE_MM[0], DIODES_MM)
        draw_diodes(axes, given, station, station == SLAVE)
