"""Log-log curves on common axes: a panel a marker or a series, with the slopes beside.

Curves are rows of a tidy frame: `curve` (its name), `x`, `y`, `lower` and `upper` (of its band, NaN
where there is none), and optionally `thin`, the name of another estimator of the same curve.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import cycle
from typing import NamedTuple

import numpy as np
import pandas as pd

from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.plot.figure import GREY, Keywords, Look, coordinate_of

MOST_MARKERS = 6  # with a panel each
MOST_SINGLE = len(plot.OTHER_LOOKS)  # curves in one panel that can be distinguished
MOST_VECTORS = 60  # lines of a family; more become an image
NOTHING = "no valid samples"
FARTHEST_BAND = 4.0  # an interval counts for the limits up to so many times the value
ALLAN_DECADES = (1.0, 7.0)  # shown at least and at most: below is rounding
ADEV_AXES = r"Averaging time $\tau$ (s)", "Allan deviation (mm)"
COLUMNS = ("curve", "x", "y", "lower", "upper")  # of curves
Limits = tuple[float, float]
Arrays = Iterable[np.ndarray | pd.Series]
Looks = Mapping[str, Look]

# Noise for the slope in each figure (S Table 1, Figure 3)
ALLAN_SLOPES = (
    (1.0, "+1: drift"),
    (0.5, "+½: random walk"),
    (0.0, "0: flicker"),
    (-0.5, "−½: white"),
    (-1.0, "−1: violet, blue,\nsinusoid"),
)
THIN = {"mdev": (0, (1, 1.2)), "hdev": (0, (3, 1.2, 1, 1.2))}
FAMILY: dict[str, Keywords] = {
    "lowest": {"color": "#10307a", "lw": 1.1, "ls": (0, (5, 1.6))},
    "highest": {"color": "#cf4a2c", "lw": 1.1, "ls": (0, (6, 1.4, 1.4, 1.4))},
    "median": {"color": "#111111", "lw": 1.5, "ls": "-"},
}


def facets(series: Iterable[str], most: int = MOST_MARKERS) -> dict[str, list[str]]:
    """Series by title of their panel: a panel a marker, or with more than `most` markers a panel a
    coordinate; then one of all distances."""
    places = {name: coordinate_of(name) for name in series}
    markers = {place[1] for place in places.values() if place}
    few = len(markers) <= most
    distances = [name for name, place in places.items() if not place]
    panels = dict.fromkeys([f"Marker {k}" for k in sorted(markers)] if few else plot.LOOKS)
    titles = {n: f"Marker {p[1]}" if few else p[0] for n, p in places.items() if p}
    by_title = {title: [n for n, of in titles.items() if of == title] for title in panels}
    by_title["Distance" if len(distances) == 1 else "Distances"] = distances
    return {title: names for title, names in by_title.items() if names}


def groups_of(frame: pd.DataFrame, column: str) -> list[tuple[str, pd.DataFrame]]:
    """Name and rows of each group of a column of names, in order of appearance."""
    return [(str(name), rows) for name, rows in frame.groupby(column, sort=False)]


def looks_of(series: Iterable[str]) -> dict[str, Look]:
    """The look of each series: of its coordinate, or the next of the others."""
    names = list(dict.fromkeys(series))
    others = cycle(plot.OTHER_LOOKS)
    return {name: plot.LOOKS[name[0]] if coordinate_of(name) else next(others) for name in names}


def adev_curves(
    allan: Mapping[str, np.ndarray], names: Mapping[str, str], band: bool = True, unit: str = "mm"
) -> pd.DataFrame:
    """Curves of a table of Allan deviations. names: series -> name of its curve; one without rows
    is a curve of one NaN. The first estimator is drawn with its interval, others are thin."""
    keys = {"tau_s": "x", f"adev_{unit}": "y"}
    keys |= {f"adev_lower_{unit}": "lower", f"adev_upper_{unit}": "upper"}
    frame = pd.DataFrame({key: np.asarray(allan[key]) for key in ("series", "estimator", *keys)})
    frame = frame.astype({"series": str, "estimator": str, **dict.fromkeys(keys, float)})
    frame = frame[frame["series"].isin(list(names))].rename(columns=keys)
    estimators = set(frame["estimator"])
    main = next((e for e in ("oadev", *THIN) if e in estimators), "oadev")
    lacking = pd.DataFrame({"series": [n for n in names if n not in set(frame["series"])]})
    if len(lacking):
        frame = pd.concat([frame, lacking.assign(estimator=main)])
    frame["thin"] = frame["estimator"].replace(main, "")
    if not band:
        frame[["lower", "upper"]] = np.nan
    return frame.assign(curve=frame["series"].map(dict(names))).reset_index(drop=True)


def curves_picture(
    panels: Mapping[str, pd.DataFrame],
    texts: plot.Texts,
    confidence: float | None,
    *,
    looks: Looks | None = None,
    y_label: str = ADEV_AXES[1],
    lettered: bool = False,
) -> plot.Picture:
    """The panels (title -> curves) on common axes, the slopes of noises in the cell after the last
    one, a legend below.

    confidence (0 ... 1): of the shaded intervals, where it is known; looks: by curve, without them
    curves are series, which have their own. Call it within `styled`.
    """
    band = "interval" if confidence is None else f"{100 * confidence:.3g} % interval"
    panels = panels or {"": pd.DataFrame(columns=COLUMNS, dtype=float)}
    limits = curve_limits(pd.concat(panels.values()))
    n_columns = 2 if len(panels) in (1, 3) else 3
    n_rows = -(-(len(panels) + 1) // n_columns)
    body = plot.new_figure(texts, 26.0 + n_rows * (58.0 if n_columns == 2 else 48.0))
    grid = body.subplots(n_rows, n_columns, sharex=True, sharey=True, squeeze=False)
    plot.log_axes(grid[0, 0], limits)
    for axes, (title, curves) in zip(grid.flat, panels.items(), strict=False):
        draw_curves(axes, curves, limits[1], looks, band)
        remark = plot.literal(invisible(curves, limits[1][0]))
        plot.panel_title(axes, plot.short(title), remark)
    slope_fan(grid.flat[len(panels)], limits)
    for axes in grid.flat[len(panels) + 1 :]:
        axes.axis("off")
    label_outer(grid, len(panels), (ADEV_AXES[0], y_label))
    if lettered:
        plot.letters(grid.flat[: len(panels)])
    return plot.finished(body, grid.flat[: len(panels)], texts.caption)


def curve_limits(curves: pd.DataFrame) -> tuple[Limits, Limits]:
    """Limits of x and of y round all curves and their bands."""
    y = curves["y"]
    bands = [curves[end].clip(y / FARTHEST_BAND, y * FARTHEST_BAND) for end in ("lower", "upper")]
    return log_limits([curves["x"]]), log_limits([y, *bands], *ALLAN_DECADES)


def label_outer(grid: np.ndarray, n_panels: int, labels: tuple[str, str]) -> None:
    """Labels of the x axis under the lowest panel of each column, of y at the first column."""
    columns = grid.shape[1]
    for k, axes in enumerate(grid.flat[:n_panels]):
        if k + columns >= n_panels:
            axes.set_xlabel(labels[0])
            axes.tick_params(labelbottom=True)
        if k % columns == 0:
            axes.set_ylabel(labels[1])


def positive(values: Iterable[float] | pd.DataFrame) -> np.ndarray:
    """What a logarithmic axis can show; NaN of the rest."""
    values = np.asarray(values, dtype=np.float64)
    return np.where(np.isfinite(values) & (values > 0), values, np.nan)


def draw_curves(
    axes: plot.Axes,
    curves: pd.DataFrame,
    y_limits: Limits,
    looks: Looks | None,
    band: str = "interval",
) -> None:
    """All curves of a panel, labelled for the legend; a family if they are too many to distinguish;
    words where there is nothing to draw."""
    if not (curves["y"] > 0).any():
        plot.write_message(axes, "all zero" if curves["y"].notna().any() else NOTHING)
        return
    if looks is None and curves["curve"].nunique() > MOST_SINGLE:
        _draw_family(axes, curves)
        return
    looks_here = looks_of(curves["curve"]) if looks is None else looks
    curves = curves if "thin" in curves else curves.assign(thin="")
    for order, (name, rows) in enumerate(groups_of(curves, "curve")):
        look = looks_here[name]
        main, others = rows[rows["thin"] == ""], rows[rows["thin"] != ""]
        ends = main[["lower", "upper"]].clip(y_limits[0] / 10, y_limits[1] * 10)
        if ends.notna().all(axis=1).any():
            how: Keywords = {"where": main["y"] > 0, "color": look.colour, **plot.BAND}
            axes.fill_between(main["x"], ends["lower"], ends["upper"], **how)
            axes.fill([], [], color=GREY, alpha=0.3, lw=0, label=band)
        for other, part in groups_of(others, "thin"):
            how = {"ls": THIN[other], "lw": 0.8, "alpha": 0.7}
            axes.plot(part["x"], positive(part["y"]), color=look.colour, **how)
            axes.plot([], [], color=GREY, label=other, **how)
        label = name[0] if looks is None and coordinate_of(name) else plot.short(name)
        how = look.line(label=label, markevery=markers_every(len(main), order))
        axes.plot(main["x"], positive(main["y"]), **how)


def markers_every(size: int, order: int) -> int | tuple[int, int]:
    """`markevery` of about eight markers on a curve, those of different curves side by side."""
    every = max(size // 8, 1)
    return 1 if size <= 15 else (every * order // 3 % every, every)


def family_ends(curves: pd.DataFrame) -> tuple[str, str]:
    """Lowest and highest curve that can be drawn, by the median of log y."""
    drawable = curves[np.isfinite(curves["y"]) & (curves["y"] > 0)]
    level = np.log(drawable["y"]).groupby(drawable["curve"]).median()
    return level.idxmin(), level.idxmax()


def _draw_family(axes: plot.Axes, curves: pd.DataFrame) -> None:
    """All in grey, the lowest, the highest, and the median where half of them have a value."""
    curves = curves.assign(y=positive(curves["y"]))
    named = dict(groups_of(curves, "curve"))
    how: Keywords = {"color": "#9a9a9a", "lw": 0.5, "rasterized": len(named) > MOST_VECTORS}
    for k, rows in enumerate(named.values()):
        axes.plot(rows["x"], rows["y"], label=None if k else f"one of {len(named)}", **how)
    for text, name in zip(FAMILY, family_ends(curves), strict=False):
        axes.plot(named[name]["x"], named[name]["y"], label=text, **FAMILY[text])
    at = curves.groupby("x")["y"].agg(["median", "count"])
    median = at["median"][at["count"] * 2 >= len(named)]
    axes.plot(median.index, median, label="median", **FAMILY["median"])


def invisible(curves: pd.DataFrame, bottom: float) -> str:
    """A note on curves of a panel that cannot be seen, and why."""
    greatest = curves.groupby("curve", sort=False)["y"].max()
    if not (greatest > 0).any():
        return ""
    cases = {NOTHING: greatest.isna(), "zero": greatest <= 0}
    cases["below the axis"] = (greatest > 0) & (greatest < bottom)
    notes = []
    for reason, applies in cases.items():
        names = greatest.index[applies]
        which = ", ".join(map(plot.clipped, names)) if len(names) <= 3 else f"{len(names)} series"
        notes += [f"{which}: {reason}"] * bool(len(names))
    return "; ".join(notes)


def log_limits(arrays: Arrays, least_decades: float = 1.0, most_decades: float = np.inf) -> Limits:
    """Limits around all positive finite values, `least_decades` apart; (0.1, 10) without any.

    `most_decades` caps how far down they go, for rounding errors of a constant series are positive
    too.
    """
    values = np.concatenate([np.zeros(0), *(positive(a).ravel() for a in arrays)])
    if np.isnan(values).all():
        return 0.1, 10.0
    high = np.log10(np.nanmax(values))
    low = max(np.log10(np.nanmin(values)), high - most_decades)
    pad = 0.1 + max(least_decades - (high - low) - 0.2, 0.0) / 2
    return float(10 ** (low - pad)), float(10 ** (high + pad))


def slope_fan(axes: plot.Axes, limits: tuple[Limits, Limits]) -> None:
    """Lines of `ALLAN_SLOPES` from one point, in axes that share the limits of the panels."""
    axes.axis("off")
    axes.set_title("Slopes", fontweight="normal", color=GREY)
    (left, right), (bottom, top) = np.log10(limits)
    steepest = max(abs(slope) for slope, _ in ALLAN_SLOPES)
    reach = min(0.24 * (right - left), 0.42 * (top - bottom) / steepest)  # decades of x
    x, y = left + 0.05 * (right - left), (bottom + top) / 2
    arrow = {"arrowstyle": "-", "color": GREY, "lw": 0.4, "shrinkA": 1, "shrinkB": 1}
    how: Keywords = {"textcoords": "axes fraction", "va": "center", "fontsize": plot.SMALL_PT}
    places = np.linspace(0.92, 0.08, len(ALLAN_SLOPES))
    for (slope, text), at in zip(ALLAN_SLOPES, places, strict=True):
        end = (10 ** (x + reach), 10 ** (y + slope * reach))
        axes.plot([10**x, end[0]], [10**y, end[1]], color=GREY, lw=0.8)
        axes.annotate(text, end, xytext=(0.35, at), arrowprops=arrow, **how)


class Bins(NamedTuple):
    """Values over logarithmic bins: centre, median and greatest, each (k,); empty bins left out."""

    centre: np.ndarray
    median: np.ndarray
    high: np.ndarray


def log_bins(x: np.ndarray, y: np.ndarray, per_decade: int) -> Bins:
    """Median and maximum of `y` (n,) over bins of equal width in log x of `x` (n,), ascending,
    without x <= 0 and y not finite. A narrow line remains in `high`; bins of one point are that
    point. The centre is the geometric mean."""
    keep = (x > 0) & np.isfinite(y)
    frame = pd.DataFrame({"x": x[keep], "y": y[keep]}, dtype=np.float64)
    frame["log"] = np.log10(frame["x"])
    bins = frame.groupby(np.floor(frame["log"] * per_decade + 1e-9))
    centre = np.where(bins.size() == 1, bins["x"].first(), 10 ** bins["log"].mean())
    return Bins(centre, bins["y"].median().to_numpy(), bins["y"].max().to_numpy())
