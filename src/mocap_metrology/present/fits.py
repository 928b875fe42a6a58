"""One series and what was fitted to it: Allan deviation and spectrum, components, residuals, and
other estimators in panels of their own."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
import pandas as pd

from mocap_metrology.noise.fit import estimates as of
from mocap_metrology.noise.model import curves as model
from mocap_metrology.noise.model.components import Component, GaussMarkov, NoiseModel, Sinusoid
from mocap_metrology.noise.model.deterministic import Deterministic
from mocap_metrology.present.plot import figure as plot
from mocap_metrology.present.plot.curves import NOTHING, log_limits, positive
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.coefficients import symbol, unit
from mocap_metrology.present.text.numbers import MARKS, significant, with_uncertainty

Kind = Component | Deterministic
ROWS_MM = (58.0, 25.0, 38.0)  # curves, residuals, other estimators
LABEL_AT = -0.21  # of the width of a panel; matplotlib would measure every tick label for it
BELOW_DATA = 8.0  # an axis extends so many times below the least datum, for components
MOST_SIGMA = 6.0  # of a spectrum's residuals; larger ones are drawn at the edge
EXACT = 1e-5  # relative error of a frequency below which only its value is written
POINTS = 300  # of a density
ALLAN = ("m", "tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm")
DATA: plot.Keywords = {"color": plot.INK, "marker": "o", "ms": 2.2, "ls": "", "zorder": 3}
DATA["markerfacecolor"] = "white"
DOTS: plot.Keywords = {"color": plot.GREY, "marker": "o", "ms": 1.4, "mew": 0, "ls": ""}
BAND: plot.Keywords = {"color": plot.GREY, "alpha": 0.3, "lw": 0}
MODEL: plot.Keywords = {"color": plot.INK, "lw": 1.5, "ls": "-", "zorder": 2.5}
FINE = (5, 1.2, 1.2, 1.2, 1.2, 1.2)
DASHES = tuple((0, on) for on in ((6, 1.4), (1.2, 1.2), (7, 1.4, 1.4, 1.4), (3, 1.2), FINE))
OTHERS: tuple[plot.Keywords, ...] = (  # other estimators: none of the components' colours
    {"color": "#23733d", "lw": 1.0, "ls": "-"},
    {"color": "#8a6500", "lw": 1.0, "ls": DASHES[0]},
    {"color": "#a8308e", "lw": 1.0, "ls": DASHES[4]},
    {"color": "#6b6b6b", "lw": 1.0, "ls": DASHES[1]},
    {"color": "#7a4f33", "lw": 1.0, "ls": DASHES[3]},
)


@dataclass(frozen=True)
class Part:
    """One component, its name with its value, and how it is drawn."""

    component: Kind
    name: str
    text: str
    look: plot.Keywords


@dataclass(frozen=True)
class Fit:
    """One estimate: the model of its noise; parts, all that was detected; `absent`, limits of what
    was not; `trouble`, what is wrong, in words; duration_s of the series."""

    estimator: str
    model: NoiseModel
    parts: tuple[Part, ...]
    absent: tuple[str, ...]
    trouble: str
    duration_s: float

    def adev(self, m: np.ndarray, frame_rate_hz: float) -> np.ndarray:
        """Allan deviation (k,), mm, of all that was detected, at whole m (k,)."""
        parts = [part.component for part in self.parts]
        avar = model.total_avar(parts, m, frame_rate_hz, self.model.form, self.duration_s)
        return np.sqrt(avar)


@plot.styled()
def fit_figure(
    texts: plot.Texts,
    allan: Mapping[str, np.ndarray],
    periodogram: Mapping[str, np.ndarray],
    estimates: Mapping[str, Sequence[of.NoiseRow]],
    frame_rate_hz: float,
    confidence: float,
) -> plot.Picture:
    """The figure of `captions.FIT`, of one series.

    allan: of allan_masked.parquet, its intervals of `confidence`; periodogram: of
    periodogram.parquet; estimates: rows of noise.csv by estimator. Components are those of the
    default estimator; models are drawn in the form of Allan variances they were fitted in, spectra
    in that of the default one.
    """
    duration_s = model.recorded_s(allan, frame_rate_hz)
    fits = {name: fit_of(name, rows, duration_s) for name, rows in estimates.items()}
    fit = fits.pop(of.DEFAULT_ESTIMATOR, None) or fit_of(of.DEFAULT_ESTIMATOR, [], duration_s)
    others = list(zip([other for other in fits.values() if other.parts], OTHERS, strict=False))
    points = pd.DataFrame({name: np.asarray(allan[name], float) for name in ALLAN})
    points = points[np.isfinite(points["adev_mm"]) & (points["adev_mm"] > 0)]
    spectrum = model.spectrum_of(periodogram)
    heights = ROWS_MM if others else ROWS_MM[:2]
    body = plot.new_figure(texts, 34.0 + sum(heights) + 1.9 * len(fit.parts))
    grid = body.subplots(len(heights), 2, sharex="col", height_ratios=heights)
    form = "" if fit.model.form == "sampled" else f"model: {fit.model.form}"
    plot.panel_title(grid[0, 0], "Allan deviation", fit.trouble or form)
    plot.panel_title(grid[0, 1], "Power spectral density")
    _allan_panel(grid[0, 0], points, fit, frame_rate_hz, f"{100 * confidence:.3g} % interval")
    _psd_panel(grid[0, 1], spectrum, fit, frame_rate_hz, confidence)
    _allan_residuals(grid[1, 0], points, [(fit, DATA)] if fit.parts else [], frame_rate_hz)
    _psd_residuals(grid[1, 1], spectrum, fit, frame_rate_hz)
    if others:
        _allan_residuals(grid[2, 0], points, others, frame_rate_hz)
        f = _density_axes(grid[2, 1], spectrum, frame_rate_hz)
        for other, look in others:
            density = other.model.psd(f, frame_rate_hz, fit.model.form)
            grid[2, 1].plot(f, density, label=other.estimator, **look)
        how: plot.Keywords = {"frameon": True, "framealpha": 0.8, "edgecolor": "none"}
        grid[2, 1].legend(loc="lower left", fontsize=plot.SMALL_PT - 1, **how)
        for axes in grid[2]:
            plot.panel_title(axes, "Other estimators")
    for axes, label in zip(grid[-1], ("Averaging time τ (s)", "Frequency (Hz)"), strict=True):
        axes.set_xlabel(label)
    for axes in grid.flat:
        axes.yaxis.set_label_coords(LABEL_AT, 0.5)
    plot.letters(grid.flat)
    plot.legend_below(body, grid[0], columns=2)
    estimated = bool(estimates.get(of.DEFAULT_ESTIMATOR))
    return plot.Picture(body, f"{_caption(fit, bool(others), estimated)} {texts.caption}")


def fit_of(estimator: str, rows: Iterable[of.NoiseRow], duration_s: float = 0.0) -> Fit:
    """A fit out of rows of noise.csv of one series and estimator; a component that is not wholly
    known is no part of it. duration_s: of the series."""
    rows = list(rows)
    detected: list[of.NoiseRow] = []
    parts = []
    for (kind, number), group in groupby(sorted(rows, key=of.component_of), key=of.component_of):
        of_part = list(group)
        known = [row for row in of_part if of.is_known(row)]
        if kind == of.SLOW:
            slow = of.deterministic_of(known)
            if not slow.empty:
                known = [row for row in known if getattr(slow, row["parameter"])]
                name = "" if slow.drift else slow.name
                parts.append(_part(slow, name, known, plot.INK, (0, (2.2, 1.2))))
        elif len(known) == len(of_part):
            detected += known
            name = ("", f"GM {number}", "sinusoid")[kind]
            step = number + 2 if kind == 0 else number - 1
            dashes = "-" if kind == 2 else DASHES[step % len(DASHES)]
            colour = plot.LOOKS["xyz"[kind]].colour
            parts.append(_part(of.model_of(known).components[0], name, known, colour, dashes))
    limited = (row for row in rows if row["status"] == "not_detected")
    absent = tuple(_limit(row) for row in limited if math.isfinite(row.get("upper_95", math.nan)))
    statuses = dict.fromkeys(row["status"] for row in rows)
    trouble = [s.replace("_", " ") for s in statuses if s in MARKS]
    noise = of.model_of(detected)
    return Fit(estimator, noise, tuple(parts), absent, ", ".join(trouble), duration_s)


def _part(
    component: Kind, name: str, rows: Iterable[of.NoiseRow], colour: str, dashes: object
) -> Part:
    text = f"{name}: " * bool(name) + ", ".join(map(_value, rows))
    return Part(component, name, text, {"color": colour, "lw": 1.0, "ls": dashes})


def _value(row: of.NoiseRow) -> str:
    """`h₀ 1.29×10⁻⁶ mm²/Hz ±0.6 %`, letters with an index as mathematics."""
    name, value, error = row["parameter"], row["value"], row.get("std_error", math.nan)
    share = error / abs(value) if value and row["status"] != "misfit" else math.nan
    if name == "f_0":
        text = with_uncertainty(value, error, "Hz") if share > EXACT else f"{value:.6g} Hz"
        return f"{symbol(name)} {text}"
    shown = re.sub(r"^([A-Za-z]+)_(\w+)$", r"$\1_\2$", symbol(name))
    digits = 1 if share < 0.095 else 2
    spread = f" ±{significant(100 * share, digits)} %" if math.isfinite(share) else ""
    kind = f" ({of.correlation_class(value)})" if name.startswith("T_c") else ""
    return f"{shown} {significant(value)} {unit(name)}{spread}{kind}"


def _limit(row: of.NoiseRow) -> str:
    parameter, kind = row["parameter"], of.limit_class(row)
    text = f"{symbol(parameter)} < {significant(row['upper_95'])} {unit(parameter)}"
    return f"{text} ({kind})" if kind else text


def _allan_panel(axes: plot.Axes, points: pd.DataFrame, fit: Fit, rate: float, band: str) -> None:
    """Data with their interval, the model, its components, a number at the peak of each
    Gauss-Markov term: 0.4365 q_c T_c^0.5 at tau = 1.893 T_c."""
    adev = points["adev_mm"]
    low, high = log_limits([adev, points["adev_upper_mm"].clip(upper=3 * adev.max())])
    limits = low / BELOW_DATA, high
    plot.log_axes(axes, (log_limits([points["tau_s"]]), limits))
    axes.set_ylabel("Allan deviation (mm)")
    if points.empty:
        plot.write_message(axes, NOTHING)
    axes.plot(points["tau_s"], adev, label="data", **DATA)
    ends = points[["adev_lower_mm", "adev_upper_mm"]].clip(limits[0] / 10, limits[1] * 10)
    axes.fill_between(points["tau_s"], *ends.to_numpy().T, label=band, **BAND)
    m = model.drawn_m(int(points["m"].max()) if len(points) else 2)
    if fit.parts:
        axes.plot(m / rate, fit.adev(m, rate), label=f"model ({fit.estimator})", **MODEL)
    for part in fit.parts:
        c = part.component
        if isinstance(c, Sinusoid):
            avar = model.sinusoid_avar(c, m, rate, fit.model.form)
        else:
            avar = model.total_avar([c], m, rate, fit.model.form, fit.duration_s)
        axes.plot(m / rate, positive(np.sqrt(avar)), label=part.text, **part.look)
        peak = (1.893 * c.T_c, 0.4 * c.q_c * c.T_c**0.5) if isinstance(c, GaussMarkov) else (0, 0)
        if axes.viewLim.contains(*peak):
            how: plot.Keywords = {"color": part.look["color"], "size": plot.SMALL_PT}
            axes.text(peak[0], peak[1], part.name.removeprefix("GM "), ha="center", va="top", **how)


def _psd_panel(
    axes: plot.Axes, spectrum: pd.DataFrame, fit: Fit, rate: float, confidence: float
) -> None:
    """Data with their interval, the model, its components; the sinusoid as a stem from the
    continuum up to what it makes of its bin's density."""
    f, form = _density_axes(axes, spectrum, rate), fit.model.form
    if spectrum.empty:
        plot.write_message(axes, NOTHING)
    ends = model.density_interval(spectrum, confidence)
    axes.vlines(spectrum["f_hz"], *ends, color=plot.GREY, lw=0.5, alpha=0.6)
    for part in fit.parts:
        c = part.component
        if isinstance(c, Sinusoid):
            base = float(fit.model.psd(np.array([c.f_0]), rate)[0])
            top = base + model.line_density(spectrum, c, rate, form).max(initial=0.0)
            how: plot.Keywords = {"color": part.look["color"], "zorder": 4}
            axes.vlines(c.f_0, base or axes.get_ylim()[0], top, lw=1.6, **how)
            axes.plot([c.f_0], [top], "D", markersize=3.5, **how)
        elif not isinstance(c, Deterministic):  # which has no density
            axes.plot(f, c.psd(f, rate, form=form), **part.look)
    if fit.parts:
        axes.plot(f, fit.model.psd(f, rate), **MODEL)


def _density_axes(axes: plot.Axes, spectrum: pd.DataFrame, rate: float) -> np.ndarray:
    """Logarithmic axes around a spectrum, which is drawn; frequencies of a curve."""
    low, high = log_limits([spectrum["psd_mm2_hz"]], 1.0, 16.0)
    across = log_limits([spectrum["f_hz"]])
    plot.log_axes(axes, (across, (low / BELOW_DATA, high * 1.5)))
    axes.set_ylabel("PSD (mm²/Hz)")
    axes.plot(spectrum["f_hz"], spectrum["psd_mm2_hz"], **DOTS)
    return np.geomspace(across[0], min(across[1], rate / 2), POINTS)


def _allan_residuals(
    axes: plot.Axes, points: pd.DataFrame, fits: Iterable[tuple[Fit, plot.Keywords]], rate: float
) -> None:
    """Allan deviation of the data over that of each fit, less 1, in per cent; of the one fit drawn
    as `DATA` with the interval of the data."""
    most = 10.0
    for fit, look in fits:
        curve = positive(fit.adev(points["m"].round().to_numpy(np.int64), rate))
        off = 100 * (points[list(ALLAN[2:])].div(curve, axis=0) - 1).clip(-1e4, 1e4)
        most = most if (off["adev_mm"].abs() <= 20).all() else 100.0
        if look is DATA:
            ends = off["adev_lower_mm"], off["adev_upper_mm"]
            axes.fill_between(points["tau_s"], *ends, **BAND)
        axes.plot(points["tau_s"], off["adev_mm"], label=fit.estimator, **look)
    axes.set_yscale("symlog", linthresh=1.0, linscale=0.8)
    ticks = [-most, -1, 0, 1, most]
    axes.set_yticks(ticks, [f"{t:g}".replace("-", "−") for t in ticks])
    axes.set_yticks([], minor=True)
    axes.set(ylim=(-2.5 * most, 2.5 * most), ylabel="Residual (%)")
    axes.axhline(0, color=plot.INK, lw=0.8)


def _psd_residuals(axes: plot.Axes, spectrum: pd.DataFrame, fit: Fit, rate: float) -> None:
    """Residuals in standard deviations, with those of one and two shaded; beyond six red at the
    edge, and their number."""
    axes.set(ylim=(-MOST_SIGMA, MOST_SIGMA), yticks=(-5, 0, 5), ylabel="Residual (σ)")
    for reach in (2, 1):
        axes.axhspan(-reach, reach, color=plot.FAINT, alpha=0.5, lw=0)
    axes.axhline(0, color=plot.INK, lw=0.8)
    if not fit.parts:
        return
    sigma = pd.Series(model.density_residual(spectrum, fit.model, rate), spectrum["f_hz"])
    beyond = sigma[sigma.abs() > MOST_SIGMA]
    axes.plot(sigma[sigma.abs() <= MOST_SIGMA], **DOTS)
    axes.plot(beyond.clip(-5.5, 5.5), "D", color=plot.LOOKS["y"].colour, markersize=2.5)
    if len(beyond):
        plot.panel_title(axes, "", f"{len(beyond)} beyond {MOST_SIGMA:g} σ")


def _caption(fit: Fit, others: bool, estimated: bool) -> str:
    """What the panels show, what was not detected, and what the signs mean."""
    slow = next((p.text for p in fit.parts if isinstance(p.component, Deterministic)), "")
    slow, kinds = slow.removeprefix("warm-up: "), {type(part.component) for part in fit.parts}
    applies = {
        captions.FIT: True,
        captions.OTHER_FITS: others,
        "No estimate by {estimator}.": not estimated,
        captions.FIT_MISFIT: "misfit" in fit.trouble,
        "Not detected (95 % limits): {absent}.": bool(fit.absent),
        captions.FIT_UNDER: bool(slow),
        captions.GAUSS_MARKOV: GaussMarkov in kinds,
        captions.FIT_STEM: Sinusoid in kinds,
    }
    text = " ".join(sentence for sentence, holds in applies.items() if holds)
    return text.format(estimator=fit.estimator, absent=", ".join(fit.absent), slow=slow)
