"""Drawings in space by parallel projection: everything on a flat page, with equal scales, and
names where there is room."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.present.drawing.axes import round_ticks
from mocap_metrology.present.drawing.style import (
    FAINT,
    GREY,
    INK,
    POINT_MM,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    Sheet,
    blank_sheet,
    head,
    size_mm,
    text_mm,
    tick_text,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SAMPLE_MM = 0.5
CLEAR_MM = 0.7  # round a name
FAR = 0.35  # a millimetre from the wished place weighs as much as this length of line covered
ON_TEXT = 6.0  # weight of a square millimetre of another name
TURNS_RAD = np.radians(np.arange(0, 360, 22.5))
REACHES_MM = (1.0, 2.0, 3.5, 5.0, 7.0, 9.5, 12.0)


class Ground:
    """Lines, dots and names on a page of this width and height, in mm from its lower left corner,
    kept as points with weights: the length of line that each stands for."""

    def __init__(self, size_mm: tuple[float, float]) -> None:
        self.size_mm = np.array(size_mm)
        self._points = [np.zeros((0, 2))]
        self._weights = [np.zeros(0)]

    def line(self, points: np.ndarray, weight: float = 1.0) -> None:
        """A line through points (n, 2)."""
        for start, end in pairwise(points):
            n = max(int(np.ceil(np.linalg.norm(end - start) / SAMPLE_MM)), 1)
            self.dots(start + (end - start) * np.linspace(0, 1, n + 1)[:, None], weight * SAMPLE_MM)

    def dots(self, points: np.ndarray, weight: float = 1.0) -> None:
        self._points.append(points)
        self._weights.append(np.full(len(points), weight))

    def box(self, centre: np.ndarray, width: float, height: float) -> None:
        """A name about its centre."""
        x, y = (np.linspace(-s / 2, s / 2, int(np.ceil(s)) + 1) for s in (width, height))
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        self.dots(centre + grid, ON_TEXT)

    def free(self, wished: np.ndarray, width: float, height: float) -> np.ndarray:
        """The place (2,) near one of the wished ones (k, 2) where a name of this width and height
        covers the least; on the page where it can be."""
        ring = np.column_stack([np.cos(TURNS_RAD), np.sin(TURNS_RAD)])
        offsets = np.vstack([np.zeros((1, 2)), *(reach * ring for reach in REACHES_MM)])
        places = (wished[:, None] + offsets).reshape(-1, 2)
        away = np.tile(np.linalg.norm(offsets, axis=1), len(wished))
        half = np.array([width, height]) / 2
        points, weights = np.vstack(self._points), np.concatenate(self._weights)
        apart = np.abs(places[:, None] - points[None])
        covered = ((apart < half + CLEAR_MM).all(axis=2) * weights).sum(axis=1)
        beyond = np.maximum(half - places, places + half - self.size_mm).max(axis=1)
        best: np.ndarray = places[np.argmin(covered + FAR * away + 1e3 * np.maximum(beyond, 0.0))]
        return best


ARROW = {"arrowstyle": "-|>,head_width=0.18,head_length=0.36", "shrinkA": 0, "shrinkB": 0}
AZIMUTHS_DEG = (200, 215, 230, 245, 115, 130, 145, 160)  # of the viewer: behind the stations
ELEVATIONS_DEG = (20, 28, 36)
SIDE_MM, HIGHEST_MM, INSET_MM = 9.0, 100.0, 7.0
LETTER_MM, BESIDE_MM = 2.4, 1.8  # of a letter beyond the tip of its axis; of names
HEIGHT_PT = 0.8  # of letters, in their size
ON_DOT = 3.0
BOX = {"facecolor": "white", "edgecolor": "none", "pad": 0.5, "alpha": 0.8}


Axis3 = tuple[np.ndarray, np.ndarray, float]  # R (3, 3), t (3,) in m, length of the axes in mm


@dataclass(frozen=True)
class Projection:
    """Parallel projection for a viewer at this azimuth, from x towards y, and elevation."""

    azimuth_deg: float
    elevation_deg: float

    def flat(self, points: np.ndarray) -> np.ndarray:
        """(..., 3) in metres to (..., 2) in metres on the page, right and up."""
        a, e = np.radians([self.azimuth_deg, self.elevation_deg])
        right = [-np.sin(a), np.cos(a), 0.0]
        up = [-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)]
        flat: np.ndarray = np.asarray(points) @ np.array([right, up]).T
        return flat


def widest(points: np.ndarray) -> Projection:
    """The projection that spreads the points (n, 3) most over the page."""
    every = [Projection(a, e) for a in AZIMUTHS_DEG for e in ELEVATIONS_DEG]
    return max(every, key=lambda one: float(np.linalg.det(np.cov(one.flat(points).T))))


@dataclass(frozen=True)
class Stage:
    """Axes without frame in metres of the page, how points in space come onto them, and what they
    cover."""

    axes: Axes
    projection: Projection
    per_mm: float
    ground: Ground

    @classmethod
    def on(cls, axes: Axes, projection: Projection, per_mm: float) -> Stage:
        return cls(axes, projection, per_mm, Ground(size_mm(axes)))

    def mm(self, points: np.ndarray) -> np.ndarray:
        """Where points (..., 3) are on the page, in mm from the lower left corner of the axes."""
        low = np.array([self.axes.get_xlim()[0], self.axes.get_ylim()[0]])
        mm: np.ndarray = (self.projection.flat(points) - low) / self.per_mm
        return mm

    def inside(self, points: np.ndarray, margin_mm: float = 1.2) -> np.ndarray:
        """Which of the points (n, 3) are on the axes, none of them at the edge."""
        at = self.mm(points)
        inside = (at > margin_mm) & (at < self.ground.size_mm - margin_mm)
        return np.asarray(inside.all(axis=1))

    def line(self, points: np.ndarray, weight: float = 1.0, **how: Any) -> None:
        """weight: how much names have to keep off it."""
        self.axes.plot(*self.projection.flat(points).T, **how)
        if how.get("ls") == "" or len(points) == 1:
            self.ground.dots(self.mm(points), ON_DOT * weight)
        else:
            self.ground.line(self.mm(points), weight)

    def fill(self, points: np.ndarray, **how: Any) -> None:
        self.axes.fill(*self.projection.flat(points).T, **how)

    def arrow(self, start: np.ndarray, end: np.ndarray, **how: Any) -> None:
        ends = self.projection.flat(np.array([start, end]))
        zorder = how.pop("zorder", 4)
        self.axes.annotate("", ends[1], ends[0], arrowprops=ARROW | how, zorder=zorder)
        self.ground.line(self.mm(np.array([start, end])))

    def curve(self, points: np.ndarray, **how: Any) -> None:
        """A line with an arrow's head at its end."""
        self.line(points[:-1], **how)
        self.arrow(points[-2], points[-1], color=how["color"], lw=how.get("lw", 1.0))

    def name(
        self, points: np.ndarray, text: str, off_mm: np.ndarray | tuple[float, float] | None = None,
        **how: Any,
    ) -> None:  # fmt: skip
        """A name at the freest place near one of the points (3,) or (k, 3): so far off it (2,) or
        (m, 2), or to its left or right, above or below. Names come after all that they have to keep
        off."""
        options: Keywords = {"size": SMALL_PT, "zorder": 6, "ha": "center"} | how
        height = HEIGHT_PT * options["size"] * POINT_MM
        width = text_mm(text, options["size"], options.get("weight", "normal"))
        if off_mm is None:
            beside, above = width / 2 + BESIDE_MM, height / 2 + BESIDE_MM
            off_mm = np.array([[beside, 0], [-beside, 0], [0, above], [0, -above]])
        wished = self.mm(np.atleast_2d(points))[:, None] + np.atleast_2d(off_mm)
        at = self.ground.free(wished.reshape(-1, 2), width, height)
        self.ground.box(at, width, height)
        low = np.array([self.axes.get_xlim()[0], self.axes.get_ylim()[0]])
        x, y = low + at * self.per_mm
        self.axes.text(x, y, text, va="center_baseline", **options)

    def frame(self, R: np.ndarray, t: np.ndarray, length_m: float, **how: Any) -> None:
        """Axes x, y, z of a frame."""
        for k in range(3):
            self.arrow(t, t + length_m * R[:, k], **how)

    def letters(self, R: np.ndarray, t: np.ndarray, length_m: float, colour: str) -> None:
        """Names of the axes of a frame, at their tips."""
        for k, letter in enumerate("xyz"):
            tip = t + length_m * R[:, k]
            way = self.mm(tip) - self.mm(t)
            off = LETTER_MM * way / max(np.linalg.norm(way), LETTER_MM)
            self.name(tip, letter, tuple(off), color=colour)

    def floor(self, low: np.ndarray, high: np.ndarray) -> None:
        """A grid of metres under everything, labelled along the edges next to the viewer."""
        step = _step(float((high - low)[:2].max()))
        start, stop = np.floor(low[:2] / step) * step, np.ceil(high[:2] / step) * step
        lines = [np.arange(a, b + step / 2, step) for a, b in zip(start, stop, strict=True)]
        z = low[2]
        how: Keywords = {"color": FAINT, "lw": 0.6, "zorder": 0, "weight": 0.1}
        for x in lines[0]:
            self.line(np.array([[x, start[1], z], [x, stop[1], z]]), **how)
        for y in lines[1]:
            self.line(np.array([[start[0], y, z], [stop[0], y, z]]), **how)
        away = np.radians(self.projection.azimuth_deg)
        near_x = stop[0] if np.cos(away) > 0 else start[0]
        near_y = stop[1] if np.sin(away) > 0 else start[1]
        self._labels([np.array([x, near_y, z]) for x in lines[0]], lines[0], "x, forward (m)")
        self._labels([np.array([near_x, y, z]) for y in lines[1]], lines[1], "y, left (m)")

    def _labels(self, points: list[np.ndarray], values: np.ndarray, name: str) -> None:
        flat = self.projection.flat(np.array(points))
        along = (flat[-1] - flat[0]) / max(np.linalg.norm(flat[-1] - flat[0]), 1e-12)
        down = np.array([along[1], -along[0]])
        down *= -np.sign(down[1] or 1.0)
        how: Keywords = {"size": SMALL_PT, "ha": "center", "va": "center", "color": GREY}
        inwards = np.zeros(len(flat))  # ends give way to those of the other edge
        inwards[[0, -1]] = 1.8, -1.8
        for at, value, off in zip(flat, values, inwards, strict=True):
            place = at + (3.2 * down + off * along) * self.per_mm
            text = tick_text(round(value, 6))
            self.axes.text(place[0], place[1], text, **how)
            self._keep(place, text_mm(text, SMALL_PT))
        ticks = max(text_mm(tick_text(round(value, 6)), SMALL_PT) for value in values)
        deep = (abs(down[0]) * ticks + abs(down[1]) * 3.0) / 2  # half of a tick's text, across
        middle = (flat[0] + flat[-1]) / 2 + (5.6 + deep) * self.per_mm * down
        turn = (np.degrees(np.arctan2(along[1], along[0])) + 90) % 180 - 90
        self.axes.text(middle[0], middle[1], name, rotation=turn, rotation_mode="anchor", **how)
        for share in (-0.3, 0.0, 0.3):
            self._keep(middle + share * text_mm(name, SMALL_PT) * self.per_mm * along, 3.0)

    def _keep(self, flat: np.ndarray, width: float) -> None:
        """Keep names off one that stands at a place of the page."""
        low = np.array([self.axes.get_xlim()[0], self.axes.get_ylim()[0]])
        self.ground.box((flat - low) / self.per_mm, width, SMALL_PT * POINT_MM)

    def drop(self, point: np.ndarray, z: float) -> None:
        """A line from a point down to the floor."""
        foot = np.array([point[0], point[1], z])
        dotted = {"color": GREY, "lw": 0.5, "ls": (0, (1, 2)), "zorder": 1}
        self.line(np.array([point, foot]), weight=0.5, **dotted)
        self.line(foot[None], marker="o", color=GREY, ms=1.6, mew=0, zorder=1)


def _step(span: float) -> float:
    """Of a grid with at most eight lines."""
    ticks = round_ticks(0.0, max(span, 1e-3), 7)
    return float(ticks[1] - ticks[0]) if len(ticks) > 1 else span


def stage(
    points: np.ndarray, title: str, note: str, above_mm: float = 0.0, below_mm: float = 0.0,
    floor: bool = True, projection: Projection | None = None, frames: Sequence[Axis3] = (),
) -> tuple[Sheet, Stage]:  # fmt: skip
    """A page on which the points (n, 3) have room, their floor drawn, and frames (R, t, length of
    the axes in mm); `above_mm` and `below_mm` are left free."""
    projection = projection or widest(points)
    corners = _corners(points) if floor else points
    tips: list[np.ndarray] = []
    for _ in range(8 if frames else 1):  # tips move with the scale
        flat = projection.flat(np.vstack([corners, *tips]))
        span = np.ptp(flat, axis=0)
        room = WIDTH_MM - 2 * SIDE_MM, HIGHEST_MM - 2 * SIDE_MM
        per_mm = float(max(span[0] / room[0], span[1] / room[1]))
        tips = [t + mm * per_mm * R.T for R, t, mm in frames]
    width, height = WIDTH_MM - 4.0, float(span[1] / per_mm) + 2 * SIDE_MM
    sheet = blank_sheet(above_mm + height + below_mm, title, note)
    axes = sheet.canvas(2.0, above_mm, width, height)
    middle = (flat.min(axis=0) + flat.max(axis=0)) / 2
    half = np.array([width, height]) * per_mm / 2
    axes.set(xlim=(middle[0] - half[0], middle[0] + half[0]))
    axes.set(ylim=(middle[1] - half[1], middle[1] + half[1]))
    made = Stage.on(axes, projection, per_mm)
    if floor:
        made.floor(*_extent(points))
    return sheet, made


def _extent(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest coordinates, with room for a floor below."""
    low, high = points.min(axis=0), points.max(axis=0)
    low[2] -= 0.04 * float((high - low).max())
    return low, high


def _corners(points: np.ndarray) -> np.ndarray:
    """The points and the corners of the floor below them."""
    low, high = _extent(points)
    step = _step(float((high - low)[:2].max()))
    a, b = np.floor(low[:2] / step) * step, np.ceil(high[:2] / step) * step
    feet = [[x, y, low[2]] for x in (a[0], b[0]) for y in (a[1], b[1])]
    return np.vstack([points, feet])


def magnified(
    sheet: Sheet, whole: Stage, box: tuple[float, float, float, float], points: np.ndarray,
    title: str, dots: Sequence[np.ndarray] = (),
) -> Stage:  # fmt: skip
    """A framed part of a drawing round the points (n, 3), with a bar for its scale; the heading
    tells how many of the dots (n, 3) are outside. box: left, top, width, height in mm."""
    flat = whole.projection.flat(points)
    axes = sheet.axes(*box)
    size = np.array(box[2:])
    per_mm = float((np.ptp(flat, axis=0) / (size - 2 * INSET_MM)).max())
    middle = (flat.min(axis=0) + flat.max(axis=0)) / 2
    low, high = middle - size * per_mm / 2, middle + size * per_mm / 2
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xticks=[], yticks=[])
    made = Stage.on(axes, whole.projection, per_mm)
    out = sum(int((~made.inside(own)).sum()) for own in dots)
    remark = _enlarged(whole.per_mm / per_mm) + (f", {out} dots outside" if out else "")
    head(axes, title, remark)
    bar = float(round_ticks(0.0, 0.3 * size[0] * per_mm, 3)[1])
    for own in dots:
        made.ground.dots(made.mm(own))
    text = f"{tick_text(round(bar, 6))} m"
    wide = bar / per_mm + 1.5 + text_mm(text, SMALL_PT)
    corners = [
        [x, y] for y in (3.0, size[1] - 3.0) for x in (3.0 + wide / 2, size[0] - wide / 2 - 3.0)
    ]
    left, middle = made.ground.free(np.array(corners), wide, 3.0) - [wide / 2, 0.0]
    start, level = low + np.array([left, middle]) * per_mm
    axes.plot([start, start + bar], [level] * 2, color=INK, lw=1.6)
    how: Keywords = {"size": SMALL_PT, "va": "center"}
    axes.text(start + bar + 1.5 * per_mm, level, text, **how)
    return made


def _enlarged(times: float) -> str:
    if times >= 1.05:
        return f"{times:.2g}× as large"
    return "same scale" if times > 0.95 else f"at {100 * times:.2g} % of the size above"


def outline(board: np.ndarray) -> np.ndarray:
    """Corners (4, 3) of the rectangle round a board in its principal plane, in its own frame."""
    centre = board.mean(axis=0)
    axes = np.linalg.svd(board - centre, full_matrices=False)[2][:2]
    within = (board - centre) @ axes.T
    (a, c), (b, d) = within.min(axis=0), within.max(axis=0)
    corners: np.ndarray = centre + np.array([[a, c], [b, c], [b, d], [a, d]]) @ axes
    return corners


def arc(start: np.ndarray, turn: np.ndarray, n: int = 40) -> np.ndarray:
    """Points (n, 3) that `start` passes on its way by the rotation matrix `turn`."""
    from scipy.spatial.transform import Rotation

    vector = Rotation.from_matrix(turn).as_rotvec()
    points: np.ndarray = Rotation.from_rotvec(np.linspace(0, 1, n)[:, None] * vector).apply(start)
    return points
