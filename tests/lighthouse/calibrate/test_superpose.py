"""Common times, Kabsch, jackknife and the static pose, against scipy and Monte Carlo."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.calibrate.static import static_pose
from mocap_metrology.lighthouse.calibrate.superpose import at_times, kabsch, superpose
from mocap_metrology.lighthouse.records import Measurements, Path
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters


def random_path(n: int, seed: int) -> Path:
    rng = np.random.default_rng(seed)
    R = Rotation.from_rotvec(np.cumsum(rng.normal(0, 0.02, (n, 3)), axis=0)).as_matrix()
    t = np.cumsum(rng.normal(0, 0.01, (n, 3)), axis=0)
    time = (np.arange(n) + rng.uniform(-0.4, 0.4, n)) / 60
    return Path(time, R, t, rng.uniform(1, 2, n) * 1e-7, np.full(n, 60), np.ones(n))


def test_interpolation_is_linear_and_slerp() -> None:
    path = random_path(200, 1)
    wanted = np.random.default_rng(2).uniform(-0.5, 4, 300)
    found, kept = at_times(path, wanted)
    inside = (wanted >= path.time_s[0]) & (wanted <= path.time_s[-1])
    np.testing.assert_array_equal(kept, inside)
    np.testing.assert_allclose(
        found.t_m, np.column_stack([np.interp(wanted[kept], path.time_s, c) for c in path.t_m.T])
    )
    peer = Slerp(path.time_s, Rotation.from_matrix(path.R))(wanted[kept]).as_matrix()
    np.testing.assert_allclose(found.R, peer, atol=1e-12)


def test_kabsch_is_scipys() -> None:
    rng = np.random.default_rng(4)
    moved, weight = rng.normal(0, 1, (50, 3)), rng.uniform(0.1, 5, 50)
    R = rotation.from_angles(0.3, -1.0, 2.0)
    fixed = moved @ R.T + [1, 2, 3] + rng.normal(0, 0.05, (50, 3))
    found, t = kabsch(moved, fixed, weight)
    a, b = weight @ moved / weight.sum(), weight @ fixed / weight.sum()
    peer, _ = Rotation.align_vectors(fixed - b, moved - a, weight)
    np.testing.assert_allclose(found, peer.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(t, b - peer.apply(a), atol=1e-12)


def test_jackknife_covers_the_error_of_kabsch() -> None:
    """Chi-squared of the error against its own covariance: mean 6 for 200 paths, within 25 %: a
    jackknife of 20 blocks scatters itself."""
    rng = np.random.default_rng(6)
    time = np.arange(400) / 60
    line = np.column_stack([np.sin(time), np.cos(1.7 * time), 0.5 * np.sin(2.3 * time)]) * 0.2
    R, t = rotation.from_angles(0.2, 0.1, -0.6), np.array([0.3, 2.0, 0.1])
    values = []
    for _ in range(200):
        slave = (line - t) @ R + rng.normal(0, 0.002, line.shape)
        Re, te, cov = superpose(slave, line + rng.normal(0, 0.002, line.shape), np.ones(400), time)
        d = np.r_[te - t, rotation.error(Re, R)]
        values.append(d @ np.linalg.solve(cov, d))
    assert np.median(values) == pytest.approx(5.35 * 1.3, rel=0.3)  # median of chi-squared 6


def test_static_pose_and_its_covariance() -> None:
    """30 draws of noise: chi-squared of the errors has mean 6 (standard error 0.6) times the
    factor (n - 6)/(n - 8) of an estimated variance, n = 64 angles a station."""
    board, ideal = flat_board(), rotor_parameters()
    R, t = rotation.from_angles(0.2, -0.1, -0.65), np.array([0.4, 2.0, 0.25])
    Rb, tb = rotation.from_angles(0.25, 0.3, np.pi + 0.4), np.array([3.2, 0.2, -0.3])
    world = board @ Rb.T + tb
    rng, values = np.random.default_rng(7), []
    for _ in range(30):
        given = [
            Measurements(np.zeros(1), (angles(own, ideal) + rng.normal(0, 3e-5, (32, 2)))[None])
            for own in (world, np.ascontiguousarray((world - t) @ R))
        ]
        found = static_pose(given, board, [ideal, ideal])
        d = np.r_[found.t_m - t, rotation.error(found.R, R)]
        values.append(d @ np.linalg.solve(found.covariance, d))
    assert np.mean(values) == pytest.approx(6.2, abs=1.5)


def test_a_robust_mean_of_rotations_ignores_a_minority() -> None:
    rng = np.random.default_rng(8)
    R = rotation.from_angles(0.5, 0.2, 1.0)
    near = [rotation.exp(v) @ R for v in rng.normal(0, 0.002, (70, 3))]
    far = [rotation.exp(v) @ R for v in rng.normal(0.6, 0.1, (30, 3))]
    off = rotation.error(rotation.mean(np.array(near + far)), R)
    assert np.linalg.norm(off) < 0.003


@pytest.mark.parametrize("n", [0, 1])
def test_of_a_single_pose_nothing_is_interpolated(n: int) -> None:
    found, kept = at_times(random_path(n, 9), np.array([-0.1, 0.0, 0.1]))
    assert len(found) == 0 and kept.tolist() == [False] * 3
