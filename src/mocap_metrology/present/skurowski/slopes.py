"""S Figure 3: what the parts of an Allan deviation look like, computed from noise models."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.present.drawing.axes import decade_axis
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    INK,
    LOOKS,
    MARGIN_MM,
    OTHER_LOOKS,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    Look,
    blank_sheet,
    head,
    label_axes,
    styled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TITLE = "Skurowski & Pawlyta 2019, Figure 3: parts of an Allan deviation and their slopes"
NOTE = (
    "Computed from noise models, continuous-time forms with f_h = 500 Hz; the coefficients are "
    "chosen so that each part has decades of its own, and the values of both axes mean nothing "
    "else. Slopes are those of the computed curves where they are written. Past six periods a "
    "sinusoid is drawn by what its bumps reach, and the sum with their mean."
)
FRAME_RATE_HZ = 1000.0
TAU0 = 1 / FRAME_RATE_HZ
TAU = np.geomspace(1e-3, 1e5, 2401)
LEFT_MM, RIGHT_MM, TITLE_MM, LABELS_MM, GAP_MM, HEIGHT_MM = 14.0, 3.0, 5.5, 10.0, 17.0, 72.0
LINE = Sinusoid(0.12, 3.0)
RESOLVED = 6.0  # periods of a sinusoid up to which its bumps are drawn one by one


class Part(NamedTuple):
    """A component with its name and look, and at which tau (s) its slope is written, how far off
    the curve in mm; None for a curve that has no slope to write."""

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
def slopes_figure(title: str = TITLE) -> Figure:
    """S Figure 3 in two panels: the colours, then correlated and periodic noise."""
    looks = {part.name: part.look for part in (*POWER_LAWS, *OTHERS)}
    entries = [
        Entry("their sum", line={"color": INK, "lw": 2.2, "alpha": 0.35}),
        *(Entry(k, line={"color": v.colour, "ls": v.dashes}) for k, v in looks.items()),
    ]
    width = WIDTH_MM - 2 * MARGIN_MM
    key_top = TITLE_MM + HEIGHT_MM + LABELS_MM
    sheet = blank_sheet(key_top + strip_height(entries, width) + 1.5, title, NOTE)
    panel = (WIDTH_MM - LEFT_MM - RIGHT_MM - GAP_MM) / 2
    for k, (name, parts) in enumerate(
        (("Power laws", POWER_LAWS), ("Correlated and periodic noise", OTHERS))
    ):
        axes = sheet.axes(LEFT_MM + k * (panel + GAP_MM), TITLE_MM, panel, HEIGHT_MM)
        _draw(axes, parts, (panel, HEIGHT_MM))
        head(axes, name)
        label_axes(axes, "Averaging time τ (s)", "Allan deviation (mm)")
    strip(sheet, MARGIN_MM, key_top, width, entries)
    return sheet.figure


def _draw(axes: Axes, parts: Sequence[Part], size: tuple[float, float]) -> None:
    from matplotlib.transforms import ScaledTranslation

    total = deviation([part.component for part in parts])
    limits = float(total.min()) / 6, float(total.max()) * 3
    decade_axis(axes, "x", (TAU[0], TAU[-1]), size[0])
    decade_axis(axes, "y", limits, size[1], plain=False)
    axes.plot(TAU, total, color=INK, lw=2.6, alpha=0.35, solid_capstyle="round")
    for part in parts:
        smooth = curve = deviation([part.component])
        if isinstance(part.component, Sinusoid):
            smooth, whole = envelope(part.component), part.component.f_0 * TAU <= RESOLVED
            curve = np.where(whole, curve, smooth)
        axes.plot(TAU, curve, color=part.look.colour, ls=part.look.dashes, lw=1.0)
        for tau, (right, up) in part.at:
            y = float(np.interp(np.log(tau), np.log(TAU), smooth))
            shift = ScaledTranslation(right / 25.4, up / 25.4, axes.figure.dpi_scale_trans)
            text = slope_text(slope_at(smooth, tau))
            how: Keywords = {"ha": "center", "va": "center", "size": SMALL_PT + 1, "weight": "bold"}
            axes.text(tau, y, text, color=part.look.colour, transform=axes.transData + shift, **how)
