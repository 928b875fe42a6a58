"""One series and what was fitted to it: Allan deviation and spectrum, components, residuals."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mocap_metrology.noise.fit.estimates import DEFAULT_ESTIMATOR, NoiseRow, correlation_class
from mocap_metrology.noise.model.components import Form, GaussMarkov, PowerLaw, Sinusoid
from mocap_metrology.present.drawing.axes import Limits, decade_axis, linear_axis, log_limits
from mocap_metrology.present.drawing.legend import ROW_MM, Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
    FAINT,
    GREY,
    INK,
    LOOKS,
    MARGIN_MM,
    SMALL_PT,
    WIDTH_MM,
    Keywords,
    Sheet,
    blank_sheet,
    head,
    label_axes,
    lines_mm,
    styled,
    wrap,
)
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

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEFT_MM, BETWEEN_MM, RIGHT_MM, TITLE_MM = 16.5, 18.0, 3.0, 5.5
PANEL_MM = (WIDTH_MM - LEFT_MM - BETWEEN_MM - RIGHT_MM) / 2, 62.0
RESIDUAL_MM, GAP_MM, LABELS_MM, BELOW_MM = 24.0, 3.0, 11.5, 1.5
BELOW_DATA = 8.0  # an axis goes so many times below the least datum, for components
MOST_SIGMA = 6.0  # of a spectrum's residuals; what is farther stands at the edge
LINEAR_PERCENT = 1.0  # residuals of the Allan deviation: linear up to here, then logarithmic
DASHES = (
    (0, (6, 1.4)),
    (0, (1.2, 1.2)),
    (0, (7, 1.4, 1.4, 1.4)),
    (0, (3, 1.2)),
    (0, (5, 1.2, 1.2, 1.2, 1.2, 1.2)),
)
DATA: Keywords = {"color": INK, "marker": "o", "markersize": 2.2, "markerfacecolor": "white"}
DOTS: Keywords = {"color": GREY, "marker": "o", "markersize": 1.4, "mew": 0}
BAND: Keywords = {"color": GREY, "alpha": 0.3, "lw": 0}
MODEL: Keywords = {"color": INK, "lw": 1.5, "ls": "-"}
UNDER: Keywords = {"color": INK, "lw": 1.0, "ls": (0, (2.2, 1.2))}
# Of other estimators: none of the components' colours
OTHERS: tuple[Keywords, ...] = tuple(
    {"color": colour, "lw": 1.0, "ls": dashes}
    for colour, dashes in (
        *(("#2f8f4e", "-"), ("#d9a300", (0, (4, 1.2)))),
        *(("#b8389c", (0, (7, 1.2, 1.2, 1.2, 1.2, 1.2))), ("#7a7a7a", (0, (1.5, 1.5)))),
        ("#8a5a3c", "-"),
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


@styled()
def fit_figure(
    title: str,
    allan: Mapping[str, np.ndarray],
    periodogram: Mapping[str, np.ndarray],
    estimates: Mapping[str, Sequence[NoiseRow]],
    frame_rate_hz: float,
    note: str = "",
    *,
    main: str = DEFAULT_ESTIMATOR,
    confidence: float = 0.683,
    lines_subtracted: bool = True,
) -> Figure:
    """Figure of one series: data, fitted model and its components, residuals below.

    allan: arrays `m`, `tau_s`, `adev_mm`, `adev_lower_mm`, `adev_upper_mm`, `n_terms`; periodogram:
    arrays `f_hz`, `f_lower_hz`, `f_upper_hz`, `psd_mm2_hz`, `dof`; estimates: rows of noise.csv of
    this series by estimator. Components are those of `main`; models are
    drawn in the form of Allan variances they were fitted in, spectra in that of `main`. confidence:
    of the intervals of `allan`; lines_subtracted: whether the sinusoid is gone from `periodogram`.
    """
    duration = recorded_s(allan, frame_rate_hz)
    fits = {name: fit_of(name, rows, duration) for name, rows in estimates.items() if rows}
    chosen = fits.pop(main, None) or fit_of(main, [])
    others = [fit for fit in fits.values() if fit.parts]
    groups = [group for group in _entries(chosen, others, confidence) if group]
    width = WIDTH_MM - 2 * MARGIN_MM
    below = _below(chosen, bool(estimates.get(main)), lines_subtracted, width)
    key_top = TITLE_MM + PANEL_MM[1] + GAP_MM + RESIDUAL_MM + LABELS_MM
    key_mm = sum(strip_height(group, width) for group in groups) + BELOW_MM
    sheet = blank_sheet(key_top + key_mm + lines_mm(len(below), SMALL_PT) + 1.5, title, note)
    spectrum = Spectrum.of(periodogram, lines=not lines_subtracted)
    _allan_column(sheet, LEFT_MM, allan, chosen, others, frame_rate_hz)
    left = LEFT_MM + PANEL_MM[0] + BETWEEN_MM
    _psd_column(sheet, left, spectrum, chosen, others, frame_rate_hz, confidence)
    for group in groups:
        strip(sheet, MARGIN_MM, key_top, width, group)
        key_top += strip_height(group, width)
    if below:
        canvas = sheet.canvas(MARGIN_MM, key_top + BELOW_MM, width, ROW_MM)
        how: Keywords = {"size": SMALL_PT, "color": GREY, "va": "top", "linespacing": 1.35}
        canvas.text(0, ROW_MM, "\n".join(below), **how)
    return sheet.figure


def _entries(fit: Fit, others: Sequence[Fit], confidence: float) -> list[list[Entry]]:
    """The key, in groups: data, model and other estimators; power laws; the other components."""
    first = [Entry(f"data, {100 * confidence:.3g} % interval", patch=BAND, dot=DATA)]
    if fit.parts:
        first.append(Entry(f"model ({fit.estimator})", line=MODEL))
    first += [Entry(other.estimator, line=how) for other, how in zip(others, OTHERS, strict=False)]
    groups: list[list[Entry]] = [first, [], []]
    for part, how in zip(fit.parts, part_styles(fit), strict=True):
        place = groups[1 if isinstance(part.component, PowerLaw) else 2]
        place.append(Entry(part.text, line=how))
    return groups


def _below(fit: Fit, estimated: bool, lines_subtracted: bool, width: float) -> list[str]:
    """What stands below the key: what was not detected, and what the signs mean."""
    said = [] if estimated else [f"No estimate by {fit.estimator}."]
    if fit.absent:
        said.append(f"Not detected (95 % limits): {', '.join(fit.absent)}.")
    if fit.under:
        said.append(
            f"Under the noise: {fit.under}; subtracted from the spectrum; part of the Allan "
            "deviation of the data and of the model."
        )
    classes = [
        f"{part.name.split()[-1]} {correlation_class(part.component.T_c)}"
        for part in fit.parts
        if isinstance(part.component, GaussMarkov)
    ]
    if classes:
        said.append(
            "GM: Gauss-Markov component, its number under its peak; classes of T_c after S 4.6: "
            f"{', '.join(classes)}."
        )
    if fit.parts:
        said.append(
            "Residuals: data/model − 1, between −1 and 1 % on a linear axis and beyond on a "
            "logarithmic one; of the spectrum over its standard deviation, √(2/dof). Shaded: the "
            "interval of the data; 1 and 2 σ."
        )
    if fit.model.lines:
        gone = ", which it was subtracted from" if lines_subtracted else ""
        said.append(f"The stem at f₀ is as high as the sinusoid would raise its bin{gone}.")
    return wrap(" ".join(said), SMALL_PT, width)


def _columns_axes(sheet: Sheet, left: float) -> tuple[Axes, Axes]:
    width, height = PANEL_MM
    above = sheet.axes(left, TITLE_MM, width, height)
    return above, sheet.axes(left, TITLE_MM + height + GAP_MM, width, RESIDUAL_MM)


def _nothing(axes: Axes) -> None:
    how: Keywords = {"transform": axes.transAxes, "ha": "center", "va": "center", "color": GREY}
    axes.text(0.5, 0.5, "no valid samples", **how)


# ---- Allan deviation


def _allan_column(
    sheet: Sheet, left: float, allan: Mapping[str, np.ndarray], fit: Fit, others: Sequence[Fit],
    frame_rate_hz: float,
) -> None:  # fmt: skip
    tau0 = 1 / frame_rate_hz
    axes, below = _columns_axes(sheet, left)
    m, tau, adev, lower, upper = (
        np.asarray(allan[k], dtype=np.float64)
        for k in ("m", "tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm")
    )
    keep = np.isfinite(adev) & (adev > 0)
    m, tau, adev, lower, upper = (v[keep] for v in (m, tau, adev, lower, upper))
    m = m.round().astype(np.int64)
    x_limits = log_limits([tau])
    low, high = log_limits([adev, np.minimum(upper[np.isfinite(upper)], 3 * adev.max(initial=0))])
    y_limits = low / BELOW_DATA, high
    decade_axis(axes, "x", x_limits, PANEL_MM[0])
    decade_axis(axes, "y", y_limits, PANEL_MM[1])
    decade_axis(below, "x", x_limits, PANEL_MM[0])
    axes.tick_params(labelbottom=False)
    head(axes, "Allan deviation", "" if fit.form == "sampled" else f"model: {fit.form}")
    label_axes(axes, y="Allan deviation (mm)", y_mm=12.5)
    label_axes(below, x="Averaging time τ (s)", y="Residual (%)", y_mm=12.5)
    if not tau.size:
        _nothing(axes)
    axes.fill_between(tau, _clip(lower, y_limits), _clip(upper, y_limits), **BAND)
    grid = drawn_m(int(m.max(initial=2)))
    _draw_models(axes, grid * tau0, y_limits, fit, others, lambda c, form: drawn_avar(
        c, grid, frame_rate_hz, form), lambda f: fit_avar(f, grid, frame_rate_hz), 0.5)  # fmt: skip
    axes.plot(tau, adev, zorder=3, ls="", **DATA)
    _number_peaks(axes, fit, (x_limits, y_limits))
    with np.errstate(divide="ignore", invalid="ignore"):
        curves = [np.sqrt(fit_avar(f, m, frame_rate_hz)) for f in (fit, *others)]
        off = [100 * (adev / curve - 1) for curve in curves]
        ends = [100 * (end / curves[0] - 1) for end in (lower, upper)]
    _percent_axis(below, off[0])
    if fit.parts:
        below.fill_between(tau, *(np.clip(end, -1e4, 1e4) for end in ends), **BAND)
        below.plot(tau, off[0], ls="", **DATA)
    for values, how in zip(off[1:], OTHERS, strict=False):
        below.plot(tau, values, **how)


def _number_peaks(axes: Axes, fit: Fit, limits: tuple[Limits, Limits]) -> None:
    """The number of each Gauss-Markov term under its peak, 0.4365 q_c T_c^0.5 at
    tau = 1.893 T_c, where that is on the axes and no other number is near."""
    placed: list[np.ndarray] = []
    spans = [np.log10(high / low) for low, high in limits]
    for part in fit.parts:
        c = part.component
        if not isinstance(c, GaussMarkov) or c.q_c == 0:
            continue
        peak = 1.893 * c.T_c, 0.4365 * c.q_c * c.T_c**0.5
        at = [
            np.log10(v / low) / span for v, (low, _), span in zip(peak, limits, spans, strict=True)
        ]
        mm = np.array([at[0] * PANEL_MM[0], at[1] * PANEL_MM[1] - 2.2])
        inside = 1.5 < mm[0] < PANEL_MM[0] - 1.5 and 1.5 < mm[1] < PANEL_MM[1] - 1.5
        if inside and all(np.hypot(*(mm - other)) > 3.5 for other in placed):
            placed.append(mm)
            place = mm / PANEL_MM
            how: Keywords = {
                "transform": axes.transAxes,
                "size": SMALL_PT,
                "ha": "center",
                "va": "center",
            }
            axes.text(place[0], place[1], part.name.split()[-1], color=LOOKS["y"].colour, **how)


def _clip(values: np.ndarray, limits: Limits) -> np.ndarray:
    clipped: np.ndarray = np.clip(
        np.nan_to_num(values, nan=limits[0]), limits[0] / 10, limits[1] * 10
    )
    return clipped


def _percent_axis(axes: Axes, values: np.ndarray) -> None:
    """Linear within ±1 %, logarithmic beyond, as far as the values reach; small ticks show it."""
    from matplotlib.ticker import FixedLocator

    finite = np.abs(values[np.isfinite(values)])
    most = 10.0 if finite.max(initial=0.0) <= 20 else 100.0
    axes.set_yscale("symlog", linthresh=LINEAR_PERCENT, linscale=0.8)
    axes.set_ylim(-2.5 * most, 2.5 * most)
    ticks = [v for v in (-100, -10, -1, 0, 1, 10, 100) if abs(v) <= most]
    axes.yaxis.set_major_locator(FixedLocator(ticks))
    between = np.outer([v for v in (0.1, 1.0, 10.0) if v < most], np.arange(2, 10)).ravel()
    axes.yaxis.set_minor_locator(FixedLocator([*-between, *between]))
    axes.tick_params(axis="y", which="minor", length=1.5, width=0.4)
    axes.set_yticklabels([str(tick).replace("-", "−") for tick in ticks])
    axes.grid(visible=True, axis="y")
    axes.axhline(0, color=INK, lw=0.8)


# ---- spectrum


def _psd_column(
    sheet: Sheet, left: float, data: Spectrum, fit: Fit, others: Sequence[Fit],
    frame_rate_hz: float, confidence: float,
) -> None:  # fmt: skip
    tau0 = 1 / frame_rate_hz
    axes, below = _columns_axes(sheet, left)
    x_limits = log_limits([data.f])
    low, high = log_limits([data.psd], 1.0, 16.0)
    y_limits = low / BELOW_DATA, high * 1.5
    decade_axis(axes, "x", x_limits, PANEL_MM[0])
    decade_axis(axes, "y", y_limits, PANEL_MM[1])
    decade_axis(below, "x", x_limits, PANEL_MM[0])
    axes.tick_params(labelbottom=False)
    head(axes, "Power spectral density", _beyond(data, fit, frame_rate_hz))
    label_axes(axes, y="PSD (mm²/Hz)", y_mm=12.5)
    label_axes(below, x="Frequency (Hz)", y="Residual (σ)", y_mm=12.5)
    if not data.f.size:
        _nothing(axes)
    lower, upper = (_clip(end, y_limits) for end in data.interval(confidence))
    axes.vlines(data.f, lower, upper, color=GREY, lw=0.5, alpha=0.6)
    axes.plot(data.f, data.psd, ls="", **DOTS)
    f = np.geomspace(x_limits[0], min(x_limits[1], 0.5 / tau0), 300)
    _draw_models(axes, f, y_limits, fit, others,
                 lambda c, _: c.psd(f, frame_rate_hz, form=fit.form),
                 lambda other: other.model.psd(f, frame_rate_hz, fit.form), 1.0)  # fmt: skip
    for part, how in zip(fit.parts, part_styles(fit), strict=True):
        if isinstance(part.component, Sinusoid):
            _stem(axes, part.component, data, fit, how, frame_rate_hz)
    _sigma_panel(below, data, fit, frame_rate_hz)


def _stem(
    axes: Axes, line: Sinusoid, data: Spectrum, fit: Fit, how: Keywords, frame_rate_hz: float
) -> None:
    """The sinusoid at f_0: from the continuum up to what it makes of its bin's density."""
    base = float(fit.model.psd(np.array([line.f_0]), frame_rate_hz)[0])
    top = base + float(data.share(line, frame_rate_hz, fit.form).max(initial=0.0))
    axes.vlines(line.f_0, base or axes.get_ylim()[0], top, color=how["color"], lw=1.6, zorder=4)
    axes.plot([line.f_0], [top], "D", color=how["color"], markersize=3.5, zorder=4)


def _sigma_panel(axes: Axes, data: Spectrum, fit: Fit, frame_rate_hz: float) -> None:
    """Residuals in standard deviations, with those of one and two shaded."""
    limit = MOST_SIGMA
    linear_axis(axes, "y", (-limit, limit), 5)
    for reach in (2, 1):
        axes.axhspan(-reach, reach, color=FAINT, alpha=0.5, lw=0)
    axes.axhline(0, color=INK, lw=0.8)
    if not fit.parts:
        return
    residual = data.residual(fit.model, frame_rate_hz)
    axes.plot(data.f, np.where(np.abs(residual) <= limit, residual, np.nan), ls="", **DOTS)
    beyond = [residual > limit, residual < -limit]
    for where, marker, at in zip(beyond, "^v", (0.92, -0.92), strict=True):
        at_edge = np.full(int(where.sum()), at * limit)
        axes.plot(data.f[where], at_edge, marker, color=LOOKS["y"].colour, markersize=3)


def _beyond(data: Spectrum, fit: Fit, frame_rate_hz: float) -> str:
    """How many residuals the axis does not hold."""
    if not fit.parts:
        return ""
    count = int((np.abs(data.residual(fit.model, frame_rate_hz)) > MOST_SIGMA).sum())
    return f"{count} beyond {MOST_SIGMA:g} σ" if count else ""


# ---- both


def _draw_models(
    axes: Axes, x: np.ndarray, y_limits: Limits, fit: Fit, others: Sequence[Fit],
    of_component: Callable[[Any, Form], np.ndarray],
    of_fit: Callable[[Fit], np.ndarray], power: float,
) -> None:  # fmt: skip
    """Components, other estimators and the model; `power` of what the functions return."""
    for other, how in zip(others, OTHERS, strict=False):
        axes.plot(x, _shown(of_fit(other) ** power, y_limits), **how)
    for part, how in zip(fit.parts, part_styles(fit), strict=True):
        if power == 1.0 and isinstance(part.component, (Sinusoid, Under)):  # without a density
            continue
        values = of_component(part.component, fit.form) ** power
        axes.plot(x, _shown(values, y_limits), **how)
    if fit.parts:
        axes.plot(x, _shown(of_fit(fit) ** power, y_limits), **MODEL)


def _shown(values: np.ndarray, limits: Limits) -> np.ndarray:
    """Values on the axis and a little beyond, so that a file holds no more than is seen."""
    near = (values > limits[0] / 3) & (values < limits[1] * 3)
    return np.where(near, values, np.nan)
