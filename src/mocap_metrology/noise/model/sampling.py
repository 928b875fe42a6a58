"""What frames make of a noise: Allan variances of points, spectra of averages over a period.

Frames that are points alias; their Allan variances need the integrals below, which cancel at no m.
The mean of m frames that are averages is the mean over m tau0, so their Allan variance is the
continuous form of `components` at every m. With x = f tau0, 0 < x <= 1/2, gain = 4 sin^2(pi x),
the spectrum of averages is the folded sum of S(f) sinc^2(f tau0), in closed form:

* white: itself; random walk: h (2 pi tau0)^2 (1/gain - 1/6);
* flicker without an upper limit: h tau0 gain / (4 pi^2) [zeta(3, x) + zeta(3, 1 - x)];
* Gauss-Markov, a = tau0/T_c: variance 2 (a - 1 + e^-a) / a^2, then (2 sinh(a/2) / a)^2 e^(-a j);
* violet up to Nyquist, as S has it: h gain / (2 pi tau0)^2, not folded;
* blue: S's form is the one for f_h tau >> 1, and the average of h f up to Nyquist misses it by
  3.6 % of the Allan deviation at one frame (0.6 % at two, 0.1 % at five). Exactly that form at
  every m have the differences of a phase whose covariance falls as -ln j from gamma + ln pi at
  j = 0: h gain / (2 pi^2 tau0) [-ln 2 - (psi(x) + psi(1 - x)) / 2], 3 % below the average of h f
  at 20 Hz of 120 and 27 % above it at Nyquist. It is drawn, so that nothing is left.

The sums over aliases are those of Hurwitz's zeta and the digamma function [NIST DLMF 25.11, 5.15];
for the logarithm, Kummer's series of sum ln j cos(2 pi j x) [DLMF 25.11.9].
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.polynomial import polynomial

PANELS = 64  # half periods of sin^4 that are integrated as they are
BLOCK = 2048  # values of m at a time: 13 MB a work array
DEGREE = 12  # of the smooth parts in x^2 on [0, 1/4]: 1e-12


def _nodes(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Legendre on [0, 1]: nodes and weights."""
    x, w = np.polynomial.legendre.leggauss(count)
    return (x + 1) / 2, w / 2


PANEL, REST = _nodes(12), _nodes(64)


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
    x, w = PANEL
    v = ((np.arange(PANELS)[:, None] + x) / 2).ravel()  # m u
    weight = np.tile(w / 2, PANELS) * np.sin(np.pi * v) ** 4
    inside = v < m[:, None] / 2  # m = 64 or less: m panels reach u = 1/2
    u = np.where(inside, v / m[:, None], 0.5)
    total: np.ndarray = np.where(inside, u**alpha / np.sin(np.pi * u) ** 2, 0.0) @ weight / m
    far = m > PANELS
    if far.any():
        total[far] += _tail_integral(alpha, m[far])
    return total


def _tail_integral(alpha: int, m: np.ndarray) -> np.ndarray:
    """The part of `band_limited` from U = PANELS / (2m) to 1/2, m > PANELS."""
    x, w = REST
    start = PANELS / (2 * m)
    span = np.log(0.5 / start)[:, None]
    u = start[:, None] * np.exp(span * x)
    constant = (u ** (alpha + 1) / np.sin(np.pi * u) ** 2 * span) @ w * 3 / 8

    def slope(u: np.ndarray) -> np.ndarray:
        angle = np.pi * u
        change: np.ndarray = alpha - 2 * angle / np.tan(angle)
        change *= u ** (alpha - 1) / np.sin(angle) ** 2
        return change

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


def power_law_means(
    alpha: int, f: np.ndarray, frame_rate_hz: float, gain: np.ndarray
) -> np.ndarray:
    """Spectrum of the frame averages of h_alpha = 1 at 0 < f <= 1/(2 tau0); gain: 4 sin^2."""
    tau0 = 1 / frame_rate_hz
    if alpha == 0:
        return np.ones_like(gain)
    if alpha == -2:
        return (2 * np.pi * tau0) ** 2 * (1 / gain - 1 / 6)
    if alpha == 2:
        return gain / (2 * np.pi * tau0) ** 2
    x = np.asarray(f, float) * tau0
    smooth = polynomial.polyval(x * x, _smooth(alpha))
    if alpha == -1:
        return tau0 / (4 * np.pi**2) * gain * (x**-3 + smooth)
    return gain / (2 * np.pi**2 * tau0) * (0.5 / x + smooth)


@lru_cache(maxsize=2)
def _smooth(alpha: int) -> np.ndarray:
    """Coefficients, in x^2, of what is left of the bracket without its pole."""
    from scipy.special import digamma, zeta

    def flicker(u: np.ndarray) -> np.ndarray:
        return zeta(3, 1 + np.sqrt(u)) + zeta(3, 1 - np.sqrt(u))

    def blue(u: np.ndarray) -> np.ndarray:
        return -math.log(2) - (digamma(1 + np.sqrt(u)) + digamma(1 - np.sqrt(u))) / 2

    of = flicker if alpha == -1 else blue
    fitted = np.polynomial.Chebyshev.interpolate(of, DEGREE, domain=[0.0, 0.25])
    return fitted.convert(kind=np.polynomial.Polynomial).coef


def correlated_means(a: float, gain: np.ndarray) -> np.ndarray:
    """Spectrum of the frame averages of a Gauss-Markov component, over 2 tau0 times its variance;
    a = tau0/T_c. Two ways of writing the same, each where it keeps its digits."""
    squared = np.expm1(-a) ** 2
    denominator = squared + math.exp(-a) * gain
    falling = -np.expm1(-2 * a)
    if a > 1:
        return 2 / a**2 * (a - falling / 2 * gain / denominator)
    return correlated_gain(a) * falling / denominator - 2 * sinh_minus(a) / a**2


def correlated_gain(a: float) -> float:
    """(2 sinh(a/2) / a)^2: covariance of two averages apart over that of two points."""
    return (2 * math.sinh(a / 2) / a) ** 2
