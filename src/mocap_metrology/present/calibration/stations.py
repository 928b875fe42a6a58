"""Stations, the board's path and the position's uncertainty, as panels in the master's frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mocap_metrology.lighthouse.assess.calibration_files import CalibrationFiles, Pose, usual_ends
from mocap_metrology.lighthouse.assess.pose_file import PoseEntry, is_network
from mocap_metrology.lighthouse.records import MASTER, SLAVE
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.plot.figure import GREY, INK, LOOKS, SMALL_PT, Keywords, write_message
from mocap_metrology.present.text.numbers import mm

COLOURS = LOOKS["x"].colour, LOOKS["y"].colour  # of master and slave
# Of stations by rising channel, which begin with those
ALL_COLOURS = 3 * (*COLOURS, LOOKS["z"].colour, "#7a4fa3", "#8c6d1f", "#3b7f86")
ALL_MARKS = 2 * "os^vDPX*"
PATHS: tuple[Keywords, ...] = (
    {"color": COLOURS[MASTER], "lw": 1.2, "label": "path of the board, by the master"},
    {"color": COLOURS[SLAVE], "lw": 0.8, "ls": (0, (3, 1.5)), "label": "by the slave, after R, t"},
)
MIRRORED: Keywords = {"marker": "v", "color": INK, "markerfacecolor": "#ffcc33", "ms": 4.2}
NAMES = ("x, forward (m)", "y, left (m)", "z, up (m)")
View = tuple[int, int]  # coordinates across and up the paper
ABOVE, RIGHT, FRONT = (0, 1), (0, 2), (1, 2)
SEEN_FROM = {ABOVE: "from above", RIGHT: "from the right", FRONT: "from the front"}
FIELD_DEG = 60.0  # half of what a laser sweeps (J II)
CONE, ARROW = 0.38, 0.15  # lengths in half widths of a view
LEAST_VIEW_M, LEAST_PATH_M, LONGEST_GAP_S = 1.5, 0.01, 0.1  # half widths; a gap in a path
AREA = float(np.sqrt(-2 * np.log(0.05)))  # half axes of a 95 % ellipse of two coordinates over σ
FARTHEST = 3.0  # of what is drawn at its place, in extents of the largest ellipse
ELLIPSES: tuple[tuple[str, float, Keywords], ...] = (
    ("covariance", AREA, {"label": "95 % region of the position", "color": INK, "lw": 1.1}),
    ("covariance", 1, {"label": "1 σ of the position", "color": INK, "lw": 0.7, "ls": (0, (5, 2))}),
    ("covariance_noise", AREA, {"label": "95 % region by noise alone", "color": COLOURS[1]}),
)
OTHERS: tuple[Keywords, ...] = (
    {"marker": "s", "color": LOOKS["x"].colour, "markerfacecolor": "none", "ms": 4.5},
    {"marker": "^", "color": LOOKS["z"].colour, "markerfacecolor": "none", "ms": 4.5},
    {"marker": "D", "color": INK, "markerfacecolor": "none", "ms": 4.5},
)
REFERENCE: Keywords = {"marker": "+", "color": INK, "ms": 8.0, "mew": 1.1}


def station_words(name: str) -> str:
    """A station in a sentence."""
    return f"station {name}" if name.isdigit() else f"the {name}"


def draw_view(axes: plot.Axes, files: CalibrationFiles, view: View) -> None:
    """One view with equal scales: stations, what they can see, the board's path, lines between."""
    known, names = files.frames(), files.names
    frames = list(known.values())
    paths, shown = files.shown_paths(), list(view)
    reference = [] if files.reference is None else [files.reference[1]]
    board = [] if paths is None else [np.median(paths[MASTER].t_m, axis=0)]
    ends = [] if paths is None else usual_ends(paths[MASTER].t_m).tolist()
    every = np.vstack([*(t for _, t in frames), *reference, *ends])
    low, high = every.min(axis=0), every.max(axis=0)
    half = max(float(((high - low) * [0.86, 1.17, 1.17]).max()), LEAST_VIEW_M)  # room for names
    draw_paths(axes, files, view)
    places = [t for _, t in frames] + board
    for k, place in enumerate(places if len(frames) < 3 else ()):
        axes.plot(*np.array([place, places[k - 1]])[:, shown].T, color=GREY, lw=0.6, ls=(0, (1, 2)))
    for k, (name, pose) in enumerate(known.items()):
        others = np.array([place for j, place in enumerate(places) if j != k])
        _draw_station(axes, pose, name, names.index(name), view, half, others)
    for place in reference:
        axes.plot(*place[shown], ls="", zorder=5, **REFERENCE)
    _equal(axes, view, (low + high) / 2, half, 0.68)


def _draw_station(
    axes: plot.Axes,
    pose: Pose,
    name: str,
    station: int,
    view: View,
    half: float,
    others: np.ndarray,
) -> None:
    """Axes x, y, z of a station, what it can see, and, from above, its name, away from other places
    (n, 3)."""
    (R, t), colour, shown = pose, ALL_COLOURS[station], list(view)
    turn, rays = np.radians(np.linspace(-FIELD_DEG, FIELD_DEG, 25)), np.zeros((25, 3))
    rays[:, 0], rays[:, view[1]] = np.cos(turn), np.sin(turn)
    fan = np.vstack([t, t + CONE * half * rays @ R.T])[:, shown]
    label = f"120° in view of {station_words(name)}"
    axes.fill(*fan.T, color=colour, alpha=0.12, lw=0, zorder=1, label=label)
    at = t[shown]
    axes.plot(*at, ALL_MARKS[station], color=colour, markersize=3.2, zorder=4)
    how: Keywords = {"color": colour, "size": SMALL_PT, "ha": "center", "va": "center", "zorder": 6}
    arrow: Keywords = {"arrowstyle": "<|-,head_width=0.14,head_length=0.28", "color": colour}
    arrow |= {"shrinkA": 0, "shrinkB": 0, "lw": 0.9}
    for letter, way in zip("xyz", R.T[:, shown], strict=True):
        if np.linalg.norm(way) > 0.5:
            tip = at + ARROW * half * way * (1 + 0.25 / np.linalg.norm(way))
            axes.annotate(letter, tuple(at), tuple(tip), arrowprops=arrow, **how)
    if view == ABOVE:
        away = -R[shown, 0] if not len(others) else at - others[:, shown].mean(axis=0) - R[shown, 0]
        off = away / max(float(np.linalg.norm(away)), 1e-9) * [25.0, 13.0]
        how |= {"weight": "bold", "textcoords": "offset points"}
        axes.annotate(name, tuple(at), tuple(off), **how)


def draw_paths(axes: plot.Axes, files: CalibrationFiles, view: View) -> None:
    """Both paths of the board, or the master's alone where there is no other; gaps stay gaps."""
    both, paths, axes_shown = files.agreement(), files.shown_paths(), list(view)
    if both is not None:
        few = thinned(len(both.time_s))
        step = np.diff(both.time_s[few], prepend=both.time_s[0])
        gap = step > max(LONGEST_GAP_S, 3 * np.median(step))
        for points, how in zip((both.master_m, both.slave_m), PATHS, strict=True):
            shown = np.where(gap[:, None], np.nan, points[few])
            axes.plot(*shown[:, axes_shown].T, zorder=3, **how)
    elif paths is not None:
        alone = paths[MASTER].t_m[thinned(len(paths[MASTER]))]
        alone_by: Keywords = {"label": "path of the board"} if is_network(files.pose) else {}
        axes.plot(*alone[:, axes_shown].T, zorder=3, **(PATHS[MASTER] | alone_by))


def draw_path(axes: plot.Axes, files: CalibrationFiles, still: bool) -> str:
    """Both paths in detail, in the view in which the board's path is largest, dots where the
    board is at rest; returns from where, nothing where there is no path."""
    both, paths = files.agreement(), files.shown_paths()
    path = both.master_m if both is not None else None if paths is None else paths[MASTER].t_m
    if path is None or len(path) < 2:
        return ""
    low, high = usual_ends(path)
    inside = path[((path >= low) & (path <= high)).all(axis=1)]
    spread = np.cov((inside if len(inside) > 2 else path).T)
    view = max(SEEN_FROM, key=lambda pair: float(np.linalg.det(spread[np.ix_(pair, pair)])))
    draw_paths(axes, files, view)
    if still:
        for line in axes.lines:
            line.set(linestyle="none", marker=".", markersize=2.0, rasterized=True)
    if both is not None and both.mirrored.any():
        axes.plot(*both.master_m[both.mirrored][:200, list(view)].T, ls="", zorder=4, **MIRRORED)
    half = max(0.6 * float((high - low)[list(view)].max()), LEAST_PATH_M)
    _equal(axes, view, (low + high) / 2, half, 1.0, 3)
    return SEEN_FROM[view]


def _equal(
    axes: plot.Axes, view: View, centre: np.ndarray, half: float, high: float, ticks: int = 6
) -> None:
    """Equal scales, `half` metres to the left and right of the centre, `high` times that up."""
    across, up = (float(centre[k]) for k in view)
    axes.set(xlim=(across - half, across + half), ylim=(up - high * half, up + high * half))
    axes.set(xlabel=NAMES[view[0]], ylabel=NAMES[view[1]], aspect="equal")
    axes.locator_params(nbins=ticks, steps=[1, 2, 5, 10])


def ellipse(covariance: np.ndarray, plane: View, scale: float) -> np.ndarray:
    """Points (n, 2) with d^T C^-1 d = scale^2, C the block of the plane of a covariance."""
    values, vectors = np.linalg.eigh(covariance[np.ix_(plane, plane)])
    turn = np.linspace(0, 2 * np.pi, 121)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    return np.asarray(scale * (circle * np.sqrt(np.clip(values, 0, None))) @ vectors.T)


def draw_ellipses(panels: Sequence[plot.Axes], files: CalibrationFiles) -> None:
    """Ellipses about the chosen position in mm, seen from above and from the right, on one scale;
    other estimates of the same frame and optics, and the reference, on the border where they are
    far off."""
    entry = files.chosen
    stated = {name: (entry or {}).get(name) or [[np.nan]] for name, *_ in ELLIPSES}
    matrices = {name: np.array(matrix, dtype=np.float64) for name, matrix in stated.items()}
    known = [one for one in ELLIPSES if np.isfinite(matrices[one[0]]).all()]
    if entry is None or not known:
        for axes in panels:
            axes.set(xticks=[], yticks=[])
            write_message(axes, "No covariance")
        return
    reach = AREA * np.sqrt(max(np.diag(matrices["covariance"])[:3]))
    others = _other_estimates(files, entry)
    near = [r for _, off, _ in others if (r := np.abs(off).max()) < FARTHEST * reach]
    half = 1.2 * float(max([reach, *near]))
    for axes, plane in zip(panels, (ABOVE, RIGHT), strict=True):
        for name, scale, how in known:
            axes.plot(*ellipse(matrices[name], plane, scale).T, **how)
        label = f"chosen estimate: {entry['estimator']}, {entry['stage']}"
        axes.plot(0, 0, "o", color=INK, ms=3.0, label=label)
        for label, off, how in others:
            at = off[list(plane)] / max(np.abs(off[list(plane)]).max() / half, 1.0)
            axes.plot(*at, clip_on=False, ls="", label=label, zorder=4, **how)
        axes.set(xlim=(-half, half), ylim=(-half, half), aspect="equal")
        axes.set(xlabel=f"{'xyz'[plane[0]]} (mm)", ylabel=f"{'xyz'[plane[1]]} (mm)")
        axes.locator_params(nbins=4, steps=[1, 2, 5, 10])


def _other_estimates(
    files: CalibrationFiles, entry: PoseEntry
) -> list[tuple[str, np.ndarray, Keywords]]:
    """Label, distance (3,) in mm from the chosen estimate, and look."""
    at = np.array(entry["translation_mm"])
    alike = (p for p in files.pose["poses"] if all(p[k] == entry[k] for k in ("optics", "frame")))
    same = (p for p in alike if p["stage"] != "kabsch" and p["estimator"] != entry["estimator"])
    others = [
        (f"{p['estimator']}, {p['stage']}", np.array(p["translation_mm"]) - at, how)
        for p, how in zip(same, OTHERS, strict=False)
    ]
    if files.reference is not None:
        others.append(("reference", 1e3 * files.reference[1] - at, REFERENCE))
    return [
        (f"{label}: {mm(float(np.linalg.norm(off)), 2)} away", off, how)
        for label, off, how in others
        if np.isfinite(off).all()
    ]


def thinned(count: int, most: int = 1500) -> slice:
    """A stride that leaves at most so many of `count` points."""
    return slice(None, None, max(-(-count // most), 1))
