"""S Figures 9 to 11: densities of location and distance, means of the distance, and standard
deviations and covariances against the number of cameras, which is drawn of any group."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pandas as pd

from mocap_metrology.noise.cameras.scaling import Scaling, fit_scaling
from mocap_metrology.noise.gaussian.two_markers import kernel_density
from mocap_metrology.present.plot import figure as fig
from mocap_metrology.present.plot.curves import groups_of, label_outer, log_limits
from mocap_metrology.present.plot.figure import GREY, INK, LOOKS, OTHER_LOOKS, SMALL_PT
from mocap_metrology.present.text import captions

SETS = dict(
    zip(("T40", "Bonita", "Vantage", "All"), (*LOOKS.values(), OTHER_LOOKS[0]), strict=True)
)
FAR = 8.0  # times the median distance from the median
LEAST_DENSITY = 0.02  # 1/mm, the lower end of the logarithmic axis
PRINTED: fig.Keywords = {"ls": (0, (1.2, 1.2)), "lw": 0.8}
Numbers = Mapping[str, float]  # a row of Table 4
Arrays = Mapping[str, np.ndarray]


def normal(x: np.ndarray, sigma: float) -> np.ndarray:
    """Density of N(0, sigma)."""
    density: np.ndarray = np.exp(-0.5 * (x / sigma) ** 2) / (sigma * np.sqrt(2 * np.pi))
    return density


@fig.styled()
def locations_figure(
    series: Arrays, published: Numbers | None, source: str, *more: str
) -> fig.Picture:
    """S Figure 9 of x1 and x2 (n,) in mm, beside a row of Table 4 (or None: of no row, and zero is
    the recording's own mean)."""
    texts = captions.of_figure("skurowski", 9, source, *more)
    body = fig.new_figure(texts, 85.0)
    grid = body.subplots(1, 2, sharey=True)
    fill: fig.Keywords = {"color": LOOKS["x"].colour, "alpha": 0.3, "lw": 0}
    for k, axes in enumerate(grid, start=1):
        middle = float(np.nanmean(series[f"x{k}"]))
        zero = published[f"mu_{k}_mm"] if published else middle
        offset = 1000 * (series[f"x{k}"] - zero)
        printed = 1000 * published[f"sigma_{k}_mm"] if published else 0.0
        mean, sigma = float(np.nanmean(offset)), float(np.nanstd(offset, ddof=1))
        low, high = min(mean - 4 * sigma, -3.5 * printed), max(mean + 4 * sigma, 3.5 * printed)
        axes.set_xlim((low, high) if low < high else (-1.0, 1.0))
        density = kernel_density(offset)
        axes.fill_between(density.x, density.density, label="kernel estimate", **fill)
        x = np.linspace(low, high, 801)
        for centre, width, look, text in (
            (mean, sigma, LOOKS["x"], "normal, its own moments"),
            (0.0, printed, LOOKS["y"], "normal, Table 4"),
        ):
            if width > 0:
                how: fig.Keywords = {"color": look.colour, "ls": look.dashes, "label": text}
                axes.plot(x, normal(x - centre, width), **how)
        fig.panel_title(axes, f"Marker {k}", f"mean {middle:.4f} mm, SD {sigma:.1f} µm")
        axes.set_xlabel(f"$x_{k}$ − {zero:.4f} mm (µm)")
    grid[0].set(ylabel="Density (1/µm)", ylim=(0, None))
    return fig.finished(body, grid, texts.caption)


@fig.styled()
def distances_figure(
    distance: Arrays, published: Mapping[str, Numbers], means: pd.DataFrame, source: str, *more: str
) -> fig.Picture:
    """S Figure 10: densities of L (n,) in mm by set (T40, Bonita, Vantage, All) beside the rows of
    Table 4, and the means of L of every subset (`papers.subsets.means_of_distance`)."""
    texts = captions.of_figure("skurowski", 10, source, *more)
    body = fig.new_figure(texts, 150.0)
    above, below = body.subplots(2)
    for name, values in distance.items():
        look = SETS.get(name, OTHER_LOOKS[1])
        density = kernel_density(values)
        how: fig.Keywords = {"color": look.colour, "ls": look.dashes, "label": fig.short(name)}
        above.plot(density.x, density.density, **how)
        if name in published:
            mu, sigma = (published[name][f"{key}_L_mm"] for key in ("mu", "sigma"))
            x = np.linspace(mu - 4 * sigma, mu + 4 * sigma, 401)
            above.plot(x, normal(x - mu, sigma), color=look.colour, **PRINTED)
    if set(distance) & set(published):
        above.plot([], [], color=GREY, label="normal, Table 4", **PRINTED)
    peak = max((float(np.max(line.get_ydata(), initial=0)) for line in above.lines), default=0.0)
    fig.log_axis(above, "y", (LEAST_DENSITY, 2 * peak or 2.0))
    above.set(title="(a) Densities of the distance L", xlabel="L (mm)", ylabel="Density (1/mm)")
    _means(below, means)
    below.set(title="(b) Means", xlabel="Number of cameras", ylabel="Mean of L (mm)")
    return fig.finished(body, [above], texts.caption)


def _means(axes: fig.Axes, means: pd.DataFrame) -> None:
    """A point a subset, a group a type; an arrow with a number where a mean is farther from the
    median than `FAR` of what is usual: one alone would flatten all others."""
    if means.empty:
        fig.write_message(axes, "no recordings")
        return
    off = (means["value"] - means["value"].median()).abs()
    near = means[off <= FAR * (off.median() or math.inf)]
    shown = near[["value", "published"]].stack()
    bars = near["error"].fillna(0.0).clip(upper=np.ptp(shown))
    ends = [*shown, *(near["value"] - bars), *(near["value"] + bars)]
    room = np.ptp(ends) or 1.0
    low, high = min(ends) - 0.08 * room, max(ends) + 0.18 * room
    x, ticks = 0, {}
    small: fig.Keywords = {"size": SMALL_PT, "va": "center"}
    for kind, of_kind in groups_of(means.sort_values("n_cameras", kind="stable"), "camera_type"):
        look, left = SETS.get(kind, OTHER_LOOKS[1]), x
        for at, n, value, error in of_kind[["n_cameras", "value", "error"]].itertuples():
            ticks[x] = n
            if at in near.index:
                how: fig.Keywords = {"color": look.colour, "marker": look.marker, "lw": 0.9}
                axes.errorbar(x, value, yerr=error, capsize=1.5, **how)
            else:
                up = value > high
                y = low + (0.86 if up else 0.03) * (high - low)
                axes.plot(x, y, marker=6 if up else 7, color=look.colour, markersize=5)
                place: fig.Keywords = {"xytext": (4, 0), "textcoords": "offset points"}
                axes.annotate(f"{value:.2f}", (x, y), color=look.colour, **place, **small)
            x += 1
        how = {"color": look.colour, "ha": "center", "transform": axes.get_xaxis_transform()}
        axes.text((left + x - 1) / 2, 0.95, fig.short(kind) or "cameras", **how, **small)
        line: fig.Keywords = {"color": look.colour, "lw": 0.8, "alpha": 0.6}
        axes.hlines(of_kind["published"].iloc[:1], left - 0.6, x - 0.4, **line)
        axes.axvline(x, color=fig.FAINT, lw=0.8)
        x += 1
    axes.set(xlim=(-1, max(x - 1, 1)), ylim=(low, high))
    axes.set_xticks(list(ticks), list(map(str, ticks.values())))
    axes.tick_params(axis="x", length=0)
    axes.grid(visible=False, axis="x")


# ---- Figure 11, of any group

COLUMNS = 3
SQUARE_MM_FROM = 0.1  # covariances, mm²: smaller ones are shown in µm²
DECADES_FROM = 50.0  # range of covariances from which their axis is logarithmic
CLOSE = 0.83  # of the next larger number of cameras, from which its label would touch
SIGMA_12 = "sigma_12_mm2"
SECOND: fig.Keywords = {"color": LOOKS["z"].colour, "marker": "^", "mfc": "white"}
SERIES: dict[str, tuple[str, fig.Keywords, fig.Keywords]] = {  # name, look of points and of line
    "sigma_1_mm": ("marker 1", {"color": LOOKS["x"].colour, "marker": "o"}, {"ls": "-"}),
    "sigma_2_mm": ("marker 2", SECOND, {"ls": (0, (5, 1.6))}),
    "sigma_L_mm": ("distance", {"color": INK, "marker": "D"}, {"ls": (0, (1.2, 1.2))}),
}
COVARIANCE: fig.Keywords = {"color": "#4d4d4d", "marker": "X", "markersize": 4.6, "mew": 0.4}
EXPECTED: fig.Keywords = {"marker": "_", "markersize": 7.0, "mew": 1.1, "alpha": 0.75}
EXTRA: dict[str, tuple[str, fig.Keywords]] = {
    "expected": ("on average, by the coefficients", EXPECTED),
    "published": ("Table 4", {"marker": "*", "markersize": 8.0, "mew": 0.8, "mfc": "none"}),
}


def fits(spreads: pd.DataFrame) -> dict[str, Scaling | None]:
    """The law fitted to every series of one camera type."""
    rows = spreads[spreads["fitted"] & (spreads["kind"] == "row")]
    return {
        quantity: fit_scaling(*rows.loc[rows["quantity"] == quantity, ["n", "value"]].to_numpy().T)
        for quantity in SERIES
    }


@fig.styled()
def scaling_figure(
    spreads: pd.DataFrame, texts: fig.Texts, *, variances: bool = False
) -> fig.Picture:
    """S Figure 11 of any group, a column a camera type; `variances`, as in S, or standard
    deviations. spreads: of `papers.subsets`."""
    power = 1 + variances
    kinds = list(spreads["camera_type"].unique()) or [""]
    rows, columns = -(-len(kinds) // COLUMNS), min(len(kinds), COLUMNS)
    body = fig.new_figure(texts, 32.0 + 98.0 * rows)
    grid = body.subplots(2 * rows, columns, sharex=True, squeeze=False, height_ratios=(3, 2) * rows)
    above, below = grid[::2].ravel(), grid[1::2].ravel()
    n = sorted(set(spreads["n"])) or [1]
    fig.log_axis(grid[0, 0], "x", (n[0] / 1.2, n[-1] * 1.2))
    covariances = spreads[spreads["quantity"] == SIGMA_12]
    large = covariances["value"].abs().max() >= SQUARE_MM_FROM
    unit, per_mm2 = ("mm²", 1.0) if large else ("µm²", 1e6)
    limits = log_limits([spreads.loc[spreads["quantity"] != SIGMA_12, "value"] ** power])
    for kind, upper, lower in zip(kinds, above, below, strict=False):
        of_type = spreads[spreads["camera_type"] == kind]
        fig.log_axis(upper, "y", limits)
        _deviations(upper, of_type, power)
        _covariance_axis(lower, covariances["value"] * per_mm2)
        for of_kind, points in groups_of(of_type[of_type["quantity"] == SIGMA_12], "kind"):
            how = {"color": INK, **EXTRA[of_kind][1]} if of_kind in EXTRA else COVARIANCE
            lower.plot(points["n"], points["value"] * per_mm2, ls="", **how)
        for letter, axes in (("a", upper), ("b", lower)):
            axes.set_title(f"({letter}) {fig.short(kind, 16) or 'cameras'}")
            axes.tick_params(which="both", labelleft=axes.get_subplotspec().is_first_col())
    ticks = fig.room_for(n, CLOSE)
    above[0].set_xticks(ticks, [f"{k:g}" for k in ticks])
    above[0].set_xticks([], minor=True)
    label_outer(grid[1::2], len(kinds), ("Number of cameras", f"Covariance ({unit})"))
    for axes in above[: len(kinds) : columns]:
        axes.set_ylabel("Variance (mm²)" if variances else "Standard deviation (mm)")
    for axes in (*above[len(kinds) :], *below[len(kinds) :]):
        axes.axis("off")
    for name, look, _ in SERIES.values():
        below[0].plot([], [], label=name, ls="", **look)
    below[0].plot([], [], label="covariance", ls="", **COVARIANCE)
    law = r"$\sigma^2/n$" if variances else r"$\sigma/\sqrt{n}$"
    below[0].plot([], [], label=law, color=GREY, lw=1.0)
    for kind in (kind for kind in EXTRA if kind in set(spreads["kind"])):
        below[0].plot([], [], label=EXTRA[kind][0], color=GREY, ls="", **EXTRA[kind][1])
    return fig.finished(body, [below[0]], texts.caption)


def _deviations(axes: fig.Axes, spreads: pd.DataFrame, power: int) -> None:
    """Standard deviations to that power with the law fitted to them; a legend of the exponents."""
    curve, laws = np.geomspace(*axes.get_xlim(), 50), fits(spreads)
    for quantity, (name, look, line) in SERIES.items():
        fit = laws[quantity]
        if fit is not None:
            error = power * fit.exponent_error
            more = "" if math.isnan(error) else f" ± {error:.2f}"
            text = f"{name}  {power * fit.exponent:.2f}{more}".replace("-", "−")
            how = {"color": look["color"], "lw": 0.9, "label": text} | line
            axes.plot(curve, fit.law(curve) ** power, **how)
        for kind, points in groups_of(spreads[spreads["quantity"] == quantity], "kind"):
            how = {"color": look["color"], **EXTRA[kind][1]} if kind in EXTRA else look
            axes.plot(points["n"], points["value"] ** power, ls="", **how)
    if any(laws.values()):
        legend = axes.legend(title="exponent of n", loc="best", handlelength=1.6, fontsize=SMALL_PT)
        legend.get_title().set(fontsize=SMALL_PT, color=GREY)


def _covariance_axis(axes: fig.Axes, values: pd.Series) -> None:
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
