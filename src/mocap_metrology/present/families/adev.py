"""Allan deviations of several recordings: a panel a series, a curve a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.drawing.curves import Curve, Key, Panel, curves_figure
from mocap_metrology.present.drawing.decades import log_limits
from mocap_metrology.present.drawing.style import Look, styled
from mocap_metrology.present.families.members import (
    CAMERAS,
    MOST_BANDS,
    Family,
    curve_of,
    left_out,
    shown_series,
)
from mocap_metrology.present.families.ratios import ratio_figure
from mocap_metrology.present.recording.figures import ALLAN_DECADES, ALLAN_SLOPES, FARTHEST_BAND

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Allan = Mapping[str, Mapping[str, np.ndarray]]


@styled()
def family_figure(
    family: Family,
    allan: Allan,
    expected: Mapping[str, Sequence[str]],
    title: str,
    note: str = "",
    confidence: float | None = None,
) -> Figure:
    """Allan deviations of a family of recordings, as S Figures 8, 12 and 13.

    allan: columns of allan_masked.parquet, and expected: series that should be there, both by
    recording; a panel shows those that should have its series. Subsets of cameras are drawn with
    their ratio to the smallest one; up to three other recordings with their intervals, of that
    `confidence` (0 to 1).
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
        return ratio_figure(panels, limits, title, f"{left_out(others)} {note}")
    ends = "" if family.looks else "Over each panel its lowest and its highest recording."
    return panels_figure(panels, title, f"{ends} {left_out(others)} {note}", confidence)


@styled()
def compared_figure(
    allan: Mapping[str, tuple[Mapping[str, np.ndarray], Look]],
    series: Sequence[str],
    title: str,
    note: str = "",
    confidence: float | None = None,
) -> Figure:
    """Named recordings with given looks, a panel a series, with intervals of that confidence;
    allan: columns of allan_masked.parquet and look, by the name in the key."""
    looks = {name: look for name, (_, look) in allan.items()}
    panels = [
        Panel(one, [curve_of(columns, one, n, True) for n, (columns, _) in allan.items()], looks)
        for one in series
    ]
    return panels_figure(panels, title, note, confidence)


def panels_figure(
    panels: Sequence[Panel], title: str, note: str, confidence: float | None = None
) -> Figure:
    """The figure of such panels on common axes, with the key of slopes."""
    curves = [curve for panel in panels for curve in panel.curves]
    band = "interval" if confidence is None else f"{100 * confidence:.3g} % interval"
    return curves_figure(
        panels,
        ("Averaging time τ (s)", "Allan deviation (mm)"),
        adev_limits(curves),
        Key(ALLAN_SLOPES, "Allan deviation", band),
        title,
        note,
    )


def adev_limits(curves: Sequence[Curve]) -> tuple[tuple[float, float], tuple[float, float]]:
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
