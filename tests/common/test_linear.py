"""Small positive definite systems, beside numpy."""

import numpy as np
import pytest

from mocap_metrology.common.linear import non_negative, solve


def system(n: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n + 3, n)) * 10 ** rng.uniform(-2, 2, n)
    return root.T @ root, rng.normal(size=n)


@pytest.mark.parametrize("n", [1, 2, 6, 12, 33])
def test_solution_and_factor_beside_numpy(n: int) -> None:
    A, b = system(n)
    matrix, x = A + np.triu(np.full((n, n), np.nan), 1), b.copy()  # the upper half is not read
    solve(matrix, x, 0.0, 1e-14, np.nan)
    np.testing.assert_allclose(x, np.linalg.solve(A, b), rtol=1e-6)
    np.testing.assert_allclose(np.tril(matrix), np.linalg.cholesky(A), rtol=1e-9)


def test_least_squares_without_negative_values_meet_their_conditions() -> None:
    """Those of Karush, Kuhn and Tucker: x >= 0, gradient >= 0, and one of both 0; also of columns
    that are nearly alike, of which the active-set method of SciPy 1.17 does not come to an end."""
    rng = np.random.default_rng(5)
    f = np.geomspace(0.01, 70, 300)
    corners = np.geomspace(0.01, 70, 12)[:, None]
    alike = np.vstack([f ** float(p) for p in (-2, -1, 0, 2)] + [corners**2 / (corners**2 + f**2)])
    for A in (rng.normal(size=(30, 8)), (alike / (1e6 / f**4 + 1e-9)).T):
        b = np.abs(rng.normal(size=len(A)))
        x = non_negative(A, b)
        norm = np.linalg.norm(A, axis=0)
        slope = (A / norm).T @ (A @ x - b) / np.linalg.norm(b)
        assert (x >= 0).all()
        assert (slope > -1e-5).all()
        assert np.abs(slope * (x * norm) / np.abs(x * norm).max()).max() < 1e-5
