"""Spectra of noises in continuous time, as textbooks print them, one-sided."""

import numpy as np

from mocap_metrology.noise.model.components import GaussMarkov, PowerLaw


def density(part: PowerLaw | GaussMarkov, f: np.ndarray) -> np.ndarray:
    """h f^alpha, or 2 (q_c T_c)^2 / (1 + (2 pi f T_c)^2)."""
    if isinstance(part, PowerLaw):
        return part.h * np.asarray(f, float) ** float(part.alpha)
    return 2 * (part.q_c * part.T_c) ** 2 / (1 + (2 * np.pi * part.T_c * np.asarray(f)) ** 2)
