"""Dynamic Allan variance: that of a window that moves through the recording, and how unlikely the
noise before and after makes it.

With window means ybar over tau = m frames, d_i = ybar_(i+m) - ybar_i is stationary for every noise
whose Allan variance converges, random walk, flicker and Gauss-Markov included. The dynamic Allan
variance [Galleani & Tavella, Metrologia 46, 2009] is half the mean of d^2 over a window; without an
event its mean is the same everywhere. That of Gaussian noise is a quadratic form: with covariance R
of the window's n differences and ratio r to its mean,

    P(r - 1 >= 2 sqrt(x / edf) + 2 kappa x) <= exp(-x)       [Laurent & Massart 2000, Lemma 1]

edf = (tr R)^2 / tr R^2, kappa = the greatest eigenvalue of R / tr R. The bound holds for every x,
where a chi-squared distribution with edf degrees is too light in the far tail.

Noise whose size varies all the time is met by the scatter of its windows. Noise with heavier tails
than a Gaussian's (of which `drawn_in` leaves little) is met by what the recording itself shows:
half of its 24 parts hold a window beyond ln w + 0.37 by chance, w being the windows of a part, and
no event lasts for half of a recording; x is divided by what they hold.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from mocap_metrology.noise.allan.variance import running_sum
from mocap_metrology.noise.diagnosis.outliers import mad_spread
from mocap_metrology.noise.fit.spectral.gaps import bridged

LONGEST_S = 0.5  # longest averaging time: slower events hide in slow noise
WINDOW_S = 1.0  # and at least
WINDOW_TAUS = 8  # averaging times long, and
WINDOW_FRAMES = 64  # frames
NEAR_S = 20.0  # from a change of level, whose time is known within ten seconds
STEPS = 4  # differences a tau
FEWEST = 8  # windows of a baseline, at least
SPECTRA = 4096  # windows of a spectrum, at most
PARTS = 24  # of a recording, whose greatest x describe the tail
MEDIAN_OF_GREATEST = -math.log(math.log(2))  # of many exponential variables, less their ln number
FAR, RARE = 2.0, 0.2  # times what chance reaches; share of the windows that bursts are
VOLATILE = 0.5  # of the degrees of freedom of Gaussian noise, that the scatter of windows shows
LEAST_SHARE = 0.5  # of a window's differences that must be there


@dataclass(frozen=True)
class Scale:
    """One averaging time. m, step, window: frames; a difference every `step`, `count` a window,
    which starts every half window."""

    m: int
    step: int
    count: int

    @property
    def window(self) -> int:
        return self.step * self.count


@dataclass(frozen=True)
class Dynamic:
    """Dynamic Allan variance of one series at one m; (k,) windows.

    hop_s: from the start of a window to that of the next; window_s: its length and that of the last
    difference; n_tests: windows in which enough is there; ratio: of the dynamic Allan variance to
    its baseline, NaN in the others; x: -ln of the bound on the probability of so much, 0 where
    there is less than the baseline. (All windows of 90 hours are half a gigabyte.)
    """

    scale: Scale
    tau_s: float
    hop_s: float
    window_s: float
    n_tests: int
    ratio: np.ndarray
    x: np.ndarray


def scales(rate_hz: float) -> list[Scale]:
    """m = 1, 2, 4, ... frames up to `LONGEST_S`."""
    windows, m = [], 1
    while m == 1 or m <= LONGEST_S * rate_hz:
        step = max(m // STEPS, 1)
        frames = max(WINDOW_S * rate_hz, WINDOW_TAUS * m, WINDOW_FRAMES)
        windows.append(Scale(m, step, 2 * math.ceil(frames / (2 * step))))
        m *= 2
    return windows


def dynamic_allan(
    series: np.ndarray,
    rate_hz: float,
    resolution: float = 0.0,
    baseline_s: float = 300.0,
    breaks_s: Sequence[float] = (),
) -> list[Dynamic]:
    """Dynamic Allan variances of a series (n,), NaN in gaps, at all `scales` that have enough
    windows.

    baseline_s: length of the running median the windows are compared with, so that a change that
    lasts for more than half of it is a new baseline and no event. breaks_s: times at which the
    level of the noise becomes another at once: each side has a baseline of its own, and near them
    the larger one counts. resolution: step of the stored values, whose variance is the least
    baseline.
    """
    valid = np.isfinite(series)
    if not valid.any():
        return []
    sums = running_sum(bridged(series) - series[valid].mean(dtype=np.float64))
    gone = None if valid.all() else running_sum(~valid)
    curves = []
    for scale in scales(rate_hz):
        differences, known = _differences(sums, gone, scale)
        rows = _rows(differences, known, scale.count)
        if differences.size < scale.count * FEWEST // 2:
            continue
        avar, share = _windows(differences, known, scale.count)
        n_tests = int(np.isfinite(avar).sum())
        if n_tests < FEWEST or not np.nanmax(avar) > 0:
            continue
        edf, kappa = _dispersion(rows)
        hop_s = scale.window / 2 / rate_hz
        reach = max(round(baseline_s / hop_s), FEWEST)
        breaks = [round(at / hop_s) for at in breaks_s]
        baseline = _baseline(avar, reach, breaks, round(NEAR_S / hop_s))
        baseline = baseline / max(1 - 2 / (9 * edf), 0.5) ** 3  # a chi-squared's median and mean
        baseline = np.maximum(baseline, resolution**2 / 12 / scale.m)
        x = _surprise(avar, baseline, share, edf, kappa)
        x = x / max(tail_factor(x), 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):  # of a constant series
            ratio = avar / baseline
        curves.append(
            Dynamic(
                scale, scale.m / rate_hz, hop_s,
                (scale.window + 2 * scale.m - scale.step) / rate_hz, n_tests, ratio, x,
            )
        )  # fmt: skip
    return curves


def tail_factor(x: np.ndarray) -> float:
    """How much larger x (k,) is than it should be: the median of the greatest of 24 parts over
    that of exponential variables; 1 where a few windows are far beyond all others, which are
    bursts, however many parts have one."""
    size = x.size // PARTS
    if size < 2:
        return 1.0
    greatest = x[: size * PARTS].reshape(PARTS, size).max(axis=1)
    ratio = float(np.median(greatest)) / (math.log(size) + MEDIAN_OF_GREATEST)
    few = np.mean(x > FAR * math.log(x.size)) < RARE
    return 1.0 if ratio > FAR and few else ratio


def _differences(
    sums: np.ndarray, gone: np.ndarray | None, scale: Scale
) -> tuple[np.ndarray, np.ndarray]:
    """d, and which of them touch no gaps."""
    m, step = scale.m, scale.step
    d: np.ndarray = sums[2 * m :: step] - sums[m:-m:step]
    d -= sums[m:-m:step]
    d += sums[: -2 * m : step]
    d /= m
    if gone is None:
        return d, np.ones(d.size, bool)
    return d, (gone[2 * m :: step] - gone[: -2 * m : step]) == 0


def _windows(d: np.ndarray, known: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Means of d^2 / 2, which takes the place of d, over windows of this size, NaN with less than
    half of the differences; share of those there."""
    d *= d
    d *= 0.5
    d[~known] = 0.0
    total, count = _pairs(d, size // 2), _pairs(known, size // 2)
    enough = count >= LEAST_SHARE * size
    return np.where(enough, total / np.maximum(count, 1), np.nan), count / size


def _pairs(values: np.ndarray, half: int) -> np.ndarray:
    parts = values[: values.size // half * half].reshape(-1, half).sum(axis=1)
    return parts[:-1] + parts[1:]


def _rows(d: np.ndarray, known: np.ndarray, size: int) -> np.ndarray:
    """A copy of some of the windows, (k, size) differences each; without gaps where enough are."""
    rows = d[: d.size // size * size].reshape(-1, size)
    whole = known[: rows.size].reshape(rows.shape).all(axis=1)
    rows = rows[whole] if FEWEST <= whole.sum() < whole.size else rows
    return rows[:: rows.shape[0] // SPECTRA + 1].copy()


def _dispersion(rows: np.ndarray) -> tuple[float, float]:
    """edf and kappa (see above) from the spectrum of the differences in a window: eigenvalues of R
    as medians over windows of its periodogram, which no event disturbs."""
    if not rows.shape[0]:
        return 1.0, 1.0
    spectrum = np.fft.rfft(rows, axis=1)
    power = np.median(spectrum.real**2 + spectrum.imag**2, axis=0)
    # Medians of chi-squared with one degree of freedom (ends) and two
    power /= math.log(2)
    power[[0, -1]] *= math.log(2) / 0.4549
    circle = np.concatenate([power, power[1:-1]])
    total = circle.sum()
    if not total > 0:
        return 1.0, 1.0
    return float(total**2 / np.sum(circle**2)), float(circle.max() / total)


def _baseline(avar: np.ndarray, size: int, breaks: Sequence[int], near: int) -> np.ndarray:
    baseline = np.zeros(avar.size)
    for first, last in pairwise([0, *breaks, avar.size]):
        if np.isfinite(avar[first:last]).any():
            side = slice(max(first - near, 0), last + near)
            part = np.pad(_running_median(avar[first:last], size), near, "edge")
            part = part[max(near - first, 0) :][: baseline[side].size]
            baseline[side] = np.maximum(baseline[side], part)
    return baseline


def _running_median(avar: np.ndarray, size: int) -> np.ndarray:
    from scipy.ndimage import median_filter

    known = np.isfinite(avar)
    level = float(np.median(avar[known]))
    if size >= avar.size:
        return np.full(avar.size, level)
    return median_filter(np.where(known, avar, level), size, mode="reflect")


def _surprise(
    avar: np.ndarray, baseline: np.ndarray, share: np.ndarray, edf: float, kappa: float
) -> np.ndarray:
    """x of the bound above; windows that scatter more than Gaussian noise would set edf, and if it
    is far more, x is at most that of a log-normal ratio, as of noise whose size varies."""
    from scipy.special import log_ndtr

    ratio = avar / np.maximum(baseline, np.finfo(float).tiny)
    scatter = mad_spread(np.log(np.maximum(ratio, 1e-6)))
    seen = 2 / scatter**2 if scatter > 0 else edf
    most = np.inf
    if seen < VOLATILE * edf:
        most = -log_ndtr(-np.log(np.maximum(ratio, 1e-6)) / scatter)
    if seen < edf:
        edf, kappa = seen, kappa * edf / seen
    a, b = 2 / np.sqrt(edf * np.maximum(share, 1e-3)), 2 * kappa / np.maximum(share, 1e-3)
    with np.errstate(invalid="ignore"):
        excess = np.maximum(ratio - 1, 0.0)
        root = (np.sqrt(a * a + 4 * b * excess) - a) / (2 * b)
    return np.where(np.isfinite(root), np.minimum(root**2, most), 0.0)
