"""Gaps filled by a draw from the noise model, given the samples around them.

A gap bridged by a line or a median has less noise than the rest, and a periodogram shows it. A
draw from the conditional distribution given the samples around it has the spectrum of the model, so
fitting and filling in turn converge on the truth, the faster the less is missing. What the filled
samples cannot determine is subtracted from the degrees of freedom by the caller. Neighbours up to
16 samples away are used: with a fifth missing in bursts of 40 and slow noise, that is too few.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.linear import cholesky
from mocap_metrology.common.types import Floats, Integers

NEIGHBOURS = 16  # samples on each side a draw is conditioned on
CHUNK = 128  # samples drawn at once; a longer gap is filled from left to right
LAGS = 1 << 16  # of the covariance; twice as many frequencies
SLOW_BANDS = 64  # that the power below the covariance's lowest frequency is summed over


def stretches(series: np.ndarray, longest_gap: int, shortest: int) -> list[slice]:
    """The series cut at gaps of more than `longest_gap` samples, without gaps at either end.

    Stretches with fewer than `shortest` valid samples are left out.
    """
    valid = np.isfinite(series)
    if valid.all():
        return [slice(0, series.size)] if series.size >= shortest else []
    at = np.flatnonzero(valid)
    if at.size == 0:
        return []
    cut = np.flatnonzero(np.diff(at) > longest_gap + 1) + 1
    groups = np.split(at, cut)
    return [slice(int(g[0]), int(g[-1]) + 1) for g in groups if g.size >= shortest]


def bridged(series: Floats) -> Floats:
    """Gaps filled by straight lines; the first guess, before there is a model. Without gaps, the
    series itself."""
    valid = np.isfinite(series)
    if valid.all():
        return series
    out, missing = series.astype(np.float64), ~valid
    beside = valid.copy()  # only the samples at the ends of gaps decide
    beside[1:-1] &= missing[:-2] | missing[2:]
    at = np.flatnonzero(beside)
    out[missing] = np.interp(np.flatnonzero(missing), at, series[at])
    return out


def filled(
    series: np.ndarray,
    density: Callable[[np.ndarray], np.ndarray],
    frame_rate_hz: float,
    rng: np.random.Generator,
) -> np.ndarray:
    """(n,) series with its NaN replaced by a draw of Gaussian noise of one-sided density
    f -> unit^2/Hz about the straight line through the series, whose slope the noise need not have,
    conditioned on up to 16 samples on each side.

    The covariance is the cosine transform of the density down to one cycle in 2^17 frames; what is
    slower is constant over a gap. First and last sample must be valid.
    """
    missing = ~np.isfinite(series)
    if not missing.any():
        return series.copy()
    time = np.linspace(-1, 1, series.size)
    level = np.polyval(np.polyfit(time[~missing], series[~missing], 1), time)
    out = series - level
    step = np.diff(np.concatenate([[0], missing.view(np.int8), [0]]))
    gaps = np.flatnonzero(step == 1), np.flatnonzero(step == -1)
    covariance = _covariance(density, frame_rate_hz, series.size)
    _fill(out, missing, gaps, covariance, rng.standard_normal(int(missing.sum())))
    out += level
    np.copyto(out, series, where=~missing)
    return out


def _covariance(
    density: Callable[[np.ndarray], np.ndarray], frame_rate_hz: float, n: int
) -> Floats:
    """Autocovariance at lags 0 ... LAGS - 1 of n samples, about their mean."""
    from scipy.fft import irfft

    tau0 = 1 / frame_rate_hz
    f = np.arange(1, LAGS + 1) / (2 * LAGS * tau0)
    psd = np.concatenate([[0.0], density(f)])
    covariance: np.ndarray = irfft(psd)[:LAGS] / (2 * tau0)
    lowest, first = 0.5 / (n * tau0), 0.25 / (LAGS * tau0)
    if lowest >= first:
        return covariance
    edge = np.geomspace(lowest, first, SLOW_BANDS + 1)
    return covariance + np.sum(density(np.sqrt(edge[:-1] * edge[1:])) * np.diff(edge))


@njit
def _fill(
    x: Floats,
    missing: np.ndarray,
    gaps: tuple[Integers, Integers],
    covariance: Floats,
    draws: Floats,
) -> None:
    """Fill x in place; gaps: where they begin and end. The joint covariance of known and unknown
    samples, known first, is L L^T: unknown = L_uk L_kk^-1 known + L_uu draw. A lone gap among valid
    samples is the common case and its L is kept."""
    begins, ends = gaps
    lone_root = np.empty((0, 0))
    used = 0
    for g in range(begins.size):
        end = ends[g]
        after = end + np.flatnonzero(~missing[end : end + 4 * NEIGHBOURS])[:NEIGHBOURS]
        for start in range(begins[g], end, CHUNK):
            stop = min(end, start + CHUNK)
            before = np.arange(max(start - NEIGHBOURS, 0), start)
            place, known = np.concatenate((before, after)), before.size + after.size
            is_lone = (
                stop - start == 1 and known == 2 * NEIGHBOURS and place[-1] == start + NEIGHBOURS
            )
            place = np.concatenate((place, np.arange(start, stop)))
            root = lone_root
            if not (is_lone and lone_root.size):
                root = _cholesky_root(place, covariance)
                if is_lone:
                    lone_root = root
            _draw(x, place, known, root, draws[used : used + stop - start])
            used += stop - start


@njit
def _cholesky_root(place: Integers, covariance: Floats) -> Floats:
    """Cholesky factor of the covariance of the samples at `place`."""
    root = np.empty((place.size, place.size))
    for i in range(place.size):
        for j in range(i + 1):
            root[i, j] = covariance[min(abs(place[i] - place[j]), covariance.size - 1)]
    least = 1e-12 * covariance[0]
    cholesky(root, place.size, least, 0.0, least)
    return root


@njit
def _draw(x: Floats, place: Integers, known: int, root: Floats, draws: Floats) -> None:
    """Draw the samples at place[known:] given those at place[:known]; x has mean 0."""
    z = np.empty(place.size)
    for i in range(place.size):
        if i < known:
            z[i] = (x[place[i]] - np.dot(root[i, :i], z[:i])) / root[i, i]
        else:
            z[i] = draws[i - known]
            x[place[i]] = np.dot(root[i, : i + 1], z[: i + 1])


def warm_up() -> None:
    """Compile the kernels."""
    x = np.arange(64.0)
    x[20] = np.nan
    filled(x, np.ones_like, 1.0, np.random.default_rng(0))
