"""Covariance of the pose of a body, from the noise of its markers."""

from __future__ import annotations

import numpy as np

FLAT = 0.02  # least spread across a line of markers, as a share of that along it


def body_covariance(places: np.ndarray, sigma: np.ndarray) -> np.ndarray | None:
    """Covariance (6, 6) of translation of the markers' centre, and of rotation about it.

    The pose that least squares fit to k >= 3 markers at p_i, whose errors are independent with
    variances S_i = diag(sigma_i^2): with J_i = (I, -[p_i - c]x) and A = sum J_i' J_i it is
    A^-1 (sum J_i' S_i J_i) A^-1 [law of propagation, JCGM 100 5.1]. Equal sigma give s^2/k for the
    translation and s^2 (sum |q_i|^2 I - q_i q_i')^-1 for the rotation.

    places, sigma: (k, 3), of one unit, which the translation has; rotation vectors in rad, in the
    axes of the places. None with fewer than three markers, or on a line, as the rotation about it
    is then unknown.
    """
    if len(places) < 3:
        return None
    centred = places - places.mean(axis=0)
    spread = np.linalg.svd(centred, compute_uv=False)
    if not spread[1] > FLAT * spread[0]:
        return None
    scale = spread[0]  # so that both kinds of unknowns are of one size
    x, y, z = centred.T / scale
    none = np.zeros_like(x)
    cross = np.moveaxis(np.array([[none, z, -y], [-z, none, x], [y, -x, none]]), 2, 0)
    jacobian = np.concatenate([np.broadcast_to(np.eye(3), cross.shape), cross], axis=2)
    inverse = np.linalg.inv(np.einsum("kab,kac->bc", jacobian, jacobian))
    noise = np.einsum("kab,ka,kac->bc", jacobian, sigma**2, jacobian)
    units = np.repeat([1.0, 1.0 / scale], 3)
    return np.asarray(inverse @ noise @ inverse * np.outer(units, units))
