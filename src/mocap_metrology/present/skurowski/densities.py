"""S Figures 9 and 10: kernel estimates of densities of location and distance, and the means."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mocap_metrology.noise.gaussian.two_markers import kernel_density
from mocap_metrology.present.plot.figure import (
    FAINT,
    GREY,
    LOOKS,
    OTHER_LOOKS,
    SMALL_PT,
    Keywords,
    Picture,
    legend_below,
    log_axis,
    new_figure,
    panel_title,
    say,
    short,
    styled,
)
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.captions import PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLE_9 = f"{PAPER}, Figure 9: where the markers were seen"
TITLE_10 = f"{PAPER}, Figure 10: one distance, several sets of cameras"
SETS = dict(
    zip(("T40", "Bonita", "Vantage", "All"), (*LOOKS.values(), OTHER_LOOKS[0]), strict=True)
)
FAR = 8.0  # times the median distance from the median
LEAST_DENSITY = 0.02  # 1/mm, the lower end of the logarithmic axis
PRINTED: Keywords = {"ls": (0, (1.2, 1.2)), "lw": 0.8}


class Mean(NamedTuple):
    """Mean of a distance, mm: of which subset, its standard error (None: not known), and the
    printed mean of the type (None: there is none)."""

    camera_type: str
    n_cameras: int
    value: float
    error: float | None
    published: float | None


def normal(x: np.ndarray, sigma: float) -> np.ndarray:
    """Density of N(0, sigma)."""
    density: np.ndarray = np.exp(-0.5 * (x / sigma) ** 2) / (sigma * np.sqrt(2 * np.pi))
    return density


@styled()
def locations_figure(
    series: Mapping[str, np.ndarray],
    published: Mapping[str, float] | None,
    source: str,
    remarks: str = "",
    title: str = TITLE_9,
) -> Picture:
    """S Figure 9 of x1 and x2 (n,) in mm, beside a row of Table 4 (or None: of no row, and zero is
    the recording's own mean); source: the line at the foot; remarks: what the caption adds."""
    body = new_figure(title, source, 85.0)
    grid = body.subplots(1, 2, sharey=True)
    fill: Keywords = {"color": LOOKS["x"].colour, "alpha": 0.3, "lw": 0, "label": "kernel estimate"}
    for k, axes in enumerate(grid, start=1):
        middle = float(np.nanmean(series[f"x{k}"]))
        zero = published[f"mu_{k}_mm"] if published else middle
        offset = 1000 * (series[f"x{k}"] - zero)
        printed = 1000 * published[f"sigma_{k}_mm"] if published else 0.0
        mean, sigma = float(np.nanmean(offset)), float(np.nanstd(offset, ddof=1))
        low = min(mean - 4 * sigma, -3.5 * printed)
        high = max(mean + 4 * sigma, 3.5 * printed)
        axes.set_xlim((low, high) if low < high else (-1.0, 1.0))
        density = kernel_density(offset)
        axes.fill_between(density.x, density.density, **fill)
        x = np.linspace(low, high, 801)
        for centre, width, look, text in (
            (mean, sigma, LOOKS["x"], "normal, its own moments"),
            (0.0, printed, LOOKS["y"], "normal, Table 4"),
        ):
            if width > 0:
                how: Keywords = {"color": look.colour, "ls": look.dashes, "label": text}
                axes.plot(x, normal(x - centre, width), **how)
        panel_title(axes, f"Marker {k}", f"mean {middle:.4f} mm, SD {sigma:.1f} µm")
        axes.set_xlabel(f"$x_{k}$ − {zero:.4f} mm (µm)")
    grid[0].set(ylabel="Density (1/µm)", ylim=(0, None))
    legend_below(body, grid)
    return Picture(body, f"{captions.SKUROWSKI[9]} {remarks}")


@styled()
def distances_figure(
    distance: Mapping[str, np.ndarray],
    published: Mapping[str, Mapping[str, float]],
    means: Sequence[Mean],
    source: str,
    remarks: str = "",
    title: str = TITLE_10,
) -> Picture:
    """S Figure 10: densities of L (n,) in mm by set (T40, Bonita, Vantage, All) beside the rows of
    Table 4, and the means of L of every subset; source: the line at the foot; remarks: what the
    caption adds."""
    body = new_figure(title, source, 150.0)
    above, below = body.subplots(2)
    _distances(above, distance, published)
    above.set(title="(a) Densities of the distance L", xlabel="L (mm)", ylabel="Density (1/mm)")
    _means(below, means)
    below.set(title="(b) Means", xlabel="Number of cameras", ylabel="Mean of L (mm)")
    legend_below(body, [above])
    return Picture(body, f"{captions.SKUROWSKI[10]} {remarks}")


def _distances(
    axes: Axes, distance: Mapping[str, np.ndarray], published: Mapping[str, Mapping[str, float]]
) -> None:
    for name, values in distance.items():
        look = SETS.get(name, OTHER_LOOKS[1])
        density, row = kernel_density(values), published.get(name)
        how: Keywords = {"color": look.colour, "ls": look.dashes, "label": short(name)}
        axes.plot(density.x, density.density, **how)
        if row is not None:
            mu, sigma = row["mu_L_mm"], row["sigma_L_mm"]
            x = np.linspace(mu - 4 * sigma, mu + 4 * sigma, 401)
            axes.plot(x, normal(x - mu, sigma), color=look.colour, **PRINTED)
    if any(name in published for name in distance):
        axes.plot([], [], color=GREY, label="normal, Table 4", **PRINTED)
    peaks = [float(np.max(line.get_ydata(), initial=0)) for line in axes.lines]
    log_axis(axes, "y", (LEAST_DENSITY, 2 * max(peaks, default=1.0) or 1.0))


def _mean_limits(means: Sequence[Mean]) -> tuple[float, float]:
    """Round the means, their errors and the printed ones, without means that are farther from the
    median than `FAR` of what is usual: one alone would flatten all others."""
    values = np.array([m.value for m in means]) if means else np.zeros(1)
    off = np.abs(values - np.median(values))
    near = [
        m for m, far in zip(means, off, strict=False) if far <= FAR * (np.median(off) or np.inf)
    ]
    own = [m.value for m in near] + [m.published for m in near if m.published is not None]
    reach = np.ptp(own) if own else 0.0
    ends = [m.value + side * min(m.error or 0.0, reach) for m in near for side in (-1, 1)]
    low, high = min([*own, *ends], default=0.0), max([*own, *ends], default=1.0)
    return low - 0.08 * (high - low or 1.0), high + 0.18 * (high - low or 1.0)


def _means(axes: Axes, means: Sequence[Mean]) -> None:
    """A point a subset, a group a type; an arrow with a number where one is beyond the axis."""
    limits, x, ticks = _mean_limits(means), 0, {}
    order = {kind: k for k, kind in enumerate(dict.fromkeys(m.camera_type for m in means))}
    ordered = sorted(means, key=lambda m: (order[m.camera_type], m.n_cameras))
    small: Keywords = {"size": SMALL_PT, "va": "center"}
    for kind, own in groupby(ordered, key=lambda m: m.camera_type):
        look, left = SETS.get(kind, OTHER_LOOKS[1]), x
        printed = None
        for mean in own:
            ticks[x], printed = str(mean.n_cameras), mean.published
            if limits[0] <= mean.value <= limits[1]:
                how: Keywords = {"color": look.colour, "marker": look.marker, "lw": 0.9}
                axes.errorbar(x, mean.value, yerr=mean.error, capsize=1.5, **how)
            else:
                up = mean.value > limits[1]
                y = limits[0] + (0.86 if up else 0.03) * (limits[1] - limits[0])
                axes.plot(x, y, marker=6 if up else 7, color=look.colour, markersize=5)
                place: Keywords = {"xytext": (4, 0), "textcoords": "offset points"}
                axes.annotate(f"{mean.value:.2f}", (x, y), color=look.colour, **place, **small)
            x += 1
        how = {"color": look.colour, "ha": "center", "transform": axes.get_xaxis_transform()}
        axes.text((left + x - 1) / 2, 0.95, short(kind) or "cameras", **how, **small)
        if printed is not None:
            axes.hlines(printed, left - 0.6, x - 0.4, color=look.colour, lw=0.8, alpha=0.6)
        axes.axvline(x, color=FAINT, lw=0.8)
        x += 1
    axes.set(xlim=(-1, max(x - 1, 1)), ylim=limits)
    axes.set_xticks(list(ticks), list(ticks.values()))
    axes.tick_params(axis="x", length=0)
    axes.grid(visible=False, axis="x")
    if not means:
        say(axes, "no recordings")
