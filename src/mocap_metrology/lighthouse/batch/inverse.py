"""Covariances out of the factor of a banded matrix."""

from __future__ import annotations

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.lighthouse.batch.kernel import POSE


@njit
def selected_inverse(L: np.ndarray) -> np.ndarray:
    """The band of A^-1 from that of the Cholesky factor of A (Takahashi, Fagan & Chin 1973).

    L (w + 1, n): lower diagonals, L[d, j] = L_{j+d, j}; returned likewise. With A^-1 = Z,
    Z_ij = (delta_ij / L_jj - sum_{k > j} L_kj Z_ik) / L_jj for i >= j, columns from the last on.
    """
    w, n = L.shape[0] - 1, L.shape[1]
    Z = np.zeros_like(L)
    for j in range(n - 1, -1, -1):
        most = min(w, n - 1 - j)
        for d in range(most, -1, -1):
            i, total = j + d, 1.0 / L[0, j] if d == 0 else 0.0
            for e in range(1, most + 1):
                k = j + e
                total -= L[e, j] * Z[abs(i - k), min(i, k)]
            Z[d, j] = total / L[0, j]
    return Z


@njit
def pose_blocks(Z: np.ndarray, first: np.ndarray, weights: np.ndarray, out: np.ndarray) -> None:
    """Blocks (n, 6, 6) of the covariance of sum_i weights_i x_{first + i}."""
    for m in range(first.size):
        for i in range(4):
            for j in range(4):
                w = weights[m, i] * weights[m, j]
                for a in range(POSE):
                    for b in range(POSE):
                        r, c = POSE * (first[m] + i) + a, POSE * (first[m] + j) + b
                        out[m, a, b] += w * Z[abs(r - c), min(r, c)]
