"""Paths of a board: shape, speed and extent by plain sampling; attitude against scipy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.lighthouse.simulate.motion import motion_of
from mocap_metrology.lighthouse.simulate.twin import MotionTwin

STATIONS = np.array([[0.0, 0.0, 0.0], [0.5, 2.0, 0.2]])
CENTRE = (3.0, 0.7, -0.2)


def path(seconds, seed=3, **keys):
    motion = motion_of(MotionTwin(centre_m=CENTRE, **keys), STATIONS, seed)
    return motion.poses(np.arange(0, seconds, 1e-3))


def greatest_speed(p):
    return np.linalg.norm(np.gradient(p, 1e-3, axis=0), axis=1).max()


def test_circle_line_and_half_circle():
    _, circle = path(8, pattern="circle", speed_m_s=0.6, extent_m=0.3)
    assert np.allclose(np.linalg.norm(circle - CENTRE, axis=1), 0.15)
    assert np.allclose(np.linalg.norm(np.diff(circle, axis=0), axis=1), 0.6e-3, rtol=1e-4)
    _, line = path(8, pattern="line", speed_m_s=0.6, extent_m=0.3)
    along = np.linalg.svd(line - CENTRE, compute_uv=False)
    assert along[1] < 1e-9 * along[0]
    assert np.linalg.norm(line - CENTRE, axis=1).max() == pytest.approx(0.15, rel=1e-4)
    assert greatest_speed(line) == pytest.approx(0.6, rel=1e-4)
    _, arc = path(8, pattern="arc", speed_m_s=0.6, extent_m=0.3)
    assert np.linalg.matrix_rank(arc - CENTRE, tol=1e-6) == 2
    ends = np.linalg.norm(arc[:, None, :][::50] - arc[None, ::50], axis=2).max()
    assert ends == pytest.approx(0.3, rel=1e-3)
    assert greatest_speed(arc) == pytest.approx(0.6, rel=1e-3)


def test_still_board_faces_the_stations():
    R, p = path(0.01, pattern="still")
    assert np.ptp(p, axis=0).max() == 0
    ways = STATIONS - CENTRE
    cosines = (ways @ R[0, :, 0]) / np.linalg.norm(ways, axis=1)
    assert cosines[0] == pytest.approx(cosines[1]) and cosines[0] > 0.8
    assert R[0, 2, 2] > 0.9 and R[0, 2, 1] == 0
    turned, _ = path(0.01, pattern="still", turn_deg=(5.0, -10.0, 20.0))
    expected = Rotation.from_euler("ZYX", [20, -10, 5], degrees=True).as_matrix()
    assert np.allclose(R[0].T @ turned[0], expected)
