"""What changed, in figures: ratios of Allan deviations, and Allan deviations over dates."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.allan.confidence import interval
from mocap_metrology.noise.changes.compare import DAYS_A_MONTH, Curve, Ratio, adev_ratio
from mocap_metrology.present.changes.compare import Columns, curve_of, series_of
from mocap_metrology.present.plot.curves import Limits, log_limits
from mocap_metrology.present.plot.figure import (
    BAND,
    GREY,
    INK,
    LOOKS,
    OTHER_LOOKS,
    SMALL_PT,
    Keywords,
    Look,
    Picture,
    coordinate_of,
    legend_below,
    log_axis,
    new_figure,
    panel_title,
    ratio_axis,
    short,
    styled,
)
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text import captions

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

MOST = 6  # comparisons on a page; more are in the table
CLEAR = ("worse", "better")  # words of a trend that is drawn
TIMES_S = (1.0, 100.0)  # averaging times of a trend beside a single frame; all are in the table
ROW_MM, REST_MM = 44.0, 28.0
N_TAUS = 60
MARGIN = "#efd98f"
CONFIDENCE = 0.683  # of the intervals of a trend


@dataclass(frozen=True)
class Comparison:
    """A recording beside its reference: names, columns of `allan_masked.parquet`."""

    recording: str
    reference: str
    new: Columns
    old: Columns


@styled()
def compare_figure(
    comparisons: Sequence[Comparison],
    margin: float,
    confidence: float,
    title: str,
    source: str,
    remarks: str = "",
) -> Picture:
    """Ratios over averaging time, a row a comparison (the last `MOST` of them), a column a marker
    or the distances. Above 1 the recording is noisier; the band is the margin within which a change
    counts as none. source: the line at the foot; remarks: what the caption adds."""
    shown = comparisons[-MOST:]
    if len(shown) < len(comparisons):
        remarks += f" The last {MOST} of {len(comparisons)} comparisons; all are in the table."
    found = [_ratios(comparison, confidence) for comparison in shown]
    panels = panels_of(list(dict.fromkeys(series for ratios in found for series in ratios)))
    looks = looks_of(panels)
    every = [ratio for ratios in found for ratio in ratios.values()]
    limits = _ratio_limits(every, margin)
    body, grid = _grid(title, source, len(shown), panels)
    for row, comparison, ratios in zip(grid, shown, found, strict=True):
        panel_title(row[0], f"{short(comparison.recording)} / {short(comparison.reference)}")
        row[0].set_ylabel("Ratio of\nAllan deviations")
        for axes, series in zip(row, panels.values(), strict=True):
            ratio_axis(axes, limits)
            axes.axhline(1, color=INK, lw=0.6, zorder=1)
            for name in (name for name in series if name in ratios):
                _draw_ratio(axes, ratios[name], looks[name], name)
            axes.axhspan(1 / (1 + margin), 1 + margin, color=MARGIN, lw=0, zorder=0)
    log_axis(grid[0, 0], "x", log_limits([ratio.tau_s for ratio in every]))
    last = grid[-1, -1]
    last.fill([], [], color=GREY, label=f"{100 * confidence:.3g} % interval", **BAND)
    last.fill([], [], color=MARGIN, lw=0, label=f"no change: within {100 * margin:.3g} %")
    for axes in grid[-1]:
        axes.set_xlabel(r"Averaging time $\tau$ (s)")
    legend_below(body, grid.flat)
    return Picture(body, f"{captions.COMPARE} {remarks}")


def _grid(
    title: str, source: str, n_rows: int, panels: Mapping[str, Sequence[str]]
) -> tuple[SubFigure, np.ndarray]:
    """The body of a figure and its axes: `n_rows` rows of these panels, which are named inside."""
    body = new_figure(title, source, REST_MM + n_rows * ROW_MM)
    grid = body.subplots(n_rows, len(panels), sharex=True, sharey="row", squeeze=False)
    how: Keywords = {"va": "top", "size": SMALL_PT, "color": GREY}
    how["bbox"] = {"facecolor": "white", "alpha": 0.7, "lw": 0, "pad": 1}
    for row in grid:
        for axes, name in zip(row, panels, strict=True):
            axes.text(0.02, 0.96, name, transform=axes.transAxes, **how)
    return body, grid


def _ratios(comparison: Comparison, confidence: float) -> dict[str, Ratio]:
    found = {}
    both = [s for s in series_of(comparison.new) if s in series_of(comparison.old)]
    for series in both:
        new, old = (curve_of(c, series).usable() for c in (comparison.new, comparison.old))
        if not (new.tau_s.size and old.tau_s.size):
            continue
        low = max(new.tau_s[0], old.tau_s[0])
        high = min(new.tau_s[-1], old.tau_s[-1])
        if high > low:
            found[series] = adev_ratio(new, old, np.geomspace(low, high, N_TAUS), confidence)
    return found


def panels_of(series: Sequence[str]) -> dict[str, list[str]]:
    """Names and series of the panels of a row: two markers and the distances, or all markers."""
    markers: dict[str, list[str]] = {}
    for name in series:
        place = coordinate_of(name)
        markers.setdefault(f"Marker {place[1]}" if place else "Distances", []).append(name)
    if len(markers) <= 3:
        return markers or {"": []}
    distances = markers.pop("Distances", [])
    return {"Markers": [s for own in markers.values() for s in own], "Distances": distances}


def looks_of(panels: Mapping[str, Sequence[str]]) -> dict[str, Look]:
    """The look of each series: of its coordinate, or the next of the others."""
    names = [name for own in panels.values() for name in own]
    others = [name for name in names if not coordinate_of(name)]
    looks = {name: OTHER_LOOKS[k % len(OTHER_LOOKS)] for k, name in enumerate(others)}
    return {name: looks.get(name) or LOOKS[name[0]] for name in names}


def _called(name: str) -> str:
    return name[0] if coordinate_of(name) else short(name)


def _ratio_limits(ratios: Sequence[Ratio], margin: float) -> Limits:
    """About the ratios themselves, 1 and its margin; wide intervals at long tau may leave."""
    values = np.concatenate([ratio.value for ratio in ratios] or [np.ones(1)])
    values = np.log(values[np.isfinite(values)])
    reach = max(np.abs(values).max(initial=0.0) * 1.25, 3 * np.log1p(margin))
    low = min(values.min(initial=0.0) * 1.25, -0.3 * reach)
    high = max(values.max(initial=0.0) * 1.25, 0.3 * reach)
    return float(np.exp(low)), float(np.exp(high))


def _draw_ratio(axes: Axes, ratio: Ratio, look: Look, name: str) -> None:
    bottom, top = axes.get_ylim()
    low, high = (np.clip(v, bottom / 2, top * 2) for v in (ratio.lower, ratio.upper))
    axes.fill_between(ratio.tau_s, low, high, color=look.colour, **BAND)
    how = look.line(marker="", lw=1.1, label=_called(name))
    axes.plot(ratio.tau_s, ratio.value, **how)


@styled()
def trend_figure(
    names: Sequence[str],
    dates: Sequence[str],
    allan: Mapping[str, Columns],
    rows: Sequence[Row],
    title: str,
    source: str,
    remarks: str = "",
) -> Picture:
    """Allan deviations over dates, a row an averaging time (a frame, and those nearest to 1 and
    100 s that all recordings have): points with 68 % intervals, and the fitted line where there is
    a trend.

    names in order of `dates` (ISO); rows: of `compare.trend_rows`.
    """
    from matplotlib.dates import AutoDateLocator, ConciseDateFormatter, date2num

    taus = _shown(sorted({float(row["tau_s"]) for row in rows}))
    panels = panels_of(list(dict.fromkeys(row["series"] for row in rows)))
    looks = looks_of(panels)
    curves = {s: [curve_of(allan[name], s).usable().at(taus) for name in names] for s in looks}
    days = np.array([date2num(datetime.fromisoformat(date)) for date in dates])
    body, grid = _grid(title, source, len(taus), panels)
    grid[0, 0].margins(x=0.06)
    locator = AutoDateLocator(minticks=2, maxticks=5)
    grid[0, 0].xaxis.set_major_locator(locator)
    grid[0, 0].xaxis.set_major_formatter(ConciseDateFormatter(locator))
    for k, (tau, panel_axes) in enumerate(zip(taus, grid, strict=True)):
        at_tau = {s: _at(own, k) for s, own in curves.items()}
        trends = {
            row["series"]: row["percent_per_month"]
            for row in rows
            if row["tau_s"] == tau and row["word"] in CLEAR
        }
        every = [values for adev, band in at_tau.values() for values in (adev, band)]
        log_axis(panel_axes[0], "y", log_limits(every, 0.3))
        for axes, series in zip(panel_axes, panels.values(), strict=True):
            shift = 0.012 * max(np.ptp(days), 1e-9)
            for order, one in enumerate(series):
                at = days + (order - (len(series) - 1) / 2) * shift
                _draw_dated(axes, at, at_tau[one], looks[one], one)
                if one in trends:
                    _draw_trend(axes, at, at_tau[one][0], looks[one], trends[one])
        name = f"One frame ({1000 * tau:.3g} ms)" if k == 0 else f"Averaged over {tau:.3g} s"
        panel_title(panel_axes[0], name)
        panel_axes[0].set_ylabel("Allan deviation (µm)")
    for axes in grid[-1]:
        axes.set_xlabel("Date (series side by side)")
    last = grid[-1, -1]
    last.plot([], [], color=GREY, ls="", marker="|", markersize=9, label="68 % interval")
    if any(row["tau_s"] in taus and row["word"] in CLEAR for row in rows):
        last.plot([], [], color=GREY, label="trend, where clear")
    legend_below(body, grid.flat)
    return Picture(body, f"{captions.TREND} {remarks}")


def _shown(taus: Sequence[float]) -> np.ndarray:
    """The first, and those nearest to `TIMES_S`."""
    chosen = [taus[0], *(min(taus, key=lambda t: abs(np.log(t / near))) for near in TIMES_S)]
    return np.array(list(dict.fromkeys(chosen)))


def _at(curves: Sequence[Curve], k: int) -> tuple[np.ndarray, np.ndarray]:
    """Deviations of the recordings at the k-th tau (n,), and their intervals (2, n), in µm."""
    adev, edf = (np.array([getattr(c, name)[k] for c in curves]) for name in ("adev", "edf"))
    low, high = np.full((2, adev.size), np.nan)
    known = np.isfinite(adev)
    low[known], high[known] = interval(adev[known] ** 2, edf[known], CONFIDENCE)
    return 1000 * adev, 1000 * np.stack([low, high])


def _draw_dated(
    axes: Axes, days: np.ndarray, values: tuple[np.ndarray, np.ndarray], look: Look, name: str
) -> None:
    adev, band = values
    how = look.line(ls="", elinewidth=0.8, label=_called(name))
    axes.errorbar(days, adev, yerr=np.abs(band - adev), **how)


def _draw_trend(
    axes: Axes, days: np.ndarray, adev: np.ndarray, look: Look, percent_per_month: float
) -> None:
    slope = np.log1p(percent_per_month / 100) / DAYS_A_MONTH
    known = np.isfinite(adev)
    level = np.mean(np.log(adev[known]) - slope * days[known])
    axes.plot(days, np.exp(level + slope * days), **look.line(marker="", lw=1.0))
