"""S Figures 6 and 17, of one series: fits to its Allan deviation, and a line in its spectrum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.model.components import Form, NoiseModel, PowerLaw
from mocap_metrology.present.fits.model import drawn_m, total_avar
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.plot.decimate import log_bins
from mocap_metrology.present.plot.figure import (
    GREY,
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
    panel_title,
    say,
    short,
    styled,
)
from mocap_metrology.present.text import captions
from mocap_metrology.present.text.numbers import significant

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DATA: Keywords = {"color": INK, "marker": "o", "markersize": 2.6, "markerfacecolor": "white"}
START: Keywords = {"color": OTHER_LOOKS[1].colour, "lw": 0.7, "ls": "-"}
FINAL: Keywords = {"color": LOOKS["x"].colour, "lw": 1.5, "ls": "-"}
ORDINARY: Keywords = {"color": LOOKS["y"].colour, "lw": 1.3, "ls": (0, (5, 1.6))}
QUANTILE, PERCENT = 0.9, (5.0, 10.0, 20.0, 50.0, 100.0)  # axis of the residuals: one of these
PER_DECADE = 200  # points of a curve: smooth where a sinusoid bends within a few frames


@styled()
def regression_figure(
    data: tuple[np.ndarray, np.ndarray],
    starts: Sequence[NoiseModel],
    ordinary: NoiseModel,
    final: NoiseModel,
    frame_rate_hz: float,
    texts: tuple[str, str, str],
    *,
    form: Form = "continuous",
) -> Picture:
    """S Figure 6: the Allan deviation, every start of annealing, the result after the ant colony
    (relative residuals, S Eq. 13) and ordinary least squares (Levenberg-Marquardt, no weights).

    data: averaging time in s and Allan deviation in mm, (k,) each; starts: annealing's results;
    texts: title, source line, and what the caption adds; form: of the Allan variances that were
    fitted. Below: residuals in per cent of the model.
    """
    tau, adev = (np.asarray(v, dtype=np.float64) for v in data)
    keep = np.isfinite(adev) & (adev > 0)
    tau, adev = tau[keep], adev[keep]
    body = new_figure(texts[0], texts[1], 150.0)
    axes, below = body.subplots(2, sharex=True, height_ratios=(2, 1))
    y_limits = log_limits([adev], 1.0)
    log_axes(axes, (log_limits([tau]), (y_limits[0] / 1.2, y_limits[1] * 1.2)))
    names = {f"{len(starts)} start{'' if len(starts) == 1 else 's'} of annealing": START}
    names["ordinary least squares (Levenberg-Marquardt)"] = ORDINARY
    names["weighted least squares: the best start after the ant colony"] = FINAL
    models = [(s, START) for s in starts] + [(ordinary, ORDINARY), (final, FINAL)]
    m = (tau * frame_rate_hz).round().astype(np.int64)
    last = float(m.max(initial=2))
    fine = np.geomspace(1, last, int(np.log10(last) * PER_DECADE) + 2)
    for model, how in models:
        axes.plot(fine / frame_rate_hz, smooth_adev(model, fine, frame_rate_hz, form), **how)
    axes.plot(tau, adev, ls="", label="data", **DATA)
    for text, how in names.items():
        axes.plot([], [], label=text, **how)
    fitted = [(np.sqrt(total_avar(x.components, m, frame_rate_hz, form)), how) for x, how in models]
    _residuals(below, (tau, adev), fitted)
    panel_title(axes, "Allan deviation", f"model: {form}")
    axes.set_ylabel("Allan deviation (mm)")
    below.set(xlabel=r"Averaging time $\tau$ (s)", ylabel="Data/model − 1 (%)")
    if not tau.size:
        say(axes, "no valid samples")
    legend_below(body, [axes])
    return Picture(body, f"{captions.SKUROWSKI[6]} {texts[2]}")


def smooth_adev(
    model: NoiseModel, m: np.ndarray, frame_rate_hz: float, form: Form = "continuous"
) -> np.ndarray:
    """Allan deviation, mm, at any m >= 1 (k,), to draw: of sampled power laws, which have one at
    whole m only, on straight lines between these in logarithms."""
    if form == "continuous":
        return np.asarray(np.sqrt(model.avar(m, frame_rate_hz, form)))
    parts = (c for c in model.components if not isinstance(c, PowerLaw))
    laws = NoiseModel(tuple(c for c in model.components if isinstance(c, PowerLaw)))
    whole = drawn_m(int(np.ceil(m.max())))
    of_laws = np.log(np.maximum(total_avar(laws.components, whole, frame_rate_hz, form), 1e-300))
    broad = np.exp(np.interp(np.log(m), np.log(whole), of_laws))
    return np.asarray(np.sqrt(sum((c.avar(m, frame_rate_hz, form) for c in parts), broad)))


def _residuals(
    axes: Axes,
    data: tuple[np.ndarray, np.ndarray],
    curves: Sequence[tuple[np.ndarray, Keywords]],
) -> None:
    """In per cent; the axis holds 90 % of each curve, of the final one all."""
    tau, adev = data
    with np.errstate(divide="ignore", invalid="ignore"):
        off = [np.where(curve > 0, 100 * (adev / curve - 1), np.nan) for curve, _ in curves]
    sizes = [np.abs(o[np.isfinite(o)]) for o in off]
    reach = max((float(np.quantile(s, QUANTILE)) for s in sizes if s.size), default=1.0)
    if sizes and sizes[-1].size:
        reach = max(reach, float(sizes[-1].max()))
    limit = next((p for p in PERCENT if p >= 1.05 * reach), PERCENT[-1])
    axes.set_ylim(-limit, limit)
    axes.axhline(0, color=INK, lw=0.6)
    for values, (_, how) in zip(off, curves, strict=True):
        axes.plot(tau, np.where(np.abs(values) < 3 * limit, values, np.nan), **how)


HALF_WIDTH_HZ = 2.0  # of the close view
BINS_PER_DECADE = 40
MARK: Keywords = {"color": INK, "lw": 0.8, "ls": (0, (1.2, 1.2)), "zorder": 1}
UNITS = (("mm²", 1.0), ("µm²", 1e6), ("nm²", 1e12))  # how many are in 1 mm²
Spectra = Mapping[str, tuple[np.ndarray, np.ndarray]]


@styled()
def periodic_figure(
    spectra: Spectra, line_hz: float, title: str, source: str, remarks: str = ""
) -> Picture:
    """Welch spectra with the line marked: all in one panel, and a close view of each.

    spectra: name (of a camera type) -> f in Hz, ascending, and density in mm^2/Hz, (k,) each;
    line_hz: where the line should be; source: the line at the foot; remarks: what the caption adds.
    The whole is shown as medians of bins with bands up to their greatest values; the close views
    show every point.
    """
    looks = dict(zip(spectra, (*LOOKS.values(), *OTHER_LOOKS), strict=False))
    rows = max(len(looks), 1)
    body = new_figure(title, source, 40.0 + max(29.0 * rows, 60.0))
    cells = body.add_gridspec(rows, 2, width_ratios=(2, 1))
    whole = body.add_subplot(cells[:, 0])
    _whole(whole, spectra, looks, line_hz)
    close = [body.add_subplot(cells[k, 1]) for k in range(len(looks))]
    for axes, (name, look) in zip(close, looks.items(), strict=True):
        _close(axes, spectra[name], (name, look), line_hz)
        axes.tick_params(labelbottom=axes is close[-1])
    if close:
        close[-1].set_xlabel("Frequency (Hz)")
    letters([whole, *close])
    legend_below(body, [whole])
    return Picture(body, f"{captions.SKUROWSKI[17]} {remarks}")


def _whole(axes: Axes, spectra: Spectra, looks: Mapping[str, Look], line_hz: float) -> None:
    bins = {name: log_bins(*spectra[name], BINS_PER_DECADE) for name in looks}
    y = log_limits([v for b in bins.values() for v in (b.median, b.high)], 2.0)
    log_axes(axes, (log_limits([b.centre for b in bins.values()]), y))
    for name, look in looks.items():
        b = bins[name]
        how: Keywords = {"color": look.colour, "ls": look.dashes}
        axes.plot(b.centre, b.median, label=short(name), **how)
        axes.plot(b.centre, b.high, color=look.colour, lw=0.5)
        axes.fill_between(b.centre, b.median, b.high, color=look.colour, alpha=0.2, lw=0)
    axes.fill([], [], color=GREY, alpha=0.25, lw=0, label="up to the maximum of a bin")
    axes.axvline(line_hz, label=f"{line_hz:g} Hz", **MARK)
    axes.set(title="Whole spectra", xlabel="Frequency (Hz)")
    axes.set_ylabel("Power spectral density (mm²/Hz)")
    if not any(b.centre.size for b in bins.values()):
        say(axes, "no spectrum")


def _close(
    axes: Axes, spectrum: tuple[np.ndarray, np.ndarray], who: tuple[str, Look], line_hz: float
) -> None:
    """Linear axes within 2 Hz of the line; over them the excess of its point."""
    f, psd = (np.asarray(v, dtype=np.float64) for v in spectrum)
    near = (np.abs(f - line_hz) <= HALF_WIDTH_HZ) & np.isfinite(psd)
    f, psd = f[near], psd[near]
    greatest = float(psd.max(initial=0.0))
    unit, per_mm2 = next((u for u in UNITS if greatest * u[1] >= 1.0), UNITS[-1])
    axes.set_xlim(line_hz - HALF_WIDTH_HZ, line_hz + HALF_WIDTH_HZ)
    axes.set_ylim(0.0, 1.1 * greatest * per_mm2 or 1.0)
    axes.axvline(line_hz, **MARK)
    axes.plot(f, psd * per_mm2, color=who[1].colour, lw=0.6)
    times = significant(greatest / float(np.median(psd))) if greatest > 0 else ""
    panel_title(axes, short(who[0]), f"{times} × median" if times else "")
    axes.set_ylabel(f"{unit}/Hz")
