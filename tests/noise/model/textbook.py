"""Spectra in continuous time, one-sided, and the Allan variance, as textbooks print them."""

import numpy as np

from mocap_metrology.noise.model.components import GaussMarkov, PowerLaw


def density(part: PowerLaw | GaussMarkov, f: np.ndarray) -> np.ndarray:
    """h f^alpha, or 2 (q_c T_c)^2 / (1 + (2 pi f T_c)^2)."""
    if isinstance(part, PowerLaw):
        return part.h * np.asarray(f, float) ** float(part.alpha)
    return 2 * (part.q_c * part.T_c) ** 2 / (1 + (2 * np.pi * part.T_c * np.asarray(f)) ** 2)


def allan_variance(y: np.ndarray, m: int) -> float:
    """Overlapping Allan variance: half the mean square of differences of adjacent means."""
    s = np.concatenate([[0.0], np.cumsum(y)])
    d = s[2 * m :] - 2 * s[m:-m] + s[: -2 * m]
    return float(d @ d) / d.size / (2 * m**2)
