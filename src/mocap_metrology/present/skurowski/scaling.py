"""S Figure 11: standard deviations and covariances against the number of cameras."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.cameras.scaling import Scaling, fit_scaling
from mocap_metrology.present.plot.curves import Limits, log_limits
from mocap_metrology.present.plot.figure import (
    GREY,
    INK,
    LOOKS,
    SMALL_PT,
    Keywords,
    Picture,
    legend_below,
    log_axis,
    new_figure,
    short,
    styled,
)
from mocap_metrology.present.skurowski.theory_figures import PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLE_11 = f"{PAPER}, Figure 11: spread over the number of cameras"
COLUMNS = 3
SQUARE_MM_FROM = 0.1  # covariances, mm²: smaller ones are shown in µm²
DECADES_FROM = 50.0  # range of covariances from which their axis is logarithmic
TEXT_SHARE, LINE_SHARE = 0.36, 0.07  # of the height of a panel: of the exponents, of a line
LABEL_SHARE = 0.09  # of the width of a panel, from one number of cameras to the next
SERIES: dict[str, Keywords] = {
    "marker 1": {"color": LOOKS["x"].colour, "marker": "o"},
    "marker 2": {"color": LOOKS["z"].colour, "marker": "^", "markerfacecolor": "white"},
    "distance": {"color": INK, "marker": "D"},
}
COLUMN_OF = {"marker 1": "sigma_1_mm", "marker 2": "sigma_2_mm", "distance": "sigma_L_mm"}
DASHES = {"marker 1": "-", "marker 2": (0, (5, 1.6)), "distance": (0, (1.2, 1.2))}
COVARIANCE: Keywords = {"color": "#4d4d4d", "marker": "X", "markersize": 4.6, "mew": 0.4, "ls": ""}
BAR: Keywords = {"marker": "_", "markersize": 7.0, "mew": 1.1, "ls": ""}
STAR: Keywords = {"marker": "*", "markersize": 8.0, "mew": 0.8, "mfc": "none", "ls": ""}
KINDS = "row", "expected", "published"
Text = tuple[str, str]  # and its colour
LABELS = dict(zip(KINDS[1:], ("on average, by the coefficients", "Table 4"), strict=True))


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
def scaling_figure(
    subsets: Sequence[Subset], texts: tuple[str, str, str], *, variances: bool = False
) -> Picture:
    """S Figure 11 of any group: a column a camera type, above the standard deviations (or, as in
    S, `variances`) with the law, below the covariances; one row of columns for every three types.

    texts: title, source line and caption.
    """
    kinds = list(dict.fromkeys(subset.camera_type for subset in subsets)) or [""]
    rows, columns = -(-len(kinds) // COLUMNS), min(len(kinds), COLUMNS)
    body = new_figure(texts[0], texts[1], 32.0 + 98.0 * rows)
    grid = body.subplots(2 * rows, columns, sharex=True, squeeze=False, height_ratios=(3, 2) * rows)
    above, below = grid[::2].ravel(), grid[1::2].ravel()
    power, unit = 1 + variances, _covariance_unit(subsets)
    y, x = _limits(subsets, power), [subset.n_cameras for subset in subsets] or [1]
    log_axis(grid[0, 0], "x", (min(x) / 1.2, max(x) * 1.2))
    exponents = []
    for k, kind in enumerate(kinds):
        own = sorted((s for s in subsets if s.camera_type == kind), key=lambda s: s.n_cameras)
        log_axis(above[k], "y", y)
        exponents.append(_deviations(above[k], own, power))
        above[k].set_title(f"(a) {short(kind, 16) or 'cameras'}")
        _covariances(below[k], own, subsets, unit[1])
        below[k].set_title(f"(b) {short(kind, 16) or 'cameras'}")
        above[k].tick_params(which="both", labelleft=k % columns == 0)
        below[k].tick_params(which="both", labelleft=k % columns == 0)
        if k % columns == 0:
            above[k].set_ylabel("Variance (mm²)" if variances else "Standard deviation (mm)")
            below[k].set_ylabel(f"Covariance ({unit[0]})")
        if k + columns >= len(kinds):
            below[k].set_xlabel("Number of cameras")
            below[k].tick_params(labelbottom=True)
    _camera_axis(grid[0, 0], sorted(set(x)))
    _write_exponents(list(above[: len(kinds)]), exponents)
    for axes in (*above[len(kinds) :], *below[len(kinds) :]):
        axes.axis("off")
    _label(above[0], subsets, r"$\sigma^2/n$" if variances else r"$\sigma/\sqrt{n}$")
    legend_below(body, [above[0]])
    return Picture(body, texts[2])


def _label(axes: Axes, subsets: Sequence[Subset], law: str) -> None:
    """Entries of the legend."""
    for name, how in SERIES.items():
        axes.plot([], [], label=name, ls="", **how)
    axes.plot([], [], label="covariance", **COVARIANCE)
    axes.plot([], [], label=law, color=GREY, lw=1.0)
    for (kind, text), how in zip(LABELS.items(), (BAR, STAR), strict=True):
        if any(getattr(subset, kind) for subset in subsets):
            axes.plot([], [], label=text, color=GREY, **how)


def _limits(subsets: Sequence[Subset], power: int) -> Limits:
    """Of the standard deviations, or of their squares."""
    return log_limits(
        _values(subsets, kind, column) ** power for kind in KINDS for column in COLUMN_OF.values()
    )


def _covariance_unit(subsets: Sequence[Subset]) -> tuple[str, float]:
    """Unit of all covariances, and how many of it are in 1 mm²."""
    values = _covariances_of(subsets)
    return ("mm²", 1.0) if np.abs(values).max(initial=0) >= SQUARE_MM_FROM else ("µm²", 1e6)


def _covariances_of(subsets: Sequence[Subset]) -> np.ndarray:
    """All of them that are known, mm²."""
    values = np.concatenate([_values(subsets, kind, "sigma_12_mm2") for kind in KINDS])
    return values[np.isfinite(values)]


def _camera_axis(axes: Axes, counts: Sequence[int]) -> None:
    """A label at every number of cameras that there is room for."""
    from matplotlib.ticker import NullLocator

    low, high = axes.get_xlim()
    room = LABEL_SHARE * math.log(high / low)
    shown: list[int] = []
    for n in reversed(counts):
        if not shown or math.log(shown[-1] / n) > room:
            shown.append(n)
    axes.set_xticks(shown, [str(n) for n in shown])
    axes.xaxis.set_minor_locator(NullLocator())


def _deviations(axes: Axes, subsets: Sequence[Subset], power: int) -> list[Text]:
    """Standard deviations to that power with the law fitted to them; the exponents of n."""
    n = np.array([subset.n_cameras for subset in subsets], float)
    curve = np.geomspace(*axes.get_xlim(), 50)
    lines = [("exponent of n", GREY)]
    for name, fit in fits(subsets).items():
        how = SERIES[name]
        values = [_values(subsets, kind, COLUMN_OF[name]) ** power for kind in KINDS]
        if fit is not None:
            axes.plot(curve, fit.law(curve) ** power, color=how["color"], ls=DASHES[name], lw=0.9)
            error = power * fit.exponent_error
            more = "" if math.isnan(error) else f" ± {error:.2f}"
            text = f"{name}  {power * fit.exponent:.2f}{more}".replace("-", "−")
            lines.append((text, how["color"]))
        axes.plot(n, values[1], color=how["color"], alpha=0.75, **BAR)
        axes.plot(n, values[2], color=how["color"], **STAR)
        axes.plot(n, values[0], ls="", **how)
    return lines if len(lines) > 1 else []


def _write_exponents(panels: Sequence[Axes], of_panels: Sequence[Sequence[Text]]) -> None:
    """In the upper right or the lower left corner, as numbers fall to the right; where both are
    occupied, all axes are extended."""
    crowded = [_free(axes)[0] for axes in panels if max(_free(axes)) < TEXT_SHARE]
    if crowded:
        low, high = panels[0].get_ylim()
        higher = (high / low) ** ((1 - min(crowded)) / (1 - TEXT_SHARE))
        for axes in panels:
            axes.set_ylim(low, low * higher)
    for axes, lines in zip(panels, of_panels, strict=True):
        top = np.argmax(_free(axes)) == 0
        x, ha, va = (0.97, "right", "top") if top else (0.03, "left", "bottom")
        for k, (text, colour) in enumerate(lines):
            y = 0.96 - LINE_SHARE * k if top else 0.04 + LINE_SHARE * (len(lines) - 1 - k)
            place: Keywords = {"transform": axes.transAxes, "ha": ha, "va": va, "size": SMALL_PT}
            axes.text(x, y, text, color=colour, **place)


def _free(axes: Axes) -> tuple[float, float]:
    """Shares of the height that are free in the upper right and in the lower left corner."""
    points = np.concatenate([line.get_xydata() for line in axes.lines] or [np.zeros((0, 2))])
    points = points[np.isfinite(points).all(axis=1) & (points > 0).all(axis=1)]
    x, y = axes.transAxes.inverted().transform(axes.transData.transform(points)).T
    return 1 - float(y[x > 0.4].max(initial=0)), float(y[x < 0.6].min(initial=1))


def _covariances(
    axes: Axes, subsets: Sequence[Subset], every: Sequence[Subset], per_mm2: float
) -> None:
    """On an axis for all types. Where they differ by decades, and one would flatten all others, it
    is logarithmic to both sides and linear near zero."""
    known = per_mm2 * _covariances_of(every)
    sizes = np.abs(known[known != 0])
    low, high = known.min(initial=0), known.max(initial=0)
    near = 10.0 ** np.floor(np.log10(np.quantile(sizes, 0.25))) if sizes.size else 1.0
    if sizes.max(initial=0) > DECADES_FROM * near:
        axes.set_yscale("symlog", linthresh=near)
        axes.set_ylim(min(2 * low, -near), max(2 * high, near))
    else:
        room = 0.1 * (high - low) or 1.0
        axes.set_ylim(low - room, high + room)
    n = np.array([subset.n_cameras for subset in subsets], float)
    values = [per_mm2 * _values(subsets, kind, "sigma_12_mm2") for kind in KINDS]
    axes.axhline(0, color=GREY, lw=0.7)
    axes.plot(n, values[0], **COVARIANCE)
    axes.plot(n, values[1], color=INK, alpha=0.75, **BAR)
    axes.plot(n, values[2], color=GREY, **STAR)
