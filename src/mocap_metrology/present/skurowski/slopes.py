"""S Figure 3: what the parts of an Allan deviation look like, computed from noise models."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.present.plot.curves import Limits
from mocap_metrology.present.plot.figure import (
    INK,
    LOOKS,
    OTHER_LOOKS,
    Keywords,
    Look,
    Picture,
    legend_below,
    letters,
    log_axes,
    new_figure,
    styled,
)
from mocap_metrology.present.text import captions

if TYPE_CHECKING:
    from matplotlib.axes import Axes

TITLE = "Skurowski & Pawlyta 2019, Figure 3: parts of an Allan deviation and their slopes"
SOURCE = "Source: computed from noise models."
FRAME_RATE_HZ = 1000.0
TAU0 = 1 / FRAME_RATE_HZ
TAU = np.geomspace(1e-3, 1e5, 2401)
MM_PT = 72 / 25.4  # points in a millimetre
LINE = Sinusoid(0.12, 3.0)
RESOLVED = 6.0  # periods of a sinusoid up to which its bumps are drawn one by one


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
OTHERS = (
    Part("white", PowerLaw(0, 2e-5), LOOKS["x"], [(4e-3, (3.0, 3.0))]),
    Part("sinusoid", LINE, OTHER_LOOKS[1], [(1e-2, (-3.5, 2.0)), (0.9, (3.5, 3.0))]),
    Part(
        "correlated (Gauss-Markov)",
        GaussMarkov(4e-3, 60.0),
        OTHER_LOOKS[0],
        [(0.06, (-3.0, 2.5)), (1.5e3, (2.5, 3.0))],
    ),
    Part("random walk", PowerLaw(-2, 2e-11), LOOKS["y"], [(4.5e4, (-3.0, 3.0))]),
)


def deviation(components: Sequence[PowerLaw | GaussMarkov | Sinusoid]) -> np.ndarray:
    """ADEV over TAU of a sum, continuous form; of a sinusoid past RESOLVED periods its mean over
    them, 3/8 of what the bumps reach."""
    broad = tuple(c for c in components if not isinstance(c, Sinusoid))
    avar = NoiseModel(broad).avar(TAU / TAU0, FRAME_RATE_HZ, "continuous")
    for line in (c for c in components if isinstance(c, Sinusoid)):
        exact = line.avar(TAU / TAU0, FRAME_RATE_HZ, "continuous")
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
def slopes_figure(title: str = TITLE) -> Picture:
    """S Figure 3 in two panels: the colours, then correlated and periodic noise."""
    body = new_figure(title, SOURCE, 105.0)
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
