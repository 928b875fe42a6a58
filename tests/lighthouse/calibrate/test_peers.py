"""Perspective-n-Point and root finding on ranges, against poses projected by atan2 here."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.calibrate import pnp
from mocap_metrology.lighthouse.rotation import error

FLAT = flat_board()
ROUGH = FLAT + np.c_[np.where(np.arange(32) % 3 == 0, 0.01, -0.01), np.zeros((32, 2))]
FACING = np.diag([-1.0, -1.0, 1.0])
METHODS = {
    "ippe": lambda d, b: pnp.board_poses(d, b, "ippe"),
    "epnp": lambda d, b: pnp.board_poses(d, b, "epnp"),
    "sqpnp": lambda d, b: pnp.board_poses(d, b, "sqpnp"),
    "geometric": pnp.geometric_poses,
}
NO_OPENCV = pytest.mark.skipif(bool(pnp.opencv_is_missing()), reason=pnp.opencv_is_missing())
CASES = [
    pytest.param("ippe", FLAT, marks=NO_OPENCV), pytest.param("epnp", ROUGH, marks=NO_OPENCV),
    pytest.param("sqpnp", FLAT, marks=NO_OPENCV), pytest.param("sqpnp", ROUGH, marks=NO_OPENCV),
    ("geometric", FLAT), ("geometric", ROUGH),
]  # fmt: skip


def views(board, n=40, seed=3, noise_rad=0.0):
    rng = np.random.default_rng(seed)
    R = Rotation.from_rotvec(rng.normal(0, 0.3, (n, 3))).as_matrix() @ FACING
    t = np.array([3.0, 0.4, 0.3]) + rng.normal(0, 0.5, (n, 3))
    p = np.einsum("nij,dj->ndi", R, board) + t[:, None]
    angles = np.arctan2(p[..., 1:], p[..., :1])
    return R, t, angles + noise_rad * rng.standard_normal(angles.shape)


def turned_deg(R, R_true):
    turns = [error(a, b) for a, b in zip(R, R_true, strict=True)]
    return np.degrees(np.linalg.norm(turns, axis=1))


@pytest.mark.parametrize(("name", "board"), CASES)
def test_cost_at_noise_and_errors_of_a_few_tenths_of_a_degree(name, board):
    """64 angles less 6 unknowns of sd 60 urad: mean cost 58 sd^2, were the fit by least squares;
    none of these methods quite is."""
    R_true, t_true, angles = views(board, n=100, noise_rad=6e-5)
    R, t, cost = METHODS[name](angles, board)
    assert 0.9 < cost.mean() / (58 * 6e-5**2) < 1.4
    assert np.median(turned_deg(R, R_true)) < 0.25
    assert np.median(np.linalg.norm(t - t_true, axis=1)) < 3e-3


@pytest.mark.parametrize("name", [pytest.param("ippe", marks=NO_OPENCV), "geometric"])
def test_a_board_in_any_frame_of_its_own(name):
    """The pose moves with the frame the board's positions are given in."""
    Q, shift = Rotation.from_rotvec([0.4, -1.1, 2.0]).as_matrix(), np.array([0.1, -0.3, 0.2])
    R_true, t_true, angles = views(FLAT, n=5)
    other = (FLAT - shift) @ Q  # FLAT = other Q^T + shift
    R, t, _ = METHODS[name](angles, other)
    assert turned_deg(R, R_true @ Q).max() < 1e-4
    np.testing.assert_allclose(t, t_true + R_true @ shift, atol=1e-6)


def test_refusals():
    _, _, angles = views(FLAT, n=1)
    with pytest.raises(Refusal, match="epnp: the board is flat"):
        pnp.board_poses(angles, FLAT, "epnp")
    with pytest.raises(Refusal, match="ippe: the board is not flat"):
        pnp.board_poses(angles, ROUGH, "ippe")
    with pytest.raises(Refusal, match="expected one of auto"):
        pnp.board_poses(angles, FLAT, "p3p")


def test_without_opencv_the_line_to_type_is_told(monkeypatch):
    monkeypatch.setattr(pnp, "find_spec", lambda name: None)
    _, _, angles = views(FLAT, n=1)
    with pytest.raises(ModuleNotFoundError, match=r"pnp needs OpenCV, .* type: make peers$"):
        pnp.board_poses(angles, FLAT, "ippe")
