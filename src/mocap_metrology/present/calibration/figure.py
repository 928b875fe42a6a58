"""The picture a lab looks at after a calibration: where the stations are, and how sure that is."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.lighthouse.records import MASTER, SLAVE
from mocap_metrology.present.calibration import space
from mocap_metrology.present.calibration import time as panels
from mocap_metrology.present.calibration.data import CalibrationFiles, agreement, pose_of
from mocap_metrology.present.calibration.text import draw_text, text_height
from mocap_metrology.present.calibration.words import expected_urad
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    INK,
    MARGIN_MM,
    WIDTH_MM,
    Sheet,
    blank_sheet,
    head,
    styled,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mocap_metrology.lighthouse.calibrate.board_pose import Path

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
    frame = space.Frame.around(scenery, *VIEW_MM)
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
    panels.draw_disagreement(axes, scenery.both, given.duration_s, why)
    axes = sheet.axes(TIME_LEFT_MM, below_top + TIME_MM + HEAD_MM, *box)
    panels.draw_residuals(axes, paths, given.duration_s, why, expected_urad(given.pose))
    return sheet.figure


def _seen(given: CalibrationFiles) -> tuple[Paths | None, space.Scenery]:
    """Paths of the chosen estimate, and what the views show."""
    entry = given.chosen
    if entry is None:
        every = (given.paths(*kind) for kind in given.kinds)
        paths = next((found for found in every if found), None)
        alone = None if paths is None else paths[MASTER].t_m
        return paths, space.Scenery(None, None, given.reference, None, alone)
    paths, pose = given.paths(entry["estimator"], entry["optics"]), pose_of(entry)
    covariance = entry.get("covariance")
    covariance = None if covariance is None else np.array(covariance, dtype=np.float64)
    if covariance is not None and not np.isfinite(covariance).all():
        covariance = None
    both = None if paths is None else agreement(paths, pose)
    if both is not None and not both.time_s.size:
        both = None
    alone = paths[MASTER].t_m if paths is not None and both is None else None
    return paths, space.Scenery(pose, covariance, given.reference, both, alone)


def _why_empty(given: CalibrationFiles, paths: Paths | None) -> str:
    if paths is not None:
        return "No moment with a pose from both stations"
    if given.chosen is None:
        return "No pose of the slave: verdict failed"
    still = given.chosen["stage"] == "static"
    return "The board was at rest: no path" if still else "No board poses of this estimate"


def _entries(scenery: space.Scenery, frame: space.Frame, moved: bool) -> list[Entry]:
    entries = []
    if moved or scenery.alone_m is not None:
        entries.append(Entry("board as the master sees it", line=space.PATHS[MASTER]))
    if scenery.both is not None:
        entries.append(Entry("as the slave does, after R and t", line=space.PATHS[SLAVE]))
    fan = {"color": space.COLOURS[MASTER], "alpha": 0.15, "lw": 0}
    entries.append(Entry("120° in view", patch=fan))
    if scenery.slave is not None and scenery.covariance is not None:
        scale = space.ellipse_scale(scenery.covariance, frame.per_mm)
        times = f", drawn {scale} times as large" if scale > 1 else ""
        dot = {"marker": "o", "markerfacecolor": "none", "color": INK, "markersize": 6}
        entries.append(Entry(f"1 σ of the slave's place{times}", dot=dot))
    if scenery.reference is not None:
        entries.append(Entry("reference", dot=space.REFERENCE))
    if scenery.both is not None and scenery.both.mirrored.any():
        entries.append(Entry("mirrored pose of one station", dot=space.MIRRORED))
    if scenery.both is not None and any(len(alone) for alone in scenery.both.alone_s):
        dot = {"marker": "|", "color": space.COLOURS[MASTER], "markersize": 5}
        entries.append(Entry("seen by this station alone", dot=dot))
    return entries


def _views(sheet: Sheet, top: float, scenery: space.Scenery, frame: space.Frame) -> None:
    lefts = LEFT_MM, WIDTH_MM - RIGHT_MM - VIEW_MM[0]
    remarks = "distances in space", "same scale"
    views = space.ABOVE, space.RIGHT
    for left, view, remark in zip(lefts, views, remarks, strict=True):
        axes = sheet.axes(left, top, *VIEW_MM)
        space.draw_view(axes, scenery, frame, view)
        title = "a  Stations from above" if view == space.ABOVE else "Stations from the right"
        head(axes, title, remark)


def _close_up(sheet: Sheet, top: float, scenery: space.Scenery, still: bool, why: str) -> None:
    axes = sheet.axes(LEFT_MM, top, *CLOSE_MM)
    view = space.draw_closeup(axes, scenery, still)
    if view is None:
        panels.nothing(axes, why)
    title = "b  Board at rest" if still else "b  Path of the board"
    head(axes, title, "" if view is None else space.view_names(view))


def _diodes(sheet: Sheet, top: float, given: CalibrationFiles) -> None:
    for station in (MASTER, SLAVE):
        at = top + station * (DIODES_MM + GAP_MM)
        axes = sheet.axes(LEFT_MM, at, CLOSE_MM[0], DIODES_MM)
        panels.draw_diodes(axes, given, station, station == SLAVE)
