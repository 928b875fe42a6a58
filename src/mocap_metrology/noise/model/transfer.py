"""Integrals behind the sampled Allan variances of `model`, without cancellation at any m."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

PANELS = 64  # half periods of sin^4 that are integrated as they are
BLOCK = 2048  # values of m at a time: 13 MB a work array


@lru_cache(maxsize=1)
def _nodes() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Gauss-Legendre on [0, 1]: nodes and weights, 12 for a panel and 64 for the rest."""
    inner = np.polynomial.legendre.leggauss(12)
    outer = np.polynomial.legendre.leggauss(64)
    return (inner[0] + 1) / 2, inner[1] / 2, (outer[0] + 1) / 2, outer[1] / 2


def band_limited(alpha: int, m: np.ndarray) -> np.ndarray:
    """I(m) = Int_0^(1/2) u^alpha sin^4(pi m u) / sin^2(pi u) du for alpha = -1, 1, 2; about 1e-8.

    The sampled Allan variance of h f^alpha up to Nyquist is 2 h tau0^(-alpha-1) I(m) / m^2.
    The first 64 half periods of sin^4 (all there are up to m = 64) by 12 nodes each. From
    U = 32/m on, sin^4 = 3/8 - cos(2 pi m u)/2 + cos(4 pi m u)/8: the constant by 64 nodes in
    ln u, a cosine by the leading term of its expansion at both ends, F'(u) cos / omega^2 with
    F = u^alpha / sin^2(pi u) (the sine terms are zero there). The cost does not depend on m.
    """
    m = np.asarray(m, float)
    flat = m.ravel()
    parts = [_block(alpha, flat[i : i + BLOCK]) for i in range(0, flat.size, BLOCK)]
    return np.concatenate([*parts, flat[:0]]).reshape(m.shape)


def _block(alpha: int, m: np.ndarray) -> np.ndarray:
    x, w, _, _ = _nodes()
    v = ((np.arange(PANELS)[:, None] + x) / 2).ravel()  # m u
    weight = np.tile(w / 2, PANELS) * np.sin(np.pi * v) ** 4
    inside = v < m[:, None] / 2  # m = 64 or less: m panels reach u = 1/2
    u = np.where(inside, v / m[:, None], 0.5)
    total = np.where(inside, u**alpha / np.sin(np.pi * u) ** 2, 0.0) @ weight / m
    far = m > PANELS
    if far.any():
        total[far] += _rest(alpha, m[far])
    return total


def _rest(alpha: int, m: np.ndarray) -> np.ndarray:
    """The part of `band_limited` from U = PANELS / (2m) to 1/2, m > PANELS."""
    _, _, x, w = _nodes()
    start = PANELS / (2 * m)
    span = np.log(0.5 / start)[:, None]
    u = start[:, None] * np.exp(span * x)
    constant = (u ** (alpha + 1) / np.sin(np.pi * u) ** 2 * span) @ w * 3 / 8

    def slope(u: np.ndarray) -> np.ndarray:
        angle = np.pi * u
        return u ** (alpha - 1) / np.sin(angle) ** 2 * (alpha - 2 * angle / np.tan(angle))

    parity = np.where(m % 2 == 0, 1.0, -1.0)  # cos(2 pi m u) at u = 1/2
    omega2 = (2 * np.pi * m) ** 2
    begin, end = slope(start), slope(np.full_like(m, 0.5))
    single, double = (end * parity - begin) / omega2, (end - begin) / (4 * omega2)
    return constant - single / 2 + double / 8


def correlated_bracket(x: np.ndarray) -> np.ndarray:
    """G(x) = 2x - 3 + 4 e^-x - e^-2x >= 0; below x = 1 by its series, sum (4 - 2^n) (-x)^n / n!."""
    x = np.asarray(x, float)
    small = -np.minimum(x, 1.0)
    coefficients = [(4.0 - 2.0**n) / math.factorial(n) for n in range(3, 25)]
    series = np.polynomial.polynomial.polyval(small, coefficients) * small**3
    return np.where(x < 1.0, series, 2 * x - 3 + 4 * np.exp(-x) - np.exp(-2 * x))


def sinh_minus(a: float) -> float:
    """sinh(a) - a, a >= 0."""
    if a > 0.5:
        return math.sinh(a) - a
    return sum(a**n / math.factorial(n) for n in range(3, 21, 2))
