"""Panels of a diagnosis: spectrum with its lines and Allan deviation, with and without filters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.noise.diagnosis.export import Resolution
from mocap_metrology.noise.diagnosis.filtering import Filtered
from mocap_metrology.noise.diagnosis.periodic import Found
from mocap_metrology.noise.diagnosis.recording import Diagnosis, Recording
from mocap_metrology.present.plot.curves import log_limits
from mocap_metrology.present.plot.decimate import Bins, log_bins
from mocap_metrology.present.plot.figure import (
    GREY,
    INK,
    Keywords,
    log_axes,
    panel_title,
    say,
)
from mocap_metrology.present.text.numbers import mm

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BINS_PER_DECADE = 40
DECADES = 9  # of a spectrum that a filter is followed down
NAMED = 4  # lines that are labelled
NEAR, HIGHER = 0.06, 4.0  # of the axis: numbers nearer than that are stacked, at so many times
SHORT_S = 60.0  # of a recording whose broad peaks are left undecided
PEAK, PEAK_DECADES, AROUND_DECADES = 3.0, 0.06, 0.4  # times what lies around; half widths
SEEN = 1e-4  # share of the Allan variance from which rounding is on the page
# None of the coordinates' own, and as far apart in lightness
FILTER_LOOKS = (
    {"color": INK, "ls": "-"},
    {"color": "#23733d", "ls": (0, (3, 1.1))},
    {"color": "#8a6500", "ls": (0, (7, 1.2, 1.2, 1.2, 1.2, 1.2))},
    {"color": "#6b2480", "ls": (0, (1.2, 1.2))},
)
ROUNDING: Keywords = {"color": INK, "lw": 0.8, "ls": ":"}
PREDICTED = "curve: by the noise model"
MEASURED = "points: measured"
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
    psd = found.spectra.get(series)
    if psd is None or not np.any(psd["psd_mm2_hz"] > 0):
        panel_title(axes, f"Spectrum of {series}")
        axes.set(xticks=[], yticks=[])
        say(axes, "no spectrum")
        return
    bins = log_bins(psd["f_hz"], psd["psd_mm2_hz"], BINS_PER_DECADE)
    own = [f for f in found.lines if f.series == series]
    panel_title(axes, f"Spectrum of {series}", _lines_remark(len(own), bins, recording.duration_s))
    axes.set(xlabel="Frequency (Hz)", ylabel="PSD (mm²/Hz)")
    rounding = rounding_of(found, series)
    least = float(np.min(bins.median[bins.median > 0], initial=np.inf)) / 300
    shown = [np.array([least]), bins.high, np.array([rounding.rounding_h0 if rounding else least])]
    lower, upper = log_limits(shown, 2.0, DECADES)
    x_limits = log_limits([bins.centre])[0], recording.frame_rate_hz / 2 * 1.1
    log_axes(axes, (x_limits, (lower, upper * (HIGHER if own else 1.0))))
    _curves(axes, bins, found, recording.frame_rate_hz, series, looks)
    if rounding:
        axes.axhline(rounding.rounding_h0, label="rounding of the file", **ROUNDING)
    _number_lines(axes, own[:NAMED], bins)


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
            look = looks[one.filter.name]
            axes.plot(bins.centre, bins.median * gain, lw=1.2, label=_called(one), **look)


def _called(one: Filtered) -> str:
    """Name of a filter in the legend."""
    return "as recorded" if one.filter.name == "none" else one.filter.name


def _lines_remark(count: int, bins: Bins, duration_s: float) -> str:
    """How many spectral lines; of a short recording without one, a broad peak that may hide one."""
    broad = broad_peak(bins) if not count and duration_s < SHORT_S else None
    if broad:
        return f"broad peak near {broad:.2g} Hz, {duration_s:.2g} s cannot decide"
    return f"{count or 'no'} spectral line{'s' if count > 1 else ''}"


def broad_peak(bins: Bins) -> float | None:
    """Frequency at which the density is three times that around it, or None: medians over 0.12
    decades over medians over 0.8 decades, where both are on the axis."""
    if not bins.centre.size or not np.all(bins.median > 0):
        return None
    at = np.log10(bins.centre)
    away = np.abs(at[:, None] - at)
    level = np.log10(bins.median)
    near, around = (
        np.array([np.median(level[row]) for row in away <= half])
        for half in (PEAK_DECADES, AROUND_DECADES)
    )
    inside = (at - at[0] > AROUND_DECADES) & (at[-1] - at > AROUND_DECADES)
    excess = np.where(inside, near - around, -np.inf)
    most = int(np.argmax(excess))
    top = int(np.argmax(np.where(away[most] <= 2 * PEAK_DECADES, level, -np.inf)))
    return float(bins.centre[top]) if excess[most] > np.log10(PEAK) else None


def _number_lines(axes: Axes, lines: Sequence[Found], bins: Bins) -> None:
    """A number over each of the strongest lines; frequency and amplitude in the legend."""
    span = np.log10(np.divide(*axes.get_xlim()[::-1]))
    before, height = -np.inf, 0
    for k, one in enumerate(sorted(lines, key=lambda f: f.line.f_0), start=1):
        f = one.line.f_0
        peak = float(bins.high[np.argmin(np.abs(np.log(bins.centre / f)))])
        height = height + 1 if np.log10(f) - before < NEAR * span else 0
        before = np.log10(f)
        label = f"{f:.4g} Hz: {_size(one.line.A_s)}"
        how: Keywords = {"ls": "", "marker": f"${k}$", "ms": 5.5, "color": INK, "mew": 0.3}
        axes.plot([f], [1.8 * peak * HIGHER ** (0.7 * height)], label=label, clip_on=False, **how)


def _size(amplitude_mm: float) -> str:
    """Two digits."""
    return mm(amplitude_mm, 2)


def draw_deviations(
    axes: Axes, recording: Recording, found: Diagnosis, series: str, looks: Looks
) -> None:
    """Allan deviations behind every filter: curves by the model, points as measured, joined where
    there is no model."""
    own = [f for f in found.filtered if f.series == series and f.filter.name in looks]
    own = [f for f in own if f.predicted or f.measured]
    filtered = any(f.filter.sos is not None for f in own)
    remark = "as it is and filtered" if filtered else "too short to filter"
    panel_title(axes, f"Allan deviation of {series}", remark if own else "")
    curves = [left.curve for f in own for left in (f.predicted, f.measured) if left]
    if not any(np.any(np.asarray(curve[1]) > 0) for curve in curves):
        axes.set(xticks=[], yticks=[])
        say(axes, "no Allan deviation")
        return
    axes.set(xlabel="Averaging time τ (s)", ylabel="ADEV (mm)")
    limits = log_limits([c[0] for c in curves]), log_limits([c[1] for c in curves])
    log_axes(axes, limits)
    for one in own:
        look = looks[one.filter.name]
        if one.predicted:
            axes.plot(*one.predicted.curve, lw=1.2, label=_called(one), **look)
        if one.measured:
            joined = {**look, "lw": 1.2, "label": _called(one)}
            if one.predicted:
                joined = {**look, "ls": ""}
            axes.plot(*one.measured.curve, marker="o", ms=2.6, mew=0, **joined)
    if any(one.predicted for one in own):
        axes.plot([], [], color=GREY, label=PREDICTED)
        axes.plot([], [], color=GREY, ls="", marker="o", ms=3, mew=0, label=MEASURED)
    if rounding := rounding_of(found, series):
        tau = np.array(limits[0])
        adev = rounding.rounding_mm / np.sqrt(np.maximum(tau * recording.frame_rate_hz, 1.0))
        axes.plot(tau, adev, label="rounding of the file", **ROUNDING)
