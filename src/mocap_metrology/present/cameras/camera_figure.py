"""Noise against the number of cameras, and what each addition did to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.cameras.camera_tables import LARGEST, NOISE, noisy, raised
from mocap_metrology.present.plot.curves import Limits, log_limits
from mocap_metrology.present.plot.figure import (
    FAINT,
    GREY,
    INK,
    LOOKS,
    Keywords,
    Picture,
    coordinate_of,
    legend_below,
    log_axis,
    new_figure,
    panel_title,
    ratio_axis,
    say,
    short,
    styled,
)
from mocap_metrology.present.tables import Record, Row
from mocap_metrology.present.text import captions

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NOISE_MM, RISE_MM, CAMERA_MM, REST_MM = 60.0, 48.0, 46.0, 22.0  # heights of rows
MOST, NAME = 3, 18  # camera types side by side, characters over a panel
ALARM = "#c2185b"
RAISED: Keywords = {"color": ALARM, "alpha": 0.13, "lw": 0}
LIMIT: Keywords = {"color": ALARM, "lw": 0.9, "ls": (0, (4, 2))}
LAW: Keywords = {"color": FAINT, "lw": 0.8}
TAU_LOOKS = (("o", INK), ("s", "#5c5c5c"), ("^", "#757575"))  # one frame, 0.1 s, 1 s
CLOSE = 0.88  # of the next larger number of cameras, from which its label would touch
ROOM_FOR_ID = 14  # ids across a page that have room for the word
WORDS = ("", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
Levels = Mapping[str, Record]  # of each recording: n, ids it is without, deviation by coordinate


@styled()
def camera_figure(
    rows: Sequence[Row],
    sigma_mm: Mapping[str, Levels],
    settings: Mapping[str, float],
    title: str,
    source: str,
    remarks: str = "",
) -> Picture:
    """A column a camera type: (a) noise at one frame against the number of cameras, (b) how it
    changed with each addition, (c) the noise of each added camera, where it is known.

    rows: those of <group>_cameras; sigma_mm: camera type -> recording -> `n`, the ids it
    is `without` and the deviation at one frame of each coordinate; settings: limits `rise`
    and `noisy`; source: the line at the foot; remarks: what the caption adds.
    """
    kinds = list(sigma_mm)
    heights = [NOISE_MM, RISE_MM]
    heights += [CAMERA_MM] if any(row["camera_noise"] is not None for row in rows) else []
    n_blocks = -(-len(kinds) // MOST)
    columns = min(len(kinds), MOST)
    room = ROOM_FOR_ID // columns
    body = new_figure(title, source, REST_MM + n_blocks * sum(heights))
    levels = log_limits([_values(of)[1] for of in sigma_mm.values()], least_decades=1.0)
    factors = [_factor_limits(rows, LARGEST[0]), _factor_limits(rows, NOISE[0])]
    last: list[Axes] = []
    for k, part in enumerate(body.subfigures(n_blocks, squeeze=False)[:, 0]):
        shown = kinds[k * MOST : (k + 1) * MOST]
        grid = part.subplots(len(heights), columns, squeeze=False, height_ratios=heights)
        for kind, column in zip(shown, grid.T, strict=False):
            own = [row for row in rows if row["camera_type"] == kind]
            _noise_panel(column[0], sigma_mm[kind], raised(own), levels)
            panel_title(column[0], short(kind, NAME))
            _rise_panel(column[1], own, settings["rise"], factors[0], room)
            if len(heights) > 2:
                _camera_panel(column[2], own, settings["noisy"], factors[1], room)
        _name_rows(grid, shown)
        last = list(grid[:, : len(shown)].flat)
    last[1].axvspan(np.nan, np.nan, label="raised or noisy", **RAISED)
    legend_below(part, last, 5)
    return Picture(body, f"{captions.CAMERAS} {remarks}")


def _name_rows(grid: np.ndarray, shown: Sequence[str]) -> None:
    """Letters and vertical axes are named at the first camera type; empty panels are removed."""
    names = (
        (shown[0], "Allan deviation,\none frame (mm)"),
        ("With each addition", "Noise of subset /\nof the smaller one"),
        ("Each added camera", "Noise of camera /\nmedian of all"),
    )
    for letter, row, (title, label) in zip("abc", grid, names, strict=False):
        panel_title(row[0], f"({letter}) {short(title, NAME)}")
        row[0].set_ylabel(label)
        for axes in row[1:]:
            axes.tick_params(labelleft=False, which="both")
        for axes in row[len(shown) :]:
            axes.axis("off")


def _values(levels: Levels) -> tuple[list[str], np.ndarray]:
    """Series, and their deviations (series, recording), recordings by number of cameras."""
    series = list(dict.fromkeys(s for found in levels.values() for s in found if coordinate_of(s)))
    names = sorted(levels, key=lambda name: levels[name]["n"])
    values = [[levels[name].get(s, np.nan) for name in names] for s in series]
    return series, np.array(values, dtype=np.float64).reshape(len(series), len(names))


def _noise_panel(axes: Axes, levels: Levels, up: Sequence[Row], limits: Limits) -> None:
    """Against the number of cameras; or, where recordings have equally many, side by side."""
    names = sorted(levels, key=lambda name: levels[name]["n"])
    n = np.array([levels[name]["n"] for name in names], dtype=np.float64)
    nested = np.unique(n).size == n.size
    x = n if nested else np.arange(n.size, dtype=np.float64)
    at = dict(zip(names, x.tolist(), strict=True))
    log_axis(axes, "y", limits)
    axes.grid(visible=False)
    for row in up:
        ends = (at[row["from"]], at[row["to"]]) if nested else (at[row["from"]], at[row["from"]])
        axes.axvspan(ends[0] - 0.5 * (not nested), ends[1] + 0.5 * (not nested), **RAISED)
    for level in np.geomspace(*limits, 9) if nested else ():
        axes.plot(n, level * (n[0] / n) ** 0.5, zorder=0.5, **LAW)
    for name, y in zip(*_values(levels), strict=True):
        axis, marker = coordinate_of(name) or ("x", 1)
        how = LOOKS[axis].line(lw=0.9, label=axis)
        how |= {"markerfacecolor": LOOKS[axis].colour if marker == 1 else "white"}
        axes.plot(x, y, **how | ({} if nested else {"ls": ""}))
    if nested:
        axes.plot([], [], label="1/√n (S Eq. 3)", **LAW)
        _count_axis(axes, n)
    else:
        _slot_axis(axes, [_without(**levels[name]) for name in names])
        axes.set_xlabel("Cameras left out (−), or their number")


def _without(n: int, without: Sequence[int | str], **_levels: float) -> str:
    """`−5` of a subset that lacks camera 5; of others, the number of cameras."""
    return "\n".join(f"−{i}" for i in without) if 0 < len(without) <= 2 else f"{n}"


def _count_axis(axes: Axes, counts: np.ndarray) -> None:
    """A logarithmic axis of numbers of cameras, labels where there is room, the largest first."""
    pad = float(counts[-1] / counts[0]) ** 0.06
    axes.set(xscale="log", xlim=(counts[0] / pad, counts[-1] * pad), xlabel="Number of cameras")
    shown = [counts[-1]]
    for count in counts[-2::-1]:
        if count < CLOSE * shown[-1]:
            shown.append(count)
    axes.set_xticks(shown, [f"{count:g}" for count in shown])
    axes.set_xticks([], minor=True)


def _rise_panel(axes: Axes, rows: Sequence[Row], rise: float, limits: Limits, room: int) -> None:
    """Factor of the worst marker with each addition, at up to three averaging times."""
    own = [row for row in rows if row["from"]]
    steps = list(dict.fromkeys((row["from"], row["to"]) for row in own))
    bad = {(row["from"], row["to"]) for row in raised(rows)}
    ratio_axis(axes, limits)
    axes.set_xlabel("Ids of the cameras added")
    if not own:
        axes.set_xticks([])
        say(axes, "no addition of cameras")
        return
    taus = sorted({row["tau_s"] for row in own})[: len(TAU_LOOKS)]
    for j, (tau, look) in enumerate(zip(taus, TAU_LOOKS, strict=False)):
        x = np.arange(len(steps)) + (j - (len(taus) - 1) / 2) * 0.24
        worst = [_worst(own, step, tau) for step in steps]
        _bars(axes, x, worst, LARGEST, look, "one frame" if j == 0 else f"{tau:.2g} s")
    _limits(axes, 1 + rise, [k for k, step in enumerate(steps) if step in bad])
    named = {step: next(r for r in own if (r["from"], r["to"]) == step) for step in steps}
    _slot_axis(axes, [_added(named[step], len(steps) <= room) for step in steps])


def _camera_panel(axes: Axes, rows: Sequence[Row], limit: float, limits: Limits, room: int) -> None:
    """Noise of each added camera at one frame."""
    shortest = min((row["tau_s"] for row in rows), default=0.0)
    own = [row for row in rows if row["tau_s"] == shortest and row["camera_noise"] is not None]
    first = list({(row["from"], row["to"]): row for row in reversed(own)}.values())[::-1]
    bad = {row["added"] for row in noisy(rows, limit)}
    ratio_axis(axes, limits)
    axes.set_xlabel("Ids of the cameras")
    if not first:
        axes.set_xticks([])
        say(axes, "frames are not shared")
        return
    _bars(axes, np.arange(len(first)), first, NOISE, TAU_LOOKS[0], "one frame")
    _limits(axes, limit, [k for k, row in enumerate(first) if row["added"] in bad])
    _slot_axis(axes, [_added(row, len(first) <= room) for row in first])


def _limits(axes: Axes, limit: float, bad: Sequence[int]) -> None:
    axes.axhline(1, color=GREY, lw=0.8)
    axes.axhline(limit, label="limit", **LIMIT)
    for k in bad:
        axes.axvspan(k - 0.5, k + 0.5, **RAISED)


def _worst(rows: Sequence[Row], step: tuple[str, str], tau: float) -> Row:
    own = [r for r in rows if (r["from"], r["to"]) == step and r["tau_s"] == tau]
    return max(own, key=lambda r: r["largest_factor"])


def _bars(
    axes: Axes,
    x: np.ndarray,
    rows: Sequence[Row],
    keys: Sequence[str],
    look: tuple[str, str],
    text: str,
) -> None:
    """Factors with intervals whose ends are wider than the points, so that short ones show."""
    value, low, high = (np.array([row[key] for row in rows], dtype=np.float64) for key in keys[:3])
    how: Keywords = {"ls": "", "marker": look[0], "color": look[1], "markersize": 2.6}
    reach = np.nan_to_num([value - low, high - value])
    axes.errorbar(
        x, value, yerr=reach, elinewidth=0.9, capsize=3.2, capthick=0.7, label=text, **how
    )


def _factor_limits(rows: Sequence[Row], key: str) -> Limits:
    """From what the estimates need; intervals may leave the panel."""
    values = [row[key] for row in rows if row[key] is not None and (row["from"] or key == NOISE[0])]
    return min([0.8, *(v / 1.12 for v in values)]), max([1.25, *(v * 1.12 for v in values)])


def _slot_axis(axes: Axes, labels: Sequence[str]) -> None:
    axes.set_xlim(-0.5, len(labels) - 0.5)
    axes.set_xticks(range(len(labels)), labels)
    axes.tick_params(axis="x", length=0)
    axes.grid(visible=False, axis="x")


def _added(row: Row, room: bool) -> str:
    """Ids, one a line, of two at most, with the word `id` where there is room; of more, their
    number in words."""
    ids = row["added"].split(";")
    if len(ids) <= 2:
        return "\n".join(f"{'id ' * room}{short(i)}" for i in ids)
    count = WORDS[len(ids)] if len(ids) < len(WORDS) else str(len(ids))
    return f"{count}\nmore" if row["from"] else f"first\n{count}"
