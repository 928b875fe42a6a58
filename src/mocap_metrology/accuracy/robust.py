"""Least squares and spread that a few gross errors do not govern."""

from __future__ import annotations

import numpy as np

from mocap_metrology.common.hampel import MAD_TO_SIGMA

TUNING = 1.345  # Huber's, of 95 % efficiency for normal noise
ROUNDS = 30


def robust_sd(values: np.ndarray) -> float:
    """1.4826 times the median absolute deviation from the median; NaN are left out."""
    return float(MAD_TO_SIGMA * np.nanmedian(np.abs(values - np.nanmedian(values))))


def huber(design: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Coefficients (p,) of target (n,) = design (n, p) by Huber's M estimate with the scale of the
    residuals' median [Huber, Robust Statistics, ch. 7], by iterated weights; the shortest ones
    where the design does not determine them."""
    weight, coefficients = np.ones(target.size), np.zeros(design.shape[1])
    for _ in range(ROUNDS):
        before = coefficients
        weighted = design.T * weight
        coefficients = np.linalg.lstsq(weighted @ design, weighted @ target, rcond=1e-10)[0]
        residual = np.abs(target - design @ coefficients)
        limit = TUNING * MAD_TO_SIGMA * float(np.median(residual))
        if not limit > 0 or np.allclose(before, coefficients, rtol=1e-4, atol=1e-4 * limit):
            break
        weight = np.minimum(limit / np.maximum(residual, limit), 1.0)
    return np.asarray(coefficients)
