"""S Figures 6 and 17, of one series: fits to its Allan deviation, and a line in its spectrum."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.model.components import Form, NoiseModel, PowerLaw
from mocap_metrology.noise.model.curves import drawn_m, total_avar
from mocap_metrology.present.plot.curves import ADEV_AXES, log_limits, positive
from mocap_metrology.present.plot.decimate import log_bins
from mocap_metrology.present.plot.figure import (
    GREY,
    INK,
    LOOKS,
    OTHER_LOOKS,
    Keywords,
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
HALF_WIDTH_HZ = 2.0  # of the close view
BINS_PER_DECADE = 40
MARK: Keywords = {"color": INK, "lw": 0.8, "ls": (0, (1.2, 1.2)), "zorder": 1}
UNITS = (("mm²", 1.0), ("µm²", 1e6), ("nm²", 1e12))  # how many are in 1 mm²
Spectra = Mapping[str, tuple[np.ndarray, np.ndarray]]


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
    fitted. Below: residuals in per cent of the model; the axis holds 90 % of each curve, of the
    final one all.
    """
    tau, adev = (np.asarray(v, dtype=np.float64) for v in data)
    tau, adev = tau[adev > 0], adev[adev > 0]
    body = new_figure(texts[0], texts[1], 150.0)
    axes, below = body.subplots(2, sharex=True, height_ratios=(2, 1))
    low, high = log_limits([adev], 1.0)
    log_axes(axes, (log_limits([tau]), (low / 1.2, high * 1.2)))
    m = (tau * frame_rate_hz).round().astype(np.int64)
    last = float(m.max(initial=2))
    fine = np.geomspace(1, last, int(np.log10(last) * PER_DECADE) + 2)
    reach = [1.0]
    for model, how in [(s, START) for s in starts] + [(ordinary, ORDINARY), (final, FINAL)]:
        axes.plot(fine / frame_rate_hz, smooth_adev(model, fine, frame_rate_hz, form), **how)
        curve = positive(np.sqrt(total_avar(model.components, m, frame_rate_hz, form)))
        off = 100 * (adev / curve - 1)
        below.plot(tau, off, **how)
        sizes = np.abs(np.nan_to_num(off)) if tau.size else np.zeros(1)
        reach.append(float(np.quantile(sizes, 1.0 if how is FINAL else QUANTILE)))
    limit = next((p for p in PERCENT if p >= 1.05 * max(reach)), PERCENT[-1])
    below.set(ylim=(-limit, limit), xlabel=ADEV_AXES[0], ylabel="Data/model − 1 (%)")
    below.axhline(0, color=INK, lw=0.6)
    axes.plot(tau, adev, ls="", label="data", **DATA)
    for text, how in (
        (f"{len(starts)} start{'' if len(starts) == 1 else 's'} of annealing", START),
        ("ordinary least squares (Levenberg-Marquardt)", ORDINARY),
        ("weighted least squares: the best start after the ant colony", FINAL),
    ):
        axes.plot([], [], label=text, **how)
    panel_title(axes, "Allan deviation", f"model: {form}")
    axes.set_ylabel(ADEV_AXES[1])
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
    laws = [c for c in model.components if isinstance(c, PowerLaw)]
    whole = drawn_m(int(np.ceil(m.max())))
    of_laws = np.log(np.maximum(total_avar(laws, whole, frame_rate_hz, form), 1e-300))
    broad = np.exp(np.interp(np.log(m), np.log(whole), of_laws))
    others = [c for c in model.components if not isinstance(c, PowerLaw)]
    return np.asarray(np.sqrt(broad + total_avar(others, m, frame_rate_hz, form)))


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
    close = [body.add_subplot(cells[k, 1]) for k in range(len(looks))]
    bins = {name: log_bins(*spectra[name], BINS_PER_DECADE) for name in looks}
    y_limits = log_limits([v for b in bins.values() for v in (b.median, b.high)], 2.0)
    log_axes(whole, (log_limits([b.centre for b in bins.values()]), y_limits))
    for axes, (name, look) in zip(close, looks.items(), strict=True):
        b = bins[name]
        whole.plot(b.centre, b.median, color=look.colour, ls=look.dashes, label=short(name))
        whole.plot(b.centre, b.high, color=look.colour, lw=0.5)
        whole.fill_between(b.centre, b.median, b.high, color=look.colour, alpha=0.2, lw=0)
        _close(axes, spectra[name], line_hz, name, look.colour)
        axes.tick_params(labelbottom=axes is close[-1])
    whole.fill([], [], color=GREY, alpha=0.25, lw=0, label="up to the maximum of a bin")
    whole.axvline(line_hz, label=f"{line_hz:g} Hz", **MARK)
    whole.set(title="Whole spectra", ylabel="Power spectral density (mm²/Hz)")
    for axes in (whole, *close[-1:]):
        axes.set_xlabel("Frequency (Hz)")
    if not any(b.centre.size for b in bins.values()):
        say(whole, "no spectrum")
    letters([whole, *close])
    legend_below(body, [whole])
    return Picture(body, f"{captions.SKUROWSKI[17]} {remarks}")


def _close(
    axes: Axes, spectrum: tuple[np.ndarray, np.ndarray], line_hz: float, name: str, colour: str
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
    axes.plot(f, psd * per_mm2, color=colour, lw=0.6)
    times = f"{significant(greatest / float(np.median(psd)))} × median" if greatest > 0 else ""
    panel_title(axes, short(name), times)
    axes.set_ylabel(f"{unit}/Hz")
