"""Covariance of the overlapping Allan variances of one Gaussian series, and whitening by it.

With S the one-sided spectrum of the frames, T the length and
|H_m(f)|^2 = 2 sin^4(pi f m tau0) / (m sin(pi f tau0))^2, AVAR_m = Int_0^fN S |H_m|^2 df and

    Cov[AVAR_a, AVAR_b] = 1/T Int_0^fN S^2 |H_a|^2 |H_b|^2 df        (T -> infinity),

Parseval's form of the sum of squared cross-covariances that Greenhall & Riley (PTTI 2003) use for
a = b. At tau near T/3 the ends count: a pair's covariance is larger by a factor that hardly depends
on the noise. Taken is that of white noise; against exact sums for 1200 samples the variance of a
random walk is then too small by 1 % at T/30, 4 % at T/7 and 18 % at T/3, that of Gauss-Markov noise
of T_c = T/30 right to 1 % everywhere.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.noise.fit.allan.separable import Problem, hermite_nodes
from mocap_metrology.noise.model.components import (
    ALPHAS,
    Form,
    GaussMarkov,
    NoiseModel,
    PowerLaw,
    Sinusoid,
)

LINEAR_UP_TO = 200  # cycles in the recording: below, two nodes a cycle; above, so many a decade
PER_DECADE = 300
EDGES_FROM = 1 / 300  # of the recording: a shorter tau does not notice its ends
N_LAGS = 240
TABLE_PER_DECADE = 40
TONE_STEP = 0.01  # of log f_0: the Allan curve's oscillations that stand out move by less
ENVELOPE = 10.0  # degrees of freedom are compared with the model's over a decade to either side


def avar_covariance(
    model: NoiseModel, m: np.ndarray, n: int, frame_rate_hz: float, edf: np.ndarray | None = None
) -> Floats:
    """(k, k) covariance, mm^4, of the overlapping Allan variances (mm^2) of one series of n samples
    at the averaging factors m (k whole numbers, 2 m <= n).

    A sinusoid adds A_s^2/T S(f_0) |H_a(f_0)|^2 |H_b(f_0)|^2, the noise that beats with it. `edf`:
    (k,) degrees of freedom; the diagonal is then made 2 AVAR^2 / edf, correlations stay.
    Positive semidefinite by construction, but for the factor of the ends.
    """
    tau0 = 1 / frame_rate_hz
    m = np.ascontiguousarray(m, dtype=np.int64)
    f, gain = _nodes(m.tobytes(), n, frame_rate_hz)
    weighted = gain * model.psd(f, frame_rate_hz)
    covariance: np.ndarray = weighted @ weighted.T
    for line in model.lines:
        at = np.array([line.f_0])
        high = line.recorded(frame_rate_hz, model.form)
        beat = (
            transfer(m, at, frame_rate_hz)[:, 0]
            * high
            * np.sqrt(model.psd(at, frame_rate_hz) / (n * tau0))
        )
        covariance += np.outer(beat, beat)
    covariance *= _ends(m.tobytes(), n)
    if edf is None:
        return covariance
    scale = np.sqrt(
        2 * model.avar(m, frame_rate_hz) ** 2 / np.asarray(edf, float) / np.diag(covariance)
    )
    return covariance * np.outer(scale, scale)


def transfer(m: np.ndarray, f: np.ndarray, frame_rate_hz: float) -> np.ndarray:
    """(k, f) of |H_m(f)|^2 = 2 sin^4(pi f m tau0) / (m sin(pi f tau0))^2."""
    tau0 = 1 / frame_rate_hz
    x = np.pi * tau0 * np.asarray(f, float)
    m = np.asarray(m, float)[:, None]
    return 2 * np.sin(m * x) ** 4 / (m * np.sin(x)) ** 2


@lru_cache(maxsize=4)
def _nodes(m_bytes: bytes, n: int, frame_rate_hz: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (Hz), and |H|^2 there times the root of weight / T.

    Where sin^4 turns faster than the nodes follow, they must not beat with it: each lies in its own
    place of its interval, at multiples of the golden ratio (a sequence of low discrepancy).
    """
    tau0 = 1 / frame_rate_hz
    m = np.frombuffer(m_bytes, dtype=np.int64)
    duration, nyquist = n * tau0, 0.5 / tau0
    bend = min(LINEAR_UP_TO / duration, nyquist)
    n_linear = max(round(2 * bend * duration), 1)
    n_log = int(np.ceil(PER_DECADE * np.log10(nyquist / bend)))
    edges = np.geomspace(bend, nyquist, n_log + 1)
    place = np.arange(n_log) * ((np.sqrt(5) - 1) / 2) % 1
    linear = (np.arange(n_linear) + 0.5) * bend / n_linear
    f = np.concatenate([linear, edges[:-1] + place * np.diff(edges)])
    weight = np.concatenate([np.full(n_linear, bend / n_linear), np.diff(edges)])
    return f, transfer(m, f, frame_rate_hz) * np.sqrt(weight / duration)


@lru_cache(maxsize=4)
def _ends(m_bytes: bytes, n: int) -> np.ndarray:
    """(k, k) covariances in a series of n samples over those without ends, for white noise.

    n Sum_k w(k) R(k)^2 / (N_a N_b Sum_k R(k)^2): R the cross-covariance of the terms of the two
    variances at lag k, w(k) the number of pairs of terms with that lag, N the numbers of terms.
    """
    m = np.frombuffer(m_bytes, dtype=np.int64).astype(float)
    factor: np.ndarray = n / (n - 2 * np.minimum.outer(m, m) + 1)  # all that matters where a << b
    for b in np.flatnonzero(m > EDGES_FROM * n):
        shorter = m <= m[b]
        # The lags resolve terms down to a twentieth; below, the loss is proportional to tau
        resolved = np.maximum(m[shorter], m[b] / 20)
        loss = 1 - _shared(resolved, m[b], n) * (n - 2 * resolved + 1) / n
        factor[shorter, b] *= 1 - loss * m[shorter] / resolved
        factor[b, shorter] = factor[shorter, b]
    return factor


def _shared(a: np.ndarray, b: float, n: int) -> np.ndarray:
    """`_ends` for factors a (any shape (k,)) <= b."""
    n_a, n_b = (n - 2 * a + 1)[:, None], n - 2 * b + 1
    first = a[:, None]
    lag = 2 * (first + b) * (np.arange(N_LAGS) + 0.5) / N_LAGS - 2 * b  # where two terms overlap
    covariance = np.zeros_like(lag)
    for i, c_i in enumerate((1, -2, 1)):
        for j, c_j in enumerate((1, -2, 1)):
            covariance -= c_i * c_j * np.abs(lag + j * b - i * first)
    pairs = np.maximum(np.minimum(n_a, n_b - lag) - np.maximum(0.0, -lag), 0.0)
    square = covariance**2
    return n * np.sum(pairs * square, axis=1) / (n_a[:, 0] * n_b * square.sum(axis=1))


@dataclass(frozen=True)
class Curves:
    """Unit curves at the averaging factors: power (k, 5) for h_alpha = 1, log_T (g,) with table
    and slope (g, k) for q_c = 1, log_f (f,) with tones (k, f) for A_s = 1."""

    m: np.ndarray
    n: int
    frame_rate_hz: float
    power: np.ndarray
    log_T: np.ndarray
    table: np.ndarray
    slope: np.ndarray
    log_f: np.ndarray
    tones: np.ndarray
    form: Form = "sampled"


@lru_cache(maxsize=4)
def unit_curves(m_bytes: bytes, n: int, frame_rate_hz: float, form: Form = "sampled") -> Curves:
    """Those of a series of n samples. T_c from tau0/2 to T/10; f_0 from two periods in the longest
    tau (slower, the curve only rises, as with random walk) to Nyquist."""
    from scipy.interpolate import CubicSpline

    tau0 = 1 / frame_rate_hz
    m = np.frombuffer(m_bytes, dtype=np.int64)
    power = np.stack(
        [PowerLaw(alpha, 1.0).avar(m, frame_rate_hz, form) for alpha in ALPHAS], axis=1
    )
    ends = np.log(tau0 / 2), np.log(n * tau0 / 10)
    log_T = np.linspace(*ends, max(int(np.ptp(ends) / np.log(10) * TABLE_PER_DECADE), 8))
    table = np.stack(
        [GaussMarkov(1.0, float(np.exp(x))).avar(m, frame_rate_hz, form) for x in log_T]
    )
    slope = CubicSpline(log_T, table, axis=0)(log_T, 1)
    ends = np.log(2 / (max(m[-1], 5) * tau0)), np.log(0.5 / tau0)
    log_f = np.linspace(*ends, max(int(np.ptp(ends) / TONE_STEP), 8) + 2)[1:-1]
    tones = [Sinusoid(1.0, float(np.exp(x))).avar(m, frame_rate_hz, form) for x in log_f]
    return Curves(
        m, n, frame_rate_hz, power, log_T, table, slope, log_f, np.stack(tones, axis=1), form
    )


@dataclass(frozen=True)
class Whitened:
    """A `Problem` with the matrix (k, k) that whitened it and its effective number of data."""

    problem: Problem
    matrix: np.ndarray
    n_effective: float


def whitened(
    curves: Curves,
    avar: np.ndarray,
    edf: np.ndarray,
    model: NoiseModel,
    alphas: tuple[int, ...],
    ridge: float,
) -> Whitened:
    """The problem with the covariance of `model`."""
    matrix = whitening_matrix(curves, edf, model, ridge)
    return whitened_by(matrix, curves, avar, alphas, model_curve(curves, model))


def whitening_matrix(
    curves: Curves, edf: np.ndarray, model: NoiseModel, ridge: float
) -> np.ndarray:
    """(k, k) inverse of the Cholesky factor of the covariance of `model`, ridge added."""
    from scipy.linalg import solve_triangular

    covariance = avar_covariance(model, curves.m, curves.n, curves.frame_rate_hz)
    variance = np.diag(covariance)
    sigma = np.sqrt(variance)
    correlation = covariance / np.outer(sigma, sigma) + ridge * np.eye(sigma.size)
    share = kept_share(curves.m, edf, 2 * model_curve(curves, model) ** 2 / variance)
    scale = np.diag(np.sqrt(share) / sigma)
    return solve_triangular(_cholesky(correlation), scale, lower=True)


def model_curve(curves: Curves, model: NoiseModel) -> np.ndarray:
    """The model's Allan variance, power laws from the unit curves (integrals are slow)."""
    total = np.zeros(curves.m.size)
    for part in model.components:
        if isinstance(part, PowerLaw):
            total += part.h * curves.power[:, ALPHAS.index(part.alpha)]
        else:
            total += part.avar(curves.m, curves.frame_rate_hz, curves.form)
    return total


def kept_share(m: np.ndarray, edf: np.ndarray, edf_model: np.ndarray) -> np.ndarray:
    """(k,) share of the model's degrees of freedom that the data have: below 1 where gaps took
    some. edf / edf_model also scatters, as edf follows whole exponents: its upper envelope over a
    decade of tau to either side is taken, and at most 1."""
    ratio = edf / edf_model
    near = np.abs(np.log(m[:, None] / m)) <= np.log(ENVELOPE)
    return np.minimum(np.max(np.where(near, ratio, 0.0), axis=1), 1.0)


def _cholesky(correlation: np.ndarray) -> np.ndarray:
    """Factor of a correlation matrix; what rounding and the ends of the series made negative in its
    spectrum is lifted as little as needed."""
    for lift in (0.0, 1e-8, 1e-6, 1e-4, 1e-3, 1e-2, 1e-1):
        try:
            return np.linalg.cholesky(correlation + lift * np.eye(len(correlation)))
        except np.linalg.LinAlgError:
            continue
    return np.eye(len(correlation))


def whitened_by(
    matrix: np.ndarray,
    curves: Curves,
    avar: np.ndarray,
    alphas: tuple[int, ...],
    scale: np.ndarray,
) -> Whitened:
    def line(log_f: np.ndarray) -> np.ndarray:
        at = curves.m, curves.frame_rate_hz, curves.form
        tones = [Sinusoid(1.0, float(np.exp(x))).avar(*at) for x in log_f]
        return matrix @ np.stack(tones, axis=1)

    fixed = matrix @ curves.power[:, [ALPHAS.index(alpha) for alpha in alphas]]
    table, slope = curves.table @ matrix.T, curves.slope @ matrix.T
    ends = float(curves.log_f[0]), float(curves.log_f[-1])
    nodes = hermite_nodes(curves.log_T, table, slope)
    problem = Problem(matrix @ avar, fixed, curves.log_T, table, nodes, line, ends)
    # 2 / (relative variance of one common factor): n for white noise
    return Whitened(problem, matrix, 2 * float(np.sum((matrix @ scale) ** 2)))
