"""Stations and the board's path seen from above and from the right, in the master's frame."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.lighthouse.records import MASTER, ROLES, SLAVE
from mocap_metrology.present.calibration.calibration_files import (
    Agreement,
    CalibrationFiles,
    Pose,
    agreement,
    pose_of,
    thinned,
)
from mocap_metrology.present.plot.figure import GREY, INK, LOOKS, SMALL_PT, Keywords

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from mocap_metrology.lighthouse.records import Path

COLOURS = LOOKS["x"].colour, LOOKS["y"].colour  # of master and slave
PATHS: tuple[Keywords, ...] = (
    {"color": COLOURS[MASTER], "lw": 1.2, "ls": "-"},
    {"color": COLOURS[SLAVE], "lw": 0.8, "ls": (0, (3, 1.5))},
)
REFERENCE: Keywords = {"marker": "+", "color": INK, "markersize": 7.0, "mew": 0.9}
MIRRORED: Keywords = {"marker": "v", "color": INK, "markerfacecolor": "#ffcc33", "markersize": 4.2}
NAMES = ("x, forward (m)", "y, left (m)", "z, up (m)")
ABOVE, RIGHT, FRONT = (0, 1), (0, 2), (1, 2)  # coordinates across and up the paper
SEEN_FROM = {ABOVE: "from above", RIGHT: "from the right", FRONT: "from the front"}
FIELD_DEG = 60.0  # half of what a laser sweeps (J II)
HIGH, PATH_HIGH = 0.68, 1.0  # heights of a view, and of the path near by, over their widths
CONE, AXES = 0.38, 0.15  # lengths in half widths of a view
LEAST_VIEW_M, LEAST_PATH_M, LONGEST_GAP_S = 1.5, 0.01, 0.1  # half widths; a gap in a path


@dataclass(frozen=True)
class Scenery:
    """What both views show: `paths` of the board in the frame of either station; slave None where
    no pose was found; `both`: these paths compared; `alone_m` (n, 3): the master's path where there
    is no other."""

    paths: tuple[Path, Path] | None
    slave: Pose | None
    covariance: np.ndarray | None  # (6, 6), mm and deg
    reference: Pose | None
    both: Agreement | None
    alone_m: np.ndarray | None

    @classmethod
    def of(cls, given: CalibrationFiles) -> Scenery:
        """Of the chosen estimate; of any board poses where there is none."""
        entry = given.chosen
        if entry is None:
            every = (given.paths(*kind) for kind in given.kinds)
            paths = next((found for found in every if found), None)
            alone = None if paths is None else paths[MASTER].t_m
            return cls(paths, None, None, given.reference, None, alone)
        paths, pose = given.paths(entry["estimator"], entry["optics"]), pose_of(entry)
        covariance = np.array(entry.get("covariance") or [[np.nan]], dtype=np.float64)
        both = None if paths is None else agreement(paths, pose)
        if both is not None and not both.time_s.size:
            both = None
        alone = paths[MASTER].t_m if paths is not None and both is None else None
        known = covariance if np.isfinite(covariance).all() else None
        return cls(paths, pose, known, given.reference, both, alone)

    @property
    def moving_m(self) -> np.ndarray | None:
        """(n, 3) places of the board in the master's frame."""
        return self.alone_m if self.both is None else self.both.master_m

    @property
    def board_m(self) -> np.ndarray | None:
        """Where the board was on the whole."""
        return None if self.moving_m is None else np.asarray(np.median(self.moving_m, axis=0))

    @property
    def stations(self) -> list[tuple[int, Pose]]:
        """Every station whose pose is known."""
        master = MASTER, (np.eye(3), np.zeros(3))
        return [master] if self.slave is None else [master, (SLAVE, self.slave)]

    def frame(self) -> tuple[np.ndarray, float]:
        """Middle (3,) and half the width of both views in metres, with room for names."""
        places = [pose[1][None] for _, pose in self.stations]
        places += [] if self.reference is None else [self.reference[1][None]]
        places += [] if self.moving_m is None else [usual(self.moving_m)]
        low, high = (np.vstack(places).min(axis=0), np.vstack(places).max(axis=0))
        half = ((high - low) * [0.86, 0.8 / HIGH, 0.8 / HIGH]).max()  # room for names
        return (low + high) / 2, max(float(half), LEAST_VIEW_M)


def usual(points: np.ndarray) -> np.ndarray:
    """Ends of all but the farthest hundredth in each coordinate: mirrored poses may be far off."""
    return np.percentile(points, [0.5, 99.5], axis=0) if len(points) else points


def draw_view(axes: Axes, scenery: Scenery, view: tuple[int, int]) -> None:
    """One view with equal scales: stations, what they can see, the board's path, lines between."""
    (centre, half), own = scenery.frame(), list(view)
    board = [] if scenery.board_m is None else [scenery.board_m]
    _draw_paths(axes, scenery, view)
    places = [pose[1] for _, pose in scenery.stations] + board
    for k, place in enumerate(places):
        ends = np.array([place, places[k - 1]])[:, own]
        axes.plot(*ends.T, color=GREY, lw=0.6, ls=(0, (1, 2)), zorder=2)
    for k, (station, pose) in enumerate(scenery.stations):
        others = [place for i, place in enumerate(places) if i != k]
        _draw_station(axes, pose, station, view, half, others)
    if scenery.reference is not None:
        place = scenery.reference[1][own]
        label = "reference" if scenery.covariance is None else None  # else beside the ellipses
        axes.plot(*place, ls="", zorder=5, label=label, **REFERENCE)
    _equal(axes, view, centre, half)


def _equal(
    axes: Axes,
    view: tuple[int, int],
    centre: np.ndarray,
    half: float,
    high: float = HIGH,
    ticks: int = 6,
) -> None:
    """Equal scales, `half` metres to the left and right of the centre."""
    from matplotlib.ticker import MaxNLocator

    across, up = (float(centre[k]) for k in view)
    axes.set(xlim=(across - half, across + half), ylim=(up - high * half, up + high * half))
    axes.set(xlabel=NAMES[view[0]], ylabel=NAMES[view[1]], aspect="equal")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(ticks, steps=[1, 2, 5, 10]))


def _draw_station(
    axes: Axes,
    pose: Pose,
    station: int,
    view: tuple[int, int],
    half: float,
    others: Sequence[np.ndarray],
) -> None:
    """Axes x, y, z of a station, what it can see, and its name, in the widest gap between its axes
    and the directions to other places (3,)."""
    (R, t), colour, own = pose, COLOURS[station], list(view)
    turn = np.radians(np.linspace(-FIELD_DEG, FIELD_DEG, 25))
    rays = np.zeros((25, 3))
    rays[:, 0], rays[:, view[1]] = np.cos(turn), np.sin(turn)
    fan = np.vstack([t, t + CONE * half * rays @ R.T])[:, own]
    label = f"120° in view of the {ROLES[station]}"
    axes.fill(*fan.T, color=colour, alpha=0.12, lw=0, zorder=1, label=label)
    at = t[own]
    axes.plot(*at, "os"[station], color=colour, markersize=3.2, zorder=4)
    ways = [way for place in others if np.linalg.norm(way := (place - t)[own]) > 0.02 * half]
    arrow: Keywords = {"arrowstyle": "<|-,head_width=0.14,head_length=0.28", "color": colour}
    arrow |= {"shrinkA": 0, "shrinkB": 0, "lw": 0.9}
    how: Keywords = {"color": colour, "size": SMALL_PT, "ha": "center", "va": "center"}
    for letter, way in zip("xyz", R.T[:, own], strict=True):
        ways.append(way)
        if np.linalg.norm(way) > 0.5:
            tip = at + AXES * half * way * (1 + 0.25 / np.linalg.norm(way))
            axes.annotate(letter, tuple(at), tuple(tip), arrowprops=arrow, zorder=4, **how)
    turns = np.sort([np.arctan2(y, x) for x, y in ways if np.hypot(x, y) > 1e-3])
    gaps = np.diff(np.append(turns, turns[0] + 2 * np.pi))
    free = turns[np.argmax(gaps)] + gaps.max() / 2
    off = float(25 * np.cos(free)), float(13 * np.sin(free))
    bold: Keywords = {"weight": "bold", "textcoords": "offset points", "zorder": 6}
    axes.annotate(ROLES[station], tuple(at), off, **how, **bold)


def _draw_paths(axes: Axes, scenery: Scenery, view: tuple[int, int]) -> None:
    own, both = list(view), scenery.both
    names = "path of the board, by the master", "by the slave, after R and t"
    if both is not None:
        few = thinned(len(both.time_s))
        step = np.diff(both.time_s[few], prepend=both.time_s[0])
        gap = step > max(LONGEST_GAP_S, 3 * np.median(step))
        for points, how, name in zip((both.master_m, both.slave_m), PATHS, names, strict=True):
            shown = np.where(gap[:, None], np.nan, points[few])
            axes.plot(*shown[:, own].T, zorder=3, label=name, **how)
    elif scenery.alone_m is not None:
        alone = scenery.alone_m[thinned(len(scenery.alone_m))]
        axes.plot(*alone[:, own].T, zorder=3, label=names[MASTER], **PATHS[MASTER])


def draw_path(axes: Axes, scenery: Scenery, still: bool) -> str:
    """Both paths in detail, in the view in which the board's path is largest, dots where the
    board is at rest; returns from where, nothing where there is no path."""
    path, both = scenery.moving_m, scenery.both
    if path is None or len(path) < 2:
        return ""
    low, high = usual(path)
    inside = path[((path >= low) & (path <= high)).all(axis=1)]
    spread = np.cov((inside if len(inside) > 2 else path).T)
    view = max(SEEN_FROM, key=lambda own: float(np.linalg.det(spread[np.ix_(own, own)])))
    own = list(view)
    half = 0.6 * ((high - low)[own] / [1, PATH_HIGH]).max()
    _draw_paths(axes, scenery, view)
    if still:
        for line in axes.lines:
            line.set(linestyle="none", marker=".", markersize=2.0, rasterized=True)
    if both is not None and both.mirrored.any():
        axes.plot(*both.master_m[both.mirrored][:200, own].T, ls="", zorder=4, **MIRRORED)
    _equal(axes, view, (low + high) / 2, max(float(half), LEAST_PATH_M), PATH_HIGH, 3)
    return SEEN_FROM[view]
