"""Allan deviations of several recordings: a panel a series, a curve a recording; by number of
cameras also their ratio to the first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.present.groups.members import (
    CAMERAS,
    MOST_BANDS,
    Family,
    curve_of,
    left_out,
    shown_series,
)
from mocap_metrology.present.plot.curves import (
    ALLAN_SLOPES,
    Curve,
    Limits,
    Panel,
    curves_picture,
    draw_panel,
    family_ends,
    log_limits,
    markers_every,
    slope_fan,
)
from mocap_metrology.present.plot.figure import (
    Look,
    Picture,
    legend_below,
    letters,
    log_axes,
    new_figure,
    panel_title,
    short,
    styled,
)
from mocap_metrology.present.recording.recording_figures import (
    ALLAN_DECADES,
    FARTHEST_BAND,
)
from mocap_metrology.present.text import captions

COLUMNS = 3
ROW_MM = 66.0  # a panel with its ratios
WITHIN, PAD = (0.5, 99.5), 0.06  # percentiles of the ratios that their axis holds, and beyond them
LEAST_RANGE = 0.1
AXES = r"Averaging time $\tau$ (s)", "Allan deviation (mm)"
Allan = Mapping[str, Mapping[str, np.ndarray]]  # columns of allan_masked.parquet by recording


def ratio_picture(
    panels: Sequence[Panel], limits: tuple[Limits, Limits], texts: tuple[str, str, str]
) -> Picture:
    """A panel a series, and under it the curves of that panel divided by its first curve.

    panels: of curves with looks, the smallest subset first; limits: of averaging time in s and
    Allan deviation in mm; texts: title, source line and caption. The ratio is computed where both
    have the averaging time. Call it within `styled`.
    """
    rows = -(-len(panels) // COLUMNS)
    body = new_figure(*texts[:2], 24.0 + rows * ROW_MM)
    grid = body.subplots(2 * rows, COLUMNS, sharex=True, squeeze=False, height_ratios=(5, 3) * rows)
    above, below = grid[::2].ravel(), grid[1::2].ravel()
    found = [ratios(panel.curves) for panel in panels]
    extent = _extent([ratio for of_panel in found for _, ratio in of_panel.values()])
    for k, panel in enumerate(panels):
        log_axes(above[k], limits)
        draw_panel(above[k], panel, limits[1])
        panel_title(above[k], short(panel.title))
        below[k].set_ylim(extent)
        below[k].locator_params(axis="y", nbins=5)
        for order, (name, (x, ratio)) in enumerate(found[k].items()):
            every = markers_every(x.size, order)
            below[k].plot(x, ratio, **panel.look(name).line(markevery=every))
        first = k % COLUMNS == 0
        for axes in (above[k], below[k]):
            axes.tick_params(labelleft=first, which="both")
        if first:
            above[k].set_ylabel(AXES[1])
            below[k].set_ylabel(f"Ratio to\n{short(next(iter(found[k]), ''))}")
        if k + COLUMNS >= len(panels):
            below[k].set_xlabel(AXES[0])
            below[k].tick_params(labelbottom=True)
    for axes in (*above[len(panels) :], *below[len(panels) :]):
        axes.axis("off")
    if len(panels) < above.size:
        log_axes(above[len(panels)], limits)
        slope_fan(above[len(panels)], limits, ALLAN_SLOPES)
    legend_below(body, above[: len(panels)])
    return Picture(body, texts[2])


def ratios(curves: Sequence[Curve]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Averaging times and ratio to the first curve, by name of the curve."""
    if not curves:
        return {}
    first, found = curves[0], {}
    for curve in curves:
        x, own, reference = np.intersect1d(curve.x, first.x, return_indices=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = curve.y[own] / first.y[reference]
        found[curve.name] = x, np.where(np.isfinite(ratio) & (ratio > 0), ratio, np.nan)
    return found


def _extent(values: Sequence[np.ndarray]) -> Limits:
    """Limits of the linear axis of ratios, with 1 inside."""
    known = np.concatenate([v[np.isfinite(v)] for v in values] or [np.ones(1)])
    low, high = np.percentile(known, WITHIN) if known.size else (1.0, 1.0)
    low, high = min(low, 1.0), max(high, 1.0)
    room = max(high - low, LEAST_RANGE) * PAD
    return max(float(low - room), 0.0), float(high + room)


@styled()
def family_figure(
    family: Family,
    allan: Allan,
    expected: Mapping[str, Sequence[str]],
    title: str,
    source: str,
    remarks: str = "",
    confidence: float | None = None,
) -> Picture:
    """Allan deviations of a family of recordings, as S Figures 8, 12 and 13.

    allan: columns of allan_masked.parquet, and expected: series that should be there, both by
    recording; a panel shows those that should have its series. Subsets of cameras are drawn with
    their ratio to the smallest one; up to three other recordings with their intervals, of that
    `confidence` (0 to 1). source: the line at the foot; remarks: what the caption adds.
    """
    shown, others = shown_series([name for names in expected.values() for name in names])
    subsets = family.by == CAMERAS and bool(family.looks)
    band = len(family.labels) <= MOST_BANDS and not subsets
    labels = {name: family.said(label) for name, label in family.labels.items()}
    looks = {family.said(label): look for label, look in family.looks.items()}
    panels = [
        Panel(
            series,
            [
                curve_of(allan[name], series, label, band)
                for name, label in labels.items()
                if series in expected[name]
            ],
            looks,
        )
        for series in shown
    ]
    if subsets:
        limits = adev_limits([curve for panel in panels for curve in panel.curves])
        caption = f"{captions.ADEV} {captions.ADEV_RATIOS} {left_out(others)} {remarks}"
        return ratio_picture(panels, limits, (title, source, caption))
    caption = f"{captions.ADEV} {_ends(panels)} {left_out(others)} {remarks}"
    return panels_picture(panels, (title, source, caption), confidence)


def _ends(panels: Sequence[Panel]) -> str:
    """Lowest and highest recording of each panel, if there are too many to distinguish."""
    found = [(panel.title, family_ends(panel.curves)) for panel in panels if panel.family]
    names = [f"{title}: {ends[0].name} and {ends[1].name}" for title, ends in found if ends]
    return captions.ADEV_ENDS.format(names="; ".join(names)) if names else ""


@styled()
def compared_figure(
    allan: Mapping[str, tuple[Mapping[str, np.ndarray], Look]],
    series: Sequence[str],
    texts: tuple[str, str, str],
    confidence: float | None = None,
) -> Picture:
    """Named recordings with given looks, a panel a series, with intervals of that confidence;
    allan: columns of allan_masked.parquet and look, by the name in the legend; texts: title,
    source line and caption."""
    looks = {name: look for name, (_, look) in allan.items()}
    panels = [
        Panel(one, [curve_of(columns, one, n, True) for n, (columns, _) in allan.items()], looks)
        for one in series
    ]
    picture = panels_picture(panels, texts, confidence)
    letters(picture.body.axes[: len(panels)])
    return picture


def panels_picture(
    panels: Sequence[Panel], texts: tuple[str, str, str], confidence: float | None = None
) -> Picture:
    """The figure of such panels on common axes, with the slopes beside; call it within `styled`."""
    limits = adev_limits([curve for panel in panels for curve in panel.curves])
    band = "interval" if confidence is None else f"{100 * confidence:.3g} % interval"
    return curves_picture(panels, AXES, limits, ALLAN_SLOPES, texts, band)


def adev_limits(curves: Sequence[Curve]) -> tuple[Limits, Limits]:
    """Limits of averaging time and deviation round the curves and their intervals."""
    bands = [
        np.clip(bound, curve.y / FARTHEST_BAND, curve.y * FARTHEST_BAND)
        for curve in curves
        for bound in curve.band or ()
    ]
    return (
        log_limits([curve.x for curve in curves]),
        log_limits([curve.y for curve in curves] + bands, 1.0, ALLAN_DECADES),
    )
