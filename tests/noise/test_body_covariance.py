"""Noise of a body's pose from that of its markers, against simulated fits."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.noise.body_covariance import body_covariance

PLACES = np.array([[0.0, 0.0, 0.0], [120.0, 0.0, 10.0], [30.0, 80.0, 0.0], [60.0, 40.0, 90.0]])
SIGMA = np.array([[0.1, 0.1, 0.3], [0.2, 0.1, 0.1], [0.1, 0.4, 0.1], [0.1, 0.1, 0.1]])


def test_covariance_of_simulated_fits():
    """Poses by Kabsch's fit to 20,000 noisy frames."""
    rng = np.random.default_rng(1)
    centred = PLACES - PLACES.mean(axis=0)
    seen = centred + SIGMA * rng.standard_normal((20_000, 4, 3))
    moved = seen.mean(axis=1)
    U, _, Vt = np.linalg.svd(np.einsum("nki,kj->nij", seen - moved[:, None], centred))
    turned = Rotation.from_matrix(U @ Vt).as_rotvec()
    sampled = np.cov(np.hstack([moved, turned]).T)
    expected = body_covariance(PLACES, SIGMA)
    sd = np.sqrt(np.diag(expected))
    np.testing.assert_allclose(sampled / np.outer(sd, sd), expected / np.outer(sd, sd), atol=0.03)


def test_equal_noise_gives_the_closed_form():
    own = PLACES - PLACES.mean(axis=0)
    inertia = (own**2).sum() * np.eye(3) - own.T @ own
    found = body_covariance(PLACES + 1e4, np.full((4, 3), 0.2))
    np.testing.assert_allclose(found[:3, :3], 0.01 * np.eye(3), atol=1e-12)
    np.testing.assert_allclose(found[3:, 3:], 0.04 * np.linalg.inv(inertia), rtol=1e-7)


@pytest.mark.parametrize("places", [PLACES[:2], np.outer([0.0, 1.0, 3.0], [1.0, 2.0, 3.0])])
def test_no_orientation_of_a_line(places):
    assert body_covariance(places, np.ones_like(places)) is None
