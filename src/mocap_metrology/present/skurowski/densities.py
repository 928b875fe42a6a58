"""S Figures 9 and 10: kernel estimates of densities of location and distance, and the means."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
    Look,
    Picture,
    legend_below,
    log_axis,
    new_figure,
    panel_title,
    say,
    short,
    styled,
)
from mocap_metrology.present.skurowski.theory_figures import KINDS, PAPER, normal
from mocap_metrology.present.text import captions

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLE_9 = f"{PAPER}, Figure 9: where the markers were seen"
TITLE_10 = f"{PAPER}, Figure 10: one distance, several sets of cameras"
SETS = KINDS | {"All": OTHER_LOOKS[0]}
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
    for k, axes in enumerate(grid, start=1):
        values = series[f"x{k}"]
        own = float(np.nanmean(values))
        zero = published[f"mu_{k}_mm"] if published else own
        sigma_um = _location(
            axes, 1000 * (values - zero), 1000 * published[f"sigma_{k}_mm"] if published else 0.0
        )
        panel_title(axes, f"Marker {k}", f"mean {own:.4f} mm, SD {sigma_um:.1f} µm")
        axes.set_xlabel(f"$x_{k}$ − {zero:.4f} mm (µm)")
    grid[0].set(ylabel="Density (1/µm)", ylim=(0, None))
    legend_below(body, grid)
    return Picture(body, f"{captions.SKUROWSKI[9]} {remarks}")


def _location(axes: Axes, offset_um: np.ndarray, published_um: float) -> float:
    """Density of offsets, and the normal ones; their own standard deviation, µm."""
    found = kernel_density(offset_um)
    mean, sigma = float(np.nanmean(offset_um)), float(np.nanstd(offset_um, ddof=1))
    low = min(mean - 4 * sigma, -3.5 * published_um)
    high = max(mean + 4 * sigma, 3.5 * published_um)
    x = np.linspace(low, high, 801)
    axes.set_xlim((low, high) if low < high else (-1.0, 1.0))
    how: Keywords = {"color": LOOKS["x"].colour, "alpha": 0.3, "lw": 0}
    axes.fill_between(found.x, found.density, label="kernel estimate", **how)
    for centre, width, look, text in (
        (mean, sigma, LOOKS["x"], "normal, its own moments"),
        (0.0, published_um, LOOKS["y"], "normal, Table 4"),
    ):
        if width > 0:
            axes.plot(x, normal(x - centre, width), color=look.colour, ls=look.dashes, label=text)
    return sigma


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
    found = {name: kernel_density(values) for name, values in distance.items()}
    rows = {name: (published[name]["mu_L_mm"], published[name]["sigma_L_mm"]) for name in distance
            if name in published}  # fmt: skip
    low = min((mu - 4 * s for mu, s in rows.values()), default=0.0)
    high = max((mu + 4 * s for mu, s in rows.values()), default=1.0)
    ends = [(d.x[0], d.x[-1]) for d in found.values() if d.x.size]
    low, high = min([low, *(e[0] for e in ends)]), max([high, *(e[1] for e in ends)])
    peaks = [d.density.max() for d in found.values() if d.x.size]
    peaks += [normal(np.zeros(1), s)[0] for _, s in rows.values()]
    axes.set_xlim(low, high)
    log_axis(axes, "y", (LEAST_DENSITY, 2 * max(peaks, default=1.0)))
    x = np.linspace(low, high, 2001)
    for name, d in found.items():
        look = SETS.get(name, OTHER_LOOKS[1])
        axes.plot(d.x, d.density, color=look.colour, ls=look.dashes, label=short(name))
        if name in rows:
            axes.plot(x, normal(x - rows[name][0], rows[name][1]), color=look.colour, **PRINTED)
    if rows:
        axes.plot([], [], color=GREY, label="normal, Table 4", **PRINTED)


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


def _means(axes: Axes, means: Sequence[Mean]) -> None:
    """A point a subset, a group a type."""
    kinds = list(dict.fromkeys(mean.camera_type for mean in means))
    limits, x, ticks = _mean_limits(means), 0.0, {}
    for kind in kinds:
        own = [mean for mean in means if mean.camera_type == kind]
        own.sort(key=lambda mean: mean.n_cameras)  # as in Figure 11
        look, left = SETS.get(kind, OTHER_LOOKS[1]), x
        for mean in own:
            ticks[x] = str(mean.n_cameras)
            if limits[0] <= mean.value <= limits[1]:
                how: Keywords = {"color": look.colour, "marker": look.marker, "lw": 0.9}
                axes.errorbar(x, mean.value, yerr=mean.error, capsize=1.5, **how)
            else:
                _far_mean(axes, x, mean.value, limits, look)
            x += 1
        text: Keywords = {"ha": "center", "va": "top", "size": SMALL_PT, "color": look.colour}
        place = (left + x - 1) / 2, 0.97
        axes.text(*place, short(kind) or "cameras", transform=axes.get_xaxis_transform(), **text)
        if own[0].published is not None:
            axes.hlines(own[0].published, left - 0.6, x - 0.4, color=look.colour, lw=0.8, alpha=0.6)
        axes.axvline(x, color=FAINT, lw=0.8)
        x += 1
    axes.set(xlim=(-1, max(x - 1, 1)), ylim=limits)
    axes.set_xticks(list(ticks), list(ticks.values()))
    axes.tick_params(axis="x", length=0)
    axes.grid(visible=False, axis="x")
    if not means:
        say(axes, "no recordings")
