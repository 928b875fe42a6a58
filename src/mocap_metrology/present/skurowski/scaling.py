"""S Figure 11: standard deviations and covariances against the number of cameras."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.cameras.scaling import Scaling, fit_scaling
from mocap_metrology.present.drawing.axes import Limits, decade_axis, linear_axis, log_limits
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    BODY_PT,
    GREY,
    INK,
    LOOKS,
    MARGIN_MM,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    blank_sheet,
    head,
    label_axes,
    shorten,
    styled,
)
from mocap_metrology.present.skurowski.model_figures import PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE_11 = f"{PAPER}, Figure 11: spread over the number of cameras"
LAW = (
    "Lines: σ/√n (Equation 3), fitted to the points of each series by the mean of their "
    "logarithms; in the corner, the exponent of n with its standard error if it is free (−0.5 by "
    "the law)."
)
NOTE_11 = (
    "(a) Standard deviations along x and of the distance (S plots their squares, variances), (b) "
    "covariances of x₁ and x₂. How they depend on n comes from the printed coefficients, of which "
    "the twins are made; bars: what these lead to on average over recordings as long. Twins of one "
    "type have one history of slow noise (below 0.1 Hz), as subsets of one recording do, so they "
    "lie above or below their bars together. Vantage's "
    "tenth camera was failing and is left out of the fits; stars: Table 4, which is of nine hours."
)
NOTE_GROUP = (
    "(a) Standard deviations along the line between the markers (of a single marker, along x) and "
    "of the distance, (b) covariances of the two markers along that line."
)
COVARIANCE = {"color": "#4d4d4d", "marker": "X", "markersize": 4.6, "mew": 0.4}
TEXT_SHARE = 0.5  # height above the points, for the exponents, in that of the points
SQUARE_MM_FROM = 0.1  # covariances, mm²: smaller ones are shown in µm²
LEFT_MM, RIGHT_MM, TITLE_MM, LABELS_MM = 17.5, 3.0, 5.5, 11.0
GAP_MM, BETWEEN_MM, COLUMNS = 15.5, 6.5, 3
CAMERA_MM = 4.4  # from label to label
BOLD = 1.15  # width of bold text, in that of the same in normal weight
SD_MM, COVARIANCE_MM = 54.0, 36.0
SERIES: dict[str, Keywords] = {
    "marker 1": {"color": LOOKS["x"].colour, "marker": "o", "markerfacecolor": LOOKS["x"].colour},
    "marker 2": {"color": LOOKS["z"].colour, "marker": "^", "markerfacecolor": "white"},
    "distance": {"color": INK, "marker": "D", "markerfacecolor": INK},
}
COLUMN_OF = {"marker 1": "sigma_1_mm", "marker 2": "sigma_2_mm", "distance": "sigma_L_mm"}
DASHES = {"marker 1": "-", "marker 2": (0, (5, 1.6)), "distance": (0, (1.2, 1.2))}


@dataclass(frozen=True)
class Subset:
    """One recording of a group: gaussian.csv's columns in `row`, what its coefficients lead to on
    average in `expected` and Table 4's numbers in `published`, the same names; `fitted`: whether
    the law is fitted to it."""

    camera_type: str
    n_cameras: int
    row: Mapping[str, float]
    expected: Mapping[str, float] = field(default_factory=dict)
    published: Mapping[str, float] = field(default_factory=dict)
    fitted: bool = True


def fits(subsets: Sequence[Subset]) -> dict[str, Scaling | None]:
    """The law fitted to every series of the subsets of one camera type."""
    own = [subset for subset in subsets if subset.fitted]
    return {
        name: fit_scaling(
            np.array([subset.n_cameras for subset in own]), _values(own, "row", column)
        )
        for name, column in COLUMN_OF.items()
    }


def _values(subsets: Sequence[Subset], kind: str, column: str) -> np.ndarray:
    return np.array([float(getattr(s, kind).get(column, math.nan)) for s in subsets])


@styled()
def scaling_figure(subsets: Sequence[Subset], title: str = TITLE_11, note: str = NOTE_11) -> Figure:
    """S Figure 11 of any group: a column a camera type, above the standard deviations with the law,
    below the covariances; one row of columns for every three types."""
    kinds = list(dict.fromkeys(subset.camera_type for subset in subsets)) or [""]
    rows = -(-len(kinds) // COLUMNS)
    block = TITLE_MM + SD_MM + BETWEEN_MM + COVARIANCE_MM + LABELS_MM
    entries = _entries(subsets)
    width = WIDTH_MM - 2 * MARGIN_MM
    key_top = rows * block
    sheet = blank_sheet(
        key_top + strip_height(entries, width) + 1.5, title, f"{LAW} {note}".strip()
    )
    columns = min(len(kinds), COLUMNS)
    panel = (WIDTH_MM - LEFT_MM - RIGHT_MM - GAP_MM * (columns - 1)) / columns
    limits, unit = _limits(subsets), _covariance_unit(subsets)
    for k, kind in enumerate(kinds):
        own = sorted((s for s in subsets if s.camera_type == kind), key=lambda s: s.n_cameras)
        row, column = divmod(k, columns)
        left, top = LEFT_MM + column * (panel + GAP_MM), row * block + TITLE_MM
        axes = sheet.axes(left, top, panel, SD_MM)
        _deviations(axes, own, limits, (panel, SD_MM))
        axes.tick_params(labelbottom=False, labelleft=column == 0)
        name = f"(a) {kind or 'cameras'}" if k == 0 else kind or "cameras"
        head(axes, shorten(name, BODY_PT * BOLD, panel))
        label_axes(axes, "", "Standard deviation (mm)" if column == 0 else "", y_mm=14.5)
        axes = sheet.axes(left, top + SD_MM + BETWEEN_MM, panel, COVARIANCE_MM)
        _covariances(axes, own, limits[0], (panel, COVARIANCE_MM), unit)
        head(axes, "(b)" if k == 0 else "")
        y = f"Covariance ({unit[0]})" if column == 0 else ""
        label_axes(axes, "Number of cameras", y, y_mm=14.5)
    strip(sheet, MARGIN_MM, key_top, width, entries)
    return sheet.figure


def _entries(subsets: Sequence[Subset]) -> list[Entry]:
    entries = [Entry(name, dot=_dot(how)) for name, how in SERIES.items()]
    entries.append(Entry("covariance", dot=COVARIANCE))
    entries.append(Entry("σ/√n", line={"color": GREY, "lw": 1.0}))
    if any(subset.expected for subset in subsets):
        entries.append(Entry("on average, by the coefficients", dot=_bar(GREY)))
    if any(subset.published for subset in subsets):
        entries.append(Entry("Table 4", dot=_star(GREY)))
    return entries


def _dot(how: Keywords) -> Keywords:
    return {"markersize": 3.8, "mew": 0.9, **how}


def _bar(colour: str) -> Keywords:
    return {"marker": "_", "color": colour, "markersize": 7.0, "mew": 1.1, "alpha": 0.75}


def _star(colour: str) -> Keywords:
    return {"marker": "*", "color": colour, "markersize": 8.0, "mew": 0.8,
            "markerfacecolor": "none"}  # fmt: skip


def _limits(subsets: Sequence[Subset]) -> tuple[Limits, Limits]:
    """Of the number of cameras and of the standard deviations; room for the exponents above."""
    kinds = ("row", "expected", "published")
    values = [_values(subsets, kind, column) for kind in kinds for column in COLUMN_OF.values()]
    low, high = log_limits(values)
    counts = [subset.n_cameras for subset in subsets] or [1]
    return (min(counts) / 1.2, max(counts) * 1.2), (low, high * (high / low) ** TEXT_SHARE)


def _covariance_unit(subsets: Sequence[Subset]) -> tuple[str, float]:
    """Unit of all covariances, and how many of it are in 1 mm²."""
    kinds = ("row", "expected", "published")
    values = np.abs(np.concatenate([_values(subsets, k, "sigma_12_mm2") for k in kinds]))
    greatest = float(values[np.isfinite(values)].max(initial=0.0))
    return ("mm²", 1.0) if greatest >= SQUARE_MM_FROM else ("µm²", 1e6)


def _camera_axis(axes: Axes, subsets: Sequence[Subset], limits: Limits, width: float) -> None:
    """Logarithmic, `width` mm, with a label at every number of cameras there is room for."""
    from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

    axes.set_xscale("log")
    axes.set_xlim(limits)
    counts = sorted({subset.n_cameras for subset in subsets})
    per_mm = math.log(limits[1] / limits[0]) / width
    kept: list[int] = []
    for n in reversed(counts):
        if not kept or math.log(kept[-1] / n) > CAMERA_MM * per_mm:
            kept.append(n)
    axes.xaxis.set_major_locator(FixedLocator(kept))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _p: f"{v:.0f}"))
    axes.grid(visible=True, axis="x")


def _deviations(
    axes: Axes, subsets: Sequence[Subset], limits: tuple[Limits, Limits], size: tuple[float, float]
) -> None:
    decade_axis(axes, "y", limits[1], size[1])
    _camera_axis(axes, subsets, limits[0], size[0])
    n = np.array([subset.n_cameras for subset in subsets], float)
    curve = np.geomspace(*limits[0], 50)
    lines = []
    for name, fit in fits(subsets).items():
        how = SERIES[name]
        found, expected, published = (
            _values(subsets, kind, COLUMN_OF[name]) for kind in ("row", "expected", "published")
        )
        if fit is not None:
            axes.plot(curve, fit.law(curve), color=how["color"], ls=DASHES[name], lw=0.9)
            error = "" if math.isnan(fit.exponent_error) else f" ± {fit.exponent_error:.2f}"
            lines.append((f"{name}  {fit.exponent:.2f}{error}".replace("-", "−"), how["color"]))
        axes.plot(n, expected, ls="", **_bar(how["color"]))
        axes.plot(n, published, ls="", **_star(how["color"]))
        axes.plot(n, found, ls="", **_dot(how))
    lines = [("exponent of n", GREY), *lines] if lines else []
    for k, (text, colour) in enumerate(lines):
        place: Keywords = {"transform": axes.transAxes, "ha": "right", "va": "top"}
        axes.text(0.97, 0.97 - 0.075 * k, text, size=SMALL_PT, color=colour, **place)


def _covariances(
    axes: Axes,
    subsets: Sequence[Subset],
    limits: Limits,
    size: tuple[float, float],
    unit: tuple[str, float],
) -> None:
    """Linear, in that unit (its name, and how many are in 1 mm²), each panel to its own scale."""
    _camera_axis(axes, subsets, limits, size[0])
    n = np.array([subset.n_cameras for subset in subsets], float)
    values = [_values(subsets, kind, "sigma_12_mm2") for kind in ("row", "expected", "published")]
    values = [v * unit[1] for v in values]
    known = np.concatenate([v[np.isfinite(v)] for v in values] + [np.zeros(1)])
    span = float(np.ptp(known)) or 1.0
    linear_axis(axes, "y", (known.min() - 0.12 * span, known.max() + 0.12 * span), 6)
    axes.axhline(0, color=GREY, lw=0.7)
    for v, how in zip(values, (COVARIANCE, _bar(INK), _star(GREY)), strict=True):
        axes.plot(n, v, ls="", **how)
