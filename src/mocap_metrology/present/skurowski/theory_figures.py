"""S Figures 1 to 3, which need no recording: the Gaussian model, and the parts of an Allan
deviation; figures of both papers that are not regenerated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from mocap_metrology.noise.cameras.scaling import fit_scaling
from mocap_metrology.noise.model.components import GaussMarkov, PowerLaw, Sinusoid
from mocap_metrology.noise.twins.published import published_gaussian
from mocap_metrology.papers import power_laws as laws
from mocap_metrology.present.plot import figure as fig
from mocap_metrology.present.skurowski.gaussian_figures import SETS, normal
from mocap_metrology.present.tables import Row
from mocap_metrology.present.text import captions

MOST_N = 12
LENGTHS = {
    "sigma_C_mm": (r"$\sigma_C$ = {:.1f} µm, correlated", fig.OTHER_LOOKS[0]),
    "sigma_B_mm": (r"$\sigma_B$ = {:.1f} µm, independent", fig.LOOKS["y"]),
    "sigma_A1_mm": (r"$\sigma_A$ = {:.1f} µm, as marker 1", fig.LOOKS["x"]),
    "sigma_A2_mm": (r"$\sigma_A$ = {:.1f} µm, as marker 2", fig.LOOKS["z"]),
}
MM_PT = 72 / 25.4  # points in a millimetre


@fig.styled()
def model_figure() -> fig.Picture:
    """S Figure 1, of row T40 of Table 4: where the markers are, and the densities."""
    row = published_gaussian("T40")
    panels = {f"Marker {k}": {f"sigma_{k}_mm": ("", fig.LOOKS["x"])} for k in (2, 1)}
    panels["Distance"] = LENGTHS
    source = "Source: computed from Table 4 of the paper, row T40."
    texts = captions.of_figure("skurowski", 1, source)
    body = fig.new_figure(texts, 100.0)
    grid = body.subplot_mosaic([["wand"] * 3, list(panels)], height_ratios=(1, 3))
    _wand(grid["wand"], row)
    sigmas = [1000 * row[name] for parts in panels.values() for name in parts]
    reach = 3.3 * max(sigmas)
    x = np.linspace(-reach, reach, 601)
    for panel, parts in panels.items():
        axes, symbol = grid[panel], panel[-1] if panel[-1].isdigit() else "e"
        text = rf"$\mu_{symbol}$ = {row[f'mu_{symbol}_mm']:.4f} mm"
        for name, (label, look) in parts.items():
            how: fig.Keywords = {"label": label.format(1000 * row[name])} if label else {}
            y = normal(x, 1000 * row[name])
            axes.plot(x, y, color=look.colour, ls=look.dashes, **how)
            text += "" if label else f"\n$\\sigma_{symbol}$ = {1000 * row[name]:.1f} µm"
        place: fig.Keywords = {"transform": axes.transAxes, "va": "top", "ha": "right"}
        axes.text(0.97, 0.96, text, size=fig.SMALL_PT, color=fig.GREY, **place)
        axes.set(xlim=(-reach, reach), ylim=(0, 1.3 * normal(np.zeros(1), min(sigmas))[0]))
        left = "$L$" if symbol == "e" else rf"$x_{symbol}$"
        axes.set(title=panel, xlabel=rf"{left} − $\mu_{symbol}$ (µm)")
        axes.tick_params(labelleft=panel == "Marker 2")
    grid["Marker 2"].set_ylabel("Density (1/µm)")
    return fig.finished(body, grid.values(), texts.caption)


def _wand(axes: fig.Axes, row: Mapping[str, float]) -> None:
    """The two markers on their common axis, to scale, and what is between them."""
    low, high = row["mu_2_mm"], row["mu_1_mm"]
    pad = 0.06 * (high - low)
    axes.set(xlim=(low - pad, high + pad), ylim=(0, 1.2), yticks=[], xlabel="x (mm)")
    axes.grid(visible=False)
    axes.spines[["left", "right", "top"]].set_visible(False)
    axes.axhline(0.3, color=fig.GREY, lw=1.5, zorder=1)
    axes.plot([low, high], [0.3, 0.3], ls="", marker="o", ms=9, color=fig.LOOKS["x"].colour)
    arrow = {"arrowstyle": "<->", "color": fig.INK, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (low, 0.72), (high, 0.72), arrowprops=arrow)
    text = rf"$L = x_1 - x_2$,  $\mu_e$ = {row['mu_e_mm']:.4f} mm"
    axes.text((low + high) / 2, 0.8, text, ha="center", va="bottom")
    for place, name in ((low, "marker 2"), (high, "marker 1")):
        axes.text(place, 0.8, name, ha="center", va="bottom", size=fig.SMALL_PT, color=fig.GREY)


@fig.styled()
def standard_error_figure() -> fig.Picture:
    """S Figure 2, with the printed white noise beside the law."""
    source = "Source: computed from Equation 3 and Tables A1-A3 of the paper."
    texts = captions.of_figure("skurowski", 2, source)
    body = fig.new_figure(texts, 95.0)
    axes = body.subplots()
    n = np.linspace(1, MOST_N, 400)
    axes.plot(n, 1 / np.sqrt(n), color=fig.INK, lw=1.4, label=r"$\sigma/\sqrt{N}$")
    roots_of = laws.white_roots().items()
    for shift, (kind, (cameras, roots)) in zip((-0.08, 0, 0.08), roots_of, strict=True):
        fit = fit_scaling(cameras, roots)
        assert fit is not None  # the printed numbers are positive
        text = f"{kind}: exponent {fit.exponent:.2f} ± {fit.exponent_error:.2f}".replace("-", "−")
        how = SETS[kind].line(ls="", markersize=4.2, label=text)
        axes.plot(cameras + shift, roots / fit.one, **how)
    axes.set(xlim=(0.5, MOST_N + 0.5), xticks=range(1, MOST_N + 1))
    axes.set_ylim(0, 1.05 * axes.get_ylim()[1])
    axes.set(xlabel="Number of observations N, or of cameras", ylabel=r"Standard error ($\sigma$)")
    return fig.finished(body, [axes], texts.caption)


class Part(NamedTuple):
    """A component with its name and look, and at which tau (s) its slope is written, how far off
    the curve in mm."""

    name: str
    component: PowerLaw | GaussMarkov | Sinusoid
    look: fig.Look
    at: Sequence[tuple[float, tuple[float, float]]] = ()


SINUSOID, CORRELATED, TERM = Sinusoid(0.12, 3.0), "correlated (Gauss-Markov)", GaussMarkov(4e-3, 60)
PANELS = {
    "Power laws": (
        Part("violet", PowerLaw(2, 6e-7), fig.OTHER_LOOKS[2], [(4e-3, (2.5, 2.5))]),
        Part("white", PowerLaw(0, 2e-3), fig.LOOKS["x"], [(1.2, (2.0, 2.0))]),
        Part("flicker", PowerLaw(-1, 7.2e-5), fig.LOOKS["z"], [(1.8e2, (0.0, 4.0))]),
        Part("random walk", PowerLaw(-2, 4.8e-9), fig.LOOKS["y"], [(3e4, (-3.0, 3.5))]),
    ),
    "Correlated and periodic noise": (
        Part("white", PowerLaw(0, 2e-5), fig.LOOKS["x"], [(4e-3, (3.0, 3.0))]),
        Part("sinusoid", SINUSOID, fig.OTHER_LOOKS[1], [(1e-2, (-3.5, 2)), (0.9, (3.5, 3))]),
        Part(CORRELATED, TERM, fig.OTHER_LOOKS[0], [(0.06, (-3, 2.5)), (1.5e3, (2.5, 3))]),
        Part("random walk", PowerLaw(-2, 2e-11), fig.LOOKS["y"], [(4.5e4, (-3.0, 3.0))]),
    ),
}


def slope_text(slope: float) -> str:
    """−½, or to two decimals where it is none of the slopes of power laws."""
    halves = {-2: "−1", -1: "−½", 0: "0", 1: "+½", 2: "+1"}
    text = halves.get(round(2 * slope)) if abs(2 * slope - round(2 * slope)) < 0.1 else None
    return text or f"{slope:+.2f}".replace("-", "−")


@fig.styled()
def slopes_figure() -> fig.Picture:
    """S Figure 3 in two panels: the colours, then correlated and periodic noise."""
    from matplotlib.ticker import LogFormatterMathtext

    texts = captions.of_figure("skurowski", 3, "Source: computed from noise models.")
    body = fig.new_figure(texts, 105.0)
    grid = body.subplots(1, 2)
    for axes, (panel, parts) in zip(grid, PANELS.items(), strict=True):
        total = laws.deviation([part.component for part in parts])
        fig.log_axes(axes, ((laws.TAU[0], laws.TAU[-1]), (total.min() / 6, total.max() * 3)))
        axes.yaxis.set_major_formatter(LogFormatterMathtext())  # alike in both panels
        axes.plot(laws.TAU, total, color=fig.INK, lw=2.6, alpha=0.35, label="their sum")
        for name, component, look, at in parts:
            smooth = curve = laws.deviation([component])
            if isinstance(component, Sinusoid):
                smooth = laws.envelope(component)
                curve = np.where(component.f_0 * laws.TAU <= laws.RESOLVED, curve, smooth)
            axes.plot(laws.TAU, curve, color=look.colour, ls=look.dashes, lw=1.0, label=name)
            for tau, (right, up) in at:
                y = float(np.interp(np.log(tau), np.log(laws.TAU), smooth))
                how: fig.Keywords = {"ha": "center", "va": "center", "weight": "bold"}
                how |= {"textcoords": "offset points", "color": look.colour}
                text = slope_text(laws.slope_at(smooth, tau))
                axes.annotate(text, (tau, y), (right * MM_PT, up * MM_PT), **how)
        axes.set(title=panel, xlabel=r"Averaging time $\tau$ (s)", ylabel="Allan deviation (mm)")
    fig.letters(grid)
    return fig.finished(body, grid, texts.caption, columns=4)


# ---- Figures of the two papers that are not regenerated, and why

OF_LEFT_OUT = ("paper", "figure", "shows", "reason")
S, J = captions.PAPERS["skurowski"], captions.PAPERS["jansen"]
LEFT_OUT = (
    (S, "Figure 4", "camera locations: a view in Vicon Blade and a photograph of the laboratory",
     "a photograph, and places of cameras of which the paper prints no coordinates"),
    (S, "Figure 5", "drawing of the calibration wand (T-frame)",
     "a drawing of a vendor's part, without data"),
    (J, "Fig. 1", "a person with receivers on the limbs, and the pose found",
     "a photograph of an earlier experiment (reference 19 there); its recording was not published"),
    (J, "Fig. 2", "illustration of a Lighthouse seen from the front",
     "an illustration of the device, without data"),
    (J, "Fig. 4", "the calibration board with its 32 photodiodes",
     "a photograph; the diodes' places are in the board file of each calibration"),
    (J, "Fig. 9", "two Lighthouses with markers for motion capture",
     "a photograph; the twins' marker mounts are in their mount files"),
)  # fmt: skip


def left_out() -> list[Row]:
    """One row a figure."""
    return [dict(zip(OF_LEFT_OUT, line, strict=True)) for line in LEFT_OUT]
