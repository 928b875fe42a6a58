"""Allan deviations over the dates of recording, with the line of their trend."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.allan.confidence import interval
from mocap_metrology.noise.changes.compare import Curve
from mocap_metrology.present.changes.compare import Columns, curve_of, days_of
from mocap_metrology.present.changes.compare_figure import panels_of
from mocap_metrology.present.drawing.axes import decade_axis, log_limits
from mocap_metrology.present.drawing.curves import look_of
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    GREY,
    SMALL_PT,
    WIDTH_MM,
    Look,
    Sheet,
    blank_sheet,
    head,
    label_axes,
    styled,
)
from mocap_metrology.present.tables import Row

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ROWS = 3  # averaging times on the page; all are in the table
HEIGHT_MM, GAP_MM, LEFT_MM, TITLE_MM, LABELS_MM = 36.0, 5.0, 15.0, 5.5, 11.0
CONFIDENCE = 0.683


@styled()
def trend_figure(
    names: Sequence[str],
    dates: Sequence[str],
    allan: Mapping[str, Columns],
    rows: Sequence[Row],
    title: str,
    note: str,
) -> Figure:
    """A row of panels an averaging time (a frame, and the decades nearest to 1 and 100 s that all
    recordings have): points with 68 % intervals, and the fitted line where there is a trend.

    names in order of `dates` (ISO); `rows` of `compare.trend_rows`.
    """
    taus = _shown(sorted({float(row["tau_s"]) for row in rows}))
    series = list(dict.fromkeys(row["series"] for row in rows))
    panels = panels_of(series)
    curves = {s: [curve_of(allan[name], s).usable().at(taus) for name in names] for s in series}
    looks = {s: look_of(s, panels.get("Distances", [])) for s in series}
    axes = [a for a in "xyz" if f"{a}1" in looks]
    entries = [Entry(a, dot=_point(looks[f"{a}1"])) for a in axes]
    entries += [Entry(name, dot=_point(looks[name])) for name in panels.get("Distances", [])]
    entries.append(Entry("68 % interval", dot={"marker": "|", "color": GREY, "markersize": 9}))
    entries.append(Entry("trend, where clear", line={"color": GREY, "lw": 1.0}))
    width = WIDTH_MM - LEFT_MM - 3.0
    key_mm = strip_height(entries, width) + 2.0
    step = HEIGHT_MM + TITLE_MM + 1.5
    sheet = blank_sheet(key_mm + len(taus) * step + LABELS_MM, title, note)
    strip(sheet, LEFT_MM, 0.5, width, entries)
    for k, tau in enumerate(taus):
        clear = {
            r["series"]: r for r in rows if r["tau_s"] == tau and r["word"] in ("worse", "better")
        }
        at_tau = {s: _at(own, k) for s, own in curves.items()}
        top = key_mm + k * step + TITLE_MM
        lowest = k == len(taus) - 1
        name = f"One frame ({1000 * tau:.3g} ms)" if k == 0 else f"Averaged over {tau:.3g} s"
        _row(sheet, top, name, days_of(dates), dates, at_tau, panels, looks, clear, lowest)
    return sheet.figure


def _point(look: Look) -> dict[str, object]:
    return {"marker": look.marker, "color": look.colour, "mfc": "white"}


def _shown(taus: Sequence[float]) -> np.ndarray:
    """The first, and those nearest to 1 s and to 100 s."""
    chosen = [taus[0], *(min(taus, key=lambda t: abs(np.log(t / near))) for near in (1.0, 100.0))]
    return np.array(list(dict.fromkeys(chosen))[:ROWS])


def _at(curves: Sequence[Curve], k: int) -> tuple[np.ndarray, np.ndarray]:
    """Deviations of the recordings at the k-th tau (n,), and their intervals (2, n), in µm."""
    adev, edf = (np.array([getattr(c, name)[k] for c in curves]) for name in ("adev", "edf"))
    low, high = np.full((2, adev.size), np.nan)
    known = np.isfinite(adev)
    low[known], high[known] = interval(adev[known] ** 2, edf[known], CONFIDENCE)
    return 1000 * adev, 1000 * np.stack([low, high])


def _row(
    sheet: Sheet,
    top: float,
    name: str,
    days: Sequence[float],
    dates: Sequence[str],
    values: Mapping[str, tuple[np.ndarray, np.ndarray]],
    panels: Mapping[str, Sequence[str]],
    looks: Mapping[str, Look],
    clear: Mapping[str, Row],
    lowest: bool,
) -> None:
    width = (WIDTH_MM - LEFT_MM - 3.0 - GAP_MM * (len(panels) - 1)) / len(panels)
    limits = log_limits([v for adev, band in values.values() for v in (adev, band)], 0.3)
    for k, (title, series) in enumerate(panels.items()):
        axes = sheet.axes(LEFT_MM + k * (width + GAP_MM), top, width, HEIGHT_MM)
        decade_axis(axes, "y", limits, HEIGHT_MM)
        _date_axis(axes, days, dates, width)
        axes.tick_params(labelbottom=lowest, labelleft=k == 0)
        shift = 0.012 * max(np.ptp(days), 1e-9)
        for order, one in enumerate(series):
            middle = np.asarray(days) + (order - (len(series) - 1) / 2) * shift
            _draw(axes, middle, *values[one], looks[one], clear.get(one))
        if lowest:
            label_axes(axes, x="Date (series side by side)")
        axes.text(0.02, 0.97, title, transform=axes.transAxes, va="top", size=SMALL_PT, color=GREY)
        if k == 0:
            head(axes, name)
            label_axes(axes, y="ADEV (µm)")


def _draw(
    axes: Axes, days: np.ndarray, adev: np.ndarray, band: np.ndarray, look: Look, row: Row | None
) -> None:
    off = np.abs(band - adev)
    axes.errorbar(
        days, adev, off, color=look.colour, ls="", marker=look.marker, mfc="white", elinewidth=0.8
    )
    if row is not None:
        slope = np.log1p(row["percent_per_month"] / 100) / 30.4375
        known = np.isfinite(adev)
        level = np.mean(np.log(adev[known]) - slope * days[known])
        axes.plot(days, np.exp(level + slope * days), color=look.colour, ls=look.dashes, lw=1.0)


def _date_axis(axes: Axes, days: Sequence[float], dates: Sequence[str], width_mm: float) -> None:
    """Ticks at recordings, as many as there is room for; first and last always, written inwards."""
    order = np.argsort(days)
    most = max(int(width_mm // 22), 2)
    picks = order[np.unique(np.linspace(0, order.size - 1, min(most, order.size)).astype(int))]
    axes.set_xticks([days[k] for k in picks], [dates[k][:10] for k in picks])
    reach = 0.12 * max(np.ptp(days), 1.0)
    axes.set_xlim(min(days) - reach, max(days) + reach)
    labels = axes.get_xticklabels()
    for label in labels:
        label.set_fontsize(SMALL_PT)
    if len(labels) == 2:
        labels[0].set_horizontalalignment("left")
        labels[-1].set_horizontalalignment("right")
        for label, side in zip(labels, (-1, 1), strict=True):
            label.set_x(label.get_position()[0] + side * reach)
    axes.grid(True, axis="x")
