"""Limits that rules of Lighthouse apply at, on the fewest hits that reach them."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess import comparison, pose_file, reference, validation
from mocap_metrology.lighthouse.assess.summary import board_rms_urad
from mocap_metrology.lighthouse.batch import estimate, gravity
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.calibrate import network
from mocap_metrology.lighthouse.calibrate.stages import BATCH, ESTIMATED, Calibration
from mocap_metrology.lighthouse.fit import board_pose
from mocap_metrology.lighthouse.records import Measurements, Path
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters
from mocap_metrology.lighthouse.still_angles import StillAngles
from mocap_metrology.papers.studies.ranks import rank_correlation


def path_of(n_angles: int, rms_rad: float, n: int = 3) -> Path:
    """Poses of which each leaves K_1 = rms^2 (angles - 6)."""
    zeros, epsilon = np.zeros((n, 3)), np.full(n, rms_rad**2 * (n_angles - 6))
    return Path(
        np.arange(n),
        np.tile(np.eye(3), (n, 1, 1)),
        zeros,
        epsilon,
        np.full(n, n_angles),
        np.full(n, np.nan),
    )


def test_rms_of_angles_about_a_pose_has_six_degrees_of_freedom_less() -> None:
    found = board_rms_urad((path_of(10, 30e-6), path_of(64, 20e-6)))
    assert found == pytest.approx(30)


def test_paths_of_batch_are_those_of_paper_lm_and_of_the_optics_it_began_with() -> None:
    paths = {("paper-lm", "factory"): 1, ("paper-lm", "ideal"): 2, ("paper", "factory"): 3}
    found = Calibration(paths=paths)
    for estimator, optics, expected in (
        (BATCH, "factory", 1),
        (BATCH, ESTIMATED, 2),
        ("paper", "factory", 3),
        ("paper", "ideal", None),
    ):
        assert found.paths_of(SimpleNamespace(estimator=estimator, optics=optics)) == expected


def test_two_diodes_have_a_common_part_and_one_has_none() -> None:
    deviation = np.array([[1.0, 3.0], [2.0, np.nan]])
    found = StillAngles(0, 0, 30.0, np.array([0, 1]), deviation)
    assert np.array_equal(found.common, [2.0, np.nan], equal_nan=True)
    # independent noise: sqrt(2 / 1) times what is left about the mean
    assert np.allclose(found.independent[0], [-(2**0.5), 2**0.5])


@pytest.mark.parametrize(("norm", "fits"), [(1.008, True), (0.992, True), (1.012, False)])
def test_a_quaternion_of_nearly_length_one_is_normalised(norm: float, fits: bool) -> None:
    q = norm * np.array([0.0, 0.0, np.sin(0.3), np.cos(0.3)])
    given = {"quaternion_xyzw": q.tolist()}
    if fits:
        R = reference._rotation(given, "r.json")
        assert np.allclose(R, Rotation.from_rotvec([0, 0, 0.6]).as_matrix(), atol=1e-12)
    else:
        with pytest.raises(Refusal, match=re.escape("norm 1.012; expected 1")):
            reference._rotation(given, "r.json")


@pytest.mark.parametrize(
    ("sd_mm", "word", "ok"), [(100.0, "good", True), (1.0, "doubtful", False), (np.nan, None, None)]
)
def test_stages_far_apart_agree_where_their_covariances_allow_it(sd_mm, word, ok) -> None:
    """They differ by 80 mm: of chi-squared of 6 degrees 0.3 where sigma is 100 mm each."""
    covariance = np.diag([sd_mm**2] * 3 + [1.0] * 3)
    one = SimpleNamespace(t_m=np.zeros(3), R=np.eye(3), covariance=covariance)
    other = SimpleNamespace(t_m=np.array([0.08, 0, 0]), R=np.eye(3), covariance=covariance)
    found = validation._stages(one, other)
    assert found.ok is ok
    assert word is None or found.level == word


def test_four_pairs_are_the_fewest_with_an_interval_of_their_rank_correlation() -> None:
    """Bonett & Wright 2000: z sqrt((1 + r^2 / 2) / (n - 3)) about atanh r = atanh 0.8."""
    x, y = np.arange(4.0), np.array([0.0, 1.0, 3.0, 2.0])
    assert np.isnan(rank_correlation(x[:3], np.array([0.0, 2.0, 1.0])).lower)
    found = rank_correlation(x, y)
    half = 1.959964 * np.sqrt(1 + 0.8**2 / 2)
    assert found.value == pytest.approx(0.8)
    assert found.lower == pytest.approx(np.tanh(np.arctanh(0.8) - half), abs=1e-6)


def test_ways_a_board_may_lie_are_rotations() -> None:
    found = board_pose._frames(np.random.default_rng(3).normal(size=(9, 3)))
    assert len(found) == 9
    assert np.allclose(found @ found.transpose(0, 2, 1), np.eye(3))
    assert np.linalg.det(found) == pytest.approx(1)


@pytest.mark.parametrize("turned", [(0, 0, 1.57), (0, 0, 3.14), (1.57, 0, 0), (0.4, 2.0, -1.1)])
def test_first_guess_of_a_board_turned_in_its_frame_faces_the_right_way(turned) -> None:
    rng, turn = np.random.default_rng(4), Rotation.from_rotvec(turned).as_matrix()
    long = np.column_stack([np.zeros(20), rng.uniform(-0.1, 0.1, 20), rng.uniform(-0.03, 0.03, 20)])
    long -= long.mean(axis=0)
    t = np.array([[3.0, 0.2, 0.1], [3.0, -0.4, 0.3], [3.0, 0.5, -0.6]])
    R = np.array([board_pose.facing(v) @ rotation.exp(rng.normal(0, 0.1, 3)) for v in t])
    seen = np.array([angles(long @ R[k].T + t[k], rotor_parameters()) for k in range(3)])
    found, _ = board_pose.first_guesses(Measurements(np.arange(3.0), seen), long @ turn.T)
    off = [rotation.error(found[k] @ turn, R[k]) for k in range(3)]
    assert np.degrees(np.linalg.norm(off, axis=1)).max() < 25


def test_both_minima_are_told_apart_by_the_angle_between_them() -> None:
    """cos = (trace R R'^T - 1) / 2, whatever the signs of their elements."""
    rng = np.random.default_rng(6)
    board = flat_board() + np.outer(np.resize([0.012, -0.012, -0.012], 32), [1, 0, 0])
    t = np.array([[4.0, y, z] for y, z in rng.uniform(-1.5, 1.5, (60, 2))])
    R = np.array([board_pose.facing(v) @ rotation.exp(rng.normal(0, 0.5, 3)) for v in t])
    seen = np.array([angles(board @ R[k].T + t[k], rotor_parameters()) for k in range(60)])
    seen += rng.normal(0, 4e-5, seen.shape)
    measured = Measurements(np.arange(60.0), seen)
    first, second = board_pose.both_minima(measured, board, rotor_parameters())
    same = board_pose.apart(first, second) < np.radians(1)
    assert 5 < same.sum() < 55
    assert np.array_equal(np.isinf(first.ambiguity), same)


def test_a_variant_is_open_unless_it_is_worse() -> None:
    standings = {"chosen": True, "open": True, "worse": False}
    assert {k: comparison._open({"standing": k}) for k in standings} == standings
    assert not comparison._open(None)


def test_a_variant_that_is_no_rotation_is_refused() -> None:
    row = {"variant": "a", "chosen": True, "standing": "chosen", "translation_mm": [0, 0, 0]}
    R = Rotation.from_rotvec([0.3, 0, 0.1]).as_matrix()
    pose_file._check_variant(row | {"rotation_matrix": R.tolist()})
    with pytest.raises(ValueError, match="variant 'a' has no pose"):
        pose_file._check_variant(row | {"rotation_matrix": (1.0002 * R).tolist()})


def test_two_stations_are_connected_by_as_many_moments_as_the_fewest() -> None:
    n = network.FEWEST_MOMENTS
    seen = [
        SimpleNamespace(measurements=SimpleNamespace(time_s=np.arange(float(k))))
        for k in (n + 1, n, n - 1)
    ]
    found = network.shared_moments(seen)
    assert found[0, 1] == n and found[0, 2] == found[1, 2] == 0
    assert network.islands(found) == [[0, 1], [2]]


def test_the_cost_of_an_estimate_is_the_sum_of_all_that_is_known() -> None:
    """Priors 2^2, recordings 4 and 6 with lengths of 1 each, and gravity that is 10 of its standard
    deviations off."""
    state = SimpleNamespace(
        values=np.array([4.0]), gravity=np.array([0, 0, -gravity.GRAVITY_M_S2]), R=[]
    )
    one, other = (
        SimpleNamespace(cost=lambda value=value: value, cost_of_lengths=lambda *_: 1.0)
        for value in (4.0, 6.0)
    )
    search = SimpleNamespace(
        state=state, working=np.array([2.0]), of=SimpleNamespace(size=3, gravity=0), ups=None,
        recordings=[one, other],
    )  # fmt: skip
    assert estimate._Search._cost(search) == pytest.approx(16.0)
    state.gravity = np.array([0, 0, -(gravity.GRAVITY_M_S2 + 10 * gravity.MAGNITUDE_SD)])
    assert estimate._Search._cost(search) == pytest.approx(116.0)
