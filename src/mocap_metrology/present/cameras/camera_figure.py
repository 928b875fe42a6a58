"""Noise against the number of cameras, and what each addition did to it."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from mocap_metrology.present.cameras.camera_tables import COLUMNS, LARGEST, NOISE, noisy, raised
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
    room_for,
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
    kinds, table = list(sigma_mm), pd.DataFrame(rows, columns=COLUMNS)
    worst = _steps(table[table["from"] != ""], LARGEST)
    added = _steps(table[table["tau_s"] == table["tau_s"].min()], NOISE)
    heights = [NOISE_MM, RISE_MM] + ([CAMERA_MM] if len(added) else [])
    n_blocks, columns = -(-len(kinds) // MOST), min(len(kinds), MOST)
    body = new_figure(title, source, REST_MM + n_blocks * sum(heights))
    levels = {kind: _levels(of) for kind, of in sigma_mm.items()}
    limits = log_limits([of.drop(columns=["n", "label"]).to_numpy() for of in levels.values()])
    for k, part in enumerate(body.subfigures(n_blocks, squeeze=False)[:, 0]):
        shown = kinds[k * MOST : (k + 1) * MOST]
        grid = part.subplots(len(heights), columns, squeeze=False, height_ratios=heights)
        for kind, (top, *panels) in zip(shown, grid.T, strict=False):
            own = [row for row in rows if row["camera_type"] == kind]
            up = {(row["from"], row["to"]) for row in raised(own)}
            _noise_panel(top, levels[kind], up, limits)
            panel_title(top, short(kind, NAME))
            loud = {row["added"] for row in noisy(own, settings["noisy"])}
            worst["bad"] = worst.set_index(["from", "to"]).index.isin(up)
            added["bad"] = added["added"].isin(loud)
            for axes, steps, limit, words in zip(
                panels,
                (worst, added),
                (1 + settings["rise"], settings["noisy"]),
                ("no addition of cameras", "frames are not shared"),
                strict=False,
            ):
                ratio_axis(axes, _ratio_limits(steps["value"]))
                own_steps = steps[steps["camera_type"] == kind]
                _factor_panel(axes, own_steps, limit, words, ROOM_FOR_ID // columns)
        _name_rows(grid, shown)
    last = list(grid[:, : len(shown)].flat)
    last[1].axvspan(np.nan, np.nan, label="raised or noisy", **RAISED)
    legend_below(part, last, 5)
    return Picture(body, f"{captions.CAMERAS} {remarks}")


def _steps(table: pd.DataFrame, keys: Sequence[str]) -> pd.DataFrame:
    """One row an addition and averaging time, of the worst marker: `value`, `lower`, `upper`."""
    names = dict(zip(keys, ("value", "lower", "upper"), strict=False))
    steps = table[table[keys[0]].notna()].rename(columns=names)
    steps[["value", "lower", "upper"]] = steps[["value", "lower", "upper"]].astype(float)
    steps = steps.sort_values("value", ascending=False, kind="stable")
    return steps.drop_duplicates(["camera_type", "from", "to", "tau_s"]).sort_index()


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


def _levels(levels: Levels) -> pd.DataFrame:
    """A row a recording, by the number `n` of cameras: its `label` (`−5` if it lacks camera 5, else
    the number) and its deviations, a column a coordinate."""
    table = pd.DataFrame.from_dict(dict(levels), orient="index")
    names = [
        "\n".join(f"−{i}" for i in ids) if 0 < len(ids) <= 2 else str(n)
        for ids, n in zip(table["without"], table["n"], strict=True)
    ]
    series = [name for name in table if coordinate_of(str(name))]
    return table.assign(label=names)[["n", "label", *series]].sort_values("n", kind="stable")


def _noise_panel(
    axes: Axes, levels: pd.DataFrame, up: Collection[tuple[str, str]], limits: Limits
) -> None:
    """Against the number of cameras; or, where recordings have equally many, side by side."""
    nested = levels["n"].is_unique
    x = levels["n"].astype(float) if nested else pd.Series(range(len(levels)), levels.index)
    log_axis(axes, "y", limits)
    axes.grid(visible=False)
    for smaller, larger in up:
        ends = (x[smaller], x[larger]) if nested else (x[smaller] - 0.5, x[smaller] + 0.5)
        axes.axvspan(*ends, **RAISED)
    for name in levels.columns.drop(["n", "label"]):
        axis, marker = coordinate_of(name) or ("x", 1)
        how = LOOKS[axis].line(lw=0.9, label=axis) | ({} if nested else {"ls": ""})
        how |= {"markerfacecolor": LOOKS[axis].colour if marker == 1 else "white"}
        axes.plot(x, levels[name], **how)
    if not nested:
        _slot_axis(axes, levels["label"].tolist())
        axes.set_xlabel("Cameras left out (−), or their number")
        return
    n = x.to_numpy()
    for level in np.geomspace(*limits, 9):
        axes.plot(n, level * (n[0] / n) ** 0.5, zorder=0.5, **LAW)
    axes.plot([], [], label="1/√n (S Eq. 3)", **LAW)
    pad = float(n[-1] / n[0]) ** 0.06
    axes.set(xscale="log", xlim=(n[0] / pad, n[-1] * pad), xlabel="Number of cameras")
    ticks = room_for(n.tolist(), CLOSE)
    axes.set_xticks(ticks, [f"{count:g}" for count in ticks])
    axes.set_xticks([], minor=True)


def _factor_panel(axes: Axes, steps: pd.DataFrame, limit: float, nothing: str, room: int) -> None:
    """Factors of each addition, at up to three averaging times, with intervals whose ends are wider
    than the points, so that short ones show; the `bad` ones shaded."""
    axes.set_xlabel("Ids of the cameras" + (" added" if "addition" in nothing else ""))
    if steps.empty:
        axes.set_xticks([])
        say(axes, nothing)
        return
    first = steps.drop_duplicates(["from", "to"])
    place = {(a, b): k for k, (a, b) in enumerate(zip(first["from"], first["to"], strict=True))}
    taus = sorted(steps["tau_s"].unique())[: len(TAU_LOOKS)]
    for j, (tau, (marker, colour)) in enumerate(zip(taus, TAU_LOOKS, strict=False)):
        own = steps[steps["tau_s"] == tau]
        at = [place[step] for step in zip(own["from"], own["to"], strict=True)]
        x = np.array(at) + (j - (len(taus) - 1) / 2) * 0.24
        reach = np.nan_to_num([own["value"] - own["lower"], own["upper"] - own["value"]])
        how: Keywords = {"ls": "", "marker": marker, "color": colour, "markersize": 2.6}
        how |= {"elinewidth": 0.9, "capsize": 3.2, "capthick": 0.7}
        label = "one frame" if j == 0 else f"{tau:.2g} s"
        axes.errorbar(x, own["value"], yerr=reach, label=label, **how)
    axes.axhline(1, color=GREY, lw=0.8)
    axes.axhline(limit, label="limit", **LIMIT)
    for k in np.flatnonzero(first["bad"]):
        axes.axvspan(k - 0.5, k + 0.5, **RAISED)
    names = zip(first["added"], first["from"], strict=True)
    _slot_axis(axes, [_added(ids, smaller, len(first) <= room) for ids, smaller in names])


def _ratio_limits(values: pd.Series) -> Limits:
    """From what the estimates need; intervals may leave the panel."""
    return min([0.8, *(values / 1.12)]), max([1.25, *(values * 1.12)])


def _slot_axis(axes: Axes, labels: Sequence[str]) -> None:
    axes.set_xlim(-0.5, len(labels) - 0.5)
    axes.set_xticks(range(len(labels)), labels)
    axes.tick_params(axis="x", length=0)
    axes.grid(visible=False, axis="x")


def _added(added: str, smaller: str, room: bool) -> str:
    """Ids, one a line, of two at most, with the word `id` where there is room; of more, their
    number in words."""
    ids = added.split(";")
    if len(ids) <= 2:
        return "\n".join(f"{'id ' * room}{short(i)}" for i in ids)
    count = WORDS[len(ids)] if len(ids) < len(WORDS) else str(len(ids))
    return f"{count}\nmore" if smaller else f"first\n{count}"
