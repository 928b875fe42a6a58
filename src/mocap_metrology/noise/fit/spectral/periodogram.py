"""Periodogram by cosine transform, in logarithmic bins: what the likelihood estimator fits.

The cosine transform (DCT-II) continues a series evenly past its ends, where a Fourier transform
takes it for a loop. A random walk does not close: in a Fourier periodogram its end-to-end jump
doubles the power at every frequency. The cosine functions are the eigenvectors of the covariance
of a random walk of n points with its mean removed, and of white noise, so for both the transform's
coefficients are independent and their variances are the sampled spectra exactly; for a
Gauss-Markov process a closed-form end correction remains (`gauss_markov_unit`). Nothing is tapered
away: n - 1 coefficients, one degree of freedom each. Flicker noise comes out 1 to 2 % low below
ten half cycles (a quarter at the first); blue and violet noise leak a floor of about 1/n of their
power into slow coefficients, which shows only where nothing else is there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.transforms import dct
from mocap_metrology.noise.model.components import Form, four_sin2
from mocap_metrology.noise.model.sampling import power_law_means

BINS_PER_DECADE = 64  # 3.7 % wide: the widest spectra here, f^2 and f^-2, bend by 2e-4 in one
LEAST_SHARE = 1e-6  # of the degrees of freedom of a bin without coefficients
SLOWEST = 2048  # coefficients stored one by one, for what is no noise (`detrend`)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(3)


# gain, parity and duration of every node, frame period (s), whether frames are averages
Where = tuple[np.ndarray, np.ndarray, np.ndarray, float, bool]


@dataclass(frozen=True)
class Bins:
    """Frequencies of the bins of one or several stretches of a series, one row a bin (B bins).

    f_hz (B, 3): Gauss-Legendre nodes of the bin; gain: 4 sin^2(pi f tau0) there; f_lower_hz,
    f_upper_hz (B,); n (B,): coefficients in the bin; duration_s (B,): of its stretch; parity (B,):
    1 even, -1 odd, 0 several coefficients; form: frames are points, or averages over tau0.
    """

    f_hz: np.ndarray
    gain: np.ndarray
    f_lower_hz: np.ndarray
    f_upper_hz: np.ndarray
    n: np.ndarray
    duration_s: np.ndarray
    parity: np.ndarray
    frame_rate_hz: float
    form: Form = "sampled"

    @property
    def centre_hz(self) -> np.ndarray:
        """(B,): geometric mean of the coefficients' frequencies, near enough."""
        return self.f_hz[:, 1]

    @property
    def where(self) -> Where:
        """What the compiled spectra need."""
        tau0 = 1 / self.frame_rate_hz
        return self.gain, self.parity, self.duration_s, tau0, self.form == "continuous"

    @property
    def T_c_range(self) -> tuple[float, float]:
        """T_c that are searched, s: from half a frame (faster is white noise) to a fifth of the
        longest stretch (slower is a random walk)."""
        tau0 = 1 / self.frame_rate_hz
        return tau0 / 2, self.span_s / 5

    @property
    def span_s(self) -> float:
        """Duration of the longest stretch."""
        return float(self.duration_s.max())


@dataclass(frozen=True)
class Slow:
    """Slow coefficients one by one (M,), of bins that are whole. value: sqrt(2 tau0) c_k, so that
    its square is a density; k; bin: where it belongs; share: of the samples that were measured; n,
    start_s: samples of its stretch, and when that begins, s from the first frame of the series."""

    value: np.ndarray
    k: np.ndarray
    bin: np.ndarray
    share: np.ndarray
    n: np.ndarray
    start_s: np.ndarray


NO_SLOW = Slow(*[np.empty(0)] * 6)


@dataclass(frozen=True)
class Periodogram:
    """psd (B,): mean of the one-sided periodogram in each bin, unit^2/Hz; weight (B,): degrees of
    freedom, the number of coefficients times the share of samples that were measured; slow: the
    coefficients of the first bins, where they were kept."""

    bins: Bins
    psd: np.ndarray
    weight: np.ndarray
    slow: Slow = NO_SLOW


@dataclass(frozen=True)
class Stretch:
    """A complete stretch (n,) of a series: the share of its samples that was measured, the frame at
    which it begins, and bands whose coefficients are left out, Hz."""

    series: np.ndarray
    share: float = 1.0
    start: int = 0
    bands: Sequence[tuple[float, float]] = ()


T = TypeVar("T", Bins, Slow, Periodogram)


def _joined(parts: Sequence[T]) -> T:
    """Columns of several stretches one after the other; what is no column of the first."""
    if len(parts) == 1:
        return parts[0]
    names = [name for name, value in vars(parts[0]).items() if isinstance(value, np.ndarray)]
    columns: Any = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return replace(parts[0], **columns)


def edges(n: int) -> np.ndarray:
    """First coefficient of each bin and, last, n: single ones at first, then even steps in log k;
    k = 1 ... n - 1."""
    steps = max(round(math.log10(n) * BINS_PER_DECADE), 1)
    return np.unique(np.rint(np.logspace(0, math.log10(n), steps + 1)).astype(np.int64))


def bins_of(n: int, frame_rate_hz: float, form: Form = "sampled") -> Bins:
    """Bins of a stretch of n samples; coefficient k has the frequency k / (2 n tau0)."""
    tau0, edge = 1 / frame_rate_hz, edges(n)
    first, last = edge[:-1], edge[1:] - 1
    count = last - first + 1
    # From half a step before the first coefficient to half a step after the last
    half = count[:, None] / 2
    k = (first + last)[:, None] / 2 + np.where(count[:, None] > 1, half * NODES, 0.0)
    step = 1 / (2 * n * tau0)
    parity = np.where(count > 1, 0, np.where(first % 2 == 0, 1, -1)).astype(np.int64)
    return Bins(
        f_hz=k * step,
        gain=four_sin2(k * step, frame_rate_hz),
        f_lower_hz=(first - 0.5) * step,
        f_upper_hz=(last + 0.5) * step,
        n=count,
        duration_s=np.full(count.size, n * tau0),
        parity=parity,
        frame_rate_hz=frame_rate_hz,
        form=form,
    )


def periodogram(
    stretches: Sequence[Stretch], frame_rate_hz: float, form: Form = "sampled"
) -> Periodogram:
    """Mean of 2 tau0 c_k^2 in each bin of each stretch, c_k the orthonormal DCT-II, and the slow
    coefficients; form: of the frames. For white noise of variance s^2 it expects 2 tau0 s^2 = h_0.
    """
    parts, slow, first = [], [], 0
    for one in stretches:
        bins = bins_of(one.series.size, frame_rate_hz, form)
        c = dct(one.series - one.series.mean(), type=2, norm="ortho", overwrite_x=True)
        parts.append(_binned(c, bins, one))
        slow.append(_slow(c, bins, one, first))
        first += bins.n.size
    return replace(_joined(parts), bins=_joined([p.bins for p in parts]), slow=_joined(slow))


def _slow(c: np.ndarray, bins: Bins, stretch: Stretch, first: int) -> Slow:
    """The slowest coefficients of one stretch, from its transform `c` (n,); its first bin has the
    number `first` among all."""
    edge = edges(c.size)
    whole = int(np.searchsorted(edge[1:], SLOWEST, side="right"))
    k = np.arange(1, edge[whole])
    left = _outside_bands(k, c.size, bins.frame_rate_hz, stretch.bands)
    k, bin_of = k[left], (np.repeat(np.arange(whole), bins.n[:whole]) + first)[left]
    tau0 = 1 / bins.frame_rate_hz
    share, n, start_s = (np.full(k.size, v) for v in (stretch.share, c.size, stretch.start * tau0))
    return Slow(np.sqrt(2 * tau0) * c[k], k, bin_of, share, n, start_s)


def _outside_bands(
    k: np.ndarray, n: int, frame_rate_hz: float, bands: Sequence[tuple[float, float]]
) -> np.ndarray:
    """Which coefficients of n samples lie in none of the bands."""
    tau0 = 1 / frame_rate_hz
    f = k / (2 * n * tau0)
    return np.all([np.ones(k.size, bool), *((f < low) | (f > high) for low, high in bands)], axis=0)


def _binned(c: np.ndarray, bins: Bins, stretch: Stretch) -> Periodogram:
    """The binned periodogram of one stretch, from its transform `c` (n,). Without the coefficients
    in its bands, bins hold the mean of what is left, with so many degrees of freedom less, and next
    to none (and what their neighbours hold) where nothing is."""
    first, power = edges(c.size)[:-1], 2 / bins.frame_rate_hz * (c * c)
    left = _outside_bands(np.arange(c.size), c.size, bins.frame_rate_hz, stretch.bands)
    if not left[1:].any():
        left[:] = True
    count = np.add.reduceat(left.astype(np.int64), first)
    total, known = np.add.reduceat(np.where(left, power, 0.0), first), np.flatnonzero(count)
    psd = np.interp(np.arange(count.size), known, total[known] / count[known])
    return Periodogram(bins, psd, stretch.share * np.maximum(count, LEAST_SHARE * bins.n))


def power_law_unit(bins: Bins, alpha: int) -> np.ndarray:
    """(B,) spectrum of h_alpha = 1, mean over each bin (see `model.PowerLaw.psd`)."""
    if bins.form == "continuous":
        return power_law_means(alpha, bins.f_hz, bins.frame_rate_hz, bins.gain) @ WEIGHTS / 2
    if alpha == -2:
        tau0 = 1 / bins.frame_rate_hz
        return (2 * np.pi * tau0) ** 2 * ((1 / bins.gain) @ WEIGHTS) / 2
    return (bins.f_hz ** float(alpha)) @ WEIGHTS / 2


def gauss_markov_unit(bins: Bins, T_c: float) -> np.ndarray:
    """(B,) expected periodogram of a Gauss-Markov component of q_c = 1.

    The spectrum S of points (`model.GaussMarkov.psd`) times the end correction of the DCT,
    1 - S / (T var (1 + c)) with c = coth(T / 2 T_c) for even and tanh for odd coefficients, T the
    duration, var = T_c / 2: the process is the one with reflecting ends, whose covariance the DCT
    diagonalises, conditioned by one rank-one term at each end (Sherman-Morrison). Of averages over
    the frame period, `sampling.correlated_means`, with the correction of the points.
    """
    out = np.empty(bins.n.size)
    unit_into(T_c, bins.where, out)
    return out


@njit
def unit_into(T_c: float, where: Where, out: np.ndarray) -> None:
    """`gauss_markov_unit`, compiled; where: `Bins.where`."""
    gain, parity, duration, tau0, averaged = where
    a = tau0 / T_c
    variance = T_c / 2
    phi = math.exp(-a)
    square = math.expm1(-a) ** 2
    scale = 2 * tau0 * variance
    numerator, slope, floor = _shape(a, averaged)
    last, even, odd = -1.0, 0.0, 0.0
    for b in range(out.size):
        if duration[b] != last:
            last = duration[b]
            tanh = math.tanh(last / (2 * T_c))
            even = 1 / (last * variance * (1 + 1 / tanh))
            odd = 1 / (last * variance * (1 + tanh))
        end = even if parity[b] == 1 else odd if parity[b] == -1 else (even + odd) / 2
        # weights 5/18, 8/18, 5/18; one coefficient has three equal nodes
        total = 0.0
        for j in range(3):
            g = gain[b, j]
            s = scale * ((numerator + slope * g) / (square + phi * g) + floor)
            total += s * (1 - s * end) * (8.0 if j == 1 else 5.0)
        out[b] = total / 18


@njit
def _shape(a: float, averaged: bool) -> tuple[float, float, float]:
    """c of (c_0 + c_1 gain) / ((1 - phi)^2 + phi gain) + c_2, the spectrum over 2 tau0 variance of
    points or, as `sampling.correlated_means`, of averages; a = tau0/T_c."""
    falling = -math.expm1(-2 * a)
    if not averaged:
        return falling, 0.0, 0.0
    if a > 1:
        return 0.0, -falling / a**2, 2 / a
    odd, term = 0.0, a  # sinh(a) - a
    for n in range(3, 21, 2):
        term *= a * a / (n * (n - 1))
        odd += term
    return falling * (2 * math.sinh(a / 2) / a) ** 2, 0.0, -2 * odd / a**2


def warm_up() -> None:
    """Compile the kernels."""
    gauss_markov_unit(periodogram([Stretch(np.arange(16.0))], 1.0).bins, 3.0)
