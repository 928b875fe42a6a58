"""Drawings in space on matplotlib's own axes: parallel projection, equal scales."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.plot.figure import FAINT, SMALL_PT, Keywords

if TYPE_CHECKING:
    from mpl_toolkits.mplot3d.axes3d import Axes3D

AZIMUTHS_DEG = (200, 215, 230, 245, 115, 130, 145, 160)  # of the viewer: behind the stations
ELEVATIONS_DEG = (20, 28, 36)
IN_SPACE: Keywords = {"projection": "3d", "proj_type": "ortho", "computed_zorder": False}
LEAST = 0.25  # extent of an axis, of the longest one
HEAD, ASIDE = 0.16, 0.3  # of an axis: head of its arrow, and distance of its letter
DIAGONAL = 1.03  # of a box, as long as matplotlib draws it, in the side of its square
LABEL_PT, TICK_PT, UP_PT = -2.0, -2.0, 2.0  # distances of labels and numbers, and of those of z


@dataclass(frozen=True)
class View:
    """A viewer at this azimuth, from x towards y, and elevation."""

    azimuth_deg: float
    elevation_deg: float

    @property
    def page(self) -> np.ndarray:
        """(2, 3) unit vectors in space to the right and up the page."""
        a, e = np.radians([self.azimuth_deg, self.elevation_deg])
        right = [-np.sin(a), np.cos(a), 0.0]
        return np.array([right, [-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)]])

    def flat(self, points: np.ndarray) -> np.ndarray:
        """(..., 3) to (..., 2) on the page, right and up, in the same unit."""
        flat: np.ndarray = np.asarray(points) @ self.page.T
        return flat


VIEWS = tuple(View(a, e) for a in AZIMUTHS_DEG for e in ELEVATIONS_DEG)


def widest(points: np.ndarray) -> View:
    """The view that spreads the points (n, 3) most over the page."""
    return max(VIEWS, key=lambda view: float(np.linalg.det(np.cov(view.flat(points).T))))


def clearest(points: np.ndarray) -> View:
    """The view in which the nearest two of the points (n, 3) are farthest apart on the page."""

    def least(view: View) -> float:
        flat = view.flat(points)
        apart = np.linalg.norm(flat[:, None] - flat[None], axis=2)
        return float(apart[np.triu_indices(len(flat), 1)].min())

    return max(VIEWS, key=least)


def freest(
    places: np.ndarray, taken: np.ndarray, view: View, shape: tuple[float, float] = (1.0, 1.0)
) -> np.ndarray:
    """Of the places (n, 3) the one farthest on the page from the points (k, 3) taken; shape: width
    and height of what is drawn there, in any unit."""
    apart = (view.flat(places)[:, None] - view.flat(taken)[None]) / np.array(shape)
    place: np.ndarray = places[np.argmax(np.linalg.norm(apart, axis=2).min(axis=1))]
    return place


def show(
    axes: Axes3D, points: np.ndarray, view: View, room: tuple[float, float], ticks: int = 6
) -> np.ndarray:
    """Axes in metres, equal scales, round the points (n, 3); (2, 3) lowest and highest values.

    room: width and height that they may take, in the side of matplotlib's square; ticks: on the
    longest axis.
    """
    from matplotlib.ticker import MaxNLocator, MultipleLocator

    low, high = points.min(axis=0), points.max(axis=0)
    longest = float((high - low).max())
    half = np.maximum(0.54 * (high - low), LEAST * longest / 2)
    limits: np.ndarray = (low + high) / 2 + np.array([[-1.0], [1.0]]) * half
    axes.set(xlim=limits[:, 0], ylim=limits[:, 1], zlim=limits[:, 2])
    axes.set(xlabel="x, forward (m)", ylabel="y, left (m)", zlabel="z, up (m)")
    edges = np.array(np.meshgrid(*limits.T)).reshape(3, -1).T
    extent = np.ptp(view.flat(edges), axis=0) / float(np.linalg.norm(2 * half))
    axes.set_box_aspect(tuple(2 * half), zoom=float((np.array(room) / extent).min()) / DIAGONAL)
    axes.view_init(view.elevation_deg, view.azimuth_deg)
    axes.tick_params(pad=TICK_PT)
    axes.tick_params(axis="z", pad=UP_PT)
    step = float(np.diff(MaxNLocator(ticks, steps=[1, 2, 5, 10]).tick_values(0, 1.08 * longest))[0])
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_locator(MultipleLocator(step))
        axis.set_pane_color("white")
        axis.labelpad = UP_PT if axis is axes.zaxis else LABEL_PT
        axis._axinfo["grid"].update(color=FAINT, linewidth=0.5)
    return limits


def arrow(axes: Axes3D, start: np.ndarray, way: np.ndarray, head_m: float, **how: object) -> None:
    """An arrow from a point (3,) along (3,)."""
    ratio = min(head_m / max(float(np.linalg.norm(way)), 1e-9), 1.0)
    axes.quiver(*start, *way, arrow_length_ratio=ratio, **how)


def name(axes: Axes3D, place: np.ndarray, text: str, **how: object) -> None:
    """Words about a place (3,), on the page: what they cover is known, as of all words on it."""
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    x, y, _ = proj_transform(*place, axes.get_proj())
    axes.text2D(x, y, text, ha="center", va="center", **how)


def unclipped(axes: Iterable[Axes3D]) -> None:
    """Enlarged axes are larger than the square that matplotlib cuts them to."""
    for one in axes:
        for artist in (*one.lines, *one.collections, *one.texts):
            artist.set(clip_on=False, in_layout=False)


def ring(view: View, width: float, height: float) -> np.ndarray:
    """(24, 3) points of an ellipse on the page about the origin."""
    turn = np.radians(np.arange(0, 360, 15))[:, None]
    points: np.ndarray = width * np.cos(turn) * view.page[0] + height * np.sin(turn) * view.page[1]
    return points


def draw_frame(
    axes: Axes3D, pose: tuple[np.ndarray, np.ndarray], length_m: float, colour: str, view: View,
    taken: Sequence[np.ndarray] = (),
) -> np.ndarray:  # fmt: skip
    """Axes x, y, z of a frame R (3, 3), t (3,), with their letters, off the points (k, 3) taken.
    Returns all points that they take."""
    R, t = pose
    ends = t + length_m * R.T
    own = [np.linspace(t, end, 40) for end in ends]
    about = ring(view, ASIDE * length_m, ASIDE * length_m)
    for letter, end in zip("xyz", ends, strict=True):
        arrow(axes, t, end - t, HEAD * length_m, color=colour, lw=1.2, zorder=5)
        own.append(freest(end + about, np.vstack([*own, *taken]), view)[None])
        name(axes, own[-1][0], letter, color=colour, size=SMALL_PT, zorder=6)
    return np.vstack(own)


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
