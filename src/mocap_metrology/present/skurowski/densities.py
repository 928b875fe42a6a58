"""S Figures 9 and 10: kernel estimates of densities of location and distance, and the means."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mocap_metrology.noise.gaussian.two_markers import kernel_density
from mocap_metrology.present.drawing.axes import decade_axis, linear_axis
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    FAINT,
    GREY,
    INK,
    LOOKS,
    MARGIN_MM,
    OTHER_LOOKS,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    Look,
    Sheet,
    blank_sheet,
    head,
    label_axes,
    plain,
    styled,
)
from mocap_metrology.present.skurowski.model_figures import KINDS, PAPER, normal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE_9 = f"{PAPER}, Figure 9: where the markers were seen"
TITLE_10 = f"{PAPER}, Figure 10: one distance, several sets of cameras"
NOTE_9 = (
    "Kernel estimates (Gaussian kernels, Silverman's bandwidth) of the cleaned coordinates; normal "
    "densities of the same mean and standard deviation, and of Table 4's. Zero is Table 4's mean, "
    "where a twin starts. Slow noise makes one recording's density lumpy and moves its mean."
)
NOTE_10 = (
    "(a) Kernel estimates of the cleaned distance, and normal densities of Table 4's μ_L and σ_L. "
    "(b) Mean distances; bars: standard error of the mean of a twin about its first frame, which "
    "has Table 4's μ_L of its type (line) for every number of cameras, as the paper prints no "
    "others. A measured recording has no such bar. An arrow with a number: a mean beyond it."
)
LEFT_MM, RIGHT_MM, TITLE_MM, LABELS_MM, GAP_MM = 18.0, 3.0, 5.5, 11.0, 9.0
SETS = KINDS | {"All": OTHER_LOOKS[0]}
FAR = 8.0  # times the median distance from the median
LEAST_DENSITY = 0.02  # 1/mm, the lower end of the logarithmic axis


class Mean(NamedTuple):
    """Mean of a distance, mm: of which subset, its standard error (None: not known), and the
    printed mean of the type (None: there is none)."""

    camera_type: str
    n_cameras: int
    value: float
    error: float | None
    published: float | None


@styled()
def locations_figure(
    series: Mapping[str, np.ndarray],
    published: Mapping[str, float] | None,
    title: str = TITLE_9,
    note: str = "",
) -> Figure:
    """S Figure 9 of x1 and x2 (n,) in mm, beside a row of Table 4 (or None: of no row, and zero is
    the recording's own mean)."""
    look, other = LOOKS["x"], LOOKS["y"]
    entries = [
        Entry("kernel estimate", patch={"color": look.colour, "alpha": 0.3, "lw": 0}),
        Entry("normal, its own moments", line=_line(look)),
        Entry("normal, Table 4", line=_line(other)),
    ]
    width, height = WIDTH_MM - 2 * MARGIN_MM, 58.0
    key_top = TITLE_MM + height + LABELS_MM
    sheet = blank_sheet(
        key_top + strip_height(entries, width) + 1.5, title, f"{NOTE_9} {note}".strip()
    )
    panel = (WIDTH_MM - LEFT_MM - RIGHT_MM - GAP_MM) / 2
    rows = [
        (published[f"mu_{k}_mm"], published[f"sigma_{k}_mm"])
        if published
        else (float(np.nanmean(series[f"x{k}"])), 0.0)
        for k in (1, 2)
    ]
    top = max(max(_peaks(1000 * series[f"x{k}"], 1000 * rows[k - 1][1])) for k in (1, 2))
    for k, name in enumerate(("x1", "x2")):
        axes = sheet.axes(LEFT_MM + k * (panel + GAP_MM), TITLE_MM, panel, height)
        mu, sigma = rows[k]
        _location(axes, 1000 * (series[name] - mu), 1000 * sigma, top)
        axes.tick_params(labelleft=k == 0)
        label_axes(
            axes, f"x{'₁₂'[k]} − {mu:.4f} mm (µm)", "Density (1/µm)" if k == 0 else "", y_mm=14
        )
        own = (np.nanmean(series[name]), np.nanstd(series[name], ddof=1) * 1000)
        head(axes, f"Marker {k + 1}", f"mean {own[0]:.4f} mm, SD {own[1]:.1f} µm")
    strip(sheet, MARGIN_MM, key_top, width, entries)
    return sheet.figure


def _line(look: Look) -> Keywords:
    return {"color": look.colour, "ls": look.dashes, "lw": 1.2}


def _peaks(values_um: np.ndarray, published_um: float) -> tuple[float, ...]:
    """Of the three curves of a panel, 1/µm."""
    sigma = float(np.nanstd(values_um, ddof=1))
    peaks = [normal(np.zeros(1), s)[0] for s in (sigma, published_um) if s > 0]
    return *peaks, kernel_density(values_um).density.max(initial=0.0)


def _location(axes: Axes, offset_um: np.ndarray, published_um: float, top: float) -> None:
    found = kernel_density(offset_um)
    mean, sigma = float(np.nanmean(offset_um)), float(np.nanstd(offset_um, ddof=1))
    low = min(mean - 4 * sigma, -3.5 * published_um)
    high = max(mean + 4 * sigma, 3.5 * published_um)
    x = np.linspace(low, high, 801)
    linear_axis(axes, "x", (low, high), 7)
    linear_axis(axes, "y", (0, 1.08 * top), 6)
    axes.fill_between(found.x, found.density, color=LOOKS["x"].colour, alpha=0.3, lw=0)
    for centre, width, look in ((mean, sigma, LOOKS["x"]), (0.0, published_um, LOOKS["y"])):
        if width > 0:
            axes.plot(x, normal(x - centre, width), **_line(look))


@styled()
def distances_figure(
    distance: Mapping[str, np.ndarray],
    published: Mapping[str, Mapping[str, float]],
    means: Sequence[Mean],
    title: str = TITLE_10,
    note: str = "",
) -> Figure:
    """S Figure 10: densities of L (n,) in mm by set (T40, Bonita, Vantage, All) beside the rows of
    Table 4, and the means of L of every subset."""
    looks = {name: SETS.get(name, OTHER_LOOKS[1]) for name in distance}
    entries = [
        *(Entry(name, line=_line(look)) for name, look in looks.items()),
        Entry("normal, Table 4", line={"color": GREY, "lw": 0.8, "ls": (0, (1.2, 1.2))}),
    ]
    width, first, second = WIDTH_MM - 2 * MARGIN_MM, 52.0, 48.0
    key_top = TITLE_MM + first + LABELS_MM
    below = key_top + strip_height(entries, width) + 3.0 + TITLE_MM
    sheet = blank_sheet(below + second + LABELS_MM, title, f"{NOTE_10} {note}".strip())
    axes = sheet.axes(LEFT_MM, TITLE_MM, WIDTH_MM - LEFT_MM - RIGHT_MM, first)
    _distances(axes, first, distance, published, looks)
    head(axes, "(a) Densities of the distance L")
    label_axes(axes, "L (mm)", "Density (1/mm)")
    strip(sheet, MARGIN_MM, key_top, width, entries)
    _means(sheet, below, second, means)
    return sheet.figure


def _distances(
    axes: Axes,
    height: float,
    distance: Mapping[str, np.ndarray],
    published: Mapping[str, Mapping[str, float]],
    looks: Mapping[str, Look],
) -> None:
    found = {name: kernel_density(values) for name, values in distance.items()}
    rows = [
        (published[name]["mu_L_mm"], published[name]["sigma_L_mm"])
        for name in distance
        if name in published
    ]
    low = min((mu - 4 * s for mu, s in rows), default=0.0)
    high = max((mu + 4 * s for mu, s in rows), default=1.0)
    ends = [(d.x[0], d.x[-1]) for d in found.values() if d.x.size]
    low, high = min([low, *(e[0] for e in ends)]), max([high, *(e[1] for e in ends)])
    peaks = [d.density.max() for d in found.values() if d.x.size]
    peaks += [normal(np.zeros(1), s)[0] for _, s in rows]
    linear_axis(axes, "x", (low, high), 9)
    decade_axis(axes, "y", (LEAST_DENSITY, 2 * max(peaks, default=1.0)), height)
    x = np.linspace(low, high, 2001)
    for name, d in found.items():
        if name in published:
            curve = normal(x - published[name]["mu_L_mm"], published[name]["sigma_L_mm"])
            axes.plot(x, curve, color=looks[name].colour, ls=(0, (1.2, 1.2)), lw=0.8)
        axes.plot(d.x, d.density, **_line(looks[name]))


def _mean_limits(means: Sequence[Mean]) -> tuple[float, float]:
    """Round the means, their errors and the printed ones, without means that are farther from the
    median than `FAR` of what is usual: one alone would flatten all others."""
    values = np.array([m.value for m in means])
    middle = float(np.median(values)) if values.size else 0.0
    off = np.abs(values - middle)
    usual = float(np.median(off)) if values.size else 0.0
    near = [m for m, far in zip(means, off, strict=True) if far <= FAR * usual or usual == 0]
    own = [m.value for m in near] + [m.published for m in near if m.published is not None]
    reach = np.ptp(own) if own else 0.0
    ends = [m.value + side * min(m.error or 0.0, reach) for m in near for side in (-1, 1)]
    low, high = min([*own, *ends], default=0.0), max([*own, *ends], default=1.0)
    span = high - low or 1.0
    return low - 0.08 * span, high + 0.18 * span


def _far_mean(axes: Axes, x: float, value: float, limits: tuple[float, float], look: Look) -> None:
    """An arrow at the end of the axis, with the number."""
    up = value > limits[1]
    y = limits[0] + (0.86 if up else 0.03) * (limits[1] - limits[0])
    axes.plot(x, y, marker=6 if up else 7, color=look.colour, markersize=5)
    how: Keywords = {
        "xytext": (4, 0),
        "textcoords": "offset points",
        "va": "center",
        "size": SMALL_PT,
    }
    axes.annotate(f"{value:.2f}", (x, y), color=look.colour, **how)


def _means(sheet: Sheet, top: float, height: float, means: Sequence[Mean]) -> None:
    """A point a subset, a group a type."""
    from matplotlib.ticker import FixedLocator, FuncFormatter

    axes = sheet.axes(LEFT_MM, top, WIDTH_MM - LEFT_MM - RIGHT_MM, height)
    kinds = list(dict.fromkeys(mean.camera_type for mean in means))
    at, labels, x = {}, {}, 0.0
    for kind in kinds:
        own = [mean for mean in means if mean.camera_type == kind]
        own.sort(key=lambda mean: mean.n_cameras)  # as in Figure 11
        left = x
        for mean in own:
            at[mean], labels[x] = x, str(mean.n_cameras)
            x += 1
        look = SETS.get(kind, OTHER_LOOKS[1])
        middle, text = (left + x - 1) / 2, plain(kind) or "cameras"
        axes.text(middle, 0.97, text, ha="center", va="top", size=SMALL_PT, color=look.colour,
                  transform=axes.get_xaxis_transform())  # fmt: skip
        printed = own[0].published
        if printed is not None:
            axes.plot([left - 0.6, x - 0.4], [printed] * 2, color=look.colour, lw=0.8, alpha=0.6)
        axes.axvline(x, color=FAINT, lw=0.8)
        x += 1
    axes.set_xlim(-1, max(x - 1, 1))
    limits = _mean_limits(means)
    linear_axis(axes, "y", limits, 7)
    axes.xaxis.set_major_locator(FixedLocator(list(labels)))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _p: labels.get(round(v), "")))
    axes.tick_params(axis="x", length=0)
    for mean, place in at.items():
        look = SETS.get(mean.camera_type, OTHER_LOOKS[1])
        how: Keywords = {"color": look.colour, "marker": look.marker, "markersize": 3.6, "lw": 0.9}
        if not limits[0] <= mean.value <= limits[1]:
            _far_mean(axes, place, mean.value, limits, look)
            continue
        axes.errorbar(place, mean.value, yerr=mean.error, capsize=1.5, capthick=0.9, **how)
    head(axes, "(b) Means")
    label_axes(axes, "Number of cameras", "Mean of L (mm)", x_mm=6.5, y_mm=14.5)
    if not means:
        axes.text(0.5, 0.5, "no recordings", transform=axes.transAxes, ha="center", color=INK)
