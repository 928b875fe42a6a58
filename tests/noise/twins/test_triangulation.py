"""The simulated facility against numerical derivatives, a non-linear solver and scipy's Wishart."""

import numpy as np
import pytest
from nonlinear import project, triangulate

from benchmarks.failing_camera import wishart_blocks
from mocap_metrology.noise.twins.take import (
    HALL_MM,
    jacobians,
    positions,
    random_facility,
)


def test_cameras_hang_on_the_scaffold_and_see_the_wand() -> None:
    facility = random_facility(np.random.default_rng(1), 30, "T40")
    x, y, z = np.abs(facility.origins_mm.T)
    assert np.all(np.isclose(x, HALL_MM[0] / 2) | np.isclose(y, HALL_MM[1] / 2))
    assert z.min() >= 2000 and z.max() <= HALL_MM[2]
    for marker in facility.markers_mm:
        assert np.abs(project(facility, marker)[:, 0]).max() < 2336 / 2
        assert np.abs(project(facility, marker)[:, 1]).max() < 1728 / 2


def test_jacobian_is_the_derivative_of_the_projection() -> None:
    facility = random_facility(np.random.default_rng(2), 5)
    step, marker = 1e-2, facility.markers_mm[1]
    for k, axis in enumerate(np.eye(3)):
        change = project(facility, marker + step * axis) - project(facility, marker - step * axis)
        assert jacobians(facility, 1)[:, :, k] == pytest.approx(change / (2 * step), rel=1e-6)


def test_linear_errors_are_those_of_non_linear_triangulation() -> None:
    rng = np.random.default_rng(3)
    facility, subset = random_facility(rng, 6), [0, 2, 3, 5]
    marker = facility.markers_mm[0]
    for _ in range(20):
        error = rng.normal(0, 0.05, (6, 2))
        linear = positions(facility, 0, error[:, :, None], subset)[:, 0]
        solved = triangulate(facility, project(facility, marker) + error, subset, marker + 5)
        assert np.linalg.norm(solved - marker - linear) < 2e-3 * np.linalg.norm(linear)


def test_wishart_scatters_as_scipy_says() -> None:
    from scipy.stats import wishart

    covariance, dof = np.array([[2.0, 0.6, 0.1], [0.6, 1.0, -0.2], [0.1, -0.2, 0.5]]), 30.0
    drawn = wishart_blocks(np.random.default_rng(5), covariance, dof * 20_000, 20_000)
    truth = wishart(dof, covariance / dof)
    assert drawn.mean(axis=0) == pytest.approx(truth.mean(), abs=0.01)
    assert drawn.var(axis=0) == pytest.approx(truth.var(), rel=0.06)
