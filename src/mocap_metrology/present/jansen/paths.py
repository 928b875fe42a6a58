"""Figures 6 to 8 of J: paths of the board from both stations, superposed, and the slave's pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.records import MASTER, ROLES, SLAVE, Path
from mocap_metrology.present.calibration.calibration_files import (
    CalibrationFiles,
    Pose,
    pose_of,
    thinned,
)
from mocap_metrology.present.calibration.views import COLOURS
from mocap_metrology.present.drawing.legend import ROW_MM, Entry, strip
from mocap_metrology.present.drawing.style import (
    GREY,
    INK,
    MARGIN_MM,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    size_mm,
    styled,
)
from mocap_metrology.present.jansen.projection import BOX, Stage, arc, magnified, outline, stage
from mocap_metrology.present.text.numbers import number

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
GHOST: Keywords = {"color": INK, "lw": 0.8, "ls": (0, (2, 1.4))}
AXES_MM, REFERENCE_MM = 16.0, 21.0
BOLD: Keywords = {"weight": "bold", "bbox": BOX}
CORE, ROOM = (5, 95), 0.2  # percentiles of a path, and what is added of their distance
STAGES = {
    "kabsch": "from the superposition of both paths (Kabsch)",
    "final": "after the last minimisation",
    "static": "from a board at rest",
}


@dataclass(frozen=True)
class Superposed:
    """What the three figures show: both paths in their own frames, the pose, and the truth."""

    paths: tuple[Path, Path]
    board: np.ndarray
    pose: Pose
    reference: Pose | None
    label: str
    mirrored: float | None = None  # share of the board poses

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
        label = (
            f"Board poses by the estimator {entry['estimator']} with {entry['optics']} optics; R"
            f" and T {STAGES.get(entry['stage'], entry['stage'])}."
        )
        share = entry.get("mirrored_share")
        return cls(paths, given.board, pose_of(entry), given.reference, label, share)

    def note(self, more: str) -> str:
        """What the dots are, those off the path included, and `more`."""
        apart = (
            "Dots off the path: the search for that board pose ended elsewhere, in the other"
            f" minimum of a flat board (mirrored poses, {100 * self.mirrored:.2g} % here, many of"
            " them near the path) or before any minimum."
            if self.mirrored
            else ""
        )
        return " ".join(filter(None, (self.label, apart, more)))


@styled()
def paths_figure(given: Superposed, title: str, note: str = "") -> Figure:
    """J Figure 6: board poses as each station sees them, both stations at the origin."""
    points = [np.zeros((1, 3)), *(_usual(path.t_m) for path in given.paths)]
    page = given.note(note), ROW_MM + 2, INSETS_MM
    frames = [(np.eye(3), np.zeros(3), 13.0)]
    sheet, drawing = stage(np.vstack(points), title, *page, frames=frames)
    outlines = [_boards(path, given.board) for path in given.paths]
    some = "seven" if all(len(boards) == N_BOARDS for boards in outlines) else "some"
    strip(sheet, MARGIN_MM, 0.5, WIDTH_MM, [
        Entry("path of the board from the master", dot=_large(OWN)),
        Entry("from the slave", dot=_large(AFTER)),
        Entry(f"the board in {some} of its poses", patch={"color": GREY, "alpha": 0.3}),
    ])  # fmt: skip
    floor = _floor(points)
    for station, (path, how) in enumerate(zip(given.paths, (OWN, AFTER), strict=True)):
        text = f"as the {ROLES[station]} sees it"
        boards = outlines[station]
        shown = np.vstack([path.t_m[_core(path.t_m)], *boards])
        near = magnified(sheet, drawing, _inset(drawing, station), shown, text, [path.t_m])
        for into in (drawing, near):
            _path(into, path.t_m[into.inside(path.t_m)], **how)
            _draw_boards(into, boards, COLOURS[station])
        drawing.drop(np.median(path.t_m, axis=0), floor)
    drawing.drop(np.zeros(3), floor)
    length = 13 * drawing.per_mm
    drawing.frame(np.eye(3), np.zeros(3), length, color=INK, lw=1.1)
    drawing.letters(np.eye(3), np.zeros(3), length, INK)
    for station, path in enumerate(given.paths):
        above = path.t_m[_core(path.t_m)]
        above = above[np.argmax(above[:, 2])]
        off = 4.0 + _half_board_mm(given.board, drawing)
        how = BOLD | {"color": COLOURS[station]}
        drawing.name(above, f"as the {ROLES[station]} sees it", (0, off), **how)
    drawing.name(np.array([0.0, 0.0, length]), "both stations", (0, 6.5), **BOLD)
    return sheet.figure


@styled()
def superposition_figure(given: Superposed, title: str, note: str = "") -> Figure:
    """J Figure 7: the slave's path goes onto the master's: shifted with its centroid, turned by R
    about it. The shift is not the T of Figure 8, R c + T = c + shift for the centroid c."""
    master, slave = given.paths
    R, t = given.pose
    centre = _usual(slave.t_m).mean(axis=0)
    shift = R @ centre + t - centre
    moved, after = slave.t_m + shift, slave.t_m @ R.T + t
    points = [_usual(p) for p in (master.t_m, slave.t_m, moved, after)]
    page = given.note(note), ROW_MM + 2, INSETS_MM
    sheet, drawing = stage(np.vstack(points), title, *page)
    strip(sheet, MARGIN_MM, 0.5, WIDTH_MM, [
        Entry("master's path", dot=_large(OWN)),
        Entry("slave's, before", dot=_large(BEFORE)),
        Entry("shifted", dot=_large(BETWEEN)),
        Entry("and turned by R", dot=_large(AFTER)),
    ])  # fmt: skip
    drawn = (slave.t_m, BEFORE), (moved, BETWEEN), (master.t_m, OWN), (after, AFTER)
    for path, how in drawn:
        _path(drawing, path[drawing.inside(path)], **how)
    shown = np.vstack([p[_core(p)] for p in (master.t_m, moved, after)])
    insets = (moved, BETWEEN, "shifted"), (after, AFTER, "and turned by R")
    for k, (path, how, name) in enumerate(insets):
        both = (master.t_m, OWN), (path, how)
        box, dots = _inset(drawing, k), [p for p, _ in both]
        near = magnified(sheet, drawing, box, shown, name, dots)
        for own, look in both:
            _path(near, own[near.inside(own)], **look)
    _draw_shift_and_turn(drawing, moved, centre, shift, R)
    return sheet.figure


def _draw_shift_and_turn(
    drawing: Stage, moved: np.ndarray, centre: np.ndarray, shift: np.ndarray, R: np.ndarray
) -> None:
    """Arrows and names: of the centroid's shift, and of the turn at both ends of the path."""
    drawing.arrow(centre, centre + shift, color=INK, lw=1.3)
    about = centre + shift
    ways = [about + arc(moved[end] - about, R) for end in _ends(moved, about)]
    for way in ways:
        drawing.curve(way, color=INK, lw=0.9)
    text = f"shift of the centroid, {number(float(np.linalg.norm(shift)), 2)} m"
    drawing.name(centre + np.outer(np.linspace(0.3, 0.6, 7), shift), text, (0, 3.0), **BOLD)
    turn = np.degrees(np.linalg.norm(rotation.log(R)))
    out = drawing.mm(ways[0][20]) - drawing.mm(about)
    off = tuple(out / max(np.linalg.norm(out), 1.0) * np.array([9.0, 4.0]))
    drawing.name(ways[0][20], f"R, {number(float(turn), 1)}°", off, **BOLD)


@styled()
def slave_figure(given: Superposed, title: str, note: str = "") -> Figure:
    """J Figure 8: R and T applied to the slave at the origin give its pose; the truth beside it."""
    master, slave = given.paths
    R, t = given.pose
    after = slave.t_m @ R.T + t
    points = [np.zeros((1, 3)), t[None], _usual(master.t_m), _usual(after)]
    rows, frames = _rows(given), [(np.eye(3), np.zeros(3), AXES_MM)]
    frames += [(own, t, AXES_MM) for own in (np.eye(3), R)]
    if given.reference is not None:
        points.append(given.reference[1][None])
        frames.append((*given.reference, REFERENCE_MM))
    above = (len(rows) + 1) * ROW_MM + 3
    sheet, drawing = stage(np.vstack(points), title, given.note(note), above, frames=frames)
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
    for path, how in ((given.paths[MASTER].t_m, OWN), (after, AFTER)):
        _path(drawing, path[drawing.inside(path)], **how)
    size = AXES_MM * drawing.per_mm
    for place in (np.zeros(3), t, np.median(after, axis=0)):
        drawing.drop(place, floor)
    drawing.arrow(np.zeros(3), t, color=INK, lw=1.3)
    for k in range(3):
        drawing.line(np.array([t, t + size * np.eye(3)[k]]), color=PALE, lw=0.9)
        drawing.curve(t + 0.75 * arc(size * np.eye(3)[k], R), color=PALE, lw=0.8)
    stations = (MASTER, np.eye(3), np.zeros(3)), (SLAVE, R, t)
    for station, turn, place in stations:
        drawing.frame(turn, place, size, color=COLOURS[station], lw=1.2)
    if given.reference is not None:
        R_true, t_true = given.reference
        ends = REFERENCE_MM * drawing.per_mm
        for k in range(3):
            drawing.line(t_true + np.outer([0, ends], R_true[:, k]), zorder=3, **GHOST)
    for station, turn, place in stations:
        drawing.letters(turn, place, size, COLOURS[station])
        drawing.name(place, ROLES[station], (0, -4.5), **BOLD | {"color": COLOURS[station]})
    drawing.name(np.outer(np.linspace(0.4, 0.7, 7), t), "T", (2.2, 0), **BOLD)


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


def _usual(points: np.ndarray) -> np.ndarray:
    """Ends of all but the farthest hundredth in each coordinate."""
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    inside = points[((points >= low) & (points <= high)).all(axis=1)]
    return inside if len(inside) else points


def _core(points: np.ndarray) -> np.ndarray:
    """Which points are on the path: within the middle nine tenths in each coordinate and a little
    round them."""
    low, high = np.percentile(points, CORE, axis=0)
    room = ROOM * (high - low).max()
    near: np.ndarray = ((points >= low - room) & (points <= high + room)).all(axis=1)
    return near


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


def _large(how: Keywords) -> Keywords:
    return how | {"markersize": 4.5}


def _boards(path: Path, board: np.ndarray) -> list[np.ndarray]:
    """Corners (4, 3) of the board at some moments, equally far apart along its path."""
    path = path.take(_core(path.t_m))
    step = np.linalg.norm(np.diff(path.t_m, axis=0), axis=1)
    far = np.concatenate([[0.0], np.cumsum(np.minimum(step, 5 * np.median(step)))])
    once = far <= _one_way(path.t_m, far)
    at = np.searchsorted(far, np.linspace(0, far[once].max(), N_BOARDS))
    corners = outline(board)
    which = np.unique(np.clip(at, 0, len(path) - 1))
    return [path.t_m[k] + corners @ path.R[k].T for k in which]


def _draw_boards(drawing: Stage, boards: list[np.ndarray], colour: str) -> None:
    for shown in boards:
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
