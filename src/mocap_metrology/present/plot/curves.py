"""Log-log curves of series: a panel a marker and one for the distances, with the slopes beside.

With more than six markers a panel holds one coordinate of all markers instead.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

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
    plain,
    say,
    short,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_MARKERS = 6  # with a panel each
MOST_SINGLE = len(OTHER_LOOKS)  # curves in one panel that can be distinguished
MOST_VECTORS = 60  # lines of a family; more become an image
MOST_REMARK = 22  # characters over a panel that name its lowest and its highest curve
NOTHING = "no valid samples"
Limits = tuple[float, float]

# Noise for the slope in each figure (S Table 1, Figure 3)
ALLAN_SLOPES = (
    (1.0, "+1: drift"),
    (0.5, "+½: random walk"),
    (0.0, "0: flicker"),
    (-0.5, "−½: white"),
    (-1.0, "−1: violet, blue,\nsinusoid"),
)
PSD_SLOPES = (
    (2.0, "+2: violet"),
    (1.0, "+1: blue"),
    (0.0, "0: white"),
    (-1.0, "−1: flicker"),
    (-2.0, "−2: random walk"),
)
ESTIMATOR_DASHES = {"mdev": (0, (1, 1.2)), "hdev": (0, (3, 1.2, 1, 1.2))}


@dataclass(frozen=True)
class Curve:
    """One line: x, y (k,); `band` between two such arrays, or None, its upper edge drawn if
    `outlined`; `extra`: (name, x, y) of the same series by other estimators, drawn thin."""

    name: str
    x: np.ndarray
    y: np.ndarray
    band: tuple[np.ndarray, np.ndarray] | None = None
    outlined: bool = False
    extra: tuple[tuple[str, np.ndarray, np.ndarray], ...] = ()

    @property
    def drawable(self) -> bool:
        return bool(np.any(np.isfinite(self.y) & (self.y > 0)))


@dataclass
class Panel:
    """Curves under one title; a family if there are too many to distinguish. `looks` by name of a
    curve; without them curves are series, which have their own."""

    title: str
    curves: list[Curve] = field(default_factory=list)
    looks: Mapping[str, Look] = field(default_factory=dict)

    @property
    def family(self) -> bool:
        return len(self.curves) > MOST_SINGLE and not self.looks

    def look(self, name: str) -> Look:
        """Of a curve: its own, that of its coordinate, or the next of the others."""
        if name in self.looks:
            return self.looks[name]
        if coordinate_of(name):
            return LOOKS[name[0]]
        others = [c.name for c in self.curves if not coordinate_of(c.name)]
        return OTHER_LOOKS[others.index(name) % len(OTHER_LOOKS)]

    def called(self, name: str) -> str:
        """Name of a curve in the legend: markers share one for each coordinate."""
        return name[0] if not self.looks and coordinate_of(name) else name


def arrange(curves: Sequence[Curve]) -> list[Panel]:
    """A panel a marker (or a coordinate, with many markers), then one of all other series."""
    markers: dict[int, list[Curve]] = {}
    others: list[Curve] = []
    for curve in curves:
        found = coordinate_of(curve.name)
        (markers.setdefault(found[1], []) if found else others).append(curve)
    panels = [Panel(f"Marker {k}", markers[k]) for k in sorted(markers)]
    if len(markers) > MOST_MARKERS:
        each = [curve for panel in panels for curve in panel.curves]
        panels = [Panel(axis, [curve for curve in each if curve.name[0] == axis]) for axis in LOOKS]
    panels.append(Panel("Distance" if len(others) == 1 else "Distances", others))
    return [panel for panel in panels if panel.curves] or [Panel("")]


def curves_picture(
    panels: Sequence[Panel],
    axis_labels: tuple[str, str],
    limits: tuple[Limits, Limits],
    slopes: Sequence[tuple[float, str]],
    texts: tuple[str, str, str],
    band: str = "interval",
) -> Picture:
    """The panels on common axes, their slopes in the cell after the last one, a legend below.

    slopes: (slope, meaning), steepest rise first; texts: title, source line and caption; band:
    what the shaded band is. Call it within `styled`.
    """
    title, source, caption = texts
    columns = 2 if len(panels) in (1, 3) else 3
    rows = -(-(len(panels) + 1) // columns)
    body = new_figure(title, source, 26.0 + rows * (58.0 if columns == 2 else 48.0))
    grid = body.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    log_axes(grid[0, 0], limits)
    for axes, panel in zip(grid.flat, panels, strict=False):
        draw_panel(axes, panel, limits[1], band)
        panel_title(axes, short(panel.title), literal("; ".join(remarks(panel, limits[1]))))
    slope_fan(grid.flat[len(panels)], limits, slopes)
    for axes in grid.flat[len(panels) + 1 :]:
        axes.axis("off")
    label_outer(grid, len(panels), axis_labels)
    legend_below(body, grid.flat[: len(panels)])
    return Picture(body, caption)


def label_outer(grid: np.ndarray, n_panels: int, labels: tuple[str, str]) -> None:
    """Labels of the x axis under the lowest panel of each column, of y at the first column."""
    columns = grid.shape[1]
    for k, axes in enumerate(grid.flat[:n_panels]):
        if k + columns >= n_panels:
            axes.set_xlabel(labels[0])
            axes.tick_params(labelbottom=True)
        if k % columns == 0:
            axes.set_ylabel(labels[1])


def draw_panel(axes: Axes, panel: Panel, y_limits: Limits, band: str = "interval") -> None:
    """All curves of a panel, labelled for the legend; words where there is nothing to draw."""
    if not any(curve.drawable for curve in panel.curves):
        known = any(np.isfinite(curve.y).any() for curve in panel.curves)
        say(axes, "all zero" if known else NOTHING)
    elif panel.family:
        _draw_family(axes, panel.curves)
    else:
        for order, curve in enumerate(panel.curves):
            look, text = panel.look(curve.name), short(panel.called(curve.name))
            _draw_curve(axes, curve, look, order, y_limits, (text, band))


def positive(values: np.ndarray) -> np.ndarray:
    """What a logarithmic axis can show; NaN of the rest."""
    return np.where(np.isfinite(values) & (values > 0), values, np.nan)


def _draw_curve(
    axes: Axes,
    curve: Curve,
    look: Look,
    order: int,
    y_limits: Limits,
    texts: tuple[str, str],
) -> None:
    y = positive(curve.y)
    if curve.band is not None:
        with np.errstate(invalid="ignore"):
            shown = np.isfinite(y) & ~np.isnan(curve.band[0]) & ~np.isnan(curve.band[1])
            low, high = (np.clip(v, y_limits[0] / 10, y_limits[1] * 10) for v in curve.band)
        axes.fill_between(curve.x, low, high, where=shown, color=look.colour, **BAND)
        axes.fill([], [], color=GREY, alpha=0.3, lw=0, label=texts[1])
        if curve.outlined:
            axes.plot(curve.x, np.where(shown, high, np.nan), color=look.colour, lw=0.5)
    for name, x, values in curve.extra:
        how: Keywords = {"ls": ESTIMATOR_DASHES[name], "lw": 0.8, "alpha": 0.7}
        axes.plot(x, positive(values), color=look.colour, **how)
        axes.plot([], [], color=GREY, label=name, **how)
    width = 0.9 if curve.outlined else 1.2
    every = markers_every(curve.x.size, order)
    axes.plot(curve.x, y, label=texts[0], **look.line(lw=width, markevery=every))


def markers_every(size: int, order: int) -> int | tuple[int, int]:
    """`markevery` of about eight markers on a curve, those of different curves side by side."""
    every = max(size // 8, 1)
    return 1 if size <= 15 else (every * order // 3 % every, every)


FAMILY: dict[str, Keywords] = {
    "median": {"color": "#111111", "lw": 1.5, "ls": "-"},
    "lowest": {"color": "#10307a", "lw": 1.1, "ls": (0, (5, 1.6))},
    "highest": {"color": "#cf4a2c", "lw": 1.1, "ls": (0, (6, 1.4, 1.4, 1.4))},
}
ONE: Keywords = {"color": "#9a9a9a", "lw": 0.5, "ls": "-"}


def family_ends(curves: Sequence[Curve]) -> tuple[Curve, Curve] | None:
    """Lowest and highest curve, by the median of log y."""
    drawable = [curve for curve in curves if curve.drawable]
    if not drawable:
        return None
    level = [np.nanmedian(np.log(positive(curve.y))) for curve in drawable]
    return drawable[int(np.argmin(level))], drawable[int(np.argmax(level))]


def _draw_family(axes: Axes, curves: Sequence[Curve]) -> None:
    for k, curve in enumerate(curves):
        text = f"one of {len(curves)}" if k == 0 else None
        rasterized = len(curves) > MOST_VECTORS
        axes.plot(curve.x, positive(curve.y), label=text, rasterized=rasterized, **ONE)
    for name, curve in zip(("lowest", "highest"), family_ends(curves) or (), strict=False):
        axes.plot(curve.x, positive(curve.y), label=name, **FAMILY[name])
    x = np.unique(np.concatenate([curve.x for curve in curves]))
    table = np.full((len(curves), x.size), np.nan)
    for row, curve in zip(table, curves, strict=True):
        row[np.searchsorted(x, curve.x)] = positive(curve.y)
    known = np.isfinite(table).sum(axis=0) * 2 >= len(curves)
    if known.any():
        median = np.nanmedian(table[:, known], axis=0)
        axes.plot(x[known], median, label="median", **FAMILY["median"])


def remarks(panel: Panel, y_limits: Limits) -> list[str]:
    """A note on curves that are invisible or indistinguishable."""
    if not any(curve.drawable for curve in panel.curves):
        return []
    found: list[str] = []
    if panel.family and (ends := family_ends(panel.curves)) is not None:
        low, high = (end.name for end in ends)
        markers = [coordinate_of(end.name) for end in ends]
        if markers[0] and markers[1]:
            found.append(f"lowest: {markers[0][1]}, highest: {markers[1][1]}")
        elif len(text := f"{plain(low)} to {plain(high)}") <= MOST_REMARK:
            found.append(text)
    why: dict[str, list[str]] = {}
    for curve in panel.curves:
        known = curve.y[np.isfinite(curve.y)]
        if not known.size:
            why.setdefault(NOTHING, []).append(curve.name)
        elif not known.max() > 0:
            why.setdefault("zero", []).append(curve.name)
        elif known.max() < y_limits[0]:
            why.setdefault("below the axis", []).append(curve.name)
    for reason, names in why.items():
        which = ", ".join(map(clipped, names)) if len(names) <= 3 else f"{len(names)} series"
        found.append(f"{which}: {reason}")
    return found


def log_limits(
    arrays: Iterable[np.ndarray], least_decades: float = 1.0, most_decades: float = np.inf
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
    across, up = right - left, top - bottom
    steepest = max(abs(slope) for slope, _ in slopes)
    reach = min(0.24 * across, 0.42 * up / steepest)  # decades of x
    x, y = left + 0.05 * across, bottom + 0.5 * up
    spread = np.linspace(0.92, 0.08, len(slopes))  # of the texts, in parts of the height
    for (slope, text), at in zip(slopes, spread, strict=True):
        end = (10 ** (x + reach), 10 ** (y + slope * reach))
        axes.plot([10**x, end[0]], [10**y, end[1]], color=GREY, lw=0.8)
        axes.annotate(
            text,
            end,
            xytext=(0.35, at),
            textcoords="axes fraction",
            va="center",
            fontsize=SMALL_PT,
            arrowprops={"arrowstyle": "-", "color": GREY, "lw": 0.4, "shrinkA": 1, "shrinkB": 1},
        )
