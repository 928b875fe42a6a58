"""Files of noise for state estimators, read back as their readers do; noise of a body's pose."""

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from mocap_metrology.noise.filters import body_covariance, covariances, px4_params, ros_yaml

PLACES_MM = np.array([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 100.0, 0.0]])


def verdict(frame_mm, labels=("A", "B", "C")):
    names = [f"{axis}{k + 1}" for k in range(len(labels)) for axis in "xyz"]
    series = {name: {"frame_mm": frame_mm} for name in names}
    return {"recording": "take", "horizon_s": 60.0, "labels": list(labels), "series": series}


def parameters(text):
    rows = [line.split("\t") for line in text.splitlines() if not line.startswith("#")]
    assert {(vehicle, component, kind) for vehicle, component, _, _, kind in rows} == {
        ("1", "1", "9")
    }
    return {name: float(value) for _, _, name, value, _ in rows}


def test_ros_covariances_in_metres():
    given = verdict(2.0)
    written = yaml.safe_load(ros_yaml(given, covariances(given, PLACES_MM)))
    marker = np.reshape(written["markers"]["B"]["covariance"], (6, 6))
    np.testing.assert_allclose(np.diag(marker), [4e-6] * 3 + [1e6] * 3)
    body = np.reshape(written["body"]["covariance"], (6, 6))
    np.testing.assert_allclose(np.diag(body)[:3], 4e-6 / 3, rtol=1e-5)
    assert written["body"]["markers"] == ["A", "B", "C"] and (np.diag(body)[3:] > 1e-4).all()
    unseen = np.where(np.arange(3)[:, None] == 1, np.nan, PLACES_MM)
    assert list(yaml.safe_load(ros_yaml(given, covariances(given, unseen)))["markers"]) == [
        "A",
        "C",
    ]


def test_noise_above_and_below_the_floors_of_px4():
    noisy, fine = verdict(60.0), verdict(0.1)
    found = parameters(px4_params(noisy, covariances(noisy, PLACES_MM)))
    assert found["EKF2_EVP_NOISE"] == np.float64(f"{0.06 / np.sqrt(3):.6g}")
    assert found["EKF2_EVA_NOISE"] > 0.5
    text = px4_params(fine, covariances(fine, PLACES_MM))
    assert parameters(text) == {"EKF2_EVP_NOISE": 0.01, "EKF2_EVA_NOISE": 0.05}
    assert text.count("binds") == 2


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


@pytest.mark.parametrize("places", [PLACES[:2], np.outer([0.0, 1.0, 3.0], [1.0, 2.0, 3.0])])
def test_no_orientation_of_a_line(places):
    assert body_covariance(places, np.ones_like(places)) is None
