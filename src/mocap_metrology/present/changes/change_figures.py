"""What changed, in figures: ratios of Allan deviations, and Allan deviations over dates."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from mocap_metrology.noise.allan.confidence import interval
from mocap_metrology.noise.changes.compare import DAYS_A_MONTH, adev_ratio
from mocap_metrology.present.changes.compare import Columns, curve_of, series_of
from mocap_metrology.present.plot.curves import ADEV_AXES, facets, groups_of, log_limits, looks_of
from mocap_metrology.present.plot.figure import (
    BAND,
    GREY,
    INK,
    SMALL_PT,
    Keywords,
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
    from matplotlib.figure import SubFigure

MOST = 6  # comparisons on a page; more are in the table
MOST_MARKERS = 2  # with a column each
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
    from matplotlib.ticker import LogLocator

    shown = comparisons[-MOST:]
    if len(shown) < len(comparisons):
        remarks += f" The last {MOST} of {len(comparisons)} comparisons; all are in the table."
    ratios = [_ratios(comparison, confidence) for comparison in shown]
    every = pd.concat(ratios)
    looks, limits = looks_of(every["series"]), _ratio_limits(every["value"], margin)
    body, grid, panels = _grid(title, source, len(shown), every["series"])
    for row, comparison, of_it in zip(grid, shown, ratios, strict=True):
        panel_title(row[0], f"{short(comparison.recording)} / {short(comparison.reference)}")
        row[0].set_ylabel("Ratio of\nAllan deviations")
        for axes, names in zip(row, panels.values(), strict=True):
            ratio_axis(axes, limits)
            axes.axhline(1, color=INK, lw=0.6, zorder=1)
            axes.axhspan(1 / (1 + margin), 1 + margin, color=MARGIN, lw=0, zorder=0)
            for name, own in groups_of(of_it[of_it["series"].isin(names)], "series"):
                ends = (own[end].clip(limits[0] / 2, limits[1] * 2) for end in ("lower", "upper"))
                axes.fill_between(own["tau_s"], *ends, color=looks[name].colour, **BAND)
                how = looks[name].line(marker="", lw=1.1, label=_called(name))
                axes.plot(own["tau_s"], own["value"], **how)
    log_axis(grid[0, 0], "x", log_limits([every["tau_s"]]))
    grid[0, 0].xaxis.set_major_locator(LogLocator(numticks=4))  # panels are narrow
    last = grid[-1, -1]
    last.fill([], [], color=GREY, label=f"{100 * confidence:.3g} % interval", **BAND)
    last.fill([], [], color=MARGIN, lw=0, label=f"no change: within {100 * margin:.3g} %")
    for axes in grid[-1]:
        axes.set_xlabel(ADEV_AXES[0])
    legend_below(body, grid.flat)
    return Picture(body, f"{captions.COMPARE} {remarks}")


def _grid(
    title: str, source: str, n_rows: int, series: Iterable[str]
) -> tuple[SubFigure, np.ndarray, dict[str, list[str]]]:
    """The body of a figure, its axes (`n_rows` rows of panels, named inside), series by panel."""
    panels = facets(series, MOST_MARKERS) or {"": []}
    body = new_figure(title, source, REST_MM + n_rows * ROW_MM)
    grid = body.subplots(n_rows, len(panels), sharex=True, sharey="row", squeeze=False)
    how: Keywords = {"va": "top", "size": SMALL_PT, "color": GREY}
    how["bbox"] = {"facecolor": "white", "alpha": 0.7, "lw": 0, "pad": 1}
    for row in grid:
        for axes, name in zip(row, panels, strict=True):
            axes.text(0.02, 0.96, name, transform=axes.transAxes, **how)
    return body, grid, panels


def _called(name: str) -> str:
    return name[0] if coordinate_of(name) else short(name)


def _ratios(comparison: Comparison, confidence: float) -> pd.DataFrame:
    """`series`, `tau_s`, `value`, `lower`, `upper` of each series that both have."""
    parts = [pd.DataFrame(columns=["series", "tau_s", "value", "lower", "upper"], dtype=float)]
    for series in (s for s in series_of(comparison.new) if s in series_of(comparison.old)):
        new, old = (curve_of(c, series).usable() for c in (comparison.new, comparison.old))
        ends = [(c.tau_s[0], c.tau_s[-1]) for c in (new, old) if c.tau_s.size]
        low, high = max((e[0] for e in ends), default=0), min((e[1] for e in ends), default=0)
        if len(ends) == 2 and high > low:
            ratio = adev_ratio(new, old, np.geomspace(low, high, N_TAUS), confidence)
            keys = ("tau_s", "value", "lower", "upper")
            parts.append(pd.DataFrame({k: getattr(ratio, k) for k in keys}).assign(series=series))
    return pd.concat(parts[1:] or parts)


def _ratio_limits(values: pd.Series, margin: float) -> tuple[float, float]:
    """About the ratios themselves, 1 and its margin; wide intervals at long tau may leave."""
    logs = 1.25 * np.log([v for v in values if v > 0 and np.isfinite(v)])
    reach = max(np.abs(logs).max(initial=0.0), 3 * np.log1p(margin))
    low, high = min(logs.min(initial=0.0), -0.3 * reach), max(logs.max(initial=0.0), 0.3 * reach)
    return float(np.exp(low)), float(np.exp(high))


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
    from matplotlib.dates import AutoDateLocator, ConciseDateFormatter

    series = list(dict.fromkeys(row["series"] for row in rows))
    taus = _shown(sorted({float(row["tau_s"]) for row in rows}))
    points, looks = _dated(names, dates, allan, series, taus), looks_of(series)
    trends = {
        (row["tau_s"], row["series"]): row["percent_per_month"]
        for row in rows
        if row["tau_s"] in taus and row["word"] in CLEAR
    }
    body, grid, panels = _grid(title, source, len(taus), series)
    grid[0, 0].margins(x=0.06)
    locator = AutoDateLocator(minticks=2, maxticks=5)
    grid[0, 0].xaxis.set_major_locator(locator)
    grid[0, 0].xaxis.set_major_formatter(ConciseDateFormatter(locator))
    beside = 0.012 * max(np.ptp(points["day"]), 1e-9)  # series side by side
    for tau, row in zip(taus, grid, strict=True):
        at_tau = points[points["tau_s"] == tau]
        log_axis(row[0], "y", log_limits([at_tau[["adev", "lower", "upper"]]], 0.3))
        for axes, own in zip(row, panels.values(), strict=True):
            for order, name in enumerate(own):
                one = at_tau[at_tau["series"] == name]
                x = one["day"] + (order - (len(own) - 1) / 2) * beside
                ends = [one["adev"] - one["lower"], one["upper"] - one["adev"]]
                how = looks[name].line(ls="", elinewidth=0.8, label=_called(name))
                axes.errorbar(x, one["adev"], yerr=ends, **how)
                if (tau, name) in trends:
                    slope = np.log1p(trends[tau, name] / 100) / DAYS_A_MONTH
                    level = np.mean(np.log(one["adev"]) - slope * one["day"])
                    line = looks[name].line(marker="", lw=1.0)
                    axes.plot(x, np.exp(level + slope * one["day"]), **line)
        single = tau == taus[0]
        panel_title(
            row[0], f"One frame ({1000 * tau:.3g} ms)" if single else f"Averaged over {tau:.3g} s"
        )
        row[0].set_ylabel("Allan deviation (µm)")
    for axes in grid[-1]:
        axes.set_xlabel("Date (series side by side)")
    last = grid[-1, -1]
    last.plot([], [], color=GREY, ls="", marker="|", markersize=9, label="68 % interval")
    if trends:
        last.plot([], [], color=GREY, label="trend, where clear")
    legend_below(body, grid.flat)
    return Picture(body, f"{captions.TREND} {remarks}")


def _shown(taus: Sequence[float]) -> np.ndarray:
    """The first, and those nearest to `TIMES_S`."""
    chosen = [taus[0], *(min(taus, key=lambda t: abs(np.log(t / near))) for near in TIMES_S)]
    return np.array(list(dict.fromkeys(chosen)))


def _dated(
    names: Sequence[str],
    dates: Sequence[str],
    allan: Mapping[str, Columns],
    series: Sequence[str],
    taus: np.ndarray,
) -> pd.DataFrame:
    """`series`, `tau_s`, `day` (of matplotlib), `adev` with its interval `lower`, `upper` in µm."""
    from matplotlib.dates import date2num

    parts = []
    for one in series:
        for name, date in zip(names, dates, strict=True):
            curve = curve_of(allan[name], one).usable().at(taus)
            values = {"tau_s": taus, "adev": curve.adev, "edf": curve.edf}
            day = date2num(datetime.fromisoformat(date))
            parts.append(pd.DataFrame(values).assign(series=one, day=day))
    points = pd.concat(parts).dropna(subset="adev")
    low, high = interval(points["adev"].to_numpy() ** 2, points["edf"].to_numpy(), CONFIDENCE)
    points = points.assign(lower=low, upper=high)
    return points.assign(**{k: 1000 * points[k] for k in ("adev", "lower", "upper")})
