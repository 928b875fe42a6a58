"""S Figures 1 to 3, which need no recording: the Gaussian model, and the parts of an Allan
deviation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mocap_metrology.noise.cameras.scaling import fit_scaling
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.noise.twins.published import published_gaussian
from mocap_metrology.papers.white_noise import white_roots
from mocap_metrology.present.plot.curves import Limits
from mocap_metrology.present.plot.figure import (
    GREY,
    INK,
    LOOKS,
    OTHER_LOOKS,
    SMALL_PT,
    Keywords,
    Look,
    Picture,
    legend_below,
    letters,
    log_axes,
    new_figure,
    styled,
)
from mocap_metrology.present.skurowski.densities import SETS, normal
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.captions import PAPER

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLE_1 = f"{PAPER}, Figure 1: Gaussian model of two markers"
TITLE_2 = f"{PAPER}, Figure 2: standard error of the mean of N"
TITLE_3 = f"{PAPER}, Figure 3: parts of an Allan deviation and their slopes"
SOURCE_1 = "Source: computed from Table 4 of the paper, row T40."
SOURCE_2 = "Source: computed from Equation 3 and Tables A1-A3 of the paper."
SOURCE_3 = "Source: computed from noise models."
MOST_N = 12
LENGTHS = (
    (r"$\sigma_C$ = {:.1f} µm, correlated", "sigma_C_mm", OTHER_LOOKS[0]),
    (r"$\sigma_B$ = {:.1f} µm, independent", "sigma_B_mm", LOOKS["y"]),
    (r"$\sigma_A$ = {:.1f} µm, as marker 1", "sigma_A1_mm", LOOKS["x"]),
    (r"$\sigma_A$ = {:.1f} µm, as marker 2", "sigma_A2_mm", LOOKS["z"]),
)
RATE_HZ = 1000.0
TAU = np.geomspace(1e-3, 1e5, 2401)
MM_PT = 72 / 25.4  # points in a millimetre
LINE = Sinusoid(0.12, 3.0)
RESOLVED = 6.0  # periods of a sinusoid up to which its bumps are drawn one by one


@styled()
def model_figure(row: Mapping[str, float] | None = None, title: str = TITLE_1) -> Picture:
    """S Figure 1 of a row of Table 4 (default T40): where the markers are, and the densities."""
    row = published_gaussian("T40") if row is None else row
    panels = {
        f"Marker {k}": ((rf"$\sigma_{k}$ = {{:.1f}} µm", f"sigma_{k}_mm", LOOKS["x"]),)
        for k in (2, 1)
    } | {"Distance": LENGTHS}
    sigmas = [1000 * row[column] for parts in panels.values() for _, column, _ in parts]
    reach = 3.3 * max(sigmas)
    body = new_figure(title, SOURCE_1, 100.0)
    grid = body.subplot_mosaic([["wand"] * 3, list(panels)], height_ratios=(1, 3))
    _wand(grid["wand"], row)
    x = np.linspace(-reach, reach, 601)
    for name, parts in panels.items():
        axes, symbol = grid[name], name[-1] if name[-1].isdigit() else "e"
        words = [rf"$\mu_{symbol}$ = {row[f'mu_{symbol}_mm']:.4f} mm"]
        for text, column, look in parts:
            sigma = 1000 * row[column]
            (line,) = axes.plot(x, normal(x, sigma), color=look.colour, ls=look.dashes)
            if len(parts) > 1:
                line.set_label(text.format(sigma))
            else:
                words.append(text.format(sigma))
        how: Keywords = {"transform": axes.transAxes, "va": "top", "ha": "right", "color": GREY}
        axes.text(0.97, 0.96, "\n".join(words), size=SMALL_PT, **how)
        axes.set(xlim=(-reach, reach), ylim=(0, 1.3 * normal(np.zeros(1), min(sigmas))[0]))
        left = "$L$" if symbol == "e" else rf"$x_{symbol}$"
        axes.set(title=name, xlabel=rf"{left} − $\mu_{symbol}$ (µm)")
        axes.tick_params(labelleft=name == "Marker 2")
    grid["Marker 2"].set_ylabel("Density (1/µm)")
    legend_below(body, grid.values())
    return Picture(body, captions.SKUROWSKI[1])


def _wand(axes: Axes, row: Mapping[str, float]) -> None:
    """The two markers on their common axis, to scale, and what is between them."""
    places = {row["mu_1_mm"]: "marker 1", row["mu_2_mm"]: "marker 2"}
    low, high = min(places), max(places)
    pad = 0.06 * (high - low)
    axes.set(xlim=(low - pad, high + pad), ylim=(0, 1.2), yticks=[], xlabel="x (mm)")
    axes.grid(visible=False)
    axes.spines[["left", "right", "top"]].set_visible(False)
    axes.axhline(0.3, color=GREY, lw=1.5, zorder=1)
    axes.plot([low, high], [0.3, 0.3], ls="", marker="o", ms=9, color=LOOKS["x"].colour)
    arrow = {"arrowstyle": "<->", "color": INK, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (low, 0.72), (high, 0.72), arrowprops=arrow)
    text = rf"$L = x_1 - x_2$,  $\mu_e$ = {row['mu_e_mm']:.4f} mm"
    axes.text((low + high) / 2, 0.8, text, ha="center", va="bottom")
    for place, name in places.items():
        axes.text(place, 0.8, name, ha="center", va="bottom", size=SMALL_PT, color=GREY)


@styled()
def standard_error_figure(title: str = TITLE_2) -> Picture:
    """S Figure 2, with the printed white noise beside the law."""
    body = new_figure(title, SOURCE_2, 95.0)
    axes = body.subplots()
    n = np.linspace(1, MOST_N, 400)
    axes.plot(n, 1 / np.sqrt(n), color=INK, lw=1.4, label=r"$\sigma/\sqrt{N}$")
    for (kind, (cameras, roots)), shift in zip(
        white_roots().items(), (-0.08, 0.0, 0.08), strict=True
    ):
        fit = fit_scaling(cameras, roots)
        if fit is None:
            continue
        text = f"{kind}: exponent {fit.exponent:.2f} ± {fit.exponent_error:.2f}".replace("-", "−")
        how = SETS[kind].line(ls="", markersize=4.2, label=text)
        axes.plot(cameras + shift, roots / fit.one, **how)
    axes.set(xlim=(0.5, MOST_N + 0.5), xticks=range(1, MOST_N + 1))
    axes.set_ylim(0, 1.05 * axes.get_ylim()[1])
    axes.set(xlabel="Number of observations N, or of cameras", ylabel=r"Standard error ($\sigma$)")
    legend_below(body, [axes])
    return Picture(body, captions.SKUROWSKI[2])


class Part(NamedTuple):
    """A component with its name and look, and at which tau (s) its slope is written, how far off
    the curve in mm."""

    name: str
    component: PowerLaw | GaussMarkov | Sinusoid
    look: Look
    at: Sequence[tuple[float, tuple[float, float]]] = ()


POWER_LAWS = (
    Part("violet", PowerLaw(2, 6e-7), OTHER_LOOKS[2], [(4e-3, (2.5, 2.5))]),
    Part("white", PowerLaw(0, 2e-3), LOOKS["x"], [(1.2, (2.0, 2.0))]),
    Part("flicker", PowerLaw(-1, 7.2e-5), LOOKS["z"], [(1.8e2, (0.0, 4.0))]),
    Part("random walk", PowerLaw(-2, 4.8e-9), LOOKS["y"], [(3e4, (-3.0, 3.5))]),
)
BUMP = GaussMarkov(4e-3, 60.0)
BUMP_AT = [(0.06, (-3.0, 2.5)), (1.5e3, (2.5, 3.0))]
OTHERS = (
    Part("white", PowerLaw(0, 2e-5), LOOKS["x"], [(4e-3, (3.0, 3.0))]),
    Part("sinusoid", LINE, OTHER_LOOKS[1], [(1e-2, (-3.5, 2.0)), (0.9, (3.5, 3.0))]),
    Part("correlated (Gauss-Markov)", BUMP, OTHER_LOOKS[0], BUMP_AT),
    Part("random walk", PowerLaw(-2, 2e-11), LOOKS["y"], [(4.5e4, (-3.0, 3.0))]),
)


def deviation(components: Sequence[PowerLaw | GaussMarkov | Sinusoid]) -> np.ndarray:
    """ADEV over TAU of a sum, continuous form; of a sinusoid past RESOLVED periods its mean over
    them, 3/8 of what the bumps reach."""
    broad = tuple(c for c in components if not isinstance(c, Sinusoid))
    avar = NoiseModel(broad).avar(TAU * RATE_HZ, RATE_HZ, "continuous")
    for line in (c for c in components if isinstance(c, Sinusoid)):
        exact = line.avar(TAU * RATE_HZ, RATE_HZ, "continuous")
        avar = avar + np.where(line.f_0 * TAU > RESOLVED, 3 / 8 * envelope(line) ** 2, exact)
    adev: np.ndarray = np.sqrt(avar)
    return adev


def slope_at(curve: np.ndarray, tau: float) -> float:
    """Log-log slope of a curve over TAU round tau: over an eighth of a decade to each side."""
    low, high = (int(np.abs(np.log(TAU / (tau * f))).argmin()) for f in (10**-0.125, 10**0.125))
    return float(np.log(curve[high] / curve[low]) / np.log(TAU[high] / TAU[low]))


def envelope(line: Sinusoid) -> np.ndarray:
    """What the bumps of a sinusoid reach: A sin^2(x)/x, x = pi f tau, up to the first, then A/x."""
    x = np.pi * line.f_0 * TAU
    return np.where(x < np.pi / 2, np.sin(x) ** 2, 1.0) * line.A_s / x


def slope_text(slope: float) -> str:
    """−½, or to two decimals where it is none of the slopes of power laws."""
    for value, text in ((-1.0, "−1"), (-0.5, "−½"), (0.0, "0"), (0.5, "+½"), (1.0, "+1")):
        if abs(slope - value) < 0.05:
            return text
    return f"{slope:+.2f}".replace("-", "−")


@styled()
def slopes_figure(title: str = TITLE_3) -> Picture:
    """S Figure 3 in two panels: the colours, then correlated and periodic noise."""
    body = new_figure(title, SOURCE_3, 105.0)
    grid = body.subplots(1, 2)
    for axes, name, parts in zip(
        grid, ("Power laws", "Correlated and periodic noise"), (POWER_LAWS, OTHERS), strict=True
    ):
        _draw(axes, parts)
        axes.set(title=name, xlabel=r"Averaging time $\tau$ (s)", ylabel="Allan deviation (mm)")
    letters(grid)
    legend_below(body, grid, columns=4)
    return Picture(body, captions.SKUROWSKI[3])


def _draw(axes: Axes, parts: Sequence[Part]) -> None:
    from matplotlib.ticker import LogFormatterMathtext

    total = deviation([part.component for part in parts])
    limits: Limits = float(total.min()) / 6, float(total.max()) * 3
    log_axes(axes, ((TAU[0], TAU[-1]), limits))
    axes.yaxis.set_major_formatter(LogFormatterMathtext())  # alike in both panels
    axes.plot(TAU, total, color=INK, lw=2.6, alpha=0.35, label="their sum")
    for part in parts:
        smooth = curve = deviation([part.component])
        if isinstance(part.component, Sinusoid):
            smooth, whole = envelope(part.component), part.component.f_0 * TAU <= RESOLVED
            curve = np.where(whole, curve, smooth)
        look = part.look
        axes.plot(TAU, curve, color=look.colour, ls=look.dashes, lw=1.0, label=part.name)
        for tau, (right, up) in part.at:
            y = float(np.interp(np.log(tau), np.log(TAU), smooth))
            how: Keywords = {"ha": "center", "va": "center", "weight": "bold"}
            how |= {"textcoords": "offset points", "color": look.colour}
            text, off_pt = slope_text(slope_at(smooth, tau)), (right * MM_PT, up * MM_PT)
            axes.annotate(text, (tau, y), off_pt, **how)
