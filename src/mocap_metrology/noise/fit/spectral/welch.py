"""Welch's estimate of the power spectral density, gaps included."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.errors import Refusal

MAX_MISSING = 0.02  # share of a segment that may be bridged: biases the density by about as much
LEAST_SEGMENT = 16
BATCH = 32  # segments at a time: a call has its price, memory too


@dataclass(frozen=True)
class PowerSpectrum:
    """f_hz, psd: (k,), one-sided density, unit of the series squared per Hz."""

    f_hz: np.ndarray
    psd: np.ndarray
    segment: int
    n_segments: int
    n_bridged: int


def welch(
    series: np.ndarray, frame_rate_hz: float, segment_s: float = 600.0, overlap: float = 0.5
) -> PowerSpectrum:
    """Mean of the Hann-windowed periodograms of overlapping segments [Welch 1967; S Figure 17].

    Segments last `segment_s`, or shorter where the series does not hold eight of them. A segment
    with up to 2 % of its samples missing is bridged linearly, one with more is left out; where
    none is left, segments are halved until one is. Without gaps it equals `scipy.signal.welch`.
    Raises Refusal when no stretch of 16 samples is complete enough.
    """
    n, valid = series.size, np.isfinite(series)
    counts = np.concatenate([[0], np.cumsum(valid)])
    segment = max(round(segment_s * frame_rate_hz), LEAST_SEGMENT)
    segment = min(segment, max(2 * n // 9, LEAST_SEGMENT))
    used = np.zeros(0, bool)
    while LEAST_SEGMENT <= segment <= n and not used.any():
        starts = np.arange(0, n - segment + 1, max(round(segment * (1 - overlap)), 1))
        missing = segment - (counts[starts + segment] - counts[starts])
        used = missing <= MAX_MISSING * segment
        segment = segment if used.any() else segment // 2
    if not used.any():
        raise Refusal(
            f"power spectrum: no {LEAST_SEGMENT} frames in a row without a gap; "
            "expected a longer series or fewer gaps"
        )
    bridged = series
    if not valid.all():
        at = np.flatnonzero(valid)
        bridged = np.interp(np.arange(n), at, series[at])
    window = _window(segment, frame_rate_hz)
    total, chosen = np.zeros(segment // 2 + 1), starts[used]
    for batch in np.array_split(chosen, -(-chosen.size // BATCH)):
        segments = np.stack([bridged[start : start + segment] for start in batch])
        total = total + _periodograms(segments, window).sum(axis=0)
    f_hz = np.fft.rfftfreq(segment, 1 / frame_rate_hz)
    return PowerSpectrum(f_hz, total / chosen.size, segment, chosen.size, int(missing[used].sum()))


def _window(n: int, rate_hz: float) -> np.ndarray:
    """Hann's window of n samples, one period, scaled for a density."""
    window = 0.5 + 0.5 * np.cos(np.linspace(-np.pi, np.pi, n + 1))[:-1]
    return window * (1 / np.sqrt(np.cumsum(window**2)[-1] / (1 / rate_hz)))


def _periodograms(segments: np.ndarray, window: np.ndarray) -> np.ndarray:
    """One-sided density of each row about its mean, to the last bit as of
    `scipy.signal.periodogram`, whose import takes longer than this."""
    from scipy.fft import rfft

    spectrum = rfft((segments - segments.mean(axis=-1, keepdims=True)) * window)
    density = spectrum.real**2 + spectrum.imag**2
    density[:, 1 : -1 if segments.shape[1] % 2 == 0 else None] *= 2
    return density
