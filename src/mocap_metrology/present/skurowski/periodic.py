"""S Figure 17: whether there is a line in the spectrum. The whole, and close round the line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

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
    """Linear axes within 2 Hz of the line; over them how far its point stands out."""
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
