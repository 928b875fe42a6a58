"""Figures 8, 12, 13 and A1 of S: recordings compared by their Allan deviations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from mocap_metrology.present.groups.adev import (
    Allan,
    compared_figure,
    panels_picture,
    series_curves,
)
from mocap_metrology.present.groups.members import Rows, count_looks
from mocap_metrology.present.plot.curves import (
    ADEV_AXES,
    Limits,
    curve_limits,
    draw_curves,
    log_limits,
    positive,
)
from mocap_metrology.present.plot.figure import (
    FAINT,
    GREY,
    LOOKS,
    OTHER_LOOKS,
    Keywords,
    Picture,
    legend_below,
    letters,
    log_axes,
    log_axis,
    new_figure,
    say,
    styled,
)
from mocap_metrology.present.skurowski.camera_tables import TABLE_4, standing_for
from mocap_metrology.present.skurowski.densities import SETS
from mocap_metrology.present.tables import Record
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.captions import PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SERIES = ("x1", "x2", "L")
SLICE_S = 10.0  # averaging time of the panel against the number of cameras
DROPS = {"T40": 3, "Bonita": 5, "Vantage": 4}  # S 4.3: "notably better suited" setups
ROW_MM = 56.0
CAMERA_LIMITS = 1.4, 10.6
LAW: Keywords = {"color": GREY, "lw": 0.8, "ls": (0, (1.2, 1.2)), "label": r"$\propto 1/\sqrt{n}$"}
DROP: Keywords = {"color": FAINT, "alpha": 0.8, "lw": 0, "label": "notably better suited (S 4.3)"}
SLICE_LOOKS = {"x1": LOOKS["x"], "x2": LOOKS["y"], "L": OTHER_LOOKS[0]}
TITLES = {
    7: f"{PAPER}, Figure 7: a seismic crump",
    8: f"{PAPER}, Figure 8: Vantage with and without the failing camera",
    12: f"{PAPER}, Figure 12: Allan deviation by number of cameras",
    13: f"{PAPER}, Figure 13: Allan deviation by camera type",
    "A1": f"{PAPER}, Figure A1: z1 after the failing camera was replaced",
}
TYPES = ("T40", "Bonita", "Vantage")
SERIES_A1 = "z1"
ALL_NOTE = (
    "No coefficients were published of all cameras: their twin is T40-10 with x1 and x2 scaled to "
    "Table 4, y and z as they are."
)


@styled()
def subsets_figure(
    types: Mapping[str, Mapping[int, Mapping[str, np.ndarray]]],
    title: str,
    source: str,
    remarks: str = "",
) -> Picture:
    """Allan deviations of x1, x2 and L by number of cameras, and at one averaging time against it.

    types: columns of allan.parquet by camera type and number of cameras; source: the line at the
    foot; remarks: what the caption adds. The column of the number that S calls notably better
    suited is shaded.
    """
    types = {name: subsets for name, subsets in types.items() if subsets}
    counts = count_looks([n for subsets in types.values() for n in subsets])
    looks = {f"{n} cameras": look for n, look in counts.items()}
    body = new_figure(title, source, 34.0 + max(len(types), 1) * ROW_MM)
    grid = body.subplots(max(len(types), 1), 4, sharey="row", sharex="col", squeeze=False)
    if not types:
        say(grid[0, 0], "no recording of such a subset")
    for name, look in looks.items():  # in this order in the legend
        grid[0, 0].plot([], [], label=name, **look.line())
    curves = {kind: _curves(subsets) for kind, subsets in types.items()}
    taus = log_limits([of[s]["x"] for of in curves.values() for s in SERIES])
    for row, (kind, of_kind) in zip(grid, curves.items(), strict=False):
        limits = taus, curve_limits(pd.concat(of_kind.values()))[1]
        for axes, series in zip(row, SERIES, strict=False):
            log_axes(axes, limits)
            draw_curves(axes, of_kind[series], limits[1], looks)
            axes.set_title(f"{kind}: {series}")
        _draw_slice(row[3], of_kind, limits[1], DROPS.get(kind))
        row[3].set_title(rf"{kind}: $\tau$ = {SLICE_S:g} s")
        row[0].set_ylabel(ADEV_AXES[1])
    for axes, label in zip(grid[-1], (*3 * (r"$\tau$ (s)",), "Cameras n"), strict=True):
        axes.set_xlabel(label)
    legend_below(body, grid.flat, columns=6)
    return Picture(body, f"{captions.SKUROWSKI[12]} {remarks}")


def _curves(subsets: Mapping[int, Mapping[str, np.ndarray]]) -> dict[str, pd.DataFrame]:
    """Curves of each series, in the order of the number of cameras `n`."""
    allan = {str(n): subsets[n] for n in sorted(subsets)}
    labels = {n: f"{n} cameras" for n in allan}
    curves = {series: series_curves(allan, series, labels, False) for series in SERIES}
    return {s: c.assign(n=c["curve"].str.split().str[0].astype(int)) for s, c in curves.items()}


def at_tau(curve: pd.DataFrame, tau_s: float) -> float:
    """Deviation at an averaging time, between two computed ones along the line in the figure; NaN
    beyond them."""
    known = curve[np.isfinite(positive(curve["y"]))]
    if known.empty:
        return np.nan
    x, y = np.log(known["x"]), np.log(known["y"])
    return float(np.exp(np.interp(np.log(tau_s), x, y, left=np.nan, right=np.nan)))


def _draw_slice(
    axes: Axes, curves: Mapping[str, pd.DataFrame], limits: Limits, drop: int | None
) -> None:
    """Deviation at one averaging time against the number of cameras."""
    log_axis(axes, "y", limits)
    axes.set(xlim=CAMERA_LIMITS, xticks=range(2, 11, 2))
    for series, own in curves.items():
        at = pd.Series({n: at_tau(curve, SLICE_S) for n, curve in own.groupby("n")})
        axes.plot(at.index, at, label=series, **SLICE_LOOKS[series].line())
        if series == "x1" and np.isfinite(at.iloc[-1]):
            n = np.linspace(at.index[0], at.index[-1])
            axes.plot(n, at.iloc[-1] * np.sqrt(n[-1] / n), **LAW, zorder=1)
        if series == "x1" and drop is not None and drop in at.index:
            axes.axvspan(drop - 0.35, drop + 0.35, zorder=0, **DROP)


def subsets_of(rows: Rows) -> dict[str, dict[int, str]]:
    """Recordings of Figure 12 by camera type and number of cameras, without the failing camera."""
    return {
        kind: {
            n: name
            for n in sorted({r["n_cameras"] for r in rows.values() if r["camera_type"] == kind})
            if n <= TABLE_4[kind] and (name := standing_for(rows, kind, n)) is not None
        }
        for kind in TYPES
    }


def numbers_figure(rows: Rows, allan: Allan, source: str, remarks: str) -> Picture:
    """S Figure 12: each camera type by number of cameras."""
    columns = {
        kind: {n: allan[name] for n, name in names.items()}
        for kind, names in subsets_of(rows).items()
    }
    return subsets_figure(columns, TITLES[12], source, remarks)


def failing_figure(
    rows: Rows, allan: Allan, source: str, remarks: str, confidence: float
) -> Picture | None:
    """S Figure 8: ten Vantage cameras, one of them failing, against nine; None without both."""
    ten, nine = (standing_for(rows, "Vantage", n) for n in (10, 9))
    if ten is None or nine is None:
        return None
    shown = {
        "10 cameras, one failing": (allan[ten], LOOKS["y"]),
        "9 cameras, without it": (allan[nine], LOOKS["x"]),
    }
    texts = TITLES[8], source, f"{captions.SKUROWSKI[8]} {remarks}"
    return compared_figure(shown, SERIES, texts, confidence)


def types_of(rows: Rows) -> dict[str, str]:
    """Recordings of Figure 13 by camera type."""
    found = {kind: standing_for(rows, kind, n) for kind, n in TABLE_4.items()}
    return {kind: name for kind, name in found.items() if name is not None}


def types_figure(rows: Rows, allan: Allan, source: str, remarks: str, confidence: float) -> Picture:
    """S Figure 13: all sound cameras of each type, and of all types."""
    names = types_of(rows)
    shown = {f"{kind} ({TABLE_4[kind]})": (allan[name], SETS[kind]) for kind, name in names.items()}
    caption = f"{captions.SKUROWSKI[13]} {_remark(rows, names.get('All'))} {remarks}"
    return compared_figure(shown, SERIES, (TITLES[13], source, caption), confidence)


def _remark(rows: Rows, name: str | None) -> str:
    """What must be known of the recording of all cameras, if it is a twin."""
    return "" if name is None or rows[name]["twin"] is None else ALL_NOTE


@styled()
def repaired_figure(
    rows: Rows, others: Rows, allan: Allan, source: str, remarks: str, confidence: float
) -> Picture:
    """S Figure A1: z1 of every camera type after the repair, and left of it of those that the
    sheet compares them with.

    rows: of the repaired recordings; others: of those named in their `compare_with`; allan: of all
    of them.
    """
    looks = {_label(row): SETS.get(row["camera_type"], OTHER_LOOKS[1]) for row in rows.values()}
    after = {name: _label(row) for name, row in rows.items()}
    before = {
        row["compare_with"]: _label(row) for row in rows.values() if row["compare_with"] in others
    }
    panels = {
        title: series_curves(allan, SERIES_A1, labels)
        for title, labels in (("Before the repair", before), ("After the repair", after))
        if labels
    }
    comments = [f"{name}: {row['comment']}." for name, row in rows.items() if row["comment"]]
    comments.append(_remark(rows, standing_for(rows, "All", TABLE_4["All"])))
    caption = f"{captions.SKUROWSKI['A1']} {' '.join(comments)} {remarks}"
    picture = panels_picture(panels, looks, (TITLES["A1"], source, caption), confidence)
    letters(picture.body.axes[: len(panels)])
    return picture


def guess_a1(limits_s: Sequence[float]) -> str:
    """What repaired twins lack: Gauss-Markov terms below these T_c."""
    limits = " or ".join(f"{limit:g} s" for limit in dict.fromkeys(limits_s))
    return (
        "The paper prints no coefficients after the repair. The parts removed from the twins are "
        f"therefore assumed: correlated noise of T_c below {limits}."
    )


def _label(row: Record) -> str:
    return f"{row['camera_type']} ({row['n_cameras']})"
