"""Orientation of clusters against scipy's alignment and the closed form of its noise."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.motion.orientation import of_cluster, unknown

SHAPE = np.array([[0, 0, 0], [100, 0, 0], [0, 60, 10], [50, 40, 30.0]])
PLACE = np.array([1000, -2000, 500.0])


# Across a line of three markers at 0, 0 and 100 mm: spread along it sqrt(2/9) of 100 mm, and with
# two of them d apart across it d / sqrt(6); the limit is 2 %
FLAT_BY = np.array([1.0, -1.0, 0.0])[:, None, None] * np.array([0, 1.0, 0])[:, None]
FLAT_BY = FLAT_BY * 0.02 * 100 * np.sqrt(2 / 9) * np.sqrt(6) / 2


def recording(turns: Rotation, sigma: float, seed: int) -> np.ndarray:
    """(k, 3, n) markers of the body turned by each rotation, with white noise."""
    points = np.stack([turns.apply(marker) + PLACE for marker in SHAPE]).transpose(0, 2, 1)
    return points + sigma * np.random.default_rng(seed).standard_normal(points.shape)


def test_covariance_is_that_of_least_squares() -> None:
    """s^2 (sum |s_i|^2 I - s_i s_i^T)^-1 with 20,000 frames: each entry to 3 % of the diagonal."""
    sigma, n = 0.05, 20_000
    found = of_cluster(recording(Rotation.identity(n), sigma, 1))
    arms = SHAPE - SHAPE.mean(axis=0)
    information = sum((a @ a) * np.eye(3) - np.outer(a, a) for a in arms)
    expected = sigma**2 * np.linalg.inv(information)
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    np.testing.assert_allclose(np.cov(found.vectors_rad) / scale, expected / scale, atol=0.03)
    # 12 coordinates less 6 of the pose, over 4 markers
    assert np.mean(found.residual_mm**2) == pytest.approx(sigma**2 * 6 / 4, rel=0.02)


def test_each_frame_as_scipy_aligns_it() -> None:
    """A turning body, with one of four markers hidden in some frames."""
    n = 200
    angle = np.linspace(-0.6, 0.6, n)
    turns = Rotation.from_rotvec(np.stack([0.3 * angle, angle, 0.1 + 0 * angle], axis=1))
    points = recording(turns, 0.02, 2)
    points[2, :, 50:60] = np.nan
    found = of_cluster(points)
    arms = SHAPE - SHAPE.mean(axis=0)
    rotations = []
    for k in range(n):
        seen = np.isfinite(points[:, 0, k])
        frame, body = points[seen, :, k], arms[seen]
        one, _ = Rotation.align_vectors(frame - frame.mean(axis=0), body - body.mean(axis=0))
        rotations.append(one.as_matrix())
    rotations = np.array(rotations)
    mean = Rotation.from_matrix(rotations).mean()
    expected = (Rotation.from_matrix(rotations) * mean.inv()).as_rotvec().T
    # the shape is found from the frames themselves: noise / sqrt(n) of it is left
    np.testing.assert_allclose(found.vectors_rad, expected, atol=2e-4)
    assert found.spread_mm == pytest.approx(np.sqrt((arms**2).sum() / 4), rel=1e-3)
    points = recording(Rotation.identity(50), 0.02, 3)
    points[:2, :, 10:20] = np.nan  # two are none of a body
    found = of_cluster(points)
    assert np.isnan(found.vectors_rad[:, 10:20]).all() and np.isnan(found.residual_mm[10:20]).all()
    assert np.isfinite(found.vectors_rad[:, 20:]).all()


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.ones((2, 3, 5)), "2 markers; expected three or more"),
        (np.full((3, 3, 5), np.nan), "no frame in which all markers"),
        (SHAPE[[0, 0, 1], :, None] * np.ones(5) + FLAT_BY * 0.9, "lie on a line"),
    ],
)
def test_what_has_no_orientation_is_refused(points: np.ndarray, message: str) -> None:
    with pytest.raises(Refusal, match=message):
        of_cluster(points)
    of_cluster(SHAPE[[0, 0, 1], :, None] * np.ones(5) + FLAT_BY * 1.1)


def test_how_far_a_swinging_body_turned() -> None:
    """0.2 sin(phi) rad, phi even over a turn: 95 % of the angles are below 0.2 sin(0.95 pi/2)."""
    phase = 2 * np.pi * np.arange(2000) / 2000
    turns = Rotation.from_rotvec(0.2 * np.sin(phase)[:, None] * [[0.6, 0.0, 0.8]])
    found = of_cluster(recording(turns, 0.0, 1))
    assert found.range_rad == pytest.approx(0.2 * np.sin(0.95 * np.pi / 2), rel=1e-3)
    assert np.isnan(unknown(5).range_rad) and unknown(5).vectors_rad.shape == (3, 5)
