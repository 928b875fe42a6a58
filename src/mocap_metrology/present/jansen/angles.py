"""Figure 5 of J: azimuth and elevation of a photodiode."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.lighthouse.records import Path
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters
from mocap_metrology.present.calibration.views import COLOURS
from mocap_metrology.present.jansen.space import (
    IN_SPACE,
    View,
    arrow,
    freest,
    name,
    show,
    unclipped,
)
from mocap_metrology.present.plot.figure import (
    GREY,
    INK,
    LOOKS,
    Keywords,
    Picture,
    legend_below,
    new_figure,
    styled,
)
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import number

if TYPE_CHECKING:
    from mpl_toolkits.mplot3d.axes3d import Axes3D

LEAST_DEG = 22.0  # as drawn, so that arcs can be distinguished
MOST_MOMENTS = 60
AZIMUTH, ELEVATION, SPHERICAL = COLOURS[0], COLOURS[1], LOOKS["z"].colour
DASHED: Keywords = {"lw": 1.0, "ls": (0, (4, 1.6))}
DOTTED: Keywords = {"color": GREY, "lw": 0.7, "ls": (0, (1, 1.6))}
NAME: Keywords = {"weight": "bold", "zorder": 6}


def clearest_point(paths: tuple[Path, Path], board: np.ndarray) -> np.ndarray:
    """Of the diodes at some moments, in the frame of a station: the one farthest off both axes."""
    points = []
    for path in paths:
        few = path.take(np.arange(0, len(path), max(len(path) // MOST_MOMENTS, 1)))
        points.append((few.R @ board.T).transpose(0, 2, 1) + few.t_m[:, None])
    every = np.concatenate(points).reshape(-1, 3)
    every = every[every[:, 0] > 0]
    seen = np.abs(angles(np.ascontiguousarray(every), rotor_parameters()))
    clearest: np.ndarray = every[int(np.argmax(seen.min(axis=1)))]
    return clearest


@styled()
def angles_figure(point: np.ndarray, title: str, source: str) -> Picture:
    """P and its projection P' on the XZ plane, with theta = atan2(y, x), phi' = atan2(z, x) (J
    Eq. 1, from the rotor model) and phi = atan2(z, sqrt(x^2 + y^2)).

    point (3,) in m in the station's frame. Where its angles are small, y and z are drawn some times
    as long, as the caption states.
    """
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    stretch = next((k for k in range(1, 9) if _least_deg(point, k) >= LEAST_DEG), 8)
    P = point * [1, stretch, stretch]
    origin, along, flat, behind = (P * k for k in ([0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 0, 1]))
    tips = np.diag(np.where(P > 0, 1.18, 0.5) * np.abs(P))
    corners = np.vstack([origin, tips, P, flat, behind])
    view = _clearest_view(corners[1:], 1 if P[1] < 0 else -1)
    body = new_figure(title, source, 108.0)
    axes: Axes3D = body.subplots(subplot_kw=IN_SPACE)
    show(axes, corners, view, (1.5, 1.05))
    axes.set(xlabel="", ylabel="", zlabel="")
    axes.axis("off")
    plane = np.array([origin, 1.1 * along, 1.1 * behind, 1.1 * (behind - along)])
    axes.add_collection3d(Poly3DCollection([plane], fc=(ELEVATION, 0.07), zorder=0))
    lines = (
        (origin, P, {"color": INK, "lw": 1.3}),
        (origin, behind, DASHED | {"color": ELEVATION}),
        (origin, flat, DASHED | {"color": AZIMUTH}),
        *((start, end, DOTTED) for start in (P, along) for end in (flat, behind)),
    )
    for start, end, how in lines:
        axes.plot(*np.array([start, end]).T, **how)
    for tip, letter in zip(tips, "xyz", strict=True):
        arrow(axes, origin, tip, 0.04 * float(P[0]), color=GREY, lw=1.0)
        name(axes, 1.07 * tip, letter, color=GREY)
    for place, letter in ((P, "P"), (behind, "P′")):
        axes.plot(*place[:, None], "o", color=INK, ms=4.0, zorder=5)
        name(axes, place + 0.08 * (P - flat), letter, **NAME)
    axes.plot([0], [0], [0], "s", color=INK, ms=6.0, zorder=5, label="laser of the station")
    metres = ", ".join(number(float(v), 3, sign=True) for v in point)
    axes.plot([], [], [], "o", color=INK, ms=4.0, label=f"P = ({metres}) m")
    axes.plot([], [], [], "s", color=ELEVATION, alpha=0.2, ms=7.0, label="XZ plane")
    ways = [_arc(along, flat, 0.82), _arc(along, behind, 0.62), _arc(flat, P, 0.72)]
    ends = [(start, end) for start, end, _ in lines] + [(origin, tip) for tip in tips]
    taken = np.vstack([*(np.linspace(start, end, 100) for start, end in ends), *ways])
    for way, (symbol, angle, colour) in zip(ways, _names(point), strict=True):
        axes.plot(*way.T, color=colour, lw=1.2, label=angle)
        axes.quiver(*way[-5], *(way[-1] - way[-5]), arrow_length_ratio=1.0, color=colour, lw=1.2)
        places = np.vstack([0.87 * way[6:-6], 1.13 * way[6:-6]])  # within and beyond the arc
        name(axes, freest(places, taken, view), symbol, color=colour, size=10, **NAME)
    unclipped([axes])
    legend_below(body, [axes], columns=3)
    times = f" y and z are drawn {stretch} times as long as x." if stretch > 1 else ""
    return Picture(body, captions.JANSEN[5] + times)


def _names(point: np.ndarray) -> list[tuple[str, str, str]]:
    """Symbol, words with the value, and colour of the azimuth, and of both elevations."""
    theta, phi = np.degrees(angles(point[None], rotor_parameters())[0]).tolist()
    spherical = float(np.degrees(np.arctan2(point[2], np.hypot(point[0], point[1]))))
    named = (
        (r"$\theta$", theta, "azimuth of P", AZIMUTH),
        (r"$\phi'$", phi, "elevation of P′, as measured", ELEVATION),
        (r"$\phi$", spherical, "elevation of P", SPHERICAL),
    )
    return [
        (symbol, f"{symbol} = {number(value, 2, sign=True)}°, {what}", colour)
        for symbol, value, what, colour in named
    ]


def _clearest_view(points: np.ndarray, side: int) -> View:
    """The view in which the lines from the origin to these points are farthest apart; `side` is +1
    where x points to the left."""

    def least(view: View) -> float:
        turn = np.sort(np.arctan2(*view.flat(points).T[::-1]))
        return float(np.diff(np.append(turn, turn[0] + 2 * np.pi)).min())

    return max((View(side * a, e) for a in range(36, 70, 4) for e in range(14, 38, 4)), key=least)


def _least_deg(point: np.ndarray, stretch: int) -> float:
    ratio = stretch * np.abs(point[1:]) / point[0]
    return float(np.degrees(np.arctan(ratio)).min())


def _arc(start: np.ndarray, end: np.ndarray, share: float) -> np.ndarray:
    """Points (40, 3) of an arc from the direction of one point to that of another."""
    a, b = start / np.linalg.norm(start), end / np.linalg.norm(end)
    whole = np.arccos(np.clip(a @ b, -1, 1))
    s = np.linspace(0, 1, 40)[:, None]
    way: np.ndarray = (np.sin((1 - s) * whole) * a + np.sin(s * whole) * b) / np.sin(whole)
    return share * np.linalg.norm(start) * way
