"""S Figure 17: is there a line in the spectrum? The whole, and close round the line."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.present.drawing.axes import decade_axis, linear_axis, log_limits
from mocap_metrology.present.drawing.legend import Entry, strip, strip_height
from mocap_metrology.present.drawing.style import (
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
from mocap_metrology.present.plot.decimate import log_bins
from mocap_metrology.present.text.numbers import power_of_ten, three_digits

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEFT_MM, BETWEEN_MM, RIGHT_MM, TITLE_MM, LABELS_MM = 16.5, 16.0, 3.0, 5.5, 11.0
WHOLE_MM, CLOSE_GAP_MM, LEAST_CLOSE_MM = 82.0, 6.5, 24.0
CLOSE_MM = WIDTH_MM - LEFT_MM - WHOLE_MM - BETWEEN_MM - RIGHT_MM
HALF_WIDTH_HZ = 2.0  # of the close view
BINS_PER_DECADE = 40
MARK: Keywords = {"color": INK, "lw": 0.8, "ls": (0, (1.2, 1.2))}
Spectra = Mapping[str, tuple[np.ndarray, np.ndarray]]


@styled()
def periodic_figure(spectra: Spectra, line_hz: float, title: str, note: str = "") -> Figure:
    """Welch spectra with the line marked: all in one panel, and a close view of each.

    spectra: name (of a camera type) -> f in Hz, ascending, and density in mm^2/Hz, (k,) each;
    line_hz: where the line should be. The whole is shown as medians of bins with bands up to their
    greatest values; the close views show every point.
    """
    looks = dict(zip(spectra, (*LOOKS.values(), *OTHER_LOOKS), strict=False))
    count = max(len(looks), 1)
    close = max((72.0 - (count - 1) * CLOSE_GAP_MM) / count, LEAST_CLOSE_MM)
    height = count * close + (count - 1) * CLOSE_GAP_MM
    entries = [Entry(name, line=_line(look)) for name, look in looks.items()]
    entries.append(Entry("to the bin's maximum", patch={"color": GREY, "alpha": 0.25, "lw": 0}))
    entries.append(Entry(f"{line_hz:g} Hz", line=MARK))
    width = WIDTH_MM - 2 * MARGIN_MM
    key_top = TITLE_MM + height + LABELS_MM
    sheet = blank_sheet(key_top + strip_height(entries, width) + 1.5, title, note)
    _whole(sheet.axes(LEFT_MM, TITLE_MM, WHOLE_MM, height), height, spectra, looks, line_hz)
    for k, (name, look) in enumerate(looks.items()):
        _close(sheet, TITLE_MM + k * (close + CLOSE_GAP_MM), close, spectra[name], (name, look),
               line_hz, k == count - 1)  # fmt: skip
    strip(sheet, MARGIN_MM, key_top, width, entries)
    return sheet.figure


def _line(look: Look) -> Keywords:
    return {"color": look.colour, "ls": look.dashes, "lw": 1.2}


def _whole(
    axes: Axes, height: float, spectra: Spectra, looks: Mapping[str, Look], line_hz: float
) -> None:
    bins = {name: log_bins(*spectra[name], BINS_PER_DECADE) for name in looks}
    decade_axis(axes, "x", log_limits([b.centre for b in bins.values()]), WHOLE_MM)
    decade_axis(
        axes, "y", log_limits([v for b in bins.values() for v in (b.median, b.high)], 2.0), height
    )
    axes.axvline(line_hz, **MARK, zorder=1)
    for name, look in looks.items():
        b = bins[name]
        axes.plot(b.centre, b.high, color=look.colour, lw=0.5)
        axes.fill_between(b.centre, b.median, b.high, color=look.colour, alpha=0.2, lw=0)
        axes.plot(b.centre, b.median, **_line(look))
    head(axes, "Power spectral density")
    label_axes(axes, x="Frequency (Hz)", y="PSD (mm²/Hz)", y_mm=12.5)
    if not any(b.centre.size for b in bins.values()):
        how: Keywords = {"transform": axes.transAxes, "ha": "center", "va": "center", "color": GREY}
        axes.text(0.5, 0.5, "no spectrum", **how)


def _close(
    sheet: Sheet,
    top: float,
    height: float,
    spectrum: tuple[np.ndarray, np.ndarray],
    who: tuple[str, Look],
    line_hz: float,
    lowest: bool,
) -> None:
    """Linear axes within 2 Hz of the line; the head says how far its point stands out."""
    name, look = who
    axes = sheet.axes(LEFT_MM + WHOLE_MM + BETWEEN_MM, top, CLOSE_MM, height)
    f, psd = (np.asarray(v, dtype=np.float64) for v in spectrum)
    near = (np.abs(f - line_hz) <= HALF_WIDTH_HZ) & np.isfinite(psd)
    f, psd = f[near], psd[near]
    linear_axis(axes, "x", (line_hz - HALF_WIDTH_HZ, line_hz + HALF_WIDTH_HZ), 5)
    greatest = float(psd.max(initial=0.0))
    exponent = int(np.floor(np.log10(greatest))) if greatest > 0 else 0
    scale = 10.0**exponent
    linear_axis(axes, "y", (0.0, 1.35 * greatest / scale if greatest > 0 else 1.0), 4)
    axes.axvline(line_hz, **MARK, zorder=1)
    axes.plot(f, psd / scale, color=look.colour, lw=0.6)
    axes.tick_params(labelbottom=lowest)
    remark = ""
    if greatest > 0:
        remark = f"peak {three_digits(greatest / float(np.median(psd)))} × median"
        text = f"×{power_of_ten(exponent)} mm²/Hz"
        how: Keywords = {"transform": axes.transAxes, "va": "top", "size": SMALL_PT, "color": GREY}
        axes.text(0.02, 0.95, text, **how)
    head(axes, name, remark)
    label_axes(axes, x="Frequency (Hz)" if lowest else "")
