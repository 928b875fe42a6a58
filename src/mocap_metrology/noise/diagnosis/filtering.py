"""What a filter would leave: by the fitted spectrum, and by filtering the series.

The filters are those of biomechanics: of second order, run forwards and backwards, so of fourth
order without delay; at the cutoff the amplitude is halved (-6 dB). A notch is run both ways too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mocap_metrology.common.types import Row
from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.fit.spectral.gaps import stretches
from mocap_metrology.noise.model.components import Sinusoid

Density = Callable[[np.ndarray], np.ndarray]
MEANS_S = 10.0  # sigma of one frame is that about means so long
CHOSEN_S = (0.1, 1.0, 10.0)
LEAST_FROM_S = 1.0
PER_DECADE = 8  # averaging times a minimum is looked for on
LONGEST_SHARE = 0.1  # of the recording
LONGEST = 1 << 20  # frames that are filtered: more makes the numbers no better
SHORTEST_S = 3.0  # of a stretch that is filtered
LOWEST = 1e-4  # cycles of the longest mean, from which the spectrum is added up
LOG_POINTS = 300  # a decade
PLACES = ("adev_1_frame", *(f"adev_{t:g}s" for t in CHOSEN_S), "least_adev", "least_adev_tau_s")


@dataclass(frozen=True)
class Filter:
    """name; sos (1, 6): b0, b1, b2, 1, a1, a2 of one pass, or None for no filter."""

    name: str
    sos: np.ndarray | None

    def gain(self, f_hz: np.ndarray, rate_hz: float) -> np.ndarray:
        """|H|^2 of one pass, which is what both passes do to the amplitude."""
        if self.sos is None:
            return np.ones_like(np.asarray(f_hz, float))
        from scipy.signal import sosfreqz

        return np.asarray(np.abs(sosfreqz(self.sos, f_hz, fs=rate_hz)[1]) ** 2)

    def applied(self, series: np.ndarray, rate_hz: float) -> np.ndarray:
        """Both ways over every stretch without a gap; shorter ones than three seconds become
        NaN."""
        if self.sos is None:
            return series
        from scipy.signal import sosfiltfilt

        out = np.full(series.size, np.nan)
        for part in stretches(series, 0, max(round(SHORTEST_S * rate_hz), 32)):
            mean = series[part].mean()
            out[part] = sosfiltfilt(self.sos, series[part] - mean) + mean
        return out


@dataclass(frozen=True)
class ResidualNoise:
    """Standard deviation about ten-second means; Allan deviations at one frame, 0.1, 1, 10 s (NaN
    beyond a tenth of the recording); the least one from a second on and where (below, a low-pass
    makes neighbours alike and nothing better); all of them. mm, s."""

    sigma: float
    adev: tuple[float, ...]
    least: float
    least_tau_s: float
    curve: tuple[np.ndarray, np.ndarray]

    def variance_share(self, before: ResidualNoise) -> float:
        """What is left of the variance before a filter; NaN where there was none."""
        return (self.sigma / before.sigma) ** 2 if before.sigma > 0 else math.nan

    def adev_1s_ratio(self, before: ResidualNoise) -> float:
        """Allan deviation at 1 s over that before a filter; NaN where there was none."""
        return self.adev[2] / before.adev[2] if before.adev[2] > 0 else math.nan


@dataclass(frozen=True)
class Filtered:
    """One filter on one series, `predicted` by the model and `measured`; None where there is
    none."""

    series: str
    filter: Filter
    n_frames: int
    predicted: ResidualNoise | None
    measured: ResidualNoise | None


def filters(
    rate_hz: float, cutoffs_hz: Sequence[float], lines_hz: Sequence[float], notch_width_hz: float
) -> list[Filter]:
    """None, the low-passes below Nyquist, and a notch at each line that has room for one."""
    from scipy.signal import butter, iirnotch, tf2sos

    nyquist = rate_hz / 2
    every = [Filter("none", None)]
    every += [
        Filter(f"Butterworth {f:g} Hz", butter(2, f, fs=rate_hz, output="sos"))
        for f in cutoffs_hz
        if f < 0.95 * nyquist
    ]
    for f in lines_hz:
        width = min(notch_width_hz, f)
        if f + width / 2 < nyquist:
            every.append(Filter(f"notch {f:.4g} Hz", tf2sos(*iirnotch(f, f / width, fs=rate_hz))))
    return every


def averaging(n: int, rate_hz: float) -> np.ndarray:
    """m: one frame, the chosen times, and eight a decade, up to a tenth of n frames."""
    last = max(n * LONGEST_SHARE, 1.0)
    grid = np.geomspace(1, last, max(round(math.log10(last) * PER_DECADE), 1) + 1)
    chosen = [round(t * rate_hz) for t in CHOSEN_S]
    m = np.unique(np.rint([*grid, *chosen]).astype(np.int64))
    return m[(m >= 1) & (m <= last)]


def predicted(
    density: Density, lines: Sequence[Sinusoid], one: Filter, m: np.ndarray, rate_hz: float
) -> ResidualNoise:
    """What a filter of gain |H|^2 a pass leaves of lines and of noise with this one-sided density,
    f -> mm^2/Hz: S |H|^4 and A |H|^2 through the transfer functions of means and of the Allan
    variance."""
    avar, variance = filtered_variances(density, one, m, rate_hz)
    size = _means_size(rate_hz)
    for line in lines:
        gain = float(one.gain(np.array([line.f_0]), rate_hz)[0])
        avar = avar + gain**2 * line.avar(m, rate_hz)
        x = math.pi * line.f_0 / rate_hz
        mean = (math.sin(size * x) / (size * math.sin(x))) ** 2 if abs(math.sin(x)) > 1e-9 else 1.0
        variance += (gain * line.A_s) ** 2 / 2 * (1 - mean) * size / (size - 1)
    return _residual_noise(math.sqrt(variance), avar, m, rate_hz)


def filtered_variances(
    density: Density, one: Filter, m: np.ndarray, rate_hz: float
) -> tuple[np.ndarray, float]:
    """Allan variances (k,) and the expected sample variance of ten seconds: 2 Int_0^fN S |H|^4
    sin^4(pi f m tau0) / (m sin(pi f tau0))^2 df, and Int S |H|^4 (1 - |D|^2) df n/(n - 1), D the
    transfer function of the mean of n frames."""
    f, kernels = _kernels(tuple(m), rate_hz)
    *avar, variance = kernels @ (density(f) * one.gain(f, rate_hz) ** 2)
    return np.array(avar), float(variance)


@lru_cache(maxsize=2)
def _kernels(m: Sequence[int], rate_hz: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (j,), evenly in log f, and weights (k + 1, j) of the sums that
    `filtered_variances` is made of, in which each power of a sine is the mean over its cell."""
    size = _means_size(rate_hz)
    low = LOWEST / max(m[-1], size) * rate_hz
    edges = np.geomspace(low, rate_hz / 2, round(LOG_POINTS * math.log10(rate_hz / 2 / low)) + 1)
    f, width = np.sqrt(edges[1:] * edges[:-1]), np.diff(edges)
    sine = np.sin(np.pi * f / rate_hz)

    def cosine(phase: np.ndarray) -> np.ndarray:
        return np.cos(phase) * np.sinc(phase / np.pi * width / f / 2)

    x = np.pi * f / rate_hz * np.array([*m, size])[:, None]
    fourth = np.where(x < 0.1, np.sin(x) ** 4, (3 - 4 * cosine(2 * x) + cosine(4 * x)) / 8)[:-1]
    mean = (1 - cosine(2 * x[-1])) / 2 / (size * sine) ** 2
    about_mean = np.where(x[-1] < 0.1, x[-1] ** 2 / 3, 1 - mean) * size / (size - 1)
    avar = 2 * fourth / (np.array(m)[:, None] * sine) ** 2
    return f, width * np.vstack([avar, about_mean])


def _means_size(rate_hz: float) -> int:
    return max(round(MEANS_S * rate_hz), 2)


def measured(
    series: np.ndarray, one: Filter, m: np.ndarray, rate_hz: float
) -> ResidualNoise | None:
    """The same of a series (n,), NaN in gaps, run through the filter."""
    out = one.applied(series, rate_hz)
    size = _means_size(rate_hz)
    rows = out[: out.size // size * size].reshape(-1, size)
    rows = rows[np.isfinite(rows).all(axis=1)]
    if not np.isfinite(out).any():
        return None
    sigma = math.sqrt(float(rows.var(axis=1, ddof=1).mean())) if len(rows) else math.nan
    return _residual_noise(sigma, allan_variance(out, m).variance, m, rate_hz)


def _residual_noise(sigma: float, avar: np.ndarray, m: np.ndarray, rate_hz: float) -> ResidualNoise:
    adev = np.sqrt(np.maximum(avar, 0.0))  # of no noise it rounds to less
    wanted = [1, *(round(t * rate_hz) for t in CHOSEN_S)]
    known = np.isfinite(adev)
    known &= (m >= LEAST_FROM_S * rate_hz) | (m[-1] < LEAST_FROM_S * rate_hz)
    best = int(np.argmin(np.where(known, adev, np.inf)))
    least = float(adev[best]) if known.any() else math.nan
    return ResidualNoise(
        sigma,
        tuple(float(adev[m == k][0]) if k in m else math.nan for k in wanted),
        least,
        float(m[best]) / rate_hz,
        (m / rate_hz, adev),
    )


def middle(values: np.ndarray) -> np.ndarray:
    """The middle 2^20 of (n,) values at most."""
    first = max((values.size - LONGEST) // 2, 0)
    return values[first : first + LONGEST]


def tried(
    series: str,
    values: np.ndarray,
    rate_hz: float,
    among: Sequence[Filter],
    density: Density | None,
    lines: Sequence[Sinusoid],
) -> list[Filtered]:
    """Every filter on the `middle` of (n,) values."""
    part = middle(values)
    m = averaging(part.size, rate_hz)
    return [
        Filtered(
            series, one, part.size,
            predicted(density, lines, one, m, rate_hz) if density else None,
            measured(part, one, m, rate_hz),
        )
        for one in among
    ]  # fmt: skip


NO_FILTER = Filtered("", Filter("none", None), 0, None, None)


def filter_row(none: Filtered, one: Filtered) -> Row:
    """Row of a filter beside the series without one: first the shares, then all deviations."""
    row: Row = {"series": one.series, "filter": one.filter.name, "n_frames": one.n_frames}
    deviations: Row = {}
    for kind in ("predicted", "measured"):
        before, after = getattr(none, kind), getattr(one, kind)
        for when, left in (("_before", before), ("", after)):
            row[f"{kind}_sigma{when}_mm"] = left.sigma if left else math.nan
        share = after.variance_share(before) if before and after else math.nan
        row[f"{kind}_share_left"] = share
        for k, place in enumerate(PLACES):
            unit = "" if place.endswith("_s") else "_mm"
            for when, left in (("_before", before), ("", after)):
                value = (*left.adev, left.least, left.least_tau_s)[k] if left else math.nan
                deviations[f"{kind}_{place}{when}{unit}"] = value
    return row | deviations
