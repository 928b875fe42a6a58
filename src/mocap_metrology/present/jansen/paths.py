"""Figures of J: 6 to 8, paths of the board from both stations, superposed, and the slave's pose;
3, what one photodiode sees in a measurement cycle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess import calibration_files as data
from mocap_metrology.lighthouse.assess.pose_file import matrix_and_metres
from mocap_metrology.lighthouse.assess.signal import N_CYCLES, Signal, signal_of
from mocap_metrology.lighthouse.records import AXES, MASTER, ROLES, SLAVE
from mocap_metrology.lighthouse.timing import CYCLE_S
from mocap_metrology.present.calibration.stations import COLOURS, thinned
from mocap_metrology.present.jansen import space
from mocap_metrology.present.plot import figure
from mocap_metrology.present.plot.figure import FAINT, GREY, INK, Keywords, Picture
from mocap_metrology.present.tables import origin_words
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import number

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
    shown = Superposed.of(files, source)
    point = space.clearest_point(shown.paths, files.board)
    return {
        3: signal_figure(signal_of(pulses, files.sweeps), source),
        5: space.angles_figure(point, source),
        6: paths_figure(shown),
        7: superposition_figure(shown),
        8: slave_figure(shown),
    }


@dataclass(frozen=True)
class Superposed:
    """What the three figures show: both paths in their own frames, the pose, and the truth."""

    paths: data.Paths
    board: np.ndarray
    pose: data.Pose
    reference: data.Pose | None
    source: str
    label: str
    mirrored: float | None = None  # share of the board poses

    @classmethod
    def of(cls, files: data.CalibrationFiles, source: str) -> Superposed:
        """The paths by the Kabsch stage of `paper`, else of `paper-lm`, or by the chosen pose.

        Raises `Refusal` where the calibration has neither.
        """
        known = (files.estimate(name, "kabsch", "ideal") for name in ("paper", "paper-lm"))
        entry = next((one for one in known if one is not None), files.chosen)
        paths = None if entry is None else files.paths(entry["estimator"], entry["optics"])
        if entry is None or paths is None:
            expected = "expected one for Figures 5 to 8 of J"
            raise Refusal(f"{files.name}: no pose with a path of the board; {expected}")
        by = f"the estimator {entry['estimator']} with {entry['optics']} optics"
        label = f"Board poses by {by}; R and T {STAGES.get(entry['stage'], entry['stage'])}."
        pose, share = matrix_and_metres(entry), entry.get("mirrored_share")
        return cls(paths, files.board, pose, files.reference, source, label, share)

    def texts(self, number: int, outside: Sequence[int] = ()) -> figure.Texts:
        """Of a figure: what the dots are, those off the path included; outside: how many are beyond
        each of its enlarged panels."""
        said = [self.label]
        if self.mirrored:
            said.append(captions.JANSEN_MIRRORED.format(percent=100 * self.mirrored))
        panels = zip("bc", outside, strict=False)
        beyond = [f"{n} dots are outside of ({panel})" for panel, n in panels if n]
        said += [f"{' and '.join(beyond)}."] * bool(beyond)
        return captions.of_figure("jansen", number, self.source, *said)


@figure.styled()
def paths_figure(shown: Superposed) -> Picture:
    """J Figure 6: board poses as each station sees them, both stations at the origin."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    body, axes = _panels(shown.texts(6))
    points = np.vstack([np.zeros((1, 3)), *(data.usual_points(path.t_m) for path in shown.paths)])
    view, length = space.widest(points), LENGTH * float(np.ptp(points, axis=0).max())
    space.show(axes["a"], points, view, WHOLE)
    outside = []
    for station, (path, how) in enumerate(zip(shown.paths, (OWN, AFTER), strict=True)):
        near, boards = axes["bc"[station]], data.boards_along(path, shown.board)
        near.set_title(f"({'bc'[station]}) As the {ROLES[station]} sees it", loc="left")
        core = np.vstack([path.t_m[data.on_the_path(path.t_m)], *boards])
        outside.append(_n_outside(space.show(near, core, view, NEAR, 4), path.t_m))
        for into in (axes["a"], near):
            _dots(into, path.t_m, f"path of the board from the {ROLES[station]}", how)
            edge: Keywords = {"ec": COLOURS[station], "lw": 0.6, "zorder": 2}
            into.add_collection3d(Poly3DCollection(boards, fc=(COLOURS[station], 0.1), **edge))
            into.plot([], [], [], label="the board in some of its poses", **BOARD)
    axes["a"].set_title("(a) Both stations at the origin", loc="left")
    space.draw_frame(axes["a"], (np.eye(3), np.zeros(3)), length, INK)
    space.unclipped(axes.values())
    return figure.finished(body, axes.values(), shown.texts(6, outside).caption)


@figure.styled()
def superposition_figure(shown: Superposed) -> Picture:
    """J Figure 7: the slave's path moved onto the master's: shifted with its centroid, turned by R
    about it. The shift is not the T of Figure 8, R c + T = c + shift for the centroid c."""
    (master, slave), (R, t) = (path.t_m for path in shown.paths), shown.pose
    centre = data.usual_points(slave).mean(axis=0)
    shift = R @ centre + t - centre
    moved, after = slave + shift, slave @ R.T + t
    body, axes = _panels(shown.texts(7))
    points = np.vstack([data.usual_points(p) for p in (master, slave, moved, after)])
    view = space.widest(points)
    space.show(axes["a"], points, view, WHOLE)
    of_master = master, "path from the master", OWN
    shifted = moved, "path from the slave, shifted", BETWEEN
    turned = after, "and turned by R", AFTER
    for path in ((slave, "path from the slave", BEFORE), shifted, of_master, turned):
        _dots(axes["a"], *path)
    core, outside = np.vstack([p[data.on_the_path(p)] for p in (master, moved, after)]), []
    headings = {"b": "(b) Shifted", "c": "(c) And turned by R"}
    for (place, heading), other in zip(headings.items(), (shifted, turned), strict=True):
        limits = space.show(axes[place], core, view, NEAR, 4)
        axes[place].set_title(heading, loc="left")
        outside.append(_n_outside(limits, of_master[0]) + _n_outside(limits, other[0]))
        for path in (of_master, other):
            _dots(axes[place], *path)
    axes["a"].set_title("(a) Shift of the centroid and rotation about it", loc="left")
    about = centre + shift
    how: Keywords = {"color": INK, "lw": 1.3, "zorder": 5}
    label = f"shift of the centroid, {number(float(np.linalg.norm(shift)), 2)} m"
    space.curve(axes["a"], np.array([centre, about]), label=label, **how)
    label = f"R, {number(float(np.degrees(np.linalg.norm(rotation.log(R)))), 1)}°"
    far = data.usual_points(moved) - about
    first = far[int(np.argmax(np.linalg.norm(far, axis=1)))]
    for end in (first, far[int(np.argmin(far @ first))]):
        space.curve(axes["a"], about + space.arc(end, R), label=label, **how | {"lw": 0.9})
    space.unclipped(axes.values())
    return figure.finished(body, axes.values(), shown.texts(7, outside).caption)


@figure.styled()
def slave_figure(shown: Superposed) -> Picture:
    """J Figure 8: R and T applied to the slave at the origin give its pose; the truth beside it."""
    (R, t), origin, reference = shown.pose, np.zeros(3), shown.reference
    master, after = shown.paths[MASTER].t_m, shown.paths[SLAVE].t_m @ R.T + t
    places = [origin[None], t[None], data.usual_points(master), data.usual_points(after)]
    places += [] if reference is None else [reference[1][None]]
    length = LENGTH * float(np.ptp(np.vstack(places), axis=0).max())
    frames = (np.eye(3), origin), (R, t)
    tips = [at + 1.3 * length * turn.T for turn, at in frames]
    points = np.vstack([*places, *tips])
    body = figure.new_figure(shown.texts(8), 135.0)
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
    return figure.finished(body, [axes], shown.texts(8).caption, columns=2)


def _panels(texts: figure.Texts) -> tuple[figure.SubFigure, dict[str, figure.Axes3D]]:
    """A figure with a large panel of all, and two enlarged ones beside it."""
    body = figure.new_figure(texts, 135.0)
    return body, body.subplot_mosaic("ab;ac", width_ratios=[5, 3], subplot_kw=space.IN_SPACE)


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


# ---- Figure 3

BETWEEN_US = 240.0  # of a flash's zoom: before and behind
ARROW: Keywords = {
    "arrowstyle": "<|-|>,head_width=0.14,head_length=0.3", "color": INK, "lw": 0.8,
    "shrinkA": 0, "shrinkB": 0,
}  # fmt: skip
TEXT: Keywords = {"size": figure.SMALL_PT, "ha": "center", "va": "bottom"}


@figure.styled()
def signal_figure(signal: Signal, source: str) -> Picture:
    """J Figure 3."""
    texts = captions.of_figure("jansen", 3, f"Diode {signal.diode}. {source}")
    body = figure.new_figure(texts, 108.0)
    axes = body.subplot_mosaic(
        [["cycles", "cycles"], ["flashes", "sweep"]], height_ratios=[5, 3], width_ratios=[3, 2]
    )
    for one in axes.values():
        one.set(ylim=(0, 1.75), yticks=[0, 1], ylabel="Light")
        one.spines[["top", "right"]].set_visible(False)
    _draw_cycles(axes["cycles"], signal)
    _draw_flashes(axes["flashes"], signal)
    sweep, half = signal.sweeps[0], max(2.2e6 * signal.sweeps[0].length_s, 6.0)
    at = f"at {1e3 * (sweep.middle_s - signal.flashes[0][0]):.2f} ms"
    figure.panel_title(axes["sweep"], "First sweep", at)
    axes["sweep"].set(xlim=(-half, half), xlabel="Time from its middle (µs)", ylabel="")
    _draw_light(axes["sweep"], -0.5e6 * sweep.length_s, 1e6 * sweep.length_s, sweep.station)
    axes["sweep"].plot([0, 0], [0, 1.0], color="white", lw=1.0, ls=(0, (2, 1)), zorder=4)
    words = f"{ROLES[sweep.station]}'s sweep\n{1e6 * sweep.length_s:.1f} µs"
    axes["sweep"].text(0, 1.06, words, color=COLOURS[sweep.station], **TEXT)
    figure.letters(axes.values())
    return figure.finished(body, [axes["cycles"]], texts.caption)


def _draw_light(axes: figure.Axes, start: float, length: float, station: int) -> None:
    """A pulse of light of a station; its edge makes a short one visible."""
    colour, name = COLOURS[station], f"light of the {ROLES[station]}"
    axes.broken_barh([(start, length)], (0, 1), color=colour, lw=0.9, zorder=3, label=name)


def _draw_cycles(axes: figure.Axes, signal: Signal) -> None:
    figure.panel_title(axes, "Four cycles")
    start_s, end_s = signal.flashes[0][0], N_CYCLES * CYCLE_S
    axes.set(xlim=(-0.5, 1e3 * end_s + 0.2), xlabel="Time from the master's flash (ms)")
    for start, length, station in signal.flashes:
        _draw_light(axes, 1e3 * (start - start_s), 1e3 * length, station)
    for k, sweep in enumerate(signal.sweeps):
        flash, middle = (1e3 * (v - start_s) for v in (sweep.flash_s, sweep.middle_s))
        _draw_light(axes, 1e3 * (sweep.start_s - start_s), 1e3 * sweep.length_s, sweep.station)
        axes.annotate("", (middle, 0.6), (flash, 0.6), arrowprops=ARROW, zorder=4)
        axes.text((flash + middle) / 2, 0.63, r"$\Delta t$", **TEXT)
        begin = 1e3 * k * CYCLE_S
        axes.axvline(begin, color=GREY, lw=0.5, ls=(0, (1, 2)), zorder=0)
        degrees = number(float(np.degrees(sweep.angle_rad)), 2, sign=True)
        angle = rf"$\{('theta', 'phi')[sweep.axis]}$ = {degrees}°"
        delta = rf"$\Delta t$ = {1e3 * sweep.delta_s:.3f} ms"
        words = f"{ROLES[sweep.station]}, {AXES[sweep.axis]}\n{delta}\n{angle}"
        axes.text(begin + 500 * CYCLE_S, 1.08, words, color=COLOURS[sweep.station], **TEXT)


def _draw_flashes(axes: figure.Axes, signal: Signal) -> None:
    figure.panel_title(axes, "Flashes of the first cycle", "at 0 ms")
    (first, _, _), (second, longer, _) = signal.flashes[:2]
    end = 1e6 * (second + longer - first) + BETWEEN_US / 3
    axes.set(xlim=(-BETWEEN_US / 3, end), xlabel="Time from the master's flash (µs)")
    for start, length, station in signal.flashes[:2]:
        at = 1e6 * (start - first)
        _draw_light(axes, at, 1e6 * length, station)
        text = f"{ROLES[station]}'s flash\n{1e6 * length:.1f} µs"
        axes.text(at + 0.5e6 * length, 1.06, text, color=COLOURS[station], **TEXT)
    offset = 1e6 * (second - first)
    axes.annotate("", (offset, 1.03), (0.0, 1.03), arrowprops=ARROW, zorder=5)
    axes.text(offset / 2, 1.06, f"begins {offset:.1f} µs later", **TEXT)
