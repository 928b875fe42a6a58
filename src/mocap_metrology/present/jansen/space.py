"""Drawings in space on matplotlib's own axes, parallel projection and equal scales; J Figure 5."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mocap_metrology.lighthouse.records import Path
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters
from mocap_metrology.present.calibration.stations import COLOURS, NAMES
from mocap_metrology.present.plot import figure
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import number

Pose = tuple[np.ndarray, np.ndarray]
View = tuple[float, float]  # azimuth of the viewer, from x towards y, and elevation, in deg
VIEWS = [(a, e) for a in (200, 215, 230, 245, 115, 130, 145, 160) for e in (20, 28, 36)]
IN_SPACE: figure.Keywords = {"projection": "3d", "proj_type": "ortho", "computed_zorder": False}
LEAST = 0.25  # extent of an axis, of the longest one
DIAGONAL = 1.03  # of a box, as long as matplotlib draws it, in the side of its square
LEAST_DEG = 22.0  # angles of Figure 5 as drawn, so that arcs can be distinguished
MOST_MOMENTS = 60


def flat(points: np.ndarray, view: View) -> np.ndarray:
    """(..., 3) to (..., 2) on the page, right and up, in the same unit."""
    a, e = np.radians(view)
    right = [-np.sin(a), np.cos(a), 0.0]
    page = np.array([right, [-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)]])
    return np.asarray(np.asarray(points) @ page.T)


def widest(points: np.ndarray) -> View:
    """The view from behind the stations that spreads the points (n, 3) most over the page."""
    return max(VIEWS, key=lambda view: float(np.linalg.det(np.cov(flat(points, view).T))))


def show(
    axes: figure.Axes3D, points: np.ndarray, view: View, room: tuple[float, float], ticks: int = 6
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
    axes.set(**dict(zip(("xlim", "ylim", "zlim"), limits.T, strict=True)))
    axes.set(**dict(zip(("xlabel", "ylabel", "zlabel"), NAMES, strict=True)))
    corners = np.array(np.meshgrid(*limits.T)).reshape(3, -1).T
    extent = np.ptp(flat(corners, view), axis=0) / float(np.linalg.norm(2 * half))
    axes.set_box_aspect(tuple(2 * half), zoom=float((np.array(room) / extent).min()) / DIAGONAL)
    axes.view_init(view[1], view[0])
    step = float(np.diff(MaxNLocator(ticks, steps=[1, 2, 5, 10]).tick_values(0, 1.08 * longest))[0])
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        axis.set_major_locator(MultipleLocator(step))
        axis.set_pane_color("white")
        axis.labelpad = 2.0 if axis is axes.zaxis else -2.0
        axis.set_tick_params(pad=2.0 if axis is axes.zaxis else -2.0)
        axis._axinfo["grid"].update(color=figure.FAINT, linewidth=0.5)
    return limits


def curve(axes: figure.Axes3D, points: np.ndarray, head: bool = True, **how: object) -> None:
    """A line through points (n, 3), with an arrow's head at its end."""
    axes.plot(*points.T, **how)
    if head:
        before = points[-8] if len(points) > 8 else points[0] + 0.96 * (points[-1] - points[0])
        how = {k: v for k, v in how.items() if k not in ("ls", "label")}
        axes.quiver(*before, *(points[-1] - before), arrow_length_ratio=1.0, **how)


def write(axes: figure.Axes3D, place: np.ndarray, text: str, **how: object) -> None:
    """Words about a place (3,), on a pale ground; on the page, so that layout knows their room."""
    from mpl_toolkits.mplot3d.proj3d import proj_transform

    box = {"boxstyle": "square,pad=0.1", "facecolor": "white", "lw": 0, "alpha": 0.7}
    how = {"ha": "center", "va": "center", "size": figure.SMALL_PT, "zorder": 7, **how}
    x, y, _ = proj_transform(*place, axes.get_proj())
    axes.text2D(x, y, text, bbox=box, **how)


def draw_frame(axes: figure.Axes3D, pose: Pose, length_m: float, colour: str) -> None:
    """Axes x, y, z of a frame R (3, 3), t (3,), with their letters."""
    R, t = pose
    for letter, way in zip("xyz", length_m * R.T, strict=True):
        axes.quiver(*t, *way, arrow_length_ratio=0.16, color=colour, lw=1.2, zorder=5)
        write(axes, t + 1.25 * way, letter, color=colour)


def unclipped(axes: Iterable[figure.Axes3D]) -> None:
    """Enlarged axes are larger than the square that matplotlib cuts them to."""
    for one in axes:
        for artist in (*one.lines, *one.collections, *one.texts):
            artist.set(clip_on=False, in_layout=False)


def arc(start: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Points (40, 3) that `start` passes on its way by the rotation matrix `turn`."""
    from scipy.spatial.transform import Rotation

    vector = Rotation.from_matrix(turn).as_rotvec()
    steps = Rotation.from_rotvec(np.linspace(0, 1, 40)[:, None] * vector)
    return np.asarray(steps.apply(start))


def clearest_point(paths: tuple[Path, Path], board: np.ndarray) -> np.ndarray:
    """The place of that diode, at some moments, which is farthest off both axes, in the frame of a
    station."""
    some = [path.take(np.arange(0, len(path), max(len(path) // MOST_MOMENTS, 1))) for path in paths]
    every = np.concatenate([
        ((path.R @ board.T).transpose(0, 2, 1) + path.t_m[:, None]).reshape(-1, 3) for path in some
    ])  # fmt: skip
    every = np.ascontiguousarray(every[every[:, 0] > 0])
    seen = np.abs(angles(every, rotor_parameters()))
    return np.asarray(every[int(np.argmax(seen.min(axis=1)))])


@figure.styled()
def angles_figure(point: np.ndarray, source: str) -> figure.Picture:
    """P and its projection P' on the XZ plane, with theta = atan2(y, x), phi' = atan2(z, x) (J
    Eq. 1, from the rotor model) and phi = atan2(z, sqrt(x^2 + y^2)). point (3,) in m in the
    station's frame."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection
    from scipy.spatial import geometric_slerp

    least = np.abs(point[1:]).min() / point[0]
    stretches = (k for k in range(1, 9) if np.degrees(np.arctan(k * least)) >= LEAST_DEG)
    stretch = next(stretches, 8)
    P = point * [1, stretch, stretch]
    origin, along, below, behind = (P * k for k in ([0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 0, 1]))
    tips = np.diag(np.where(P > 0, 1.18, 0.5) * np.abs(P))
    times = f"y and z are drawn {stretch} times as long as x." if stretch > 1 else ""
    texts = captions.of_figure("jansen", 5, source, times)
    body = figure.new_figure(texts, 108.0)
    axes: figure.Axes3D = body.subplots(subplot_kw=IN_SPACE)
    corners = np.vstack([origin, tips, P, below, behind])
    show(axes, corners, (48.0 if P[1] < 0 else -48.0, 22.0), (1.5, 1.05))
    axes.axis("off")
    axes.set(xlabel="", ylabel="", zlabel="")
    plane = np.array([origin, 1.1 * along, 1.1 * behind, 1.1 * (behind - along)])
    azimuth, elevation, spherical = *COLOURS, figure.LOOKS["z"].colour
    axes.add_collection3d(Poly3DCollection([plane], fc=(elevation, 0.07), zorder=0))
    axes.plot(*np.array([origin, P]).T, color=figure.INK, lw=1.3)
    for end, colour in ((behind, elevation), (below, azimuth)):
        axes.plot(*np.array([origin, end]).T, color=colour, lw=1.0, ls=(0, (4, 1.6)))
        for start in (P, along):
            axes.plot(*np.array([start, end]).T, color=figure.GREY, lw=0.7, ls=(0, (1, 1.6)))
    for tip, letter in zip(tips, "xyz", strict=True):
        axes.quiver(*tip * 0, *tip, arrow_length_ratio=0.05, color=figure.GREY, lw=1.0)
        write(axes, 1.09 * tip, letter, color=figure.GREY)
    for place, letter in ((P, "P"), (behind, "P′")):
        axes.plot(*place[:, None], "o", color=figure.INK, ms=4.0, zorder=5)
        write(axes, place + 0.1 * (P - below), letter, weight="bold")
    axes.plot([0], [0], [0], "s", color=figure.INK, ms=6.0, zorder=5, label="laser of the station")
    metres = ", ".join(number(float(v), 3, sign=True) for v in point)
    axes.plot([], [], [], "o", color=figure.INK, ms=4.0, label=f"P = ({metres}) m")
    axes.plot([], [], [], "s", color=elevation, alpha=0.2, ms=7.0, label="XZ plane")
    theta, phi = np.degrees(angles(point[None], rotor_parameters())[0]).tolist()
    of_P = float(np.degrees(np.arctan2(point[2], np.hypot(point[0], point[1]))))
    for start, end, share, symbol, degrees, words, colour in (
        (along, below, 0.82, r"$\theta$", theta, "azimuth of P", azimuth),
        (along, behind, 0.62, r"$\phi'$", phi, "elevation of P′, as measured", elevation),
        (below, P, 0.72, r"$\phi$", of_P, "elevation of P", spherical),
    ):
        first, last = (v / np.linalg.norm(v) for v in (start, end))
        way = geometric_slerp(first, last, np.linspace(0, 1, 40)) * share * np.linalg.norm(start)
        label = f"{symbol} = {number(degrees, 2, sign=True)}°, {words}"
        curve(axes, way, color=colour, lw=1.2, label=label)
        write(axes, 1.1 * way[20], symbol, color=colour, size=10)
    unclipped([axes])
    return figure.finished(body, [axes], texts.caption, columns=3)
