"""Log-log curves on common axes: a panel a marker or a series, with the slopes beside.

Curves are rows of a tidy frame: `curve` (its name), `x`, `y`, `lower` and `upper` (of its band, NaN
where there is none), and optionally `thin`, the name of another estimator of the same curve.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from mocap_metrology.present.plot.figure import (
    BAND,
    GREY,
    LOOKS,
    OTHER_LOOKS,
    SMALL_PT,
    Keywords,
    Look,
    Picture,
    clipped,
    coordinate_of,
    legend_below,
    literal,
    log_axes,
    new_figure,
    panel_title,
    say,
    short,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_MARKERS = 6  # with a panel each
MOST_SINGLE = len(OTHER_LOOKS)  # curves in one panel that can be distinguished
MOST_VECTORS = 60  # lines of a family; more become an image
NOTHING = "no valid samples"
FARTHEST_BAND = 4.0  # an interval counts for the limits up to so many times the value
ALLAN_DECADES = (1.0, 7.0)  # shown at least and at most: below is rounding
ADEV_AXES = r"Averaging time $\tau$ (s)", "Allan deviation (mm)"
Limits = tuple[float, float]
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
    names = list(dict.fromkeys(series))
    places = {name: coordinate_of(name) for name in names}
    markers = sorted({place[1] for place in places.values() if place})
    panels: dict[str, list[str]] = (
        {f"Marker {k}": [] for k in markers}
        if len(markers) <= most
        else {axis: [] for axis in LOOKS}
    )
    distances = [name for name, place in places.items() if not place]
    for name, place in places.items():
        if place:
            panels[f"Marker {place[1]}" if len(markers) <= most else place[0]].append(name)
    panels["Distance" if len(distances) == 1 else "Distances"] = distances
    return {title: own for title, own in panels.items() if own}


def groups_of(frame: pd.DataFrame, column: str) -> list[tuple[str, pd.DataFrame]]:
    """Name and rows of each group of a column of names, in order of appearance."""
    return [(str(name), rows) for name, rows in frame.groupby(column, sort=False)]


def looks_of(series: Iterable[str]) -> dict[str, Look]:
    """The look of each series: of its coordinate, or the next of the others."""
    names = list(dict.fromkeys(series))
    others = [name for name in names if not coordinate_of(name)]
    looks = {name: OTHER_LOOKS[k % len(OTHER_LOOKS)] for k, name in enumerate(others)}
    return {name: looks.get(name) or LOOKS[name[0]] for name in names}


def adev_curves(
    allan: Mapping[str, np.ndarray], names: Mapping[str, str], band: bool = True, unit: str = "mm"
) -> pd.DataFrame:
    """Curves of a table of Allan deviations. names: series -> name of its curve; one without rows
    is a curve of one NaN. The first estimator is drawn with its interval, others are thin."""
    keys = {"tau_s": "x", f"adev_{unit}": "y"}
    keys |= {f"adev_lower_{unit}": "lower", f"adev_upper_{unit}": "upper"}
    pick = np.isin(np.asarray(allan["series"]).astype(str), list(names))
    frame = pd.DataFrame({key: np.asarray(allan[key])[pick] for key in ("series", *keys)})
    estimator = np.asarray(allan["estimator"]).astype(str)[pick]
    main = next((e for e in ("oadev", *THIN) if (estimator == e).any()), "oadev")
    frame["thin"] = np.where(estimator == main, "", estimator)
    lacking = [name for name in names if name not in set(frame["series"])]
    frame = pd.concat([frame, pd.DataFrame({"series": lacking, "thin": ""})]) if lacking else frame
    frame = frame.rename(columns=keys).astype(dict.fromkeys(keys.values(), float))
    if not band:
        frame[["lower", "upper"]] = np.nan
    return frame.assign(curve=frame["series"].map(dict(names))).reset_index(drop=True)


def curves_picture(
    panels: Mapping[str, pd.DataFrame],
    axis_labels: tuple[str, str],
    slopes: Sequence[tuple[float, str]],
    texts: tuple[str, str, str],
    band: str = "interval",
    *,
    looks: Looks | None = None,
    limits: tuple[Limits, Limits] | None = None,
) -> Picture:
    """The panels (title -> curves) on common axes, their slopes in the cell after the last one, a
    legend below.

    slopes: (slope, meaning), steepest rise first; texts: title, source line and caption; band: what
    the shaded band is; looks: by curve, without them curves are series, which have their own. Call
    it within `styled`.
    """
    panels = panels or {
        "": pd.DataFrame(columns=["curve", "x", "y", "lower", "upper"], dtype=float)
    }
    limits = limits or curve_limits(pd.concat(panels.values()))
    columns = 2 if len(panels) in (1, 3) else 3
    rows = -(-(len(panels) + 1) // columns)
    body = new_figure(texts[0], texts[1], 26.0 + rows * (58.0 if columns == 2 else 48.0))
    grid = body.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    log_axes(grid[0, 0], limits)
    for axes, (title, curves) in zip(grid.flat, panels.items(), strict=False):
        draw_curves(axes, curves, limits[1], looks, band)
        panel_title(axes, short(title), literal(invisible(curves, limits[1][0])))
    slope_fan(grid.flat[len(panels)], limits, slopes)
    for axes in grid.flat[len(panels) + 1 :]:
        axes.axis("off")
    label_outer(grid, len(panels), axis_labels)
    legend_below(body, grid.flat[: len(panels)])
    return Picture(body, texts[2])


def curve_limits(
    curves: pd.DataFrame,
    decades: tuple[float, float] = ALLAN_DECADES,
    farthest_band: float = FARTHEST_BAND,
) -> tuple[Limits, Limits]:
    """Limits of x and of y round all curves and their bands."""
    y = curves["y"]
    bands = [curves[end].clip(y / farthest_band, y * farthest_band) for end in ("lower", "upper")]
    return log_limits([curves["x"]]), log_limits([y, *bands], *decades)


def label_outer(grid: np.ndarray, n_panels: int, labels: tuple[str, str]) -> None:
    """Labels of the x axis under the lowest panel of each column, of y at the first column."""
    columns = grid.shape[1]
    for k, axes in enumerate(grid.flat[:n_panels]):
        if k + columns >= n_panels:
            axes.set_xlabel(labels[0])
            axes.tick_params(labelbottom=True)
        if k % columns == 0:
            axes.set_ylabel(labels[1])


def positive(values: Iterable[float]) -> np.ndarray:
    """What a logarithmic axis can show; NaN of the rest."""
    values = np.asarray(values, dtype=np.float64)
    return np.where(np.isfinite(values) & (values > 0), values, np.nan)


def draw_curves(
    axes: Axes,
    curves: pd.DataFrame,
    y_limits: Limits,
    looks: Looks | None = None,
    band: str = "interval",
) -> None:
    """All curves of a panel, labelled for the legend; a family if they are too many to distinguish;
    words where there is nothing to draw."""
    if not (curves["y"] > 0).any():
        say(axes, "all zero" if curves["y"].notna().any() else NOTHING)
        return
    if looks is None and curves["curve"].nunique() > MOST_SINGLE:
        _draw_family(axes, curves)
        return
    own = looks_of(curves["curve"]) if looks is None else looks
    curves = curves if "thin" in curves else curves.assign(thin="")
    for order, (name, rows) in enumerate(groups_of(curves, "curve")):
        look = own[name]
        main, others = rows[rows["thin"] == ""], rows[rows["thin"] != ""]
        if main[["lower", "upper"]].notna().all(axis=1).any():
            low, high = (
                main[["lower", "upper"]].clip(y_limits[0] / 10, y_limits[1] * 10).to_numpy().T
            )
            axes.fill_between(main["x"], low, high, where=main["y"] > 0, color=look.colour, **BAND)
            axes.fill([], [], color=GREY, alpha=0.3, lw=0, label=band)
        for other, part in groups_of(others, "thin"):
            how: Keywords = {"ls": THIN[other], "lw": 0.8, "alpha": 0.7}
            axes.plot(part["x"], positive(part["y"]), color=look.colour, **how)
            axes.plot([], [], color=GREY, label=other, **how)
        text = name[0] if looks is None and coordinate_of(name) else short(name)
        every = {"markevery": markers_every(len(main), order)}
        axes.plot(main["x"], positive(main["y"]), label=text, **look.line(**every))


def markers_every(size: int, order: int) -> int | tuple[int, int]:
    """`markevery` of about eight markers on a curve, those of different curves side by side."""
    every = max(size // 8, 1)
    return 1 if size <= 15 else (every * order // 3 % every, every)


def family_ends(curves: pd.DataFrame) -> tuple[str, str]:
    """Lowest and highest curve that can be drawn, by the median of log y."""
    drawable = curves[np.isfinite(curves["y"]) & (curves["y"] > 0)]
    level = np.log(drawable["y"]).groupby(drawable["curve"]).median()
    return level.idxmin(), level.idxmax()


def _draw_family(axes: Axes, curves: pd.DataFrame) -> None:
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
    why = np.select(
        [greatest.isna(), greatest <= 0, greatest < bottom], [NOTHING, "zero", "below the axis"], ""
    )
    notes = []
    for reason in dict.fromkeys(why[why != ""]):
        names = greatest.index[why == reason]
        which = ", ".join(map(clipped, names)) if len(names) <= 3 else f"{len(names)} series"
        notes.append(f"{which}: {reason}")
    return "; ".join(notes)


def log_limits(
    arrays: Iterable[np.ndarray | pd.Series],
    least_decades: float = 1.0,
    most_decades: float = np.inf,
) -> Limits:
    """Limits around all positive finite values, `least_decades` apart; (0.1, 10) without any.

    `most_decades` caps how far down they go, for rounding errors of a constant series are positive
    too.
    """
    values = np.concatenate([np.zeros(0), *(np.asarray(a, float).ravel() for a in arrays)])
    values = values[np.isfinite(values) & (values > 0)]
    if not values.size:
        return 0.1, 10.0
    low, high = np.log10(values.min()), np.log10(values.max())
    low = max(low, high - most_decades) - 0.1
    high += 0.1
    missing = max(least_decades - (high - low), 0.0)
    return float(10 ** (low - missing / 2)), float(10 ** (high + missing / 2))


def slope_fan(
    axes: Axes, limits: tuple[Limits, Limits], slopes: Sequence[tuple[float, str]]
) -> None:
    """Lines of the given slopes from one point, in axes that share the limits of the panels."""
    axes.axis("off")
    axes.set_title("Slopes", fontweight="normal", color=GREY)
    (left, right), (bottom, top) = np.log10(limits)
    steepest = max(abs(slope) for slope, _ in slopes)
    reach = min(0.24 * (right - left), 0.42 * (top - bottom) / steepest)  # decades of x
    x, y = left + 0.05 * (right - left), (bottom + top) / 2
    arrow = {"arrowstyle": "-", "color": GREY, "lw": 0.4, "shrinkA": 1, "shrinkB": 1}
    how: Keywords = {"textcoords": "axes fraction", "va": "center", "fontsize": SMALL_PT}
    for (slope, text), at in zip(slopes, np.linspace(0.92, 0.08, len(slopes)), strict=True):
        end = (10 ** (x + reach), 10 ** (y + slope * reach))
        axes.plot([10**x, end[0]], [10**y, end[1]], color=GREY, lw=0.8)
        axes.annotate(text, end, xytext=(0.35, at), arrowprops=arrow, **how)
