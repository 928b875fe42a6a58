"""Figures 6 to 8 of J: paths of the board from both stations, superposed, and the slave's pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

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
from mocap_metrology.present.jansen.space import (
    HEAD,
    IN_SPACE,
    arc,
    arrow,
    clearest,
    draw_frame,
    freest,
    name,
    outline,
    ring,
    show,
    unclipped,
    widest,
)
from mocap_metrology.present.plot.figure import (
    FAINT,
    GREY,
    INK,
    SMALL_PT,
    Keywords,
    Picture,
    legend_below,
    new_figure,
    styled,
)
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import number

if TYPE_CHECKING:
    from matplotlib.figure import SubFigure
    from mpl_toolkits.mplot3d.axes3d import Axes3D

N_BOARDS = 7
DENSE = 500  # so many dots are an image in an SVG
DOTS: Keywords = {"ls": "", "mew": 0, "markersize": 1.9}
BEFORE = DOTS | {"color": "#c06a52", "marker": "s", "markersize": 1.5}
BETWEEN = DOTS | {"color": "#757575", "marker": "s", "markersize": 1.5}
AFTER = DOTS | {"color": COLOURS[SLAVE], "marker": "s", "markersize": 1.6}
OWN = DOTS | {"color": COLOURS[MASTER], "marker": "o", "markersize": 2.4}
GHOST: Keywords = {"color": INK, "lw": 0.8, "ls": (0, (2, 1.4))}
PALE: Keywords = {"color": "#757575", "lw": 0.9}
AXES, REFERENCE, TURN = 0.14, 1.15, 0.75  # length of axes in that of the room; in that of axes
LEFT = -0.36  # title of a panel wider than its square
NEAR_TICKS = 4
WHOLE, NEAR = (1.2, 0.8), (0.84, 0.8)  # size of a drawing in its panel
WIDE, HIGH, BESIDE = 0.8, 0.45, 0.6  # of names about a station, in lengths of axes
CORE, ROOM = (5, 95), 0.2  # percentiles of a path, and what is added of their distance
PAGE_MM = 180.0
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
        """Of the Kabsch stage of an estimator; else of `paper-lm`, or of the chosen pose.

        Raises `Refusal` where the calibration has neither.
        """
        known = (given.estimate(name, "kabsch", optics) for name in (estimator, "paper-lm"))
        entry = next((one for one in known if one is not None), given.chosen)
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

    def caption(self, figure: int, outside: Sequence[int] = ()) -> str:
        """Caption of a figure: what the dots are, those off the path included; outside: how many
        are beyond each of its enlarged panels."""
        apart = (
            "Dots off the path: the search for that board pose ended elsewhere, in the other"
            f" minimum of a flat board (mirrored poses, {100 * self.mirrored:.2g} % here, many of"
            " them near the path) or before any minimum."
            if self.mirrored
            else ""
        )
        panels = zip("bc", outside, strict=False)
        beyond = [f"{n} dots are outside of ({panel})" for panel, n in panels if n]
        ends = [f"{' and '.join(beyond)}."] if beyond else []
        return " ".join(filter(None, (captions.JANSEN[figure], self.label, apart, *ends)))


@styled()
def paths_figure(given: Superposed, title: str, source: str) -> Picture:
    """J Figure 6: board poses as each station sees them, both stations at the origin."""
    body = new_figure(title, source, PAGE_MM)
    axes = _panels(body)
    points = np.vstack([np.zeros((1, 3)), *(_usual(path.t_m) for path in given.paths)])
    view, length = widest(points), AXES * float(np.ptp(points, axis=0).max())
    floor = show(axes["all"], points, view, WHOLE)[0, 2]
    outside = []
    for station, (path, how) in enumerate(zip(given.paths, (OWN, AFTER), strict=True)):
        near, boards = axes[("left", "right")[station]], _boards(path, given.board)
        near.set_title(f"({'bc'[station]}) As the {ROLES[station]} sees it", loc="left")
        limits = show(near, np.vstack([path.t_m[_core(path.t_m)], *boards]), view, NEAR, NEAR_TICKS)
        outside.append(_n_outside(limits, path.t_m))
        for into in (axes["all"], near):
            _dots(into, path.t_m, f"path of the board from the {ROLES[station]}", how)
            _draw_boards(into, boards, COLOURS[station])
        _drop(axes["all"], np.median(path.t_m, axis=0), floor)
    axes["all"].set_title("(a) Both stations at the origin", loc="left", x=LEFT)
    draw_frame(axes["all"], (np.eye(3), np.zeros(3)), length, INK, view)
    _drop(axes["all"], np.zeros(3), floor)
    unclipped(axes.values())
    legend_below(body, axes.values())
    return Picture(body, given.caption(6, outside))


@styled()
def superposition_figure(given: Superposed, title: str, source: str) -> Picture:
    """J Figure 7: the slave's path moved onto the master's: shifted with its centroid, turned by R
    about it. The shift is not the T of Figure 8, R c + T = c + shift for the centroid c."""
    master, slave = (path.t_m for path in given.paths)
    R, t = given.pose
    centre = _usual(slave).mean(axis=0)
    shift = R @ centre + t - centre
    moved, after = slave + shift, slave @ R.T + t
    body = new_figure(title, source, PAGE_MM)
    axes = _panels(body)
    points = np.vstack([_usual(p) for p in (master, slave, moved, after)])
    view, length = widest(points), float(np.linalg.norm(shift))
    head = HEAD * AXES * float(np.ptp(points, axis=0).max())
    show(axes["all"], points, view, WHOLE)
    own = master, "path from the master", OWN
    shifted = moved, "path from the slave, shifted", BETWEEN
    turned = after, "and turned by R", AFTER
    for path, text, how in ((slave, "path from the slave", BEFORE), shifted, own, turned):
        _dots(axes["all"], path, text, how)
    shown, outside = np.vstack([p[_core(p)] for p in (master, moved, after)]), []
    for place, other, heading in (
        ("left", shifted, "(b) Shifted"),
        ("right", turned, "(c) And turned by R"),
    ):
        limits = show(axes[place], shown, view, NEAR, NEAR_TICKS)
        axes[place].set_title(heading, loc="left")
        outside.append(sum(_n_outside(limits, path) for path, _, _ in (own, other)))
        for path, text, how in (own, other):
            _dots(axes[place], path, text, how)
    axes["all"].set_title("(a) Shift of the centroid and rotation about it", loc="left", x=LEFT)
    text = f"shift of the centroid, {number(length, 2)} m"
    arrow(axes["all"], centre, shift, head, color=INK, lw=1.3, zorder=5, label=text)
    about = centre + shift
    turn = number(float(np.degrees(np.linalg.norm(rotation.log(R)))), 1)
    for end in _ends(moved, about):
        way = about + arc(moved[end] - about, R)
        _curve(axes["all"], way, f"R, {turn}°", color=INK, lw=0.9, zorder=5)
    unclipped(axes.values())
    legend_below(body, axes.values())
    return Picture(body, given.caption(7, outside))


@styled()
def slave_figure(given: Superposed, title: str, source: str) -> Picture:
    """J Figure 8: R and T applied to the slave at the origin give its pose; the truth beside it."""
    (R, t), origin = given.pose, np.zeros(3)
    master, after = given.paths[MASTER].t_m, given.paths[SLAVE].t_m @ R.T + t
    places = [origin[None], t[None], _usual(master), _usual(after)]
    places += [] if given.reference is None else [given.reference[1][None]]
    longest = float(np.ptp(np.vstack(places), axis=0).max())
    length = AXES * longest
    frames = (MASTER, np.eye(3), origin), (SLAVE, R, t)
    tips = [at + 1.2 * length * turn.T for _, turn, at in frames]
    view = clearest(np.vstack([origin, t, *tips]))
    body = new_figure(title, source, 140.0)
    axes = body.subplots(subplot_kw=IN_SPACE)
    reach = [place + 1.5 * length * np.vstack([turn.T, -turn.T]) for _, turn, place in frames]
    floor = show(axes, np.vstack([*places, *reach]), view, (1.2, 0.84))[0, 2]
    _dots(axes, master, "board, from the master", OWN)
    _dots(axes, after, "board, from the slave, after R and T", AFTER)
    for place in (origin, t, np.median(after, axis=0)):
        _drop(axes, place, floor)
    T = f"T = ({_numbers(1e3 * t, 1)}) mm"
    arrow(axes, origin, t, HEAD * length, color=INK, lw=1.3, zorder=4, label=T)
    angles = np.degrees(rotation.to_angles(R))
    turns = [f"{k} = {number(float(v), 2, sign=True)}°" for k, v in zip("αβγ", angles, strict=True)]
    for k in range(3):
        ends = np.array([t, t + length * np.eye(3)[k]])
        _curve(axes, ends, f"axes before R: {', '.join(turns)}", head=False, **PALE)
        _curve(axes, t + TURN * arc(length * np.eye(3)[k], R), "", **PALE)
    if given.reference is not None:
        R_true, t_true = given.reference
        turned, off = np.degrees(rotation.error(R, R_true)), 1e3 * (t - t_true)
        text = f"reference; from it T is off by ({_numbers(off, 1)}) mm, "
        text += f"R turned by ({_numbers(turned, 2)})°"
        for k in range(3):
            ends = t_true + np.outer([0, REFERENCE * length], R_true[:, k])
            _curve(axes, ends, text, head=False, zorder=3, **GHOST)
    taken = [np.linspace(origin, t, 100)]
    taken += [t + length * np.linspace(0, 1, 40)[:, None] * axis for axis in np.eye(3)]
    taken += [t + TURN * arc(length * np.eye(3)[k], R) for k in range(3)]
    if given.reference is not None:
        ways = REFERENCE * length * given.reference[0].T
        taken += [given.reference[1] + np.linspace(0, 1, 40)[:, None] * way for way in ways]
    for station, turn, place in frames:
        colour = COLOURS[station]
        taken.append(draw_frame(axes, (turn, place), length, colour, view, taken))
        taken.append(np.linspace(place, [*place[:2], floor], 40))
    about = length * np.vstack([size * ring(view, WIDE, HIGH) for size in (1.0, 1.35)])
    along = np.vstack([BESIDE * about + share * t for share in (0.5, 0.4, 0.6)])
    named = zip((*ROLES, "T"), (about, t + about, along), (*COLOURS, INK), strict=True)
    for text, around, colour in named:  # off all lines
        taken.append(freest(around, np.vstack(taken), view, (2.5, 1.0))[None])
        how: Keywords = {"color": colour, "weight": "bold", "size": SMALL_PT, "zorder": 7}
        name(axes, taken[-1][0], text, **how)
    unclipped([axes])
    legend_below(body, [axes], columns=2)
    return Picture(body, given.caption(8))


def _panels(body: SubFigure) -> dict[str, Axes3D]:
    """One panel of all, and two enlarged ones below it."""
    return body.subplot_mosaic(
        [["all", "all"], ["left", "right"]], height_ratios=[3, 2], subplot_kw=IN_SPACE
    )


def _curve(axes: Axes3D, points: np.ndarray, label: str, head: bool = True, **how: object) -> None:
    """A line through points (n, 3), with an arrow's head at its end."""
    axes.plot(*points.T, label=label or None, **how)
    if head:
        tip = points[-1] - points[-8]
        axes.quiver(*points[-8], *tip, arrow_length_ratio=1.0, **how)


def _drop(axes: Axes3D, point: np.ndarray, floor: float) -> None:
    """A line from a point down to the floor."""
    foot = np.array([point, [point[0], point[1], floor]])
    axes.plot(*foot.T, color=GREY, lw=0.5, ls=(0, (1, 2)), zorder=1)


def _dots(axes: Axes3D, points: np.ndarray, label: str, how: Keywords) -> None:
    """A dot a measurement: those in the other minimum are apart, and no lines lead there."""
    shown = points[thinned(len(points))]
    axes.plot(*shown.T, zorder=3, axlim_clip=True, rasterized=len(shown) > DENSE, **how)
    axes.plot([], [], [], label=label, **how | {"markersize": 4.0})


def _n_outside(limits: np.ndarray, points: np.ndarray) -> int:
    """How many of the dots (n, 3) an enlarged panel leaves out."""
    shown = points[thinned(len(points))]
    return int((~((shown >= limits[0]) & (shown <= limits[1])).all(axis=1)).sum())


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


def _draw_boards(axes: Axes3D, boards: list[np.ndarray], colour: str) -> None:
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    axes.add_collection3d(Poly3DCollection(boards, fc=(colour, 0.1), ec=colour, lw=0.6, zorder=2))
    how: Keywords = {"marker": "s", "ls": "", "color": GREY, "markerfacecolor": FAINT, "ms": 6.0}
    axes.plot([], [], [], label="the board in some of its poses", **how)


def _one_way(points: np.ndarray, far: np.ndarray) -> float:
    """How far along the path the board has been everywhere once (within a tenth of its extent)."""
    low, high = np.percentile(points, [2, 98], axis=0)
    axis = int(np.argmax(high - low))
    reach = points[:, axis]
    tenth = 0.1 * (high - low)[axis]
    ends = [np.flatnonzero(reach < low[axis] + tenth), np.flatnonzero(reach > high[axis] - tenth)]
    return float(max(far[end[0]] for end in ends if end.size)) + 1e-9


def _ends(points: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Two points: the usual one farthest from the centre, and the one most opposite to it."""
    inside = np.flatnonzero(
        (np.abs(points - centre) <= np.percentile(np.abs(points - centre), 98, axis=0)).all(axis=1)
    )
    about = points[inside] - centre
    first = int(np.argmax(np.linalg.norm(about, axis=1)))
    second = int(np.argmin(about @ about[first]))
    return inside[[first, second]]
