"""Compiled: Allan variances of a model, their misfit to data, and the descent to its minimum.

Kernels of `relative`, which describes the coordinates. (k,) averaging times, (d,) coordinates.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.linear import solve
from mocap_metrology.common.types import Floats
from mocap_metrology.noise.model.sampling import correlated_bracket

# Table of F(x) = G(x) / x^2 (see `model.GaussMarkov.avar`): e^-23 <= x <= e^23, 128 steps an e-fold
FIRST, LAST, STEPS = -23, 23, 128
SINGULAR = 1e-15  # what is left of a diagonal element, over it

# What a cost depends on besides the point; `residual` names the nine in order. A plain tuple, as
# numba takes 0.7 us a call to check the class of a named one.
Problem = tuple[*tuple[Floats, Floats, Floats, Floats, Floats], *tuple[float, int, bool, Floats]]


@lru_cache(maxsize=1)
def correlated_table() -> np.ndarray:
    """(46 * 128, 4) cubics of F(x) = G(x) / x^2 between even steps of ln x, lowest power first.

    They meet F and its slope at the steps; with E = 1 - e^-x, G' = 2 E^2, so that slope is
    2 E^2 / x - 2 F. Right to 1e-10 of F, at a tenth of the time of the exponentials.
    """
    x = np.exp(np.arange(FIRST * STEPS, LAST * STEPS + 1) / STEPS)
    F = correlated_bracket(x) / x**2
    # The slope cancels below x = 1, where F = sum_n c_n x^(n - 2)
    terms = [(n - 2) * (4.0 - 2.0**n) / math.factorial(n) * (-1) ** n for n in range(3, 25)]
    series = np.polynomial.polynomial.polyval(np.minimum(x, 1.0), terms) * x
    slope = np.where(x < 1, series, 2 * np.expm1(-x) ** 2 / x - 2 * F) / STEPS
    rise, begin, end = np.diff(F), slope[:-1], slope[1:]
    cubics = [F[:-1], begin, 3 * rise - 2 * begin - end, begin + end - 2 * rise]
    return np.ascontiguousarray(np.column_stack(cubics))


@njit
def _correlated(log_T: float, problem: Problem, curve: Floats, slope: Floats) -> None:
    """Allan variance of a Gauss-Markov term of variance 1 at m, and its derivative by log T_c.

    `model.GaussMarkov.avar`: with a = tau0 / T_c, x = m a, continuous F(x), sampled
    (2m (sinh a - a) + x^2 F) / (2m sinh(a/2))^2, which is a factor times F plus a rest over m.
    """
    _, m, log_m, _, _, tau0, _, sampled, table = problem
    log_a = math.log(tau0) - log_T
    factor, rest, factor_slope, rest_slope = 1.0, 0.0, 0.0, 0.0
    if sampled:
        factor, rest, factor_slope, rest_slope = _points(math.exp(log_a))
    for k in range(log_m.size):
        at = (log_m[k] + log_a - FIRST) * STEPS
        i = min(max(int(at), 0), table.shape[0] - 1)
        t = at - i
        p0, p1, p2, p3 = table[i, 0], table[i, 1], table[i, 2], table[i, 3]
        F = p0 + t * (p1 + t * (p2 + t * p3))
        rising = STEPS * (p1 + t * (2 * p2 + t * 3 * p3))
        curve[k] = factor * F + rest / m[k]
        slope[k] = factor_slope * F - factor * rising + rest_slope / m[k]


@njit
def _points(a: float) -> tuple[float, float, float, float]:
    """Functions of a = tau0 / T_c for a sampled Gauss-Markov term: (a / (2 sinh(a/2)))^2 and
    (sinh a - a) / (2 sinh^2(a/2)), and their derivatives by log T_c = -log a + constant."""
    if a > 300:  # white: variance / m
        return 0.0, 1.0, 0.0, 0.0
    half = math.sinh(a / 2)
    minus = math.sinh(a) - a
    if a < 0.5:
        a2 = a * a
        minus = a * a2 / 6 * (1 + a2 / 20 * (1 + a2 / 42 * (1 + a2 / 72 * (1 + a2 / 110))))
    factor = (a / (2 * half)) ** 2
    points = minus / (2 * half * half)
    twist = a / math.tanh(a / 2)
    return factor, points, factor * (twist - 2), points * twist - a


@njit
def _line(f_0: float, problem: Problem, curve: Floats, slope: Floats) -> None:
    """Allan variance of a sinusoid of amplitude 1, and its derivative by log f_0."""
    _, m, _, _, _, tau0, _, sampled, _ = problem
    x = math.pi * f_0 * tau0
    below = math.sin(x) if sampled else x
    falling = x / math.tan(x) if sampled else 1.0
    for k in range(m.size):
        s, c = math.sin(m[k] * x), math.cos(m[k] * x)
        curve[k] = s**4 / (m[k] * below) ** 2
        slope[k] = 4 * s**3 * c * x / (m[k] * below**2) - 2 * falling * curve[k]


@njit
def _add(
    x: Floats, i: int, weights: Floats, curve: Floats, slope: Floats, r: Floats, jacobian: Floats
) -> None:
    """Add the component of coordinates i, i + 1 at its share: w curve / rms(w curve) * share."""
    squares, product = 0.0, 0.0
    for k in range(r.size):
        curve[k] *= weights[k]
        slope[k] *= weights[k]
        squares += curve[k] * curve[k]
        product += curve[k] * slope[k]
    scale = math.exp(x[i]) / math.sqrt(squares / r.size)
    lost = product / squares
    for k in range(r.size):
        part = scale * curve[k]
        r[k] += part
        if jacobian.shape[0] == x.size:
            jacobian[i, k] = part
            jacobian[i + 1, k] = scale * slope[k] - lost * part


@njit
def residual(x: Floats, problem: Problem, jacobian: Floats) -> Floats:
    """(k,) w (model - obs); its derivatives go to `jacobian`, (d, k), or (0, k) if not wanted."""
    fixed, m, _, weights, target, _, gauss_markov, _, _ = problem
    r = -target
    n = fixed.shape[0]
    for i in range(n):
        share = math.exp(x[i])
        for k in range(r.size):
            part = share * fixed[i, k]
            r[k] += part
            if jacobian.shape[0] == x.size:
                jacobian[i, k] = part
    curve, slope = np.empty(m.size), np.empty(m.size)
    for i in range(n, x.size, 2):
        if i < n + 2 * gauss_markov:
            _correlated(x[i + 1], problem, curve, slope)
        else:
            _line(math.exp(x[i + 1]), problem, curve, slope)
        _add(x, i, weights, curve, slope, r, jacobian)
    return r


@njit
def costs_at(points: np.ndarray, problem: Problem) -> np.ndarray:
    """Sums of squared residuals of the Allan variances at points (n, parameters)."""
    costs, none = np.zeros(points.shape[0]), np.empty((0, 1))
    for i in range(costs.size):
        r = residual(points[i], problem, none)
        for k in range(r.size):
            costs[i] += r[k] * r[k]
    return costs


@njit
def descend(
    start: np.ndarray, lower: np.ndarray, upper: np.ndarray, iterations: int, problem: Problem
) -> tuple[np.ndarray, float]:
    """Projected Levenberg-Marquardt: (point, cost) of the local minimum below `start`.

    Damped by the diagonal of J'J, so the scale of a coordinate does not matter; a coordinate on
    a bound that the descent would leave the range by stands still; steps end at the bounds.
    """
    d, n = start.size, problem[1].size
    x = np.minimum(np.maximum(start, lower), upper)
    jacobian = np.empty((d, n))
    none = np.empty((0, 1))
    r = residual(x, problem, jacobian)
    cost = np.dot(r, r)
    damping, stalled = 1.0, 0
    for _ in range(iterations):
        gradient = np.dot(jacobian, r)
        normal = np.dot(jacobian, jacobian.T)
        free = np.ones(d, np.bool_)
        for i in range(d):
            if (x[i] <= lower[i] and gradient[i] > 0) or (x[i] >= upper[i] and gradient[i] < 0):
                free[i] = False
        better = False
        while damping < 1e12:
            damped = normal.copy()
            for i in range(d):
                damped[i, i] += damping * normal[i, i] + 1e-300 if free[i] else np.inf
            step = gradient.copy()
            solve(damped, step, 0.0, SINGULAR, np.inf)
            trial = np.minimum(np.maximum(x - step, lower), upper)
            then = residual(trial, problem, none)
            if np.dot(then, then) < cost:
                better = True
                break
            damping *= 4
        if not better:
            break
        gain = cost - np.dot(then, then)
        x, damping = trial, max(damping / 8, 1e-12)
        r = residual(x, problem, jacobian)
        stalled = stalled + 1 if gain < 1e-9 * cost else 0
        cost -= gain
        if stalled == 3:
            break
    return x, np.dot(r, r)
