"""Whitening of Allan variances by their covariance, and the unit curves of all components."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from mocap_metrology.noise.fit.allan.avar_covariance import avar_covariance
from mocap_metrology.noise.fit.allan.separable import Problem, hermite_nodes
from mocap_metrology.noise.model.components import (
    ALPHAS,
    Form,
    GaussMarkov,
    NoiseModel,
    PowerLaw,
    Sinusoid,
)

TABLE_PER_DECADE = 40
TONE_STEP = 0.01  # of log f_0: the Allan curve's oscillations that stand out move by less
ENVELOPE = 10.0  # degrees of freedom are compared with the model's over a decade to either side


@dataclass(frozen=True)
class Curves:
    """Unit curves at the averaging factors: power (k, 5) for h_alpha = 1, log_T (g,) with table
    and slope (g, k) for q_c = 1, log_f (f,) with tones (k, f) for A_s = 1."""

    m: np.ndarray
    n: int
    tau0: float
    power: np.ndarray
    log_T: np.ndarray
    table: np.ndarray
    slope: np.ndarray
    log_f: np.ndarray
    tones: np.ndarray
    form: Form = "sampled"


@lru_cache(maxsize=4)
def unit_curves(m_bytes: bytes, n: int, tau0: float, form: Form = "sampled") -> Curves:
    """Those of a series of n samples. T_c from tau0/2 to T/10; f_0 from two periods in the longest
    tau (slower, the curve only rises, as with random walk) to Nyquist."""
    from scipy.interpolate import CubicSpline

    m = np.frombuffer(m_bytes, dtype=np.int64)
    power = np.stack([PowerLaw(alpha, 1.0).avar(m, tau0, form) for alpha in ALPHAS], axis=1)
    ends = np.log(tau0 / 2), np.log(n * tau0 / 10)
    log_T = np.linspace(*ends, max(int(np.ptp(ends) / np.log(10) * TABLE_PER_DECADE), 8))
    table = np.stack([GaussMarkov(1.0, float(np.exp(x))).avar(m, tau0, form) for x in log_T])
    slope = CubicSpline(log_T, table, axis=0)(log_T, 1)
    ends = np.log(2 / (max(m[-1], 5) * tau0)), np.log(0.5 / tau0)
    log_f = np.linspace(*ends, max(int(np.ptp(ends) / TONE_STEP), 8) + 2)[1:-1]
    tones = [Sinusoid(1.0, float(np.exp(x))).avar(m, tau0, form) for x in log_f]
    return Curves(m, n, tau0, power, log_T, table, slope, log_f, np.stack(tones, axis=1), form)


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

    covariance = avar_covariance(model, curves.m, curves.n, curves.tau0)
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
            total += part.avar(curves.m, curves.tau0, curves.form)
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
        at = curves.m, curves.tau0, curves.form
        tones = [Sinusoid(1.0, float(np.exp(x))).avar(*at) for x in log_f]
        return matrix @ np.stack(tones, axis=1)

    fixed = matrix @ curves.power[:, [ALPHAS.index(alpha) for alpha in alphas]]
    table, slope = curves.table @ matrix.T, curves.slope @ matrix.T
    ends = float(curves.log_f[0]), float(curves.log_f[-1])
    nodes = hermite_nodes(curves.log_T, table, slope)
    problem = Problem(matrix @ avar, fixed, curves.log_T, table, nodes, line, ends)
    # 2 / (relative variance of one common factor): n for white noise
    return Whitened(problem, matrix, 2 * float(np.sum((matrix @ scale) ** 2)))
