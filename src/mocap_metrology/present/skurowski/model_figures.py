"""S Figures 1 and 2: what the simple Gaussian model says."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.cameras.scaling import Scaling, fit_scaling
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw
from mocap_metrology.noise.twins.published import (
    FRAME_RATE_HZ,
    published_gaussian,
    published_keys,
    published_row,
)
from mocap_metrology.present.drawing.axes import linear_axis
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    BODY_PT,
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
    styled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PAPER = "Skurowski & Pawlyta 2019"
TITLE_1 = f"{PAPER}, Figure 1: Gaussian model of two markers"
TITLE_2 = f"{PAPER}, Figure 2: standard error of the mean of N"
NOTE_1 = (
    "Computed from the printed numbers of Table 4, row T40: N(μ, σ) of x of either marker, and of "
    "the distance with each of the four standard deviations of section 2.2."
)
NOTE_2 = (
    "Line: the standard error σ/√N in units of σ (Equation 3). Points: root of the printed white "
    "noise h₀ (Tables A1-A3; correlated noise shorter than a frame counts as white), geometric "
    "mean over x, y, z of both markers, with n cameras; each type divided by what the law, fitted "
    "to it, gives for one camera, so only how it falls is to be compared. In the key: exponent of "
    "n if free, −0.5 by the law. Vantage without the failing tenth camera."
)
LEFT_MM, RIGHT_MM, TITLE_MM, LABELS_MM, GAP_MM = 16.0, 3.0, 5.5, 10.0, 8.0
MOST_N = 12
WAND_MM, PANEL_MM = 24.0, 46.0
LENGTHS = {
    "σ_C = {:.1f} µm, correlated": ("sigma_C_mm", OTHER_LOOKS[0]),
    "σ_B = {:.1f} µm, independent": ("sigma_B_mm", LOOKS["y"]),
    "σ_A = {:.1f} µm, as marker 1": ("sigma_A1_mm", LOOKS["x"]),
    "σ_A = {:.1f} µm, as marker 2": ("sigma_A2_mm", LOOKS["z"]),
}
KINDS = dict(zip(("T40", "Bonita", "Vantage"), LOOKS.values(), strict=True))


def normal(x: np.ndarray, sigma: float) -> np.ndarray:
    """Density of N(0, sigma)."""
    density: np.ndarray = np.exp(-0.5 * (x / sigma) ** 2) / (sigma * np.sqrt(2 * np.pi))
    return density


@styled()
def model_figure(row: Mapping[str, float] | None = None, title: str = TITLE_1) -> Figure:
    """S Figure 1 of a row of Table 4 (default T40): where the markers are, and the densities."""
    row = published_gaussian("T40") if row is None else row
    entries = [
        Entry(name.format(1000 * row[key]), line=_line(look))
        for name, (key, look) in LENGTHS.items()
    ]
    width = WIDTH_MM - 2 * MARGIN_MM
    key_top = WAND_MM + TITLE_MM + PANEL_MM + LABELS_MM
    sheet = blank_sheet(key_top + strip_height(entries, width) + 1.5, title, NOTE_1)
    _wand(sheet, row)
    panel = (WIDTH_MM - LEFT_MM - RIGHT_MM - 2 * GAP_MM) / 3
    curves = {
        "Marker 2": {"": (row["sigma_2_mm"], LOOKS["x"])},
        "Marker 1": {"": (row["sigma_1_mm"], LOOKS["x"])},
        "Distance": {name: (row[key], look) for name, (key, look) in LENGTHS.items()},
    }
    reach = 3.3e3 * max(sigma for of in curves.values() for sigma, _ in of.values())
    top = max(normal(np.zeros(1), s)[0] for of in curves.values() for s, _ in of.values()) / 1000
    means = (row["mu_2_mm"], row["mu_1_mm"], row["mu_e_mm"])
    for k, (name, of) in enumerate(curves.items()):
        axes = sheet.axes(LEFT_MM + k * (panel + GAP_MM), WAND_MM + TITLE_MM, panel, PANEL_MM)
        linear_axis(axes, "x", (-reach, reach), 5)
        linear_axis(axes, "y", (0, 1.12 * top), 5)
        x = np.linspace(-reach, reach, 601)
        for sigma, look in of.values():
            axes.plot(x, normal(x, 1000 * sigma), **_line(look))
        axes.tick_params(labelleft=k == 0)
        symbol = "xₖ − μₖ".replace("ₖ", "₂₁"[k]) if k < 2 else "L − μₑ"
        label_axes(axes, f"{symbol} (µm)", "Density (1/µm)" if k == 0 else "")
        head(axes, name)
        lines = [f"μ{'₂₁ₑ'[k]} = {means[k]:.4f} mm"]
        lines += [f"σ{'₂₁'[k]} = {1000 * of[''][0]:.1f} µm"] if k < 2 else []
        how: Keywords = {
            "transform": axes.transAxes,
            "va": "top",
            "ha": "right",
            "linespacing": 1.4,
        }
        axes.text(0.97, 0.97, "\n".join(lines), size=SMALL_PT, color=GREY, **how)
    strip(sheet, MARGIN_MM, key_top, width, entries)
    return sheet.figure


def _line(look: Look) -> Keywords:
    return {"color": look.colour, "ls": look.dashes, "lw": 1.3}


def _wand(sheet: Sheet, row: Mapping[str, float]) -> None:
    """The two markers on their common axis, to scale, and what is between them."""
    width = WIDTH_MM - LEFT_MM - RIGHT_MM
    axes = sheet.axes(LEFT_MM, 1.0, width, WAND_MM - 11.0)
    low, high = sorted((row["mu_1_mm"], row["mu_2_mm"]))
    pad = 0.06 * (high - low)
    axes.set(xlim=(low - pad, high + pad), ylim=(0, 1), yticks=[])
    for side in ("left", "right", "top"):
        axes.spines[side].set_visible(False)
    axes.axhline(0.32, color=GREY, lw=1.5, zorder=1)
    axes.plot([low, high], [0.32, 0.32], ls="", marker="o", ms=9, color=LOOKS["x"].colour)
    arrow = {"arrowstyle": "<->", "color": INK, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", (low, 0.68), (high, 0.68), arrowprops=arrow)
    text = f"L = x₁ − x₂,  μₑ = {row['mu_e_mm']:.4f} mm"
    axes.text((low + high) / 2, 0.74, text, ha="center", va="bottom", size=BODY_PT)
    names = {row["mu_1_mm"]: "marker 1", row["mu_2_mm"]: "marker 2"}
    for place, name in names.items():
        axes.text(place, 0.76, name, ha="center", va="bottom", size=SMALL_PT, color=GREY)
    label_axes(axes, "x (mm)")


def white_level(model: NoiseModel) -> float:
    """h_0 and, in mm^2/Hz too, 2 (q_c T_c)^2 of correlated noise with T_c below a frame: the level
    that its density has at low frequencies."""
    level = 0.0
    for part in model.components:
        if isinstance(part, GaussMarkov) and part.T_c < 1 / FRAME_RATE_HZ:
            level += 2 * (part.q_c * part.T_c) ** 2
        elif isinstance(part, PowerLaw) and part.alpha == 0:
            level += part.h
    return level


def white_roots() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Camera type -> numbers of cameras and root of `white_level`, mm/sqrt(Hz), geometric mean over
    the six coordinates; without Vantage's ten."""
    found = {}
    for kind in KINDS:
        counts = sorted(n for k, n in published_keys() if k == kind and (k, n) != ("Vantage", 10))
        roots = []
        for n in counts:
            h_0 = [white_level(model) for s, model in published_row(kind, n).items() if s != "L"]
            roots.append(float(np.exp(np.mean(np.log(h_0)) / 2)))
        found[kind] = np.array(counts), np.array(roots)
    return found


@styled()
def standard_error_figure(title: str = TITLE_2) -> Figure:
    """S Figure 2, with the printed white noise beside the law."""
    height = 68.0
    found = {kind: fit_scaling(*pair) for kind, pair in white_roots().items()}
    fits = {kind: fit for kind, fit in found.items() if fit is not None}
    entries = [Entry("σ/√N", line={"color": INK, "lw": 1.4})]
    for kind, look in KINDS.items():
        fit = fits[kind]
        text = f"{kind}: exponent {fit.exponent:.2f} ± {fit.exponent_error:.2f}".replace("-", "−")
        entries.append(Entry(text, dot=_dot(look)))
    width = WIDTH_MM - 2 * MARGIN_MM
    key_top = TITLE_MM + height + LABELS_MM
    sheet = blank_sheet(key_top + strip_height(entries, width) + 1.5, title, NOTE_2)
    axes = sheet.axes(LEFT_MM, TITLE_MM, WIDTH_MM - LEFT_MM - RIGHT_MM, height)
    _standard_error(axes, fits)
    strip(sheet, MARGIN_MM, key_top, width, entries)
    return sheet.figure


def _dot(look: Look) -> Keywords:
    return {"color": look.colour, "marker": look.marker, "markersize": 4.2, "mew": 0.8,
            "markerfacecolor": "white"}  # fmt: skip


def _standard_error(axes: Axes, fits: Mapping[str, Scaling]) -> None:
    linear_axis(axes, "x", (0.5, MOST_N + 0.5), MOST_N)
    points = {kind: (n, roots / fits[kind].one) for kind, (n, roots) in white_roots().items()}
    linear_axis(axes, "y", (0, 1.08 * max(1.0, *(y.max() for _, y in points.values()))), 8)
    n = np.linspace(1, MOST_N, 400)
    axes.plot(n, 1 / np.sqrt(n), color=INK, lw=1.4)
    for (kind, look), shift in zip(KINDS.items(), (-0.08, 0.0, 0.08), strict=True):
        cameras, relative = points[kind]
        axes.plot(cameras + shift, relative, ls="", **_dot(look))
    label_axes(axes, "Number of observations N, or of cameras", "Standard error (σ)", y_mm=10.5)
