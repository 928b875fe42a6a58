"""Panels of a diagnosis: spectrum with its lines and Allan deviation, with and without filters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.diagnosis.export import Resolution
from mocap_metrology.noise.diagnosis.filtering import Filtered
from mocap_metrology.noise.diagnosis.recording import Diagnosis, Recording
from mocap_metrology.present.drawing.axes import decade_axis, log_limits
from mocap_metrology.present.drawing.style import (
    GREY,
    INK,
    SMALL_PT,
    Keywords,
    head,
    label_axes,
    say,
    shorten,
    size_mm,
    text_mm,
)
from mocap_metrology.present.plot.decimate import Bins, log_bins
from mocap_metrology.present.text.numbers import mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BINS_PER_DECADE = 40
DECADES = 9  # of a spectrum that a filter is followed down
NAMED = 4  # lines that are labelled
SEEN = 1e-4  # share of the Allan variance from which rounding is on the page
# None of the coordinates' own, and as far apart in lightness
FILTER_LOOKS = (
    {"color": INK, "ls": "-"},
    {"color": "#2f8f4e", "ls": (0, (3, 1.1))},
    {"color": "#d9a300", "ls": (0, (7, 1.2, 1.2, 1.2, 1.2, 1.2))},
    {"color": "#6b2480", "ls": (0, (1.2, 1.2))},
)
LINE: Keywords = {"color": GREY, "lw": 0.7, "ls": (0, (1.2, 1.2))}
ROUNDING: Keywords = {"color": INK, "lw": 0.8, "ls": ":"}
Looks = Mapping[str, Keywords]


def filter_looks(filtered: Sequence[Filtered], series: str) -> dict[str, Keywords]:
    """How every filter of a series is drawn: none, two low-passes, the notch of its main line."""
    names = [f.filter.name for f in filtered if f.series == series]
    passes = [n for n in names if not n.startswith("notch")]
    notches = [n for n in names if n.startswith("notch")]
    shown = [*passes[:3], *notches[:1]]
    looks = {n: FILTER_LOOKS[min(k, 2)] for k, n in enumerate(passes[:3])}
    looks |= dict.fromkeys(notches[:1], FILTER_LOOKS[3])
    return {n: dict(looks[n]) for n in shown}


def draw_spectrum(
    axes: Axes,
    recording: Recording,
    found: Diagnosis,
    series: str,
    looks: Looks,
) -> None:
    """Welch's spectrum, its lines by name, and what is left of it behind each filter."""
    head(axes, f"Spectrum of {series}", _lines_remark(found, series))
    psd = found.spectra.get(series)
    width, height = size_mm(axes)
    label_axes(axes, x="Frequency (Hz)", y="PSD (mm²/Hz)", y_mm=12.5)
    if psd is None or not np.any(psd["psd_mm2_hz"] > 0):
        axes.set_xticks([])
        axes.set_yticks([])
        say(axes, "no spectrum")
        return
    bins = log_bins(psd["f_hz"], psd["psd_mm2_hz"], BINS_PER_DECADE)
    rounding = rounding_of(found, series)
    low, high = log_limits([bins.centre])[0], recording.frame_rate_hz / 2 * 1.1
    decade_axis(axes, "x", (low, high), width)
    least = float(np.min(bins.median[bins.median > 0], initial=np.inf)) / 300
    shown = [np.array([least]), bins.high]
    if rounding:
        shown.append(np.array([rounding.rounding_h0]))
    lower, upper = log_limits(shown, 2.0, DECADES)
    decade_axis(axes, "y", (lower, upper * 6), height)
    _curves(axes, bins, found, recording.frame_rate_hz, series, looks)
    if rounding:
        axes.plot([low, high], [rounding.rounding_h0] * 2, **ROUNDING)
    _name_lines(axes, found, series, bins, (low, high), upper * 6)


def rounding_of(found: Diagnosis, series: str) -> Resolution | None:
    """The rounding of a series if it makes so much of its noise that it is drawn."""
    own = next((r for r in found.resolutions if r.series == series), None)
    return own if own and own.share > SEEN else None


def _curves(
    axes: Axes, bins: Bins, found: Diagnosis, rate_hz: float, series: str, looks: Looks
) -> None:
    axes.fill_between(bins.centre, bins.median, bins.high, color=INK, alpha=0.2, lw=0)
    axes.plot(bins.centre, bins.high, color=GREY, lw=0.6)
    for one in found.filtered:
        if one.series == series and one.filter.name in looks:
            gain = one.filter.gain(bins.centre, rate_hz) ** 2
            axes.plot(bins.centre, bins.median * gain, lw=1.2, **looks[one.filter.name])


def _lines_remark(found: Diagnosis, series: str) -> str:
    own = sum(x.series == series for x in found.lines)
    return f"{own or 'no'} spectral line{'s' if own > 1 else ''}"


def _name_lines(
    axes: Axes,
    found: Diagnosis,
    series: str,
    bins: Bins,
    x: tuple[float, float],
    top: float,
) -> None:
    """A dotted line over each of the strongest, its frequency and amplitude above it."""
    own = [f for f in found.lines if f.series == series][:NAMED]
    width, _ = size_mm(axes)
    used: list[tuple[float, float, int]] = []
    for one in sorted(own, key=lambda f: f.line.f_0):
        f = one.line.f_0
        peak = float(bins.high[np.argmin(np.abs(np.log(bins.centre / f)))])
        axes.plot([f, f], [1.3 * peak, top / 6], **LINE, zorder=1)
        text = shorten(f"{f:.4g} Hz: {_size(one.line.A_s)}", SMALL_PT, width)
        centre = width * math.log(f / x[0]) / math.log(x[1] / x[0])
        half = text_mm(text, SMALL_PT) / 2
        centre = min(max(centre, half + 1), width - half - 1)
        level = _free(used, centre, half)
        used.append((centre, half, level))
        axes.text(centre / width, 0.965 - 0.06 * level, text, size=SMALL_PT, ha="center", va="top",
                  transform=axes.transAxes)  # fmt: skip


def _size(amplitude_mm: float) -> str:
    """Two digits."""
    return mm(amplitude_mm, 2)


def _free(used: Sequence[tuple[float, float, int]], centre: float, half: float) -> int:
    """The first row in which a text of that half width touches none of those used."""
    return next(
        row
        for row in range(len(used) + 1)
        if all(abs(centre - c) > half + h + 1 for c, h, own in used if own == row)
    )


def draw_deviations(
    axes: Axes, recording: Recording, found: Diagnosis, series: str, looks: Looks
) -> None:
    """Allan deviations behind every filter: curves by the model, points as measured, joined where
    there is no model."""
    own = [f for f in found.filtered if f.series == series and f.filter.name in looks]
    own = [f for f in own if f.predicted or f.measured]
    filtered = any(f.filter.sos is not None for f in own)
    remark = "as it is and filtered" if filtered else "too short to filter"
    head(axes, f"Allan deviation of {series}", remark if own else "")
    label_axes(axes, x="Averaging time τ (s)", y="ADEV (mm)", y_mm=12.5)
    curves = [left.curve for f in own for left in (f.predicted, f.measured) if left]
    if not any(np.any(np.asarray(curve[1]) > 0) for curve in curves):
        axes.set_xticks([])
        axes.set_yticks([])
        say(axes, "no Allan deviation")
        return
    width, height = size_mm(axes)
    decade_axis(axes, "x", log_limits([c[0] for c in curves]), width)
    decade_axis(axes, "y", log_limits([c[1] for c in curves]), height)
    limits = axes.get_xlim(), axes.get_ylim()
    for one in own:
        look = looks[one.filter.name]
        if one.predicted:
            axes.plot(*one.predicted.curve, lw=1.2, **look)
        if one.measured:
            joined = {**look, "lw": 1.2} if not one.predicted else {**look, "ls": ""}
            axes.plot(*one.measured.curve, marker="o", ms=2.6, mew=0, **joined)
    rounding = rounding_of(found, series)
    if rounding:
        tau = np.array(limits[0])
        adev = rounding.rounding_mm / np.sqrt(np.maximum(tau * recording.frame_rate_hz, 1.0))
        axes.plot(tau, adev, **ROUNDING)
        axes.set(xlim=limits[0], ylim=limits[1])
