"""Noise against the number of cameras, and what each addition did to it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.cameras.camera_tables import NOISE, noisy, raised
from mocap_metrology.present.drawing.axes import decade_axis, log_limits
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    FAINT,
    GREY,
    INK,
    LOOKS,
    MARGIN_MM,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    Sheet,
    blank_sheet,
    coordinate_of,
    head,
    label_axes,
    size_mm,
    styled,
    text_mm,
)
from mocap_metrology.present.tables import Record, Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEFT_MM, GAP_MM, RIGHT_MM, TOP_MM = 17.0, 11.0, 3.0, 6.0
NOISE_MM, RISE_MM, CAMERA_MM, LABELS_MM, BETWEEN_MM = 48.0, 34.0, 30.0, 12.0, 2.0
RATIOS = "Noise of subset /\nof the smaller one", "Noise of camera /\nmedian of all"
MOST = 3  # camera types side by side
ALARM = "#c2185b"
TICK_PT = SMALL_PT - 0.5
TAU_LOOKS = (("o", INK), ("s", "#5c5c5c"), ("^", "#858585"))  # one frame, 0.1 s, 1 s
DOT = 3.8  # points
WORDS = ("", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
NOTE = (
    "Above: Allan deviation at one frame against the number of cameras; first marker filled, "
    "others open; grey: 1/√n (S Eq. 3). Below: noise of each subset relative to the next "
    "smaller one, in the direction in which it rose most, of the worst marker, with 95 % "
    "intervals; sound cameras give 1 or less; dashed: limit. "
)
CAMERA_NOTE = (
    "Last: noise of each added camera (of the noisiest, where several were added at once) relative "
    "to the median of all cameras, from frames that the subsets share; dashed: limit. "
)


@styled()
def camera_figure(
    rows: Sequence[Row],
    sigma_mm: Mapping[str, Mapping[str, Record]],
    settings: Mapping[str, float],
    title: str,
    note: str = "",
) -> Figure:
    """rows: those of <group>_cameras; sigma_mm: camera type -> recording -> `n`, the ids it
    is `without` and the deviation at one frame of each coordinate; settings: limits `rise`
    and `noisy`."""
    types = list(sigma_mm)
    told = any(row["camera_noise"] is not None for row in rows)
    block = TOP_MM + NOISE_MM + LABELS_MM + BETWEEN_MM + RISE_MM + LABELS_MM
    block += (CAMERA_MM + BETWEEN_MM + LABELS_MM) if told else 0.0
    n_rows = -(-len(types) // MOST)
    entries = _entries(rows)
    width = WIDTH_MM - 2 * MARGIN_MM
    body = n_rows * block + strip_height(entries, width) + 4.0
    sheet = blank_sheet(body, title, f"{NOTE}{CAMERA_NOTE if told else ''}{note}")
    columns = min(len(types), MOST)
    panel = (WIDTH_MM - LEFT_MM - RIGHT_MM - (columns - 1) * GAP_MM) / columns
    for k, kind in enumerate(types):
        place = LEFT_MM + k % MOST * (panel + GAP_MM), TOP_MM + k // MOST * block, panel
        own = [row for row in rows if row["camera_type"] == kind]
        _block(sheet, place, kind, own, sigma_mm[kind], settings, told)
    strip(sheet, MARGIN_MM, n_rows * block + 2.0, width, entries)
    return sheet.figure


def _block(
    sheet: Sheet,
    place: tuple[float, float, float],
    kind: str,
    rows: Sequence[Row],
    sigma_mm: Mapping[str, Record],
    settings: Mapping[str, float],
    told: bool,
) -> None:
    left, top, width = place
    up = raised(rows)
    axes = sheet.axes(left, top, width, NOISE_MM)
    _noise_panel(axes, sigma_mm, up, width)
    head(axes, kind)
    first = left == LEFT_MM  # of its row: it alone names the vertical axes
    names = "Allan deviation, one frame (mm)", *RATIOS
    names = names if first else ("", "", "")
    counted = len({found["n"] for found in sigma_mm.values()}) == len(sigma_mm)
    across = "Number of cameras" if counted else "Cameras left out (−), or their number"
    label_axes(axes, x=across, y=names[0], x_mm=LABELS_MM - 2.0, y_mm=13.0)
    top += NOISE_MM + LABELS_MM + BETWEEN_MM
    axes = sheet.axes(left, top, width, RISE_MM)
    _rise_panel(axes, rows, up, settings["rise"])
    label_axes(axes, x="Ids of the cameras added", y=names[1], x_mm=LABELS_MM - 2.0, y_mm=12.5)
    if told:
        top += RISE_MM + LABELS_MM + BETWEEN_MM
        axes = sheet.axes(left, top, width, CAMERA_MM)
        _camera_panel(axes, rows, settings["noisy"])
        label_axes(axes, x="Ids of the cameras", y=names[2], x_mm=LABELS_MM - 2.0, y_mm=12.5)


def _noise_panel(
    axes: Axes, sigma_mm: Mapping[str, Record], up: Sequence[Row], width: float
) -> None:
    """Against the number of cameras; or, where recordings have equally many, side by side."""
    names = sorted(sigma_mm, key=lambda name: sigma_mm[name]["n"])
    n = np.array([sigma_mm[name]["n"] for name in names], dtype=np.float64)
    nested = np.unique(n).size == n.size
    x = n if nested else np.arange(n.size, dtype=np.float64)
    at = dict(zip(names, x, strict=True))
    series = {s: place for f in sigma_mm.values() for s in f if (place := coordinate_of(s))}
    values = {s: np.array([sigma_mm[name].get(s, np.nan) for name in names]) for s in series}
    limits = log_limits(list(values.values()), least_decades=1.0)
    for row in up:
        ends = (at[row["from"]], at[row["to"]]) if nested else at[row["from"]] + SLOT
        axes.axvspan(*ends, color=ALARM, alpha=0.13, lw=0)
    if nested:
        grid = np.array([n.min(), n.max()])
        for level in np.geomspace(*limits, 9):
            axes.plot(grid, level * (n.min() / grid) ** 0.5, color=FAINT, lw=0.8, zorder=0.5)
    for (axis, marker), y in zip(series.values(), values.values(), strict=True):
        look = LOOKS[axis]
        fill = look.colour if marker == 1 else "white"
        how: Keywords = {"color": look.colour, "marker": look.marker, "markerfacecolor": fill}
        axes.plot(x, y, ls=look.dashes if nested else "", lw=0.9, **how)
    decade_axis(axes, "y", limits, NOISE_MM)
    axes.grid(visible=False, axis="y")
    if nested:
        _count_axis(axes, n, width)
    else:
        _slot_axis(axes, [_without(**sigma_mm[name]) for name in names])


SLOT = np.array([-0.5, 0.5])


def _without(n: int, without: Sequence[int | str], **_levels: float) -> str:
    """`−5` of a subset that lacks camera 5; of others, the number of cameras."""
    return "\n".join(f"−{i}" for i in without) if 0 < len(without) <= 2 else f"{n}"


def _count_axis(axes: Axes, counts: np.ndarray, width: float) -> None:
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    low, high = counts.min(), counts.max()
    pad = (high / low) ** 0.06
    axes.set_xscale("log")
    axes.set_xlim(low / pad, high * pad)
    at = width / np.log(high / low * pad**2)
    shown = [counts[-1]]
    for count in counts[-2::-1]:  # labels where there is room, the largest first
        if np.log(shown[-1] / count) * at > 4.0:
            shown.append(count)
    axes.xaxis.set_major_locator(FixedLocator(sorted(shown)))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _p: f"{v:g}"))


def _rise_panel(axes: Axes, rows: Sequence[Row], up: Sequence[Row], rise: float) -> None:
    steps = list(dict.fromkeys((r["from"], r["to"]) for r in rows if r["from"]))
    own = [r for r in rows if r["from"]]
    if not own:
        _nothing(axes, "nothing to tell")
        return
    taus = sorted({r["tau_s"] for r in own})[: len(TAU_LOOKS)]
    bad = {(r["from"], r["to"]) for r in up}
    for k, step in enumerate(steps):
        if step in bad:
            axes.axvspan(k - 0.5, k + 0.5, color=ALARM, alpha=0.13, lw=0)
    for j, (tau, (marker, colour)) in enumerate(zip(taus, TAU_LOOKS, strict=False)):
        worst = [_worst(own, step, tau) for step in steps]
        x = np.arange(len(steps)) + (j - (len(taus) - 1) / 2) * 0.24
        _dots(
            axes,
            x,
            worst,
            ("largest_factor", "largest_lower_95", "largest_upper_95"),
            marker,
            colour,
        )
    axes.axhline(1, color=GREY, lw=0.8)
    axes.axhline(1 + rise, color=ALARM, lw=0.9, ls=(0, (4, 2)))
    named = {s: next(r for r in own if (r["from"], r["to"]) == s) for s in steps}
    _factor_axis(axes, own, "largest")
    _slot_axis(axes, _step_labels([named[s] for s in steps], size_mm(axes)[0]))


def _camera_panel(axes: Axes, rows: Sequence[Row], limit: float) -> None:
    shortest = min((r["tau_s"] for r in rows), default=0.0)
    own = [r for r in rows if r["tau_s"] == shortest and r["camera_noise"] is not None]
    first = list({(r["from"], r["to"]): r for r in reversed(own)}.values())[::-1]
    sets = {r["added"] for r in noisy(rows, limit)}
    if not first:
        _nothing(axes, "frames are not shared")
        return
    for k, row in enumerate(first):
        if row["added"] in sets:
            axes.axvspan(k - 0.5, k + 0.5, color=ALARM, alpha=0.13, lw=0)
    _dots(axes, np.arange(len(first)), first, NOISE[:3], "o", INK)
    axes.axhline(1, color=GREY, lw=0.8)
    axes.axhline(limit, color=ALARM, lw=0.9, ls=(0, (4, 2)))
    _factor_axis(axes, first, "camera_noise")
    _slot_axis(axes, _step_labels(first, size_mm(axes)[0]))


def _nothing(axes: Axes, why: str) -> None:
    axes.set(xticks=[], yticks=[])
    how: Keywords = {"transform": axes.transAxes, "ha": "center", "va": "center", "size": SMALL_PT}
    axes.text(0.5, 0.5, why, color=GREY, **how)


def _worst(rows: Sequence[Row], step: tuple[str, str], tau: float) -> Row:
    own = [r for r in rows if (r["from"], r["to"]) == step and r["tau_s"] == tau]
    return max(own, key=lambda r: r["largest_factor"])


def _dots(
    axes: Axes,
    x: np.ndarray,
    rows: Sequence[Row],
    keys: Sequence[str],
    marker: str,
    colour: str,
) -> None:
    value, low, high = (np.array([r[key] for r in rows], dtype=np.float64) for key in keys)
    axes.vlines(x, low, high, color=colour, lw=1.0)
    axes.plot(x, value, ls="", marker=marker, color=colour, markersize=DOT)


def _factor_axis(axes: Axes, rows: Sequence[Row], which: str) -> None:
    """Logarithmic, from what the estimates need; intervals may leave the panel."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    key = "largest_factor" if which == "largest" else which
    values = np.array([r[key] for r in rows], dtype=np.float64)
    low, high = min(values.min() / 1.12, 0.8), max(values.max() * 1.12, 1.25)
    fine, coarse = [0.8, 0.9, 1, 1.1, 1.2, 1.3, 1.5], [0.1, 0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 4]
    ticks = np.array(fine if high / low < 2 else [*coarse, 6, 10, 20, 50])
    ticks = ticks[(ticks > low) & (ticks < high)]
    axes.set_yscale("log")
    axes.set_ylim(low, high)
    axes.yaxis.set_major_locator(FixedLocator(ticks))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda v, _p: f"{v:g}"))
    axes.grid(visible=True, axis="y")


def _slot_axis(axes: Axes, labels: Sequence[str]) -> None:
    from matplotlib.ticker import FixedLocator, FuncFormatter

    axes.set_xlim(-0.5, len(labels) - 0.5)
    axes.xaxis.set_major_locator(FixedLocator(range(len(labels))))
    names = dict(enumerate(labels))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _p: names.get(round(v), "")))
    axes.tick_params(axis="x", length=0, labelsize=TICK_PT)


def _step_labels(rows: Sequence[Row], width: float) -> list[str]:
    """Ids, one a line, of two at most, with the word `id` where axes `width` mm wide have room; of
    more, their number in words."""
    few = [ids for row in rows if len(ids := row["added"].split(";")) <= 2]
    widest = max((text_mm(f"id {i}", TICK_PT) for ids in few for i in ids), default=0.0)
    word = "id " if widest < 0.8 * width / max(len(rows), 1) else ""
    return [_step_label(row, word) for row in rows]


def _step_label(row: Row, word: str) -> str:
    ids = row["added"].split(";")
    if len(ids) <= 2:
        return "\n".join(f"{word}{i}" for i in ids)
    count = WORDS[len(ids)] if len(ids) < len(WORDS) else str(len(ids))
    return f"{count}\nmore" if row["from"] else f"first\n{count}"


def _entries(rows: Sequence[Row]) -> list[Entry]:
    entries = [Entry(axis, look=LOOKS[axis]) for axis in LOOKS]
    taus = sorted({r["tau_s"] for r in rows if r["from"]})[: len(TAU_LOOKS)]
    for k, (tau, (marker, colour)) in enumerate(zip(taus, TAU_LOOKS, strict=False)):
        text = "one frame" if k == 0 else f"{tau:.2g} s"
        entries.append(Entry(text, dot={"marker": marker, "color": colour, "markersize": DOT}))
    entries.append(Entry("limit", line={"color": ALARM, "lw": 0.9, "ls": (0, (4, 2))}))
    entries.append(Entry("raised or noisy", patch={"color": ALARM, "alpha": 0.13, "lw": 0}))
    return entries
