"""Scale factors of the Allan variances of power-law noises, S Table 1, found again two ways.

    S(f) = h f^alpha up to f_h,   AVAR(tau) = 2 Int_0^fh S(f) sin^4(pi f tau) / (pi f tau)^2 df

is h K_alpha tau^mu, exactly (alpha -2, -1, 0, without a limit f_h) or for f_h tau >> 1 (1, 2).
Everything is for h = 1: K_alpha in S's scale factors A ... E, of which D depends on tau.
"""

from __future__ import annotations

import math

import numpy as np

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.model.components import NoiseModel, PowerLaw
from mocap_metrology.noise.model.synthesis import circle_length, draw, increment_spectrum

MU = {-2: 1, -1: 0, 0: -1, 1: -2, 2: -2}  # S Table 1
PRINTED_D = 1.038  # 3 gamma - ln 2 = 1.03850


def printed_scale(alpha: int, tau: float, f_h: float) -> float:
    """K_alpha as S prints it: A = 2 pi^2/3, B = 2 ln 2, C = 1/2,
    D = (1.038 + 3 ln(2 pi f_h tau)) / (4 pi^2), E = 3 f_h / (4 pi^2)."""
    return {
        -2: 2 * math.pi**2 / 3,
        -1: 2 * math.log(2),
        0: 0.5,
        1: (PRINTED_D + 3 * math.log(2 * math.pi * f_h * tau)) / (4 * math.pi**2),
        2: 3 * f_h / (4 * math.pi**2),
    }[alpha]


def integrated_avar(alpha: int, tau: float, f_h: float) -> tuple[float, float]:
    """The integral above for h = 1, and a bound of its numerical error.

    With u = pi f tau it is 2 (pi tau)^(-alpha-1) Int_0^U u^(alpha-2) sin^4 u du, taken half period
    by half period of sin^4. Without limit (alpha <= 0 only) the part above 1000 of them is that of
    the mean of sin^4, 3/8; what is left of it there is below U^(alpha-3).
    """
    from scipy.integrate import quad

    unlimited = math.isinf(f_h)
    end = 1000 * math.pi if unlimited else math.pi * f_h * tau
    edges = np.append(np.arange(0.0, end * (1 - 1e-12), math.pi), end)
    parts = [
        quad(lambda u: u ** (alpha - 2) * math.sin(u) ** 4, a, b)
        for a, b in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
    ]
    total, error = (math.fsum(part[k] for part in parts) for k in (0, 1))
    if unlimited:
        total += 3 / 8 * end ** (alpha - 1) / (1 - alpha)
        error += end ** (alpha - 3)
    unit = 2 * (math.pi * tau) ** (-alpha - 1)
    return unit * total, unit * error


def averaged_samples(
    alpha: int, n: int, frame_rate_hz: float, rng: np.random.Generator
) -> np.ndarray:
    """(n,) means over successive times tau0 of noise with S = f^alpha up to f_h = 1/(2 tau0).

    Of such a series the mean of m samples is the mean over m tau0, so its sampled Allan variance is
    the continuous one at every m. A camera takes points instead, see `model`.
    """
    length = circle_length(n)
    spectrum = increment_spectrum(NoiseModel((PowerLaw(alpha, 1.0),)), length, frame_rate_hz)
    mean = np.sinc(np.arange(spectrum.size) / length) ** 2
    # `PowerLaw.psd` holds the aliases of a random walk; there are none here
    spectrum *= mean**2 if alpha == -2 else mean
    return draw(spectrum, n, length, frame_rate_hz, rng)


def simulated_avar(
    alpha: int, m: np.ndarray, n: int, frame_rate_hz: float, repeats: int, rng: np.random.Generator
) -> np.ndarray:
    """(repeats, k) overlapping Allan variances at m tau0 of `averaged_samples`."""
    runs = (averaged_samples(alpha, n, frame_rate_hz, rng) for _ in range(repeats))
    return np.array([allan_variance(series, m).variance for series in runs])


def mean_and_error(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean over the realisations, (repeats, k), and its standard error, each (k,)."""
    return values.mean(axis=0), values.std(axis=0, ddof=1) / math.sqrt(values.shape[0])


def slope_weights(tau: np.ndarray) -> np.ndarray:
    """w with slope = sum w ln y: least squares of ln y on ln tau, each (k,)."""
    x = np.log(tau) - np.log(tau).mean()
    return x / np.sum(x**2)


def slope_and_error(tau: np.ndarray, values: np.ndarray) -> tuple[float, float]:
    """Log-log slope of the mean of realisations, (repeats, k), and its standard error.

    The logarithm is taken of the mean, for that of a single estimate is biased; its error follows
    from the linearised scatter, sum w (value / mean), of the realisations.
    """
    weights, mean = slope_weights(tau), values.mean(axis=0)
    scatter = (values / mean) @ weights
    return float(weights @ np.log(mean)), float(scatter.std(ddof=1) / math.sqrt(scatter.size))
