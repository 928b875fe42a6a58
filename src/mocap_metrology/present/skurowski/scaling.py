"""S Figure 11: standard deviations and covariances against the number of cameras."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from mocap_metrology.noise.cameras.scaling import Scaling, fit_scaling
from mocap_metrology.present.plot.curves import groups_of, label_outer, log_limits
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
    room_for,
    short,
    styled,
)
from mocap_metrology.present.text.captions import PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLE_11 = f"{PAPER}, Figure 11: spread over the number of cameras"
COLUMNS = 3
SQUARE_MM_FROM = 0.1  # covariances, mm²: smaller ones are shown in µm²
DECADES_FROM = 50.0  # range of covariances from which their axis is logarithmic
CLOSE = 0.83  # of the next larger number of cameras, from which its label would touch
SERIES: dict[str, Keywords] = {
    "marker 1": {"color": LOOKS["x"].colour, "marker": "o"},
    "marker 2": {"color": LOOKS["z"].colour, "marker": "^", "markerfacecolor": "white"},
    "distance": {"color": INK, "marker": "D"},
}
COLUMN_OF = {"marker 1": "sigma_1_mm", "marker 2": "sigma_2_mm", "distance": "sigma_L_mm"}
SIGMA_12 = "sigma_12_mm2"
DASHES = {"marker 1": "-", "marker 2": (0, (5, 1.6)), "distance": (0, (1.2, 1.2))}
COVARIANCE: Keywords = {"color": "#4d4d4d", "marker": "X", "markersize": 4.6, "mew": 0.4, "ls": ""}
EXTRA: dict[str, tuple[str, Keywords]] = {
    "expected": (
        "on average, by the coefficients",
        {"marker": "_", "markersize": 7.0, "mew": 1.1, "ls": "", "alpha": 0.75},
    ),
    "published": (
        "Table 4",
        {"marker": "*", "markersize": 8.0, "mew": 0.8, "mfc": "none", "ls": ""},
    ),
}


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


def frame_of(subsets: Sequence[Subset]) -> pd.DataFrame:
    """A row a number: `camera_type`, `n`, `fitted`, `kind` (row, expected, published), `column`,
    `value`."""
    rows = [
        (s.camera_type, s.n_cameras, s.fitted, kind, column, float(value))
        for s in subsets
        for kind in ("row", *EXTRA)
        for column in (*COLUMN_OF.values(), SIGMA_12)
        if (value := getattr(s, kind).get(column)) is not None
    ]
    names = ["camera_type", "n", "fitted", "kind", "column", "value"]
    return pd.DataFrame(rows, columns=names).sort_values("n", kind="stable").dropna()


def fits(subsets: Sequence[Subset]) -> dict[str, Scaling | None]:
    """The law fitted to every series of the subsets of one camera type."""
    frame = frame_of(subsets)
    frame = frame[frame["fitted"] & (frame["kind"] == "row")]
    return {
        name: fit_scaling(*frame.loc[frame["column"] == column, ["n", "value"]].to_numpy(float).T)
        for name, column in COLUMN_OF.items()
    }


@styled()
def scaling_figure(
    subsets: Sequence[Subset], texts: tuple[str, str, str], *, variances: bool = False
) -> Picture:
    """S Figure 11 of any group: a column a camera type, above the standard deviations (or, as in
    S, `variances`) with the law, below the covariances; one row of columns for every three types.

    texts: title, source line and caption.
    """
    frame, power = frame_of(subsets), 1 + variances
    kinds = list(dict.fromkeys(subset.camera_type for subset in subsets)) or [""]
    rows, columns = -(-len(kinds) // COLUMNS), min(len(kinds), COLUMNS)
    body = new_figure(texts[0], texts[1], 32.0 + 98.0 * rows)
    grid = body.subplots(2 * rows, columns, sharex=True, squeeze=False, height_ratios=(3, 2) * rows)
    above, below = grid[::2].ravel(), grid[1::2].ravel()
    n = frame["n"].to_numpy(float) if len(frame) else np.ones(1)
    log_axis(grid[0, 0], "x", (n.min() / 1.2, n.max() * 1.2))
    covariances = frame[frame["column"] == SIGMA_12]
    large = covariances["value"].abs().max() >= SQUARE_MM_FROM
    unit, per_mm2 = ("mm²", 1.0) if large else ("µm²", 1e6)
    limits = log_limits([frame.loc[frame["column"] != SIGMA_12, "value"] ** power])
    for kind, upper, lower in zip(kinds, above, below, strict=False):
        of_kind = [subset for subset in subsets if subset.camera_type == kind]
        own, law = frame[frame["camera_type"] == kind], fits(of_kind)
        log_axis(upper, "y", limits)
        _deviations(upper, own, law, power)
        _covariance_axis(lower, covariances["value"] * per_mm2)
        _covariances(lower, own[own["column"] == SIGMA_12], per_mm2)
        for letter, axes in (("a", upper), ("b", lower)):
            axes.set_title(f"({letter}) {short(kind, 16) or 'cameras'}")
            axes.tick_params(which="both", labelleft=axes.get_subplotspec().is_first_col())
    ticks = room_for(sorted(set(n)), CLOSE)
    above[0].set_xticks(ticks, [f"{k:g}" for k in ticks])
    above[0].set_xticks([], minor=True)
    labels = "Number of cameras", f"Covariance ({unit})"
    label_outer(below.reshape(rows, columns), len(kinds), labels)
    for axes in above[: len(kinds) : columns]:
        axes.set_ylabel("Variance (mm²)" if variances else "Standard deviation (mm)")
    for axes in (*above[len(kinds) :], *below[len(kinds) :]):
        axes.axis("off")
    _label(below[0], set(frame["kind"]), r"$\sigma^2/n$" if variances else r"$\sigma/\sqrt{n}$")
    legend_below(body, [below[0]])
    return Picture(body, texts[2])


def _label(axes: Axes, kinds: set[str], law: str) -> None:
    """Entries of the legend below."""
    for name, how in SERIES.items():
        axes.plot([], [], label=name, ls="", **how)
    axes.plot([], [], label="covariance", **COVARIANCE)
    axes.plot([], [], label=law, color=GREY, lw=1.0)
    for kind, (text, how) in EXTRA.items():
        if kind in kinds:
            axes.plot([], [], label=text, color=GREY, **how)


def _deviations(
    axes: Axes, frame: pd.DataFrame, laws: Mapping[str, Scaling | None], power: int
) -> None:
    """Standard deviations to that power with the law fitted to them; a legend of the exponents."""
    curve = np.geomspace(*axes.get_xlim(), 50)
    for name, column in COLUMN_OF.items():
        how, fit = SERIES[name], laws[name]
        own = frame[frame["column"] == column]
        if fit is not None:
            error = power * fit.exponent_error
            more = "" if math.isnan(error) else f" ± {error:.2f}"
            text = f"{name}  {power * fit.exponent:.2f}{more}".replace("-", "−")
            line = {"color": how["color"], "ls": DASHES[name], "lw": 0.9}
            axes.plot(curve, fit.law(curve) ** power, label=text, **line)
        for kind, points in groups_of(own, "kind"):
            look = {"color": how["color"], **EXTRA[kind][1]} if kind in EXTRA else how | {"ls": ""}
            axes.plot(points["n"], points["value"] ** power, **look)
    if any(laws.values()):
        legend = axes.legend(title="exponent of n", loc="best", handlelength=1.6, fontsize=SMALL_PT)
        legend.get_title().set(fontsize=SMALL_PT, color=GREY)


def _covariance_axis(axes: Axes, values: pd.Series) -> None:
    """An axis for all types. Where they differ by decades, and one would flatten all others, it is
    logarithmic to both sides and linear near zero."""
    sizes = values.abs()[values != 0]
    low, high = min([0.0, *values]), max([0.0, *values])
    near = 10.0 ** np.floor(np.log10(sizes.quantile(0.25))) if len(sizes) else 1.0
    if len(sizes) and sizes.max() > DECADES_FROM * near:
        axes.set_yscale("symlog", linthresh=near)
        axes.set_ylim(min(2 * low, -near), max(2 * high, near))
    else:
        room = 0.1 * (high - low) or 1.0
        axes.set_ylim(low - room, high + room)
    axes.axhline(0, color=GREY, lw=0.7)


def _covariances(axes: Axes, frame: pd.DataFrame, per_mm2: float) -> None:
    for kind, own in groups_of(frame, "kind"):
        how = {"color": INK, **EXTRA[kind][1]} if kind in EXTRA else COVARIANCE
        axes.plot(own["n"], own["value"] * per_mm2, **how)
