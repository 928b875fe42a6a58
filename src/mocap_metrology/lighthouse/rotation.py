"""Rotations: rotation vectors, and the angles of J.

R = Rz(gamma) Ry(beta) Rx(alpha), the convention of the whole project.
"""

from __future__ import annotations

import numpy as np

Angle = float | np.ndarray


def from_angles(alpha: Angle, beta: Angle, gamma: Angle) -> np.ndarray:
    """R = Rz(gamma) Ry(beta) Rx(alpha), (..., 3, 3); angles (...) in rad.

    scipy's `Rotation.from_euler("xyz", ...)` differs from it by rounding, 6e-16, which the
    covariance of a weak simplex fit magnifies to 8e-12 of its value.
    """
    angles = np.array([alpha, beta, gamma])
    (ca, cb, cg), (sa, sb, sg) = np.cos(angles), np.sin(angles)
    R = np.array(
        [
            [cg * cb, cg * sb * sa - sg * ca, cg * sb * ca + sg * sa],
            [sg * cb, sg * sb * sa + cg * ca, sg * sb * ca - cg * sa],
            [-sb, cb * sa, cb * ca],
        ]
    )
    return np.moveaxis(R, (0, 1), (-2, -1)) if R.ndim > 2 else R


def to_angles(R: np.ndarray) -> np.ndarray:
    """alpha, beta, gamma in rad (..., 3) of R = Rz(gamma) Ry(beta) Rx(alpha), (..., 3, 3); beta in
    [-pi/2, pi/2].

    At beta = +-pi/2 only alpha -+ gamma is determined; gamma is set to 0.
    """
    level = np.hypot(R[..., 2, 1], R[..., 2, 2])
    free = level > 1e-9
    alpha = np.where(
        free, np.arctan2(R[..., 2, 1], R[..., 2, 2]), np.arctan2(-R[..., 1, 2], R[..., 1, 1])
    )
    gamma = np.where(free, np.arctan2(R[..., 1, 0], R[..., 0, 0]), 0.0)
    return np.stack([alpha, np.arctan2(-R[..., 2, 0], level), gamma], axis=-1)


def exp(v: np.ndarray) -> np.ndarray:
    """Rotation matrices of rotation vectors in rad."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(v).as_matrix()


def log(R: np.ndarray) -> np.ndarray:
    """Rotation vector in rad of a rotation matrix, length in [0, pi]."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(R).as_rotvec()


def quaternions(R: np.ndarray) -> np.ndarray:
    """x, y, z, w with w >= 0 of rotation matrices (..., 3, 3), (..., 4)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(R).as_quat(canonical=True)


def of_quaternions(q: np.ndarray) -> np.ndarray:
    """Rotation matrices of x, y, z, w, (..., 4)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(q).as_matrix()


def cross(v: np.ndarray) -> np.ndarray:
    """Matrices (..., 3, 3) with [v] w = v x w."""
    return np.cross(v[..., None, :], -np.eye(3))


def error(R_est: np.ndarray, R_true: np.ndarray) -> np.ndarray:
    """Rotation vector in rad of R_est R_true^T, in master axes: the error in every table."""
    return log(R_est @ R_true.T)


def mean(rotations: np.ndarray) -> np.ndarray:
    """Robust mean of rotation matrices (n, 3, 3): least sum of angles (Weiszfeld on rotations)."""
    from scipy.spatial.transform import Rotation

    turns = Rotation.from_matrix(rotations)
    middle = turns.mean()
    for _ in range(10):
        v = (turns * middle.inv()).as_rotvec()
        weight = 1 / np.maximum(np.linalg.norm(v, axis=1), 1e-6)
        step = weight @ v / weight.sum()
        middle = Rotation.from_rotvec(step) * middle
        if np.linalg.norm(step) < 1e-5:  # rad, below the resolution of a pose
            break
    return middle.as_matrix()
