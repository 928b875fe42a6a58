"""Positive definite systems of few unknowns, solved inside compiled loops, least squares of
unknowns that are not negative, and rotations nearest to matrices.

In a compiled loop a call of LAPACK costs more than the work, and each caller has its own answer to
a matrix that rounding has made singular: `least`, `relative` and `instead`. A pivot is what is left
of A_jj; one that is not above least + relative A_jj is replaced by `instead`: a small number to go
on with, NaN to make the whole solution NaN, or infinity to leave the unknown out, as 0. An unknown
whose A_jj is infinite is left out, too.
"""

from __future__ import annotations

import math

import numpy as np

from mocap_metrology.common.compiled import njit


@njit
def cholesky(matrix: np.ndarray, n: int, least: float, relative: float, instead: float) -> None:
    """Lower factor L of A = L L^T, in place: matrix[:n, :n] holds A, of which the lower half
    is read, and then L there."""
    for j in range(n):
        pivot = matrix[j, j]
        limit = least + relative * pivot
        for k in range(j):
            pivot -= matrix[j, k] * matrix[j, k]
        root = math.sqrt(pivot if pivot > limit else instead)
        matrix[j, j] = root
        for i in range(j + 1, n):
            s = matrix[i, j]
            for k in range(j):
                s -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = s / root


@njit
def solve(
    matrix: np.ndarray, right: np.ndarray, least: float, relative: float, instead: float
) -> None:
    """Solve A x = b in place: matrix (n, n) holds A, then its factor; right (n,) b, then x."""
    n = right.size
    cholesky(matrix, n, least, relative, instead)
    for i in range(n):
        s = right[i]
        for k in range(i):
            s -= matrix[i, k] * right[k]
        right[i] = s / matrix[i, i]
    for i in range(n - 1, -1, -1):
        s = right[i]
        for k in range(i + 1, n):
            s -= matrix[k, i] * right[k]
        right[i] = s / matrix[i, i]


def non_negative(matrix: np.ndarray, target: np.ndarray) -> np.ndarray:
    """x >= 0 (n,) of least |A x - b|, for A (m, n) and b (m,) [Lawson & Hanson, Solving Least
    Squares Problems, ch. 23]; by interior points where columns so alike make that method cycle."""
    from scipy.optimize import lsq_linear, nnls

    norm = np.linalg.norm(matrix, axis=0)
    norm[norm == 0] = 1.0
    scaled = matrix / norm
    try:
        x = nnls(scaled, target)[0]
    except RuntimeError:
        x = np.maximum(lsq_linear(scaled, target, (0.0, np.inf)).x, 0.0)
    return np.asarray(x / norm)


def nearest_rotation(H: np.ndarray) -> np.ndarray:
    """Rotations (..., 3, 3) nearest to matrices: greatest trace of R^T H [Kabsch 1978]."""
    U, _, Vt = np.linalg.svd(H)
    U[..., 2] *= np.sign(np.linalg.det(U) * np.linalg.det(Vt))[..., None]
    return U @ Vt
