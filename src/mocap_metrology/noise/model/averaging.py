"""Spectra of frames that are averages over the frame period, where those of points alias.

The mean of m such frames is the mean over m tau0, so their Allan variance is the continuous form
of `model` at every m. With x = f tau0, 0 < x <= 1/2, gain = 4 sin^2(pi x), each spectrum is the
folded sum of S(f) sinc^2(f tau0), in closed form:

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

from mocap_metrology.noise.model.transfer import sinh_minus

DEGREE = 12  # of the smooth parts in x^2 on [0, 1/4]: 1e-12


def power_law_means(alpha: int, f: np.ndarray, tau0: float, gain: np.ndarray) -> np.ndarray:
    """Spectrum of the frame averages of h_alpha = 1 at 0 < f <= 1/(2 tau0); gain: 4 sin^2."""
    if alpha == 0:
        return np.ones_like(gain)
    if alpha == -2:
        return (2 * np.pi * tau0) ** 2 * (1 / gain - 1 / 6)
    if alpha == 2:
        return gain / (2 * np.pi * tau0) ** 2
    x = np.asarray(f, float) * tau0
    if alpha == -1:
        return tau0 / (4 * np.pi**2) * gain * (x**-3 + _smooth(-1, x))
    return gain / (2 * np.pi**2 * tau0) * (0.5 / x + _smooth(1, x))


def _smooth(alpha: int, x: np.ndarray) -> np.ndarray:
    """What is left of the bracket without its pole: even in x."""
    return polynomial.polyval(x * x, _coefficients(alpha))


@lru_cache(maxsize=2)
def _coefficients(alpha: int) -> np.ndarray:
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
