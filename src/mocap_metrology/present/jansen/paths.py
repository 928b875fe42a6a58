"""Figures 6 to 8 of J: paths of the board from both stations, superposed, and the slave's pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.calibrate.board_pose import Path
from mocap_metrology.lighthouse.records import MASTER, ROLES, SLAVE
from mocap_metrology.present.calibration.data import CalibrationFiles, Pose, pose_of, thinned
from mocap_metrology.present.calibration.space import COLOURS
from mocap_metrology.present.drawing.legend import ROW_MM, Entry, strip
from mocap_metrology.present.drawing.linear import number
from mocap_metrology.present.drawing.style import (
    GREY,
    INK,
    MARGIN_MM,
    SMALL_PT,
    WIDTH_MM,
    size_mm,
    styled,
)
from mocap_metrology.present.jansen.space import BOX, Stage, arc, magnified, outline, stage

if TYPE_CHECKING:
    from matplotlib.figure import Figure

N_BOARDS = 7
INSETS_MM, INSET_GAP_MM = 54.0, 6.0
DENSE = 500  # so many dots are an image in an SVG
PALE = "#9a9a9a"
DOTS = {"mew": 0, "markersize": 1.9}
BEFORE = DOTS | {"color": "#e39a86", "marker": "s", "markersize": 1.5}
BETWEEN = DOTS | {"color": PALE, "marker": "s", "markersize": 1.5}
AFTER = DOTS | {"color": COLOURS[SLAVE], "marker": "s", "markersize": 1.6}
OWN = DOTS | {"color": COLOURS[MASTER], "marker": "o", "markersize": 2.4}
GHOST = {"color": INK, "lw": 0.8, "ls": (0, (2, 1.4))}


@dataclass(frozen=True)
class Superposed:
    """What the three figures show: both paths in their own frames, the pose, and the truth."""

    paths: tuple[Path, Path]
    board: np.ndarray
    pose: Pose
    reference: Pose | None
    label: str

    @classmethod
    def of(
        cls, given: CalibrationFiles, estimator: str = "paper", optics: str = "ideal"
    ) -> Superposed:
        """Of the Kabsch stage of an estimator, of the chosen pose where there is none.

        Raises `Refusal` where the calibration has neither.
        """
        entry = given.estimate(estimator, "kabsch", optics) or given.chosen
        paths = None if entry is None else given.paths(entry["estimator"], entry["optics"])
        if entry is None or paths is None:
            raise Refusal(
                f"{given.name}: no pose with a path of the board;"
                " expected one for Figures 5 to 8 of J"
            )
        label = f"{entry['estimator']}, stage {entry['stage']}, {entry['optics']} optics"
        return cls(paths, given.board, pose_of(entry), given.reference, label)


@styled()
def paths_figure(given: Superposed, title: str, note: str = "") -> Figure:
    """J Figure 6: board poses as each station sees them, both stations at the origin."""
    points = [np.zeros((1, 3)), *(_usual(path.t_m) for path in given.paths)]
    page = _note(given, note), ROW_MM + 2, INSETS_MM
    sheet, drawing = stage(np.vstack(points), title, *page)
    strip(sheet, MARGIN_MM, 0.5, WIDTH_MM, [
        Entry("path of the board from the master", dot=_large(OWN)),
        Entry("from the slave", dot=_large(AFTER)),
        Entry(f"the board itself, {N_BOARDS} times", patch={"color": GREY, "alpha": 0.3}),
    ])  # fmt: skip
    floor = _floor(points)
    for station, (path, how) in enumerate(zip(given.paths, (OWN, AFTER), strict=True)):
        text = f"as the {ROLES[station]} sees it"
        box = _inset(drawing, station)
        near = magnified(sheet, drawing, box, _with_boards(path, given.board), text)
        for into in (drawing, near):
            _path(into, path.t_m, **how)
            _boards(into, path, given.board, COLOURS[station])
        middle = np.median(path.t_m, axis=0)
        drawing.drop(middle, floor)
        above = path.t_m[np.argmax(path.t_m[:, 2])]
        off = 4.0 + _half_board_mm(given.board, drawing)
        drawing.text(above, text, (0, off), color=COLOURS[station], weight="bold", bbox=BOX)
    drawing.drop(np.zeros(3), floor)
    drawing.frame(np.eye(3), np.zeros(3), 13 * drawing.per_mm, color=INK, lw=1.1)
    tip = np.array([0.0, 0.0, 13 * drawing.per_mm])
    drawing.text(tip, "both stations", (0, 7.5), weight="bold", bbox=BOX)
    return sheet.figure


@styled()
def superposition_figure(given: Superposed, title: str, note: str = "") -> Figure:
    """J Figure 7: the slave's path goes onto the master's, by T of its centroid and R about it."""
    master, slave = given.paths
    R, t = given.pose
    centre = _usual(slave.t_m).mean(axis=0)
    T = R @ centre + t - centre
    moved, after = slave.t_m + T, slave.t_m @ R.T + t
    points = [_usual(p) for p in (master.t_m, slave.t_m, moved, after)]
    page = _note(given, note), ROW_MM + 2, INSETS_MM
    sheet, drawing = stage(np.vstack(points), title, *page)
    strip(sheet, MARGIN_MM, 0.5, WIDTH_MM, [
        Entry("master's path", dot=_large(OWN)),
        Entry("slave's, before", dot=_large(BEFORE)),
        Entry("moved by T", dot=_large(BETWEEN)),
        Entry("and turned by R", dot=_large(AFTER)),
    ])  # fmt: skip
    _path(drawing, slave.t_m, **BEFORE)
    _path(drawing, moved, **BETWEEN)
    _path(drawing, master.t_m, **OWN)
    _path(drawing, after, **AFTER)
    shown = np.vstack([_usual(p) for p in (master.t_m, moved, after)])
    for k, (points, how, name) in enumerate((
        (moved, BETWEEN, "moved by T"), (after, AFTER, "and turned by R"),
    )):  # fmt: skip
        near = magnified(sheet, drawing, _inset(drawing, k), shown, name)
        _path(near, master.t_m, **OWN)
        _path(near, points, **how)
    drawing.arrow(centre, centre + T, color=INK, lw=1.3)
    text = f"T, {number(float(np.linalg.norm(T)), 2)} m"
    drawing.text(centre + 0.42 * T, text, weight="bold", bbox=BOX)
    for point in moved[_ends(moved, centre + T)]:
        way = centre + T + arc(point - centre - T, R)
        drawing.curve(way, color=INK, lw=0.9)
    turn = np.degrees(np.linalg.norm(rotation.log(R)))
    way = centre + T + arc(moved[_ends(moved, centre + T)[0]] - centre - T, R)
    out = np.diff(drawing.projection.flat(np.array([centre + T, way[20]])), axis=0)[0]
    off = tuple(out / np.linalg.norm(out) * np.array([10.0, 5.0]))
    text = f"R, {number(float(turn), 1)}°"
    drawing.text(way[20], text, off, weight="bold", bbox=BOX)
    return sheet.figure


@styled()
def slave_figure(given: Superposed, title: str, note: str = "") -> Figure:
    """J Figure 8: R and T applied to the slave at the origin give its pose; the truth beside it."""
    master, slave = given.paths
    R, t = given.pose
    after = slave.t_m @ R.T + t
    points = [np.zeros((1, 3)), t[None], _usual(master.t_m), _usual(after)]
    rows = _rows(given)
    sheet, drawing = stage(
        np.vstack(points), title, _note(given, note), (len(rows) + 1) * ROW_MM + 3
    )
    entries = [
        Entry("board, from the master", dot=_large(OWN)),
        Entry("from the slave, after R and T", dot=_large(AFTER)),
        Entry("axes before R", line={"color": PALE, "lw": 0.9}),
    ]
    if given.reference is not None:
        entries.append(Entry("reference", line=GHOST))
    strip(sheet, MARGIN_MM, 0.5, WIDTH_MM, entries)
    height = len(rows) * ROW_MM
    canvas = sheet.canvas(MARGIN_MM, ROW_MM + 2, WIDTH_MM - 2 * MARGIN_MM, height)
    for k, row in enumerate(rows):
        canvas.text(0, height - (k + 0.5) * ROW_MM, row, size=SMALL_PT, va="center_baseline")
    _draw_stations(drawing, given, after, _floor(points))
    return sheet.figure


def _draw_stations(drawing: Stage, given: Superposed, after: np.ndarray, floor: float) -> None:
    """Both paths and both stations, the slave turned by R from the master's axes, and T."""
    R, t = given.pose
    _path(drawing, given.paths[MASTER].t_m, **OWN)
    _path(drawing, after, **AFTER)
    size = 16 * drawing.per_mm
    for place in (np.zeros(3), t, np.median(after, axis=0)):
        drawing.drop(place, floor)
    drawing.arrow(np.zeros(3), t, color=INK, lw=1.3)
    drawing.text(0.5 * t, "T", weight="bold", bbox=BOX)
    for k in range(3):
        drawing.line(np.array([t, t + size * np.eye(3)[k]]), color=PALE, lw=0.9)
        drawing.curve(t + 0.75 * arc(size * np.eye(3)[k], R), color=PALE, lw=0.8)
    drawing.frame(np.eye(3), np.zeros(3), size, color=COLOURS[MASTER], lw=1.2)
    drawing.frame(R, t, size, letters=1.5, color=COLOURS[SLAVE], lw=1.2)
    if given.reference is not None:
        R_true, t_true = given.reference
        for k in range(3):
            drawing.line(t_true + np.outer([0, 1.35 * size], R_true[:, k]), zorder=3, **GHOST)
    for place, station in ((np.zeros(3), MASTER), (t, SLAVE)):
        how: dict[str, Any] = {"color": COLOURS[station], "weight": "bold", "bbox": BOX}
        drawing.text(place, ROLES[station], (0, -5.0), **how)


def _rows(given: Superposed) -> list[str]:
    R, t = given.pose
    angles = ", ".join(
        f"{name} = {number(float(v), 2, sign=True)}°"
        for name, v in zip("αβγ", np.degrees(rotation.to_angles(R)), strict=True)
    )
    rows = [f"T = ({_numbers(1e3 * t, 1)}) mm,  R: {angles}"]
    if given.reference is not None:
        R_true, t_true = given.reference
        turned = np.degrees(rotation.error(R, R_true))
        rows.append(
            f"less the reference: ({_numbers(1e3 * (t - t_true), 1)}) mm,"
            f"  turned from it by ({_numbers(turned, 2)})° about x, y, z"
        )
    return rows


def _numbers(values: np.ndarray, digits: int) -> str:
    return ", ".join(number(float(v), digits, sign=True) for v in values)


def _note(given: Superposed, note: str) -> str:
    return f"{given.label}. {note}".strip()


def _usual(points: np.ndarray) -> np.ndarray:
    """Ends of all but the farthest hundredth in each coordinate."""
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    inside = points[((points >= low) & (points <= high)).all(axis=1)]
    return inside if len(inside) else points


def _floor(points: list[np.ndarray]) -> float:
    every = np.vstack(points)
    return float(every[:, 2].min() - 0.04 * np.ptp(every, axis=0).max())


def _path(drawing: Stage, points: np.ndarray, **how: Any) -> None:
    """A dot a measurement: those in the other minimum are apart, and no lines lead there."""
    shown = points[thinned(len(points))]
    drawing.line(shown, ls="", zorder=3, rasterized=len(shown) > DENSE, **how)


def _inset(drawing: Stage, which: int) -> tuple[float, float, float, float]:
    """Place in mm of one of two magnified parts, side by side at the foot of a page."""
    width = (WIDTH_MM - 2 * MARGIN_MM - INSET_GAP_MM) / 2
    left = MARGIN_MM + which * (width + INSET_GAP_MM)
    top = ROW_MM + 2 + size_mm(drawing.axes)[1] + 6.5
    return left, top, width, INSETS_MM - 8.0


def _with_boards(path: Path, board: np.ndarray) -> np.ndarray:
    """What a magnified part shows: the usual places of the board, and its corners there."""
    corners = outline(board)
    few = path.take(thinned(len(path), 60))
    near = np.isin(few.t_m, _usual(path.t_m)).all(axis=1)
    shown = few.t_m[near, None] + (few.R[near] @ corners.T).transpose(0, 2, 1)
    return np.vstack([_usual(path.t_m), shown.reshape(-1, 3)])


def _large(how: dict[str, Any]) -> dict[str, Any]:
    return how | {"markersize": 4.5}


def _boards(drawing: Stage, path: Path, board: np.ndarray, colour: str) -> None:
    """The board at some moments, equally far apart along its path."""
    step = np.linalg.norm(np.diff(path.t_m, axis=0), axis=1)
    far = np.concatenate([[0.0], np.cumsum(np.minimum(step, 5 * np.median(step)))])
    once = far <= _one_way(path.t_m, far)
    at = np.searchsorted(far, np.linspace(0, far[once].max(), N_BOARDS))
    corners = outline(board)
    for k in np.unique(np.clip(at, 0, len(path) - 1)):
        shown = path.t_m[k] + corners @ path.R[k].T
        drawing.fill(shown, facecolor=colour, alpha=0.10, edgecolor="none", zorder=2)
        drawing.line(shown[[0, 1, 2, 3, 0]], color=colour, lw=0.6, zorder=2)


def _one_way(points: np.ndarray, far: np.ndarray) -> float:
    """How far along the path the board has been everywhere once (within a tenth of its extent)."""
    low, high = np.percentile(points, [2, 98], axis=0)
    axis = int(np.argmax(high - low))
    reach = points[:, axis]
    tenth = 0.1 * (high - low)[axis]
    ends = [np.flatnonzero(reach < low[axis] + tenth), np.flatnonzero(reach > high[axis] - tenth)]
    return float(max(far[end[0]] for end in ends if end.size)) + 1e-9


def _half_board_mm(board: np.ndarray, drawing: Stage) -> float:
    return float(np.ptp(board, axis=0).max() / 2 / drawing.per_mm)


def _ends(points: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Two points: the usual one farthest from the centre, and the one most opposite to it."""
    inside = np.flatnonzero(
        (np.abs(points - centre) <= np.percentile(np.abs(points - centre), 98, axis=0)).all(axis=1)
    )
    about = points[inside] - centre
    first = int(np.argmax(np.linalg.norm(about, axis=1)))
    second = int(np.argmin(about @ about[first]))
    return inside[[first, second]]
