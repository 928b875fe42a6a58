"""One series and what was fitted to it: Allan deviation and spectrum, components, residuals, and
other estimators in panels of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, NoiseRow, correlation_class
from mocap_metrology.noise.model.components import GaussMarkov, PowerLaw, Sinusoid
from mocap_metrology.present.fits.parts import (
    Fit,
    Spectrum,
    Under,
    drawn_avar,
    drawn_m,
    fit_avar,
    fit_of,
    recorded_s,
)
from mocap_metrology.present.plot.curves import NOTHING, Limits, log_limits
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
LABEL_AT = -0.15  # of the width of a panel; matplotlib would measure every tick label for it
BELOW_DATA = 8.0  # an axis goes so many times below the least datum, for components
MOST_SIGMA = 6.0  # of a spectrum's residuals; what is farther stands at the edge
LINEAR_PERCENT = 1.0  # residuals of the Allan deviation: linear up to here, then logarithmic
POINTS = 300  # of a density
APART = 0.07  # of an axis, between the numbers of two peaks
DASHES = (
    (0, (6, 1.4)),
    (0, (1.2, 1.2)),
    (0, (7, 1.4, 1.4, 1.4)),
    (0, (3, 1.2)),
    (0, (5, 1.2, 1.2, 1.2, 1.2, 1.2)),
)
DATA: Keywords = {"color": INK, "marker": "o", "ms": 2.2, "markerfacecolor": "white", "ls": ""}
DOTS: Keywords = {"color": GREY, "marker": "o", "ms": 1.4, "mew": 0, "ls": ""}
BAND: Keywords = {"color": GREY, "alpha": 0.3, "lw": 0}
MODEL: Keywords = {"color": INK, "lw": 1.5, "ls": "-", "zorder": 2.5}
UNDER: Keywords = {"color": INK, "lw": 1.0, "ls": (0, (2.2, 1.2))}
OTHERS: tuple[Keywords, ...] = tuple(  # other estimators: none of the components' colours
    {"color": colour, "lw": 1.0, "ls": dashes}
    for colour, dashes in (
        *(("#23733d", "-"), ("#8a6500", (0, (4, 1.2)))),
        *(("#a8308e", (0, (7, 1.2, 1.2, 1.2, 1.2, 1.2))), ("#6b6b6b", (0, (1.5, 1.5)))),
        ("#7a4f33", (0, (9, 1.2))),
    )
)


def part_styles(fit: Fit) -> list[Keywords]:
    """How each part is drawn: power laws blue, Gauss-Markov terms red, the sinusoid cyan; dashes
    by alpha or number. What is no noise has the colour of the model."""
    styles: list[Keywords] = []
    dashes: str | tuple[int, tuple[float, ...]]
    number = 0
    for part in fit.parts:
        if isinstance(part.component, PowerLaw):
            colour, dashes = LOOKS["x"].colour, DASHES[part.component.alpha + 2]
        elif isinstance(part.component, GaussMarkov):
            colour, dashes = LOOKS["y"].colour, DASHES[number % len(DASHES)]
            number += 1
        elif isinstance(part.component, Under):
            styles.append(UNDER)
            continue
        else:
            colour, dashes = LOOKS["z"].colour, "-"
        styles.append({"color": colour, "ls": dashes, "lw": 1.0})
    return styles


@dataclass(frozen=True)
class _Shown:
    """What is drawn. allan: columns of the Allan deviation where there is one, float64."""

    allan: Mapping[str, np.ndarray]
    spectrum: Spectrum
    fit: Fit
    others: Sequence[Fit]
    rate_hz: float
    confidence: float

    @property
    def band(self) -> str:
        return f"{100 * self.confidence:.3g} % interval"


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
    chosen = fits.pop(main, None) or fit_of(main, [])
    shown = _Shown(
        _positive(allan),
        Spectrum.of(periodogram, lines=not lines_subtracted),
        chosen,
        [fit for fit in fits.values() if fit.parts],
        frame_rate_hz,
        confidence,
    )
    rows = ["ab", "cd", "ef"] if shown.others else ["ab", "cd"]
    heights = ROWS_MM[: len(rows)]
    n_entries = 3 + len(chosen.parts) + len(shown.others)
    body = new_figure(title, source, 28.0 + sum(heights) + 1.9 * n_entries)
    panels = body.subplot_mosaic("\n".join(rows), height_ratios=heights)
    _share(panels)
    _allan(panels["a"], shown)
    _psd(panels["b"], shown)
    _allan_residual(panels["c"], shown)
    _psd_residual(panels["d"], shown)
    if shown.others:
        _other_residuals(panels["e"], shown)
        _other_spectra(panels["f"], shown)
    letters(panels.values())
    legend_below(body, panels.values(), columns=3)
    caption = _caption(shown, bool(estimates.get(main)), lines_subtracted)
    return Picture(body, f"{caption} {remarks}".strip())


def _positive(allan: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Where there is a deviation that a logarithmic axis can show."""
    names = ("m", "tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm")
    columns = {name: np.asarray(allan[name], dtype=np.float64) for name in names}
    keep = np.isfinite(columns["adev_mm"]) & (columns["adev_mm"] > 0)
    return {name: values[keep] for name, values in columns.items()}


def _share(panels: Mapping[str, Axes]) -> None:
    """One x axis a column, its label below the last panel; labels of y in line."""
    for column, label in (("ace", "Averaging time τ (s)"), ("bdf", "Frequency (Hz)")):
        own = [panels[name] for name in column if name in panels]
        own[-1].set_xlabel(label)
        for axes in own[1:]:
            axes.sharex(own[0])
        for axes in own[:-1]:
            axes.tick_params(labelbottom=False)
    for axes in panels.values():
        axes.yaxis.set_label_coords(LABEL_AT, 0.5)


def _near(values: np.ndarray, limits: Limits) -> np.ndarray:
    """Values on the axis and a little beyond, so that a file holds no more than is seen."""
    near = (values > limits[0] / 3) & (values < limits[1] * 3)
    return np.where(near, values, np.nan)


def _clip(values: np.ndarray, limits: Limits) -> np.ndarray:
    known = np.nan_to_num(values, nan=limits[0])
    clipped: np.ndarray = np.clip(known, limits[0] / 10, limits[1] * 10)
    return clipped


# ---- Allan deviation


def _allan(axes: Axes, shown: _Shown) -> None:
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
        axes.plot(grid / rate, _near(model, limits), label=f"model ({fit.estimator})", **MODEL)
    for part, how in zip(fit.parts, part_styles(fit), strict=True):
        values = np.sqrt(drawn_avar(part.component, grid, rate, fit.form))
        axes.plot(grid / rate, _near(values, limits), label=part.text, **how)
    axes.plot(tau, adev, zorder=3, label="data", **DATA)
    axes.fill_between(tau, _clip(lower, limits), _clip(upper, limits), label=shown.band, **BAND)
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


def _residual(shown: _Shown, fit: Fit) -> np.ndarray:
    """Allan deviation of the data over that of a fit, less 1, in per cent."""
    m = shown.allan["m"].round().astype(np.int64)
    with np.errstate(divide="ignore", invalid="ignore"):
        curve: np.ndarray = np.sqrt(fit_avar(fit, m, shown.rate_hz))
        off: np.ndarray = 100 * (shown.allan["adev_mm"] / curve - 1)
    return off


def _allan_residual(axes: Axes, shown: _Shown) -> None:
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


def _other_residuals(axes: Axes, shown: _Shown) -> None:
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


# ---- spectrum


def _psd(axes: Axes, shown: _Shown) -> None:
    """Data with their interval, the model, its components."""
    data, fit, rate = shown.spectrum, shown.fit, shown.rate_hz
    limits = _density_axes(axes, data)
    panel_title(axes, "Power spectral density", _beyond(data, fit, rate))
    if not data.f.size:
        say(axes, NOTHING)
    gap = np.full(data.f.size, np.nan)
    ends = [_clip(end, limits) for end in data.interval(shown.confidence)]
    strokes = np.column_stack([*ends, gap]).ravel()  # one line for all: matplotlib's are slow
    axes.plot(np.repeat(data.f, 3), strokes, color=GREY, lw=0.5, alpha=0.6)
    axes.plot(data.f, data.psd, **DOTS)
    f = _frequencies(axes, rate)
    for part, how in zip(fit.parts, part_styles(fit), strict=True):
        if isinstance(part.component, Sinusoid):
            _stem(axes, part.component, data, fit, how, rate)
        elif not isinstance(part.component, Under):  # which has no density
            values = part.component.psd(f, rate, form=fit.form)
            axes.plot(f, _near(values, limits), **how)
    if fit.parts:
        axes.plot(f, _near(fit.model.psd(f, rate, fit.form), limits), **MODEL)


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


def _psd_residual(axes: Axes, shown: _Shown) -> None:
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


def _other_spectra(axes: Axes, shown: _Shown) -> None:
    """Data, and the models of other estimators."""
    limits = _density_axes(axes, shown.spectrum)
    panel_title(axes, "Other estimators")
    axes.plot(shown.spectrum.f, shown.spectrum.psd, **DOTS)
    f = _frequencies(axes, shown.rate_hz)
    for other, how in zip(shown.others, OTHERS, strict=False):
        axes.plot(f, _near(other.model.psd(f, shown.rate_hz, shown.fit.form), limits), **how)


# ---- caption


def _caption(shown: _Shown, estimated: bool, lines_subtracted: bool) -> str:
    """What the panels show, what was not detected, and what the signs mean."""
    fit = shown.fit
    told = [captions.FIT, captions.OTHER_FITS if shown.others else ""]
    told.append("" if estimated else f"No estimate by {fit.estimator}.")
    if fit.absent:
        told.append(f"Not detected (95 % limits): {', '.join(fit.absent)}.")
    if fit.under:
        told.append(
            f"Under the noise: {fit.under}; subtracted from the spectrum; part of the Allan "
            "deviation of the data and of the model."
        )
    classes = [
        f"{part.name.split()[-1]} {correlation_class(part.component.T_c)}"
        for part in fit.parts
        if isinstance(part.component, GaussMarkov)
    ]
    if classes:
        told.append(f"{captions.GAUSS_MARKOV} {', '.join(classes)}.")
    if fit.model.lines:
        gone = ", which it was subtracted from" if lines_subtracted else ""
        told.append(f"The stem at f_0 is as high as the sinusoid would raise its bin{gone}.")
    return " ".join(filter(None, told))
