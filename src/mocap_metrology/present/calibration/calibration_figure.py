"""The picture a lab looks at after a calibration: where the stations are, and how sure that is."""

from __future__ import annotations

from collections.abc import Mapping
from textwrap import wrap
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.lighthouse.records import MASTER, ROLES, SLAVE
from mocap_metrology.present.calibration.calibration_files import (
    CalibrationFiles,
    residuals_urad,
    seen_shares,
    thinned,
)
from mocap_metrology.present.calibration.pose_ellipses import PLANES, draw_ellipses
from mocap_metrology.present.calibration.pose_text import (
    BEYOND_SIGMA,
    beyond_sigma,
    expected_urad,
    facts,
    pose_rows,
)
from mocap_metrology.present.calibration.residual_panels import (
    PANELS,
    draw_diode_residuals,
    draw_means,
    residuals_of,
)
from mocap_metrology.present.calibration.views import (
    ABOVE,
    COLOURS,
    MIRRORED,
    RIGHT,
    Scenery,
    draw_path,
    draw_view,
)
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.plot.figure import (
    GREY,
    INK,
    SMALL_PT,
    UNKNOWN_WORD,
    VERDICT_WORDS,
    Keywords,
    Picture,
    legend_below,
    letters,
    log_axis,
    new_figure,
    panel_title,
    say,
    styled,
    wrapped,
)
from mocap_metrology.present.tables import Record
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import mm, significant

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

DENSE = 500  # so many dots are an image in an SVG
MOST_DOTS, MOST_MARKS = 4000, 300
UNSEEN, SELDOM = 0.01, 0.5  # share of sweeps seen; SELDOM of the median diode's
FLAT = 0.05  # thickness of a board whose diodes all face the same way, over its width
MOST_NAMED = 3  # diodes
LINE_MM, SMALL_MM, SPACING = 3.95, 3.5, 1.3  # of lines
REASON, FACT = 84, 57  # characters in a line
LEGEND_MM = 30.0
TOP = [(66.0, [["above", "right"]]), (51.0, [["path", "horizontal", "vertical"]])]
BY_BATCH = [  # rows of panels: height in mm, panels
    *TOP,
    (43.0, [list(PANELS)]),
    (50.0, [["diodes", "master"], ["diodes", "slave"]]),
]
BY_BOARD_POSES = [*TOP, (50.0, [["apart", "poses"]]), (36.0, [["master", "slave"]])]
DOT: Keywords = {"ls": "", "markersize": 1.5, "mew": 0, "alpha": 0.7}


@styled()
def calibration_figure(given: CalibrationFiles) -> Picture:
    """One page of a calibration: verdict and pose in numbers; stations and path from above and from
    the right; the path near by; uncertainty of the slave's position; residuals of `batch` by angle,
    time and diode, of other estimators distance of both paths and residuals of board poses;
    diodes.

    Two plane views show the stations rather than one in 3-D, in which a point has no place that
    can be read off the paper. If the board was at rest or no pose was found, empty panels state
    the reason.
    """
    scenery, why = Scenery.of(given), _why_empty(given)
    reason, below = _words(given, scenery)
    kind = f"simulated stand-in (twin) {given.twin}" if given.twin else "measured"
    source = f"Source: {kind}. All positions are in the frame of the master."
    residuals = residuals_of(given.chosen)
    rows = BY_BATCH if residuals else BY_BOARD_POSES
    lines = max(len(reason), 2), max(map(len, below))
    head_mm = LINE_MM * lines[0] + SMALL_MM * lines[1] + 5.0
    *high, last = (height for height, _ in rows)
    heights = [head_mm, *high, last + LEGEND_MM]
    page = new_figure(f"{given.name}: calibration", source, sum(heights))
    head, *bodies = page.subfigures(len(heights), 1, squeeze=False, height_ratios=heights)[:, 0]
    _draw_words(head, given.pose["verdict"]["word"], reason, below)
    axes: dict[str, Axes] = {}
    for body, (_, places) in zip(bodies, rows, strict=True):
        axes |= body.subplot_mosaic(places)
    draw_view(axes["above"], scenery, ABOVE)
    draw_view(axes["right"], scenery, RIGHT)
    panel_title(axes["above"], "Stations from above")
    panel_title(axes["right"], "Stations from the right", "same scale")
    still = given.chosen is not None and given.chosen["stage"] == "static"
    seen_from = draw_path(axes["path"], scenery, still)
    panel_title(axes["path"], f"{'At rest,' if still else 'Path'} {seen_from}".strip(" ,"))
    planes = zip(PLANES, ("horizontal", "vertical"), strict=True)
    draw_ellipses({plane: axes[name] for plane, name in planes}, given)
    said = [_draw_fit(axes, given, scenery, residuals)]
    for empty in (axes[name] for name in ("path", "apart", "poses") if name in axes):
        if not empty.lines:
            empty.set(xticks=[], yticks=[])
            say(empty, why)
    said += [draw_diodes(axes[ROLES[station]], given, station) for station in (MASTER, SLAVE)]
    axes["slave"].set_xlabel("Diode (from 0)")
    letters(axes.values())
    legend_below(bodies[-1], axes.values())
    said.append(BEYOND_SIGMA if given.chosen and beyond_sigma(given.chosen) else "")
    fit = captions.CALIBRATION_BATCH if residuals else captions.CALIBRATION_BOARD_POSES
    return Picture(bodies[-1], " ".join(filter(None, (captions.CALIBRATION, fit, *said))))


def _draw_fit(
    axes: Mapping[str, Axes], given: CalibrationFiles, scenery: Scenery, residuals: Record | None
) -> str:
    """Residuals of `batch`, or those of board poses; a sentence on excluded diodes."""
    if residuals is None:
        draw_disagreement(axes["apart"], scenery, given.duration_s)
        draw_residuals(axes["poses"], scenery, given)
        return ""
    draw_means({key: axes[key] for key in PANELS}, residuals)
    entry: Record = dict(given.chosen or {})
    noise = entry["details"]["noise_hit_urad"]
    axes["master"].tick_params(labelbottom=False)
    return draw_diode_residuals(axes["diodes"], residuals, len(given.board), noise)


def _words(given: CalibrationFiles, scenery: Scenery) -> tuple[list[str], list[list[str]]]:
    """Lines of the reason of the verdict; columns of lines below it: labels of the pose, its three
    numbers, and its evidence."""
    reason = wrap(wrapped(given.pose["verdict"]["reason"]), REASON)
    rows = pose_rows(given.chosen) if given.chosen else [("No pose of the slave.", [""] * 3)]
    lines = [line for fact in facts(given, scenery.board_m) for line in wrap(wrapped(fact), FACT)]
    labels, numbers = zip(*rows, strict=True)
    return reason, [list(labels), *map(list, zip(*numbers, strict=True)), lines]


def _draw_words(head: SubFigure, word: str, reason: list[str], below: list[list[str]]) -> None:
    """Verdict and its reason above; the pose on the left, its evidence on the right."""
    colour, behind = VERDICT_WORDS.get(word, UNKNOWN_WORD)  # as on the pages
    box = {"boxstyle": "round,pad=0.35", "facecolor": behind, "edgecolor": colour, "lw": 0.6}
    how: Keywords = {"va": "top", "linespacing": SPACING}
    head.text(0.02, 0.98, word, weight="bold", color=colour, bbox=box, **how)
    head.text(0.15, 1.0, "\n".join(reason), **how)
    rows = SMALL_MM * max(map(len, below)) + 2.0
    at = rows / (LINE_MM * max(len(reason), 2) + rows + 1.0)
    places = (
        (0.01, GREY, "left"),
        *((x, INK, "right") for x in (0.275, 0.37, 0.465)),
        (0.5, INK, "left"),
    )
    for (x, ink, side), column in zip(places, below, strict=True):
        how |= {"size": SMALL_PT, "color": ink, "ha": side}
        head.text(x, at, "\n".join(column), **how)


def _why_empty(given: CalibrationFiles) -> str:
    if given.chosen is None:
        return "No pose of the slave: verdict failed"
    if given.paths(given.chosen["estimator"], given.chosen["optics"]) is not None:
        return "No moment with a pose from both stations"
    still = given.chosen["stage"] == "static"
    return "The board was at rest: no path" if still else "No board poses of this estimate"


def draw_disagreement(axes: Axes, scenery: Scenery, duration_s: float) -> None:
    """Distance between both paths over time; mirrored moments and those of one station marked."""
    panel_title(axes, "Distance between both paths")
    both = scenery.both
    if both is None:
        return
    value = np.maximum(both.apart_mm, 1e-3)
    median, most = float(np.median(value)), float(np.percentile(value, 95))
    axes.set(xlim=(0.0, duration_s), xlabel="Time (s)", ylabel="Distance (mm)")
    log_axis(axes, "y", log_limits([np.maximum(value, median / 300)], 2.0))
    few = thinned(value.size, MOST_DOTS)
    dense = value.size > DENSE
    axes.plot(both.time_s[few], value[few], "o", color="#4d4d4d", rasterized=dense, **DOT)
    text = f"median distance: {mm(median, 2)}, 95 % below {mm(most, 2)}"
    axes.axhline(median, color=INK, lw=0.7, ls=(0, (5, 2)), label=text)
    turned = np.flatnonzero(both.mirrored)
    if turned.size:
        turned = turned[thinned(turned.size, MOST_MARKS)]
        how: Keywords = {"ls": "", "zorder": 4, "label": "mirrored pose of one station"} | MIRRORED
        axes.plot(both.time_s[turned], value[turned], **how)
    for station, level in enumerate((0.97, 0.92)):
        alone = both.alone_s[station]
        if alone.size:
            how = {"ls": "", "marker": "|", "ms": 3.0, "mew": 0.5, "color": COLOURS[station]}
            how |= {"label": f"only the {ROLES[station]} sees it", "rasterized": alone.size > DENSE}
            at = np.full(alone.size, level)
            axes.plot(alone, at, transform=axes.get_xaxis_transform(), **how)


def draw_residuals(axes: Axes, scenery: Scenery, given: CalibrationFiles) -> None:
    """sqrt(epsilon / n_angles) of each board pose over time, both stations, and the noise of one
    angle to expect."""
    panel_title(axes, "Residuals of board poses")
    if scenery.paths is None:
        return
    expected = expected_urad(given.pose)
    values = [residuals_urad(path) for path in scenery.paths]
    shown = [np.maximum(v, np.median(v) / 100) for v in values]
    axes.set(xlim=(0.0, given.duration_s), xlabel="Time (s)", ylabel="Residual (µrad)")
    log_axis(axes, "y", log_limits([*shown, np.array([1.5 * expected])]))
    for station, path in enumerate(scenery.paths):
        few, colour = thinned(len(path), MOST_DOTS), COLOURS[station]
        how: Keywords = DOT | {"color": colour, "rasterized": len(path) > DENSE}
        axes.plot(path.time_s[few], shown[station][few], "os"[station], zorder=2.2 - station, **how)
        median = significant(float(np.median(values[station])), 2)
        text = f"residuals by the {ROLES[station]}: median {median} µrad"
        axes.plot([], [], "os"[station], color=colour, ms=3.0, mew=0, label=text)
    text = f"expected noise of an angle: {expected:.0f} µrad"
    axes.axhline(expected, color=INK, lw=0.8, ls=(0, (1, 1.5)), label=text)


def draw_diodes(axes: Axes, given: CalibrationFiles, station: int) -> str:
    """Share of the station's sweeps that each diode saw, a bar a diode; dead ones crossed. Returns
    the diodes that it saw seldom or never, by number."""
    n = len(given.board)
    shares = np.array([seen_shares(given.sweeps, one, n) for one in (MASTER, SLAVE)])
    states = faint_diodes(shares, given.board, station)
    bars = axes.bar(np.arange(n), 100 * shares[station], 0.72, color=COLOURS[station])
    for k in states["seldom"]:
        bars[k].set_alpha(0.5)
    if (dead := states["dead"]).size:
        cross: Keywords = {"marker": "x", "color": INK, "ls": "", "markersize": 4, "mew": 1.1}
        axes.plot(dead, np.full(dead.size, 9.0), label="dead diode", **cross)
    axes.set(xlim=(-0.8, n - 0.2), ylim=(0, 105), yticks=[0, 50, 100], ylabel="Seen (%)")
    axes.set_xticks(range(0, n, 4 if n > 16 else 2))
    axes.grid(visible=False, axis="x")
    known = {word: own for word, own in states.items() if own.size}
    few = sum(own.size for own in known.values()) <= MOST_NAMED
    remark = [f"{word}: {_named(own) if few else own.size}" for word, own in known.items()]
    if not shares[station].any():
        remark = ["no sweep seen"]
    panel_title(axes, f"Diodes, {ROLES[station]}", ", ".join(remark or ["all seen"]))
    said = "; ".join(f"{word}: {_named(own)}" for word, own in known.items())
    return f"Diodes of the {ROLES[station]}, {said}." if said and not few else ""


def _named(diodes: np.ndarray) -> str:
    return ", ".join(map(str, diodes.tolist()))


def faint_diodes(shares: np.ndarray, board: np.ndarray, station: int) -> dict[str, np.ndarray]:
    """Numbers of the diodes that are dead, that this station has not seen, and that it has seen
    less than half as often as the median one.

    shares (2, n): of the sweeps of either station that each diode saw. Those on a flat board all
    face the same way, so one that no station sees where others are seen is dead. On a board with
    depth it may face away, or something may be in the way: it is `not seen`.
    """
    seen = shares >= UNSEEN
    thickness, _, width = np.linalg.svd(board - board.mean(axis=0), compute_uv=False)[::-1]
    proven = thickness < FLAT * width and seen.any()
    dead = ~seen.any(axis=0) & proven
    own = seen[station]
    usual = np.median(shares[station][own]) if own.any() else 0.0
    return {
        "dead": np.flatnonzero(dead),
        "not seen": np.flatnonzero(~own & ~dead),
        "seldom": np.flatnonzero(own & (shares[station] < SELDOM * usual)),
    }
