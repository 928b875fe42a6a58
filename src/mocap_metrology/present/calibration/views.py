"""Stations and the board's path seen from above and from the right, in the master's frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.lighthouse.records import MASTER, ROLES, SLAVE
from mocap_metrology.present.calibration.calibration_files import Agreement, Pose, thinned
from mocap_metrology.present.drawing.axes import linear_axis
from mocap_metrology.present.drawing.style import (
    GREY,
    INK,
    LOOKS,
    SMALL_PT,
    Keywords,
    label_axes,
    size_mm,
)
from mocap_metrology.present.text.numbers import number

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COLOURS = LOOKS["x"].colour, LOOKS["y"].colour  # of master and slave
PATHS: tuple[Keywords, ...] = (
    {"color": COLOURS[MASTER], "lw": 1.2, "ls": "-"},
    {"color": COLOURS[SLAVE], "lw": 0.8, "ls": (0, (3, 1.5))},
)
REFERENCE: Keywords = {"marker": "+", "color": INK, "markersize": 7.0, "mew": 0.9}
MIRRORED: Keywords = {"marker": "v", "color": INK, "markerfacecolor": "#ffcc33", "markersize": 4.2}
ELLIPSE = {"facecolor": "none", "edgecolor": INK, "lw": 0.9}
NAMES = ("x, forward (m)", "y, left (m)", "z, up (m)")
ABOVE, RIGHT = (0, 1), (0, 2)  # coordinates across and up the paper
FIELD_DEG = 60.0  # half of what a laser sweeps (J II)
CONE_MM, FRAME_MM, SMALLEST_MM = 15.0, 6.0, 1.6
LEAST_VIEW_M, LEAST_PATH_M, LONGEST_GAP_S = 3.0, 0.02, 0.1
ROUND = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000)


@dataclass(frozen=True)
class Scenery:
    """What both views show; slave None where no pose was found."""

    slave: Pose | None
    covariance: np.ndarray | None  # (6, 6), mm and deg
    reference: Pose | None
    both: Agreement | None
    alone_m: np.ndarray | None = None  # (n, 3) the master's path where there is no other

    @property
    def board_m(self) -> np.ndarray | None:
        """Where the board was on the whole."""
        moving = self.alone_m
        if self.both is not None and len(self.both.time_s):
            moving = self.both.master_m
        return None if moving is None else np.asarray(np.median(moving, axis=0))

    def points(self) -> np.ndarray:
        """What has to be on the paper, apart from cones."""
        found = [np.zeros((1, 3))]
        found += [pose[1][None] for pose in (self.slave, self.reference) if pose is not None]
        if self.both is not None:
            found.append(_usual(self.both.master_m))
        if self.alone_m is not None:
            found.append(_usual(self.alone_m))
        return np.concatenate(found)


def _usual(points: np.ndarray) -> np.ndarray:
    """Ends of all but the farthest hundredth in each coordinate: mirrored poses may be far off."""
    return np.percentile(points, [0.5, 99.5], axis=0) if len(points) else points


@dataclass(frozen=True)
class Frame:
    """Middle of the views and metres on a millimetre of paper, the same for both."""

    centre: np.ndarray  # (3,)
    per_mm: float

    @classmethod
    def around(cls, scenery: Scenery, width_mm: float, height_mm: float) -> Frame:
        points = scenery.points()
        low, high = points.min(axis=0), points.max(axis=0)
        room = np.array([width_mm, height_mm, height_mm]) - 2 * np.array([16.0, 9.0, 9.0])
        per_mm = max(((high - low) / room).max(), LEAST_VIEW_M / width_mm)
        return cls((low + high) / 2, float(per_mm))


def draw_view(axes: Axes, scenery: Scenery, frame: Frame, view: tuple[int, int]) -> None:
    """One view with equal scales; distances are written into the one from above."""
    size = size_mm(axes)
    for which, coordinate, mm in zip("xy", view, size, strict=True):
        half = frame.per_mm * mm / 2
        middle = frame.centre[coordinate]
        linear_axis(axes, which, (middle - half, middle + half), int(mm / 9))
    axes.set_aspect("equal")
    label_axes(axes, NAMES[view[0]], NAMES[view[1]], x_mm=7.0, y_mm=9.5)
    stations = [(MASTER, (np.eye(3), np.zeros(3)))]
    stations += [] if scenery.slave is None else [(SLAVE, scenery.slave)]
    _draw_paths(axes, scenery, view)
    _draw_distances(axes, scenery, view, frame.per_mm)
    ends = [pose[1] for _, pose in stations] + [scenery.board_m]
    for station, pose in stations:
        lines = [p for k, p in enumerate(ends) if p is not None and k != station]
        others = [p + FRAME_MM * frame.per_mm * R.T for k, (R, p) in stations if k != station]
        draw_station(axes, pose, station, view, frame.per_mm, (lines, others))
    if scenery.reference is not None:
        axes.plot(*scenery.reference[1][list(view)], ls="", zorder=5, **REFERENCE)
    if scenery.slave is not None and scenery.covariance is not None:
        scale = ellipse_scale(scenery.covariance, frame.per_mm)
        _draw_ellipse(axes, scenery.slave[1], scenery.covariance, view, scale)


def draw_station(
    axes: Axes, pose: Pose, station: int, view: tuple[int, int], per_mm: float,
    clear_of: tuple[Sequence[np.ndarray], Sequence[np.ndarray]],
) -> None:  # fmt: skip
    """Axes x, y, z of a station, what it can see, and its name, clear of lines to some points and
    of other points (n, 3)."""
    R, t = pose
    colour, own = COLOURS[station], list(view)
    turn = np.radians(np.linspace(-FIELD_DEG, FIELD_DEG, 25))
    across = np.zeros((25, 3))
    across[:, 0], across[:, view[1]] = np.cos(turn), np.sin(turn)
    fan = t + CONE_MM * per_mm * across @ R.T
    axes.fill(*np.vstack([t, fan])[:, own].T, color=colour, alpha=0.12, lw=0, zorder=1)
    for k, letter in enumerate("xyz"):
        end = t + FRAME_MM * per_mm * R[:, k]
        arrow = {"arrowstyle": "-|>,head_width=0.14,head_length=0.28", "color": colour, "lw": 0.9}
        arrow |= {"shrinkA": 0, "shrinkB": 0}
        axes.annotate("", tuple(end[own]), tuple(t[own]), arrowprops=arrow, zorder=4)
        reach = np.linalg.norm((end - t)[own]) / per_mm
        if reach > 0.5 * FRAME_MM:
            at = t + (FRAME_MM * (1 + 1.4 / reach)) * per_mm * R[:, k]
            how: Keywords = {
                "size": SMALL_PT - 0.5,
                "color": colour,
                "ha": "center",
                "va": "center",
            }
            axes.text(at[own[0]], at[own[1]], letter, **how)
    axes.plot(*t[own], "os"[station], color=colour, markersize=3.2, zorder=4)
    spokes = [FRAME_MM * R[own, k] * f for k in range(3) for f in (0.5, 1.0, 1.3)]
    for way in ((end - t)[own] / per_mm for end in clear_of[0]):
        far = float(np.linalg.norm(way))
        spokes += [way / max(far, 1e-9) * min(mm, far) for mm in (2.0, 4.0, 6.0, 8.0)]
    spokes += [way for points in clear_of[1] for way in (points - t)[:, own] / per_mm]
    at = t[own] + _free_place(np.array(spokes)) * per_mm
    how = {"color": colour, "weight": "bold", "size": SMALL_PT, "ha": "center", "va": "center"}
    axes.text(at[0], at[1], ROLES[station], zorder=6, **how)


def _free_place(taken: np.ndarray) -> np.ndarray:
    """Where a name stands, in mm about its station, farthest from the places (n, 2) taken."""
    turn = np.radians(np.arange(0, 360, 15))
    places = np.column_stack([8.0 * np.cos(turn), 4.2 * np.sin(turn)])
    apart = (places[:, None] - taken[None]) / np.array([1.8, 1.0])
    place: np.ndarray = places[
        np.argmax(np.linalg.norm(apart, axis=2).min(axis=1) - 1e-6 * np.sin(turn))
    ]
    return place


def _draw_paths(axes: Axes, scenery: Scenery, view: tuple[int, int]) -> None:
    own, both = list(view), scenery.both
    if both is not None:
        few = thinned(len(both.time_s))
        step = np.diff(both.time_s[few], prepend=both.time_s[0])
        gap = step > max(LONGEST_GAP_S, 3 * np.median(step))
        for points, how in zip((both.master_m, both.slave_m), PATHS, strict=True):
            shown = np.where(gap[:, None], np.nan, points[few])
            axes.plot(*shown[:, own].T, zorder=3, **how)
    elif scenery.alone_m is not None:
        axes.plot(*scenery.alone_m[thinned(len(scenery.alone_m))][:, own].T, zorder=3, **PATHS[0])


def _draw_distances(axes: Axes, scenery: Scenery, view: tuple[int, int], per_mm: float) -> None:
    """Lines between stations and board; their lengths in space, in the view from above."""
    places = [(MASTER, np.zeros(3))]
    places += [] if scenery.slave is None else [(SLAVE, scenery.slave[1])]
    board, lines = scenery.board_m, []
    if len(places) == 2:
        lines.append((places[0][1], places[1][1]))
    if board is not None:
        lines += [(place, board) for _, place in places]
    for start, end in lines:
        ends = np.array([start, end])[:, list(view)]
        axes.plot(*ends.T, color=GREY, lw=0.6, ls=(0, (1, 2)), zorder=2)
        if view != ABOVE:
            continue
        length = float(np.linalg.norm(end - start))
        step = ends[1] - ends[0]
        if np.linalg.norm(step) < 16 * per_mm:
            continue
        turn = (np.degrees(np.arctan2(step[1], step[0])) + 90) % 180 - 90
        box = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85}
        how: Keywords = {
            "rotation": turn,
            "rotation_mode": "anchor",
            "ha": "center",
            "va": "center",
        }
        middle = ends[0] + 0.55 * step
        text = f"{number(length, 2)} m"
        axes.text(middle[0], middle[1], text, size=SMALL_PT, bbox=box, zorder=2.5, **how)


def ellipse_scale(covariance: np.ndarray, per_mm: float) -> int:
    """How many times its size the ellipse is drawn, so that it can be seen on the paper."""
    largest = np.sqrt(np.linalg.eigvalsh(covariance[:3, :3])[-1]) / 1e3 / per_mm
    if not 0 < largest < SMALLEST_MM:
        return 1
    return next((k for k in ROUND if k * largest >= SMALLEST_MM), ROUND[-1])


def _draw_ellipse(
    axes: Axes, place: np.ndarray, covariance: np.ndarray, view: tuple[int, int], scale: int
) -> None:
    from matplotlib.patches import Ellipse

    own = list(view)
    part = covariance[np.ix_(own, own)] / 1e6
    values, vectors = np.linalg.eigh(part)
    width, height = 2 * scale * np.sqrt(np.clip(values, 0, None))
    turn = np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0]))
    axes.add_patch(
        Ellipse((place[view[0]], place[view[1]]), width, height, angle=turn, zorder=5, **ELLIPSE)
    )


def draw_closeup(axes: Axes, scenery: Scenery, still: bool) -> tuple[int, int] | None:
    """Both paths, in the view in which the board's path takes the most room; dots where
    the board is at rest."""
    both = scenery.both
    path = scenery.alone_m if both is None else both.master_m
    if path is None or len(path) < 2:
        return None
    low, high = _usual(path)
    inside = path[((path >= low) & (path <= high)).all(axis=1)]
    spread = np.cov((inside if len(inside) > 2 else path).T)
    views = ABOVE, RIGHT, (1, 2)
    view = max(views, key=lambda own: np.linalg.det(spread[np.ix_(own, own)]))
    own, size = list(view), np.array(size_mm(axes))
    per_mm = max(((high - low)[own] / (size - 8.0)).max(), LEAST_PATH_M / size[0])
    middle = (low + high)[own] / 2
    for which, centre, mm in zip("xy", middle, size, strict=True):
        half = per_mm * mm / 2
        linear_axis(axes, which, (centre - half, centre + half), int(mm / 11))
    axes.set_aspect("equal")
    label_axes(axes, NAMES[view[0]], NAMES[view[1]], x_mm=7.0, y_mm=12.5)
    _draw_paths(axes, scenery, view)
    if still:
        for line in axes.lines:
            line.set(linestyle="none", marker=".", markersize=2.0, rasterized=True)
    if both is not None and both.mirrored.any():
        axes.plot(*both.master_m[both.mirrored][:200, own].T, ls="", zorder=4, **MIRRORED)
    return view


def view_name(view: tuple[int, int]) -> str:
    """From where a view of two coordinates looks."""
    return {(0, 1): "from above", (0, 2): "from the right", (1, 2): "from the front"}[view]
