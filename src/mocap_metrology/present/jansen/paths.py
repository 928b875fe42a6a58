"""Figures 6 to 8 of J: paths of the board from both stations, superposed, and the slave's pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess import calibration_files as data
from mocap_metrology.lighthouse.assess.pose_file import matrix_and_metres
from mocap_metrology.lighthouse.assess.signal import signal_of
from mocap_metrology.lighthouse.records import MASTER, ROLES, SLAVE
from mocap_metrology.present.calibration.stations import COLOURS, thinned
from mocap_metrology.present.jansen import signal, space
from mocap_metrology.present.plot import figure
from mocap_metrology.present.plot.figure import FAINT, GREY, INK, Keywords, Picture
from mocap_metrology.present.tables import origin_words
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import number

TITLES = {
    3: "signal of a photodiode over a measurement cycle",
    5: "azimuth and elevation of a photodiode",
    6: "board poses from both stations, both at the origin",
    7: "the slave's path superposed on the master's",
    8: "pose of the slave by T and R",
}
DENSE = 500  # so many dots are an image in an SVG
DOTS: Keywords = {"ls": "", "mew": 0, "marker": "s", "markersize": 1.6}
BEFORE, BETWEEN = DOTS | {"color": "#c06a52"}, DOTS | {"color": "#757575"}
AFTER = DOTS | {"color": COLOURS[SLAVE]}
OWN = DOTS | {"color": COLOURS[MASTER], "marker": "o", "markersize": 2.4}
BOARD: Keywords = {"marker": "s", "ls": "", "color": GREY, "markerfacecolor": FAINT, "ms": 6.0}
LENGTH = 0.14  # of the axes of a frame, in that of the room
WHOLE, NEAR, ALONE = (0.76, 0.85), (0.76, 0.7), (1.25, 0.88)  # size of a drawing in its panel
STAGES = {
    "kabsch": "from the superposition of both paths (Kabsch)",
    "final": "after the last minimisation",
    "static": "from a board at rest",
}


def jansen_figures(files: data.CalibrationFiles, pulses: data.Columns) -> dict[int, Picture]:
    """Figures 3, 5, 6, 7 and 8 of J from one calibration, by number.

    pulses: columns of pulses.parquet. Figures 6 to 8 show the Kabsch stage of `paper` with ideal
    optics, as J's do; of the chosen pose where the calibration has it not.
    """
    source = f"Source: calibration {files.name}, {origin_words(files.twin)}."
    titles = {k: f"Jansen et al. 2019, Figure {k}: {text}" for k, text in TITLES.items()}
    shown = Superposed.of(files)
    point = space.clearest_point(shown.paths, files.board)
    four_cycles = signal_of(pulses, files.sweeps)
    return {
        3: signal.signal_figure(four_cycles, titles[3], source),
        5: space.angles_figure(point, titles[5], source),
        6: paths_figure(shown, titles[6], source),
        7: superposition_figure(shown, titles[7], source),
        8: slave_figure(shown, titles[8], source),
    }


@dataclass(frozen=True)
class Superposed:
    """What the three figures show: both paths in their own frames, the pose, and the truth."""

    paths: data.Paths
    board: np.ndarray
    pose: data.Pose
    reference: data.Pose | None
    label: str
    mirrored: float | None = None  # share of the board poses

    @classmethod
    def of(cls, files: data.CalibrationFiles) -> Superposed:
        """The paths by the Kabsch stage of `paper`, else of `paper-lm`, or by the chosen pose.

        Raises `Refusal` where the calibration has neither.
        """
        known = (files.estimate(name, "kabsch", "ideal") for name in ("paper", "paper-lm"))
        entry = next((one for one in known if one is not None), files.chosen)
        paths = None if entry is None else files.paths(entry["estimator"], entry["optics"])
        if entry is None or paths is None:
            raise Refusal(
                f"{files.name}: no pose with a path of the board;"
                " expected one for Figures 5 to 8 of J"
            )
        label = (
            f"Board poses by the estimator {entry['estimator']} with {entry['optics']} optics; R"
            f" and T {STAGES.get(entry['stage'], entry['stage'])}."
        )
        pose, share = matrix_and_metres(entry), entry.get("mirrored_share")
        return cls(paths, files.board, pose, files.reference, label, share)

    def caption(self, number: int, outside: Sequence[int] = ()) -> str:
        """Caption of a figure: what the dots are, those off the path included; outside: how many
        are beyond each of its enlarged panels."""
        mirrored = (
            "Dots off the path: the search for that board pose ended elsewhere, in the other"
            f" minimum of a flat board (mirrored poses, {100 * self.mirrored:.2g} % here, many of"
            " them near the path) or before any minimum."
            if self.mirrored
            else ""
        )
        panels = zip("bc", outside, strict=False)
        beyond = " and ".join(f"{n} dots are outside of ({panel})" for panel, n in panels if n)
        parts = captions.JANSEN[number], self.label, mirrored, f"{beyond}." if beyond else ""
        return " ".join(filter(None, parts))


@figure.styled()
def paths_figure(shown: Superposed, title: str, source: str) -> Picture:
    """J Figure 6: board poses as each station sees them, both stations at the origin."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    body = figure.new_figure(title, source, 135.0)
    axes = _panels(body)
    points = np.vstack([np.zeros((1, 3)), *(data.usual_points(path.t_m) for path in shown.paths)])
    view, length = space.widest(points), LENGTH * float(np.ptp(points, axis=0).max())
    space.show(axes["all"], points, view, WHOLE)
    outside = []
    for station, (path, how) in enumerate(zip(shown.paths, (OWN, AFTER), strict=True)):
        near, boards = axes[("left", "right")[station]], data.boards_along(path, shown.board)
        near.set_title(f"({'bc'[station]}) As the {ROLES[station]} sees it", loc="left")
        core = np.vstack([path.t_m[data.on_the_path(path.t_m)], *boards])
        outside.append(_n_outside(space.show(near, core, view, NEAR, 4), path.t_m))
        for into in (axes["all"], near):
            _dots(into, path.t_m, f"path of the board from the {ROLES[station]}", how)
            faces = Poly3DCollection(
                boards, fc=(COLOURS[station], 0.1), ec=COLOURS[station], lw=0.6, zorder=2
            )
            into.add_collection3d(faces)
            into.plot([], [], [], label="the board in some of its poses", **BOARD)
    axes["all"].set_title("(a) Both stations at the origin", loc="left")
    space.draw_frame(axes["all"], (np.eye(3), np.zeros(3)), length, INK)
    space.unclipped(axes.values())
    return figure.finished(body, axes.values(), shown.caption(6, outside))


@figure.styled()
def superposition_figure(shown: Superposed, title: str, source: str) -> Picture:
    """J Figure 7: the slave's path moved onto the master's: shifted with its centroid, turned by R
    about it. The shift is not the T of Figure 8, R c + T = c + shift for the centroid c."""
    (master, slave), (R, t) = (path.t_m for path in shown.paths), shown.pose
    centre = data.usual_points(slave).mean(axis=0)
    shift = R @ centre + t - centre
    moved, after = slave + shift, slave @ R.T + t
    body = figure.new_figure(title, source, 135.0)
    axes = _panels(body)
    points = np.vstack([data.usual_points(p) for p in (master, slave, moved, after)])
    view = space.widest(points)
    space.show(axes["all"], points, view, WHOLE)
    own = master, "path from the master", OWN
    shifted = moved, "path from the slave, shifted", BETWEEN
    turned = after, "and turned by R", AFTER
    for path in ((slave, "path from the slave", BEFORE), shifted, own, turned):
        _dots(axes["all"], *path)
    core, outside = np.vstack([p[data.on_the_path(p)] for p in (master, moved, after)]), []
    for place, other, heading in (
        ("left", shifted, "(b) Shifted"),
        ("right", turned, "(c) And turned by R"),
    ):
        limits = space.show(axes[place], core, view, NEAR, 4)
        axes[place].set_title(heading, loc="left")
        outside.append(_n_outside(limits, own[0]) + _n_outside(limits, other[0]))
        for path in (own, other):
            _dots(axes[place], *path)
    axes["all"].set_title("(a) Shift of the centroid and rotation about it", loc="left")
    about = centre + shift
    how: Keywords = {"color": INK, "lw": 1.3, "zorder": 5}
    label = f"shift of the centroid, {number(float(np.linalg.norm(shift)), 2)} m"
    space.curve(axes["all"], np.array([centre, about]), label=label, **how)
    label = f"R, {number(float(np.degrees(np.linalg.norm(rotation.log(R)))), 1)}°"
    far = data.usual_points(moved) - about
    first = far[int(np.argmax(np.linalg.norm(far, axis=1)))]
    for end in (first, far[int(np.argmin(far @ first))]):
        space.curve(axes["all"], about + space.arc(end, R), label=label, **how | {"lw": 0.9})
    space.unclipped(axes.values())
    return figure.finished(body, axes.values(), shown.caption(7, outside))


@figure.styled()
def slave_figure(shown: Superposed, title: str, source: str) -> Picture:
    """J Figure 8: R and T applied to the slave at the origin give its pose; the truth beside it."""
    (R, t), origin, reference = shown.pose, np.zeros(3), shown.reference
    master, after = shown.paths[MASTER].t_m, shown.paths[SLAVE].t_m @ R.T + t
    places = [origin[None], t[None], data.usual_points(master), data.usual_points(after)]
    places += [] if reference is None else [reference[1][None]]
    length = LENGTH * float(np.ptp(np.vstack(places), axis=0).max())
    frames = (np.eye(3), origin), (R, t)
    tips = [at + 1.3 * length * turn.T for turn, at in frames]
    points = np.vstack([*places, *tips])
    body = figure.new_figure(title, source, 135.0)
    axes: figure.Axes3D = body.subplots(subplot_kw=space.IN_SPACE)
    space.show(axes, points, space.widest(points), ALONE)
    _dots(axes, master, "board, from the master", OWN)
    _dots(axes, after, "board, from the slave, after R and T", AFTER)
    label = f"T = ({_numbers(1e3 * t, 1)}) mm"
    space.curve(axes, np.array([origin, t]), color=INK, lw=1.3, zorder=4, label=label)
    turns = zip("αβγ", np.degrees(rotation.to_angles(R)), strict=True)
    label = ", ".join(f"{k} = {number(float(v), 2, sign=True)}°" for k, v in turns)
    pale: Keywords = {"color": "#757575", "lw": 0.9, "label": f"axes before R: {label}"}
    for way in length * np.eye(3):
        space.curve(axes, np.array([t, t + way]), head=False, **pale)
        space.curve(axes, t + 0.75 * space.arc(way, R), **pale)
    if reference is not None:
        turned, off = np.degrees(rotation.error(R, reference[0])), 1e3 * (t - reference[1])
        label = f"reference; from it T is off by ({_numbers(off, 1)}) mm, "
        label += f"R turned by ({_numbers(turned, 2)})°"
        ghost: Keywords = {"color": INK, "lw": 0.8, "ls": (0, (2, 1.4)), "label": label}
        for way in 1.15 * length * reference[0].T:
            space.curve(axes, reference[1] + np.array([way * 0, way]), head=False, **ghost)
    for (turn, at), role, colour in zip(frames, ROLES, COLOURS, strict=True):
        space.draw_frame(axes, (turn, at), length, colour)
        below = at - 0.6 * length * turn.mean(axis=1)
        space.write(axes, below, role, color=colour, weight="bold")
    space.write(axes, 0.5 * t, "T", weight="bold")
    space.unclipped([axes])
    return figure.finished(body, [axes], shown.caption(8), columns=2)


def _panels(body: figure.SubFigure) -> dict[str, figure.Axes3D]:
    """A large panel of all, and two enlarged ones beside it."""
    return body.subplot_mosaic(
        [["all", "left"], ["all", "right"]], width_ratios=[5, 3], subplot_kw=space.IN_SPACE
    )


def _dots(axes: figure.Axes3D, points: np.ndarray, label: str, how: Keywords) -> None:
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
