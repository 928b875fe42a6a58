"""Spectrum of a fit: data, model and components; residuals; models of other estimators."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.model.components import Sinusoid
from mocap_metrology.present.fits.parts import Fit, Spectrum, Under
from mocap_metrology.present.fits.shown import (
    BELOW_DATA,
    DOTS,
    MODEL,
    OTHERS,
    Shown,
    clip,
    near,
    part_styles,
)
from mocap_metrology.present.plot.curves import NOTHING, Limits, log_limits
from mocap_metrology.present.plot.figure import (
    FAINT,
    GREY,
    INK,
    LOOKS,
    Keywords,
    log_axes,
    panel_title,
    say,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_SIGMA = 6.0  # of a spectrum's residuals; larger ones are drawn at the edge
POINTS = 300  # of a density


def psd_panel(axes: Axes, shown: Shown) -> None:
    """Data with their interval, the model, its components."""
    data, fit, rate = shown.spectrum, shown.fit, shown.rate_hz
    limits = _density_axes(axes, data)
    panel_title(axes, "Power spectral density", _beyond(data, fit, rate))
    if not data.f.size:
        say(axes, NOTHING)
    gap = np.full(data.f.size, np.nan)
    ends = [clip(end, limits) for end in data.interval(shown.confidence)]
    strokes = np.column_stack([*ends, gap]).ravel()  # one line for all: matplotlib's are slow
    axes.plot(np.repeat(data.f, 3), strokes, color=GREY, lw=0.5, alpha=0.6)
    axes.plot(data.f, data.psd, **DOTS)
    f = _frequencies(axes, rate)
    for part, how in zip(fit.parts, part_styles(fit), strict=True):
        if isinstance(part.component, Sinusoid):
            _stem(axes, part.component, data, fit, how, rate)
        elif not isinstance(part.component, Under):  # which has no density
            values = part.component.psd(f, rate, form=fit.form)
            axes.plot(f, near(values, limits), **how)
    if fit.parts:
        axes.plot(f, near(fit.model.psd(f, rate, fit.form), limits), **MODEL)


def _density_axes(axes: Axes, data: Spectrum) -> Limits:
    """Logarithmic axes around a spectrum; limits of the densities."""
    low, high = log_limits([data.psd], 1.0, 16.0)
    limits = low / BELOW_DATA, high * 1.5
    log_axes(axes, (log_limits([data.f]), limits))
    axes.set_ylabel("PSD (mm²/Hz)")
    return limits


def _frequencies(axes: Axes, rate_hz: float) -> np.ndarray:
    first, last = axes.get_xlim()
    return np.geomspace(first, min(last, rate_hz / 2), POINTS)


def _stem(
    axes: Axes, line: Sinusoid, data: Spectrum, fit: Fit, how: Keywords, frame_rate_hz: float
) -> None:
    """The sinusoid at f_0: from the continuum up to what it makes of its bin's density."""
    base = float(fit.model.psd(np.array([line.f_0]), frame_rate_hz)[0])
    top = base + float(data.share(line, frame_rate_hz, fit.form).max(initial=0.0))
    axes.vlines(line.f_0, base or axes.get_ylim()[0], top, color=how["color"], lw=1.6, zorder=4)
    axes.plot([line.f_0], [top], "D", color=how["color"], markersize=3.5, zorder=4)


def psd_residual_panel(axes: Axes, shown: Shown) -> None:
    """Residuals in standard deviations, with those of one and two shaded."""
    data, limit = shown.spectrum, MOST_SIGMA
    axes.set(ylim=(-limit, limit), yticks=(-5, 0, 5), ylabel="Residual (σ)")
    for reach in (2, 1):
        axes.axhspan(-reach, reach, color=FAINT, alpha=0.5, lw=0)
    axes.axhline(0, color=INK, lw=0.8)
    if not shown.fit.parts:
        return
    residual = data.residual(shown.fit.model, shown.rate_hz)
    axes.plot(data.f, np.where(np.abs(residual) <= limit, residual, np.nan), **DOTS)
    for where, marker, at in ((residual > limit, "^", 0.92), (residual < -limit, "v", -0.92)):
        at_edge = np.full(int(where.sum()), at * limit)
        axes.plot(data.f[where], at_edge, marker, color=LOOKS["y"].colour, markersize=3)


def _beyond(data: Spectrum, fit: Fit, frame_rate_hz: float) -> str:
    """How many residuals the axis does not hold."""
    if not fit.parts:
        return ""
    count = int((np.abs(data.residual(fit.model, frame_rate_hz)) > MOST_SIGMA).sum())
    return f"{count} residuals beyond {MOST_SIGMA:g} σ" if count else ""


def other_spectra_panel(axes: Axes, shown: Shown) -> None:
    """Data, and the models of other estimators."""
    limits = _density_axes(axes, shown.spectrum)
    panel_title(axes, "Other estimators")
    axes.plot(shown.spectrum.f, shown.spectrum.psd, **DOTS)
    f = _frequencies(axes, shown.rate_hz)
    for other, how in zip(shown.others, OTHERS, strict=False):
        axes.plot(f, near(other.model.psd(f, shown.rate_hz, shown.fit.form), limits), **how)
