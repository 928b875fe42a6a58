"""Figure 5 of J: azimuth and elevation as the station measures them, as projected angles."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.lighthouse.calibrate.board_pose import Path
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters
from mocap_metrology.present.calibration.space import COLOURS
from mocap_metrology.present.drawing.linear import number
from mocap_metrology.present.drawing.style import BODY_PT, GREY, INK, LOOKS, styled
from mocap_metrology.present.jansen.space import BOX, Projection, Stage, stage

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEAST_DEG = 22.0  # as drawn, so that arcs can be told apart
MOST_MOMENTS = 60
BOLD = {"weight": "bold", "bbox": BOX}
AZIMUTH, ELEVATION, SPHERICAL = COLOURS[0], COLOURS[1], LOOKS["z"].colour


def clearest_point(paths: tuple[Path, Path], board: np.ndarray) -> np.ndarray:
    """Of the diodes at some moments, in the frame of a station: the one farthest off both axes."""
    points = []
    for path in paths:
        few = path.take(slice(None, None, max(len(path) // MOST_MOMENTS, 1)))
        points.append((few.R @ board.T).transpose(0, 2, 1) + few.t_m[:, None])
    every = np.concatenate(points).reshape(-1, 3)
    every = every[every[:, 0] > 0]
    seen = np.abs(angles(np.ascontiguousarray(every), rotor_parameters()))
    return every[int(np.argmax(seen.min(axis=1)))]


@styled()
def angles_figure(point: np.ndarray, title: str, note: str = "") -> Figure:
    """P and its projection P' on the XZ plane, with theta = atan2(y, x), phi' = atan2(z, x) (J
    Eq. 1, from the rotor model) and phi = atan2(z, sqrt(x^2 + y^2)).

    point (3,) in m in the station's frame. Where its angles are small, y and z are drawn some times
    as long, and the note says so.
    """
    theta, phi = np.degrees(angles(point[None], rotor_parameters())[0])
    spherical = np.degrees(np.arctan2(point[2], np.hypot(point[0], point[1])))
    stretch = next((k for k in range(1, 9) if _least_deg(point, k) >= LEAST_DEG), 8)
    if stretch > 1:
        note = f"y and z are drawn {stretch} times as long as x. {note}".strip()
    P = point * [1, stretch, stretch]
    flat, behind = P * [1, 1, 0], P * [1, 0, 1]
    tips = np.diag(np.where(P > 0, 1.18, 0.5) * np.abs(P))
    corners = np.vstack([np.zeros(3), tips, P, flat, behind])
    side = 1 if P[1] < 0 else -1
    look = _clearest_look(np.vstack([tips, P, flat, behind]), side)
    sheet, drawing = stage(corners, title, note, floor=False, projection=look)
    _plane(drawing, P)
    for tip in tips:
        drawing.arrow(np.zeros(3), tip, color=GREY, lw=1.0)
    origin = np.zeros(3)
    solid, dashed = {"lw": 1.3}, {"lw": 1.0, "ls": (0, (4, 1.6))}
    drawing.line(np.array([origin, P]), color=INK, **solid)
    drawing.line(np.array([origin, behind]), color=ELEVATION, **dashed)
    drawing.line(np.array([origin, flat]), color=AZIMUTH, **dashed)
    for foot in (flat, behind):
        drawing.line(np.array([P, foot]), color=GREY, lw=0.7, ls=(0, (1, 1.6)))
    for foot in (flat, behind):
        drawing.line(np.array([tips[0] * P[0] / tips[0, 0], foot]), color=GREY, lw=0.5, ls=":")
    along = np.array([P[0], 0.0, 0.0])
    said = []
    for ends, share, colour, name, value in (
        ((along, flat), 0.82, AZIMUTH, "θ", theta),
        ((along, behind), 0.62, ELEVATION, "φ′", phi),
        ((flat, P), 0.72, SPHERICAL, "φ", spherical),
    ):
        way = _angle(drawing, *ends, share, colour)
        said.append((way[12:29:4], f"{name} = {number(value, 2, sign=True)}°", colour))
    for place in (P, behind):
        drawing.line(place[None], marker="o", color=INK, ms=4.0, zorder=5, weight=5.0)
    drawing.line(np.zeros((1, 3)), marker="s", color=INK, ms=6.0, zorder=5, weight=5.0)
    _names(drawing, point, P, behind, side)
    for way, text, colour in said:
        how = {"weight": "bold", "color": colour, "size": BODY_PT, "bbox": BOX}
        drawing.name(way, text, **how)
    for tip, name in zip(tips, ("x, forward", "y, left", "z, up"), strict=True):
        drawing.name(tip, name, color=GREY)
    inside = [[x, 0.0, z] for z in (0.85, 0.7, 0.97) for x in (0.3, 0.5, 0.2, 0.7, 0.9)]
    drawing.name(inside * P, "XZ plane", (0, 0), color=ELEVATION)
    return sheet.figure


def _names(drawing: Stage, point: np.ndarray, P: np.ndarray, behind: np.ndarray, side: int) -> None:
    """Names of P, P' and the station; `side` is +1 where x points to the left."""
    metres = ", ".join(number(float(v), 3, sign=True) for v in point)
    up = np.sign(P[2])
    drawing.name(P, f"P = ({metres}) m", (14.0 * side, 5.0 * up), **BOLD)
    drawing.name(behind, "P′", (-4.0 * side, 2.5 * up), **BOLD)
    drawing.name(np.zeros(3), "laser of the station", (15.0 * side, 2.5), bbox=BOX)


def _clearest_look(points: np.ndarray, side: int) -> Projection:
    """The view in which the lines from the origin to these points are farthest apart."""

    def least(look: Projection) -> float:
        turn = np.sort(np.arctan2(*look.flat(points).T[::-1]))
        return float(np.diff(np.append(turn, turn[0] + 2 * np.pi)).min())

    every = [Projection(side * a, e) for a in range(36, 70, 4) for e in range(14, 38, 4)]
    return max(every, key=least)


def _least_deg(point: np.ndarray, stretch: int) -> float:
    ratio = stretch * np.abs(point[1:]) / point[0]
    return float(np.degrees(np.arctan(ratio)).min())


def _plane(drawing: Stage, P: np.ndarray) -> None:
    corners = np.array([[0, 0, 0], [1.1, 0, 0], [1.1, 0, 1.1], [0, 0, 1.1]]) * P
    drawing.fill(corners, color=ELEVATION, alpha=0.07, lw=0, zorder=0)


def _angle(
    drawing: Stage, start: np.ndarray, end: np.ndarray, share: float, colour: str
) -> np.ndarray:
    """Draw an arc from the direction of one point to that of another; return its points."""
    a, b = start / np.linalg.norm(start), end / np.linalg.norm(end)
    whole = np.arccos(np.clip(a @ b, -1, 1))
    s = np.linspace(0, 1, 40)[:, None]
    way = (np.sin((1 - s) * whole) * a + np.sin(s * whole) * b) / np.sin(whole)
    way = share * np.linalg.norm(start) * way
    drawing.curve(way, color=colour, lw=1.2)
    return way
