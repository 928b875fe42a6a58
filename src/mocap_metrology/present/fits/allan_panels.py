"""Allan deviation of a fit: data, model, components; residuals, of other estimators too."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.model.components import GaussMarkov
from mocap_metrology.present.fits.parts import Fit, drawn_avar, drawn_m, fit_avar
from mocap_metrology.present.fits.shown import (
    BAND,
    BELOW_DATA,
    DATA,
    MODEL,
    OTHERS,
    Shown,
    clip,
    near,
    part_styles,
)
from mocap_metrology.present.plot.curves import NOTHING, log_limits
from mocap_metrology.present.plot.figure import (
    INK,
    LOOKS,
    SMALL_PT,
    Keywords,
    log_axes,
    panel_title,
    say,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LINEAR_PERCENT = 1.0  # residuals of the Allan deviation: linear up to here, then logarithmic
APART = 0.07  # of an axis, between the numbers of two peaks


def allan_panel(axes: Axes, shown: Shown) -> None:
    """Data with their interval, the model, its components."""
    from matplotlib.ticker import NullLocator

    fit, rate = shown.fit, shown.rate_hz
    m, tau, adev, lower, upper = shown.allan.values()
    nearest = np.minimum(upper[np.isfinite(upper)], 3 * adev.max(initial=0))
    low, high = log_limits([adev, nearest])
    limits = low / BELOW_DATA, high
    log_axes(axes, (log_limits([tau]), limits))
    axes.yaxis.set_minor_locator(NullLocator())  # a tick is an artist, and slow
    axes.set_ylabel("Allan deviation (mm)")
    panel_title(axes, "Allan deviation", "" if fit.form == "sampled" else f"model: {fit.form}")
    if not tau.size:
        say(axes, NOTHING)
    grid = drawn_m(int(m.max(initial=2)))
    if fit.parts:
        model = np.sqrt(fit_avar(fit, grid, rate))
        axes.plot(grid / rate, near(model, limits), label=f"model ({fit.estimator})", **MODEL)
    for part, how in zip(fit.parts, part_styles(fit), strict=True):
        values = np.sqrt(drawn_avar(part.component, grid, rate, fit.form))
        axes.plot(grid / rate, near(values, limits), label=part.text, **how)
    axes.plot(tau, adev, zorder=3, label="data", **DATA)
    axes.fill_between(tau, clip(lower, limits), clip(upper, limits), label=shown.band, **BAND)
    _number_peaks(axes, fit)


def _number_peaks(axes: Axes, fit: Fit) -> None:
    """The number of each Gauss-Markov term under its peak, 0.4365 q_c T_c^0.5 at
    tau = 1.893 T_c, where that is on the axes and no other number is near."""
    low, high = np.log10([axes.get_xlim(), axes.get_ylim()]).T
    placed: list[np.ndarray] = []
    for part in fit.parts:
        c = part.component
        if not isinstance(c, GaussMarkov) or c.q_c == 0:
            continue
        peak = 1.893 * c.T_c, 0.4365 * c.q_c * c.T_c**0.5
        at = (np.log10(peak) - low) / (high - low)
        if (
            0.02 < at[0] < 0.98
            and 0.06 < at[1] < 1
            and all(np.hypot(*(at - other)) > APART for other in placed)
        ):
            placed.append(at)
            where: Keywords = {"xytext": (0, -2.5), "textcoords": "offset points"}
            how: Keywords = {"size": SMALL_PT, "ha": "center", "va": "top"}
            axes.annotate(part.name.split()[-1], peak, color=LOOKS["y"].colour, **where, **how)


def _residual(shown: Shown, fit: Fit) -> np.ndarray:
    """Allan deviation of the data over that of a fit, less 1, in per cent."""
    m = shown.allan["m"].round().astype(np.int64)
    with np.errstate(divide="ignore", invalid="ignore"):
        curve: np.ndarray = np.sqrt(fit_avar(fit, m, shown.rate_hz))
        off: np.ndarray = 100 * (shown.allan["adev_mm"] / curve - 1)
    return off


def allan_residual_panel(axes: Axes, shown: Shown) -> None:
    """Data over model, with the interval of the data."""
    _, tau, adev, lower, upper = shown.allan.values()
    off = _residual(shown, shown.fit)
    _percent_axis(axes, off)
    axes.set_ylabel("Residual (%)")
    if shown.fit.parts:
        with np.errstate(invalid="ignore"):
            ends = [100 * ((off / 100 + 1) * end / adev - 1) for end in (lower, upper)]
        axes.fill_between(tau, *(np.clip(end, -1e4, 1e4) for end in ends), **BAND)
        axes.plot(tau, off, **DATA)


def other_residuals_panel(axes: Axes, shown: Shown) -> None:
    """Data over the models of other estimators."""
    found = [_residual(shown, other) for other in shown.others]
    panel_title(axes, "Other estimators")
    axes.set_ylabel("Residual (%)")
    _percent_axis(axes, np.concatenate(found))
    for other, off, how in zip(shown.others, found, OTHERS, strict=False):
        axes.plot(shown.allan["tau_s"], off, label=other.estimator, **how)


def _percent_axis(axes: Axes, values: np.ndarray) -> None:
    """Linear within ±1 %, logarithmic beyond, as far as the values reach."""
    from matplotlib.ticker import FixedLocator, NullLocator, StrMethodFormatter

    finite = np.abs(values[np.isfinite(values)])
    most = 10.0 if finite.max(initial=0.0) <= 20 else 100.0
    axes.set_yscale("symlog", linthresh=LINEAR_PERCENT, linscale=0.8)
    axes.set_ylim(-2.5 * most, 2.5 * most)
    ticks = (-most, -1, 0, 1, most)
    axes.yaxis.set(major_locator=FixedLocator(ticks), minor_locator=NullLocator())
    axes.yaxis.set_major_formatter(StrMethodFormatter("{x:.0f}"))
    axes.axhline(0, color=INK, lw=0.8)
