"""One series and what was fitted to it: Allan deviation and spectrum, components, residuals, and
other estimators in panels of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, NoiseRow
from mocap_metrology.noise.model.components import GaussMarkov, PowerLaw, Sinusoid
from mocap_metrology.present.fits.model import (
    Fit,
    Under,
    drawn_avar,
    drawn_m,
    fit_of,
    interval,
    recorded_s,
    residual,
    share,
    spectrum_of,
    total_avar,
)
from mocap_metrology.present.plot.curves import NOTHING, log_limits, positive
from mocap_metrology.present.plot.figure import (
    FAINT,
    GREY,
    INK,
    LOOKS,
    SMALL_PT,
    Keywords,
    Picture,
    legend_below,
    letters,
    log_axes,
    new_figure,
    panel_title,
    say,
    styled,
)
from mocap_metrology.present.text import captions

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ROWS_MM = (58.0, 25.0, 38.0)  # curves, residuals, other estimators
LABEL_AT = -0.21  # of the width of a panel; matplotlib would measure every tick label for it
BELOW_DATA = 8.0  # an axis extends so many times below the least datum, for components
MOST_SIGMA = 6.0  # of a spectrum's residuals; larger ones are drawn at the edge
POINTS = 300  # of a density
DATA: Keywords = {"color": INK, "marker": "o", "ms": 2.2, "markerfacecolor": "white", "ls": ""}
DOTS: Keywords = {"color": GREY, "marker": "o", "ms": 1.4, "mew": 0, "ls": ""}
BAND: Keywords = {"color": GREY, "alpha": 0.3, "lw": 0}
MODEL: Keywords = {"color": INK, "lw": 1.5, "ls": "-", "zorder": 2.5}
UNDER: Keywords = {"color": INK, "lw": 1.0, "ls": (0, (2.2, 1.2))}
DASHES = (
    (0, (6, 1.4)),
    (0, (1.2, 1.2)),
    (0, (7, 1.4, 1.4, 1.4)),
    (0, (3, 1.2)),
    (0, (5, 1.2, 1.2, 1.2, 1.2, 1.2)),
)
OTHERS: tuple[Keywords, ...] = (  # other estimators: none of the components' colours
    {"color": "#23733d", "lw": 1.0, "ls": "-"},
    {"color": "#8a6500", "lw": 1.0, "ls": (0, (4, 1.2))},
    {"color": "#a8308e", "lw": 1.0, "ls": (0, (7, 1.2, 1.2, 1.2, 1.2, 1.2))},
    {"color": "#6b6b6b", "lw": 1.0, "ls": (0, (1.5, 1.5))},
    {"color": "#7a4f33", "lw": 1.0, "ls": (0, (9, 1.2))},
)


@styled()
def fit_figure(
    title: str,
    allan: Mapping[str, np.ndarray],
    periodogram: Mapping[str, np.ndarray],
    estimates: Mapping[str, Sequence[NoiseRow]],
    frame_rate_hz: float,
    source: str = "",
    remarks: str = "",
    *,
    main: str = DEFAULT_ESTIMATOR,
    confidence: float = 0.683,
    lines_subtracted: bool = True,
) -> Picture:
    """Figure of one series: data, fitted model and its components, residuals below; then what other
    estimators found.

    allan: arrays `m`, `tau_s`, `adev_mm`, `adev_lower_mm`, `adev_upper_mm`, `n_terms`; periodogram:
    arrays `f_hz`, `f_lower_hz`, `f_upper_hz`, `psd_mm2_hz`, `dof`; estimates: rows of noise.csv of
    this series by estimator. Components are those of `main`; models are
    drawn in the form of Allan variances they were fitted in, spectra in that of `main`. confidence:
    of the intervals of `allan`; lines_subtracted: whether the sinusoid is gone from `periodogram`.
    `source`: the line at the foot; `remarks`: what the caption adds.
    """
    duration = recorded_s(allan, frame_rate_hz)
    fits = {name: fit_of(name, rows, duration) for name, rows in estimates.items() if rows}
    fit = fits.pop(main, None) or fit_of(main, [])
    others = [other for other in fits.values() if other.parts]
    names = ("m", "tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm")
    points = pd.DataFrame({name: np.asarray(allan[name], float) for name in names})
    points = points[np.isfinite(points["adev_mm"]) & (points["adev_mm"] > 0)]
    spectrum = spectrum_of(periodogram)
    heights = ROWS_MM if others else ROWS_MM[:2]
    body = new_figure(title, source, 34.0 + sum(heights) + 1.9 * len(fit.parts))
    grid = body.subplots(len(heights), 2, sharex="col", height_ratios=heights)
    panels = dict(zip("abcdef", grid.flat, strict=False))
    for axes in grid.flat:
        axes.yaxis.set_label_coords(LABEL_AT, 0.5)
    for axes, label in zip(grid[-1], ("Averaging time τ (s)", "Frequency (Hz)"), strict=True):
        axes.set_xlabel(label)
    _allan_panel(panels["a"], points, fit, frame_rate_hz, f"{100 * confidence:.3g} % interval")
    _psd_panel(panels["b"], spectrum, fit, frame_rate_hz, confidence)
    _allan_residuals(panels["c"], points, [(fit, DATA)] if fit.parts else [], frame_rate_hz)
    _psd_residuals(panels["d"], spectrum, fit, frame_rate_hz, lines=not lines_subtracted)
    if others:
        looks = list(zip(others, OTHERS, strict=False))
        _allan_residuals(panels["e"], points, looks, frame_rate_hz)
        _other_spectra(panels["f"], spectrum, looks, fit, frame_rate_hz)
        for name in "ef":
            panel_title(panels[name], "Other estimators")
    letters(panels.values())
    legend_below(body, [panels[name] for name in "ab"], columns=2)
    caption = _caption(fit, bool(others), bool(estimates.get(main)), lines_subtracted)
    return Picture(body, f"{caption} {remarks}".strip())


def part_styles(fit: Fit) -> list[Keywords]:
    """How each part is drawn: power laws blue, Gauss-Markov terms red, the sinusoid cyan; dashes
    by alpha or number. What is no noise has the colour of the model."""
    styles: list[Keywords] = []
    for part in fit.parts:
        if isinstance(part.component, PowerLaw):
            how: Keywords = {"color": LOOKS["x"].colour, "ls": DASHES[part.component.alpha + 2]}
        elif isinstance(part.component, GaussMarkov):
            number = sum(style["color"] == LOOKS["y"].colour for style in styles)
            how = {"color": LOOKS["y"].colour, "ls": DASHES[number % len(DASHES)]}
        elif isinstance(part.component, Under):
            how = UNDER
        else:
            how = {"color": LOOKS["z"].colour, "ls": "-"}
        styles.append({"lw": 1.0} | how)
    return styles


def _fit_avar(fit: Fit, m: np.ndarray, rate: float) -> np.ndarray:
    """Allan variance of all that was found: of the noise, and of what lies under it."""
    return total_avar([part.component for part in fit.parts], m, rate, fit.form)


def _near(values: np.ndarray, limits: tuple[float, float]) -> np.ndarray:
    """Values on the axis and a little beyond, so that a file holds no more than is seen."""
    return np.where((values > limits[0] / 3) & (values < limits[1] * 3), values, np.nan)


def _clip(values: np.ndarray | pd.Series, limits: tuple[float, float]) -> np.ndarray:
    return np.clip(np.nan_to_num(values, nan=limits[0]), limits[0] / 10, limits[1] * 10)


def _allan_panel(axes: Axes, points: pd.DataFrame, fit: Fit, rate: float, band: str) -> None:
    """Data with their interval, the model, its components, a number at the peak of each
    Gauss-Markov term: 0.4365 q_c T_c^0.5 at tau = 1.893 T_c."""
    from matplotlib.ticker import NullLocator

    tau, adev, upper = points["tau_s"], points["adev_mm"], points["adev_upper_mm"]
    low, high = log_limits([adev, upper.clip(upper=3 * adev.max())])
    limits = low / BELOW_DATA, high
    log_axes(axes, (log_limits([tau]), limits))
    axes.yaxis.set_minor_locator(NullLocator())  # a tick is an artist, and slow
    axes.set_ylabel("Allan deviation (mm)")
    form = "" if fit.form == "sampled" else f"model: {fit.form}"
    panel_title(axes, "Allan deviation", fit.trouble or form)
    if points.empty:
        say(axes, NOTHING)
    axes.plot(tau, adev, zorder=3, label="data", **DATA)
    ends = [_clip(points[f"adev_{end}_mm"], limits) for end in ("lower", "upper")]
    axes.fill_between(tau, ends[0], ends[1], label=band, **BAND)
    m = drawn_m(int(points["m"].max()) if len(points) else 2)
    if fit.parts:
        model = np.sqrt(_fit_avar(fit, m, rate))
        axes.plot(m / rate, _near(model, limits), label=f"model ({fit.estimator})", **MODEL)
    for part, how in zip(fit.parts, part_styles(fit), strict=True):
        c = part.component
        values = np.sqrt(drawn_avar(c, m, rate, fit.form))
        axes.plot(m / rate, _near(values, limits), label=part.text, **how)
        peak = (
            (1.893 * c.T_c, 0.4365 * c.q_c * c.T_c**0.5) if isinstance(c, GaussMarkov) else (0, 0)
        )
        if axes.viewLim.contains(*peak):
            place: Keywords = {"xytext": (0, -2.5), "textcoords": "offset points", "va": "top"}
            place |= {"ha": "center", "color": how["color"], "size": SMALL_PT}
            axes.annotate(part.name[3:], peak, **place)


def _psd_panel(
    axes: Axes, spectrum: pd.DataFrame, fit: Fit, rate: float, confidence: float
) -> None:
    """Data with their interval, the model, its components; the sinusoid as a stem from the
    continuum up to what it makes of its bin's density."""
    limits, f = _density_axes(axes, spectrum, rate)
    panel_title(axes, "Power spectral density")
    if spectrum.empty:
        say(axes, NOTHING)
    ends = [_clip(end, limits) for end in interval(spectrum, confidence)]
    strokes = np.column_stack([*ends, np.full(len(spectrum), np.nan)]).ravel()
    axes.plot(np.repeat(spectrum["f_hz"], 3), strokes, color=GREY, lw=0.5, alpha=0.6)  # one is fast
    axes.plot(spectrum["f_hz"], spectrum["psd_mm2_hz"], **DOTS)
    for part, how in zip(fit.parts, part_styles(fit), strict=True):
        c = part.component
        if isinstance(c, Sinusoid):
            base = float(fit.model.psd(np.array([c.f_0]), rate)[0])
            top = base + float(share(spectrum, c, rate, fit.form).max(initial=0.0))
            axes.vlines(c.f_0, base or limits[0], top, color=how["color"], lw=1.6, zorder=4)
            axes.plot([c.f_0], [top], "D", color=how["color"], markersize=3.5, zorder=4)
        elif not isinstance(c, Under):  # which has no density
            axes.plot(f, _near(c.psd(f, rate, form=fit.form), limits), **how)
    if fit.parts:
        axes.plot(f, _near(fit.model.psd(f, rate, fit.form), limits), **MODEL)


def _density_axes(
    axes: Axes, spectrum: pd.DataFrame, rate: float
) -> tuple[tuple[float, float], np.ndarray]:
    """Logarithmic axes around a spectrum; limits of the densities, and frequencies of a curve."""
    low, high = log_limits([spectrum["psd_mm2_hz"]], 1.0, 16.0)
    limits, across = (low / BELOW_DATA, high * 1.5), log_limits([spectrum["f_hz"]])
    log_axes(axes, (across, limits))
    axes.set_ylabel("PSD (mm²/Hz)")
    return limits, np.geomspace(across[0], min(across[1], rate / 2), POINTS)


def _allan_residuals(
    axes: Axes, points: pd.DataFrame, fits: Sequence[tuple[Fit, Keywords]], rate: float
) -> None:
    """Allan deviation of the data over that of each fit, less 1, in per cent; of the one fit drawn
    as `DATA` with the interval of the data."""
    m, adev = points["m"].round().astype(np.int64).to_numpy(), points["adev_mm"].to_numpy()
    most = 10.0
    for fit, how in fits:
        curve = positive(np.sqrt(_fit_avar(fit, m, rate)))
        off = 100 * (adev / curve - 1)
        most = most if np.nanmax(np.abs(off), initial=0.0) <= 20 else 100.0
        if how is DATA:
            ends = (points[f"adev_{end}_mm"] for end in ("lower", "upper"))
            band = (np.clip(100 * (end / curve - 1), -1e4, 1e4) for end in ends)
            axes.fill_between(points["tau_s"], *band, **BAND)
        axes.plot(points["tau_s"], off, label=None if how is DATA else fit.estimator, **how)
    axes.set_yscale("symlog", linthresh=1.0, linscale=0.8)
    axes.set_yticks(
        [-most, -1, 0, 1, most], [f"{t:g}".replace("-", "−") for t in (-most, -1, 0, 1, most)]
    )
    axes.set_yticks([], minor=True)
    axes.set(ylim=(-2.5 * most, 2.5 * most), ylabel="Residual (%)")
    axes.axhline(0, color=INK, lw=0.8)


def _psd_residuals(
    axes: Axes, spectrum: pd.DataFrame, fit: Fit, rate: float, *, lines: bool
) -> None:
    """Residuals in standard deviations, with those of one and two shaded; beyond six at the edge,
    and their number."""
    axes.set(ylim=(-MOST_SIGMA, MOST_SIGMA), yticks=(-5, 0, 5), ylabel="Residual (σ)")
    for reach in (2, 1):
        axes.axhspan(-reach, reach, color=FAINT, alpha=0.5, lw=0)
    axes.axhline(0, color=INK, lw=0.8)
    if not fit.parts:
        return
    sigma = residual(spectrum, fit.model, rate, lines)
    beyond = np.abs(sigma) > MOST_SIGMA
    axes.plot(spectrum["f_hz"], np.where(beyond, np.nan, sigma), **DOTS)
    edges: Keywords = {"color": LOOKS["y"].colour, "ls": "", "markersize": 3}
    for where, marker, at in ((sigma > MOST_SIGMA, "^", 0.92), (sigma < -MOST_SIGMA, "v", -0.92)):
        axes.plot(spectrum["f_hz"][where], np.full(where.sum(), at * MOST_SIGMA), marker, **edges)
    if beyond.any():
        panel_title(axes, "", f"{beyond.sum()} beyond {MOST_SIGMA:g} σ")


def _other_spectra(
    axes: Axes,
    spectrum: pd.DataFrame,
    others: Sequence[tuple[Fit, Keywords]],
    fit: Fit,
    rate: float,
) -> None:
    """Data, and the models of other estimators, named in the panel."""
    limits, f = _density_axes(axes, spectrum, rate)
    axes.plot(spectrum["f_hz"], spectrum["psd_mm2_hz"], **DOTS)
    for other, look in others:
        values = _near(other.model.psd(f, rate, fit.form), limits)
        axes.plot(f, values, label=other.estimator, **look)
    how: Keywords = {"fontsize": SMALL_PT - 1, "frameon": True, "framealpha": 0.8}
    axes.legend(loc="lower left", edgecolor="none", **how)


def _caption(fit: Fit, others: bool, estimated: bool, lines_subtracted: bool) -> str:
    """What the panels show, what was not detected, and what the signs mean."""
    words = [captions.FIT, captions.OTHER_FITS if others else ""]
    words.append("" if estimated else f"No estimate by {fit.estimator}.")
    if "misfit" in fit.trouble:
        words.append("Misfit: the model does not describe the data; no number of it is valid.")
    if fit.absent:
        words.append(f"Not detected (95 % limits): {', '.join(fit.absent)}.")
    if fit.under:
        words.append(
            f"Under the noise: {fit.under}; subtracted from the spectrum; part of the Allan "
            "deviation of the data and of the model."
        )
    if any(isinstance(part.component, GaussMarkov) for part in fit.parts):
        words.append(captions.GAUSS_MARKOV)
    if fit.model.lines:
        gone = ", which it was subtracted from" if lines_subtracted else ""
        words.append(f"The stem at f_0 is as high as the sinusoid would raise its bin{gone}.")
    return " ".join(filter(None, words))
