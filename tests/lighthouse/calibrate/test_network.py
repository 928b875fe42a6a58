"""Four stations and a board in one estimate."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.batch import Scene, joint
from mocap_metrology.lighthouse.calibrate.network import start
from mocap_metrology.lighthouse.decode.chain import decode_light
from mocap_metrology.lighthouse.decode.clean import Cleaning
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.lighthouse.simulate.motion import facing_to
from mocap_metrology.lighthouse.simulate.turns import TurnsTwin, simulate_turns, stations_around
from mocap_metrology.lighthouse.simulate.twin import MotionTwin
from tests.lighthouse.calibrate import scenes

UNITS = np.r_[np.full(3, 1e3), np.full(3, 180 / np.pi)]
THIRD = from_angles(-0.1, 0.15, 0.7), np.array([0.3, -2.2, -0.4])
FOURTH = from_angles(0.05, 0.3, 0.1), np.array([0.6, 0.1, 1.4])
NOISE_RAD = 50e-6


def given(seed: int) -> tuple[scenes.Scene, Scene]:
    made = scenes.scene(seed, noise_rad=NOISE_RAD, more=(THIRD, FOURTH))
    priors = Priors(0, 0, 0, 0, 0)
    return made, Scene(made.hits, made.board, "ideal", [None] * 4, None, "crazyflie", priors)


def true_poses(made: scenes.Scene) -> list[tuple[np.ndarray, np.ndarray]]:
    return [(made.R, made.t_m), THIRD, FOURTH]


def test_each_station_is_where_its_covariance_says() -> None:
    """Six recordings of four stations: 18 squared distances of six degrees of freedom, their sum
    within its 99 % interval, and each pose within 2 mm and 0.05 deg."""
    total, n = 0.0, 0
    for seed in range(6):
        made, scene = given(seed)
        found = joint(scene)[0]
        for k, (R, t) in enumerate(true_poses(made), start=1):
            off = np.r_[found.state.t_m[k] - t, rotation.error(found.state.R[k], R)]
            assert np.linalg.norm(off[:3]) < 2e-3 and np.linalg.norm(off[3:]) < np.radians(0.05)
            total += off @ np.linalg.solve(found.pose_covariance(k), off)
            n += 6
    assert chi2.ppf(0.005, n) < total < chi2.ppf(0.995, n)


def test_a_station_that_shares_no_view_with_the_master_comes_by_another() -> None:
    """The master sees the board in the first half only, the third station in the second only."""
    made, scene = given(7)
    hits, half = made.hits, np.median(made.hits.time_s)
    early, late = hits.time_s < half, hits.time_s > half
    kept = hits.take(((hits.station != 0) | early) & ((hits.station != 2) | late))
    found = joint(replace(scene, hits=kept))[0]
    for k, (R, t) in enumerate(true_poses(made), start=1):
        off = np.r_[found.state.t_m[k] - t, rotation.error(found.state.R[k], R)]
        assert off @ np.linalg.solve(found.pose_covariance(k), off) < chi2.ppf(0.999, 6)


DECK_M = np.array([[x, y, 0.0] for x in (-0.015, 0.015) for y in (-0.0075, 0.0075)])


def test_a_deck_that_hovers_starts_from_the_right_minima() -> None:
    """It hardly turns, so board poses that are mirrored for both stations agree as well as the
    right ones, and K_1 decides."""
    rng = np.random.default_rng(1)
    R, t, middle, up = stations_around(2, rng, 2.4, 1.6)
    x = np.cross(up, rng.normal(size=3))
    x /= np.linalg.norm(x)
    level = facing_to(middle, t).T @ np.column_stack([x, np.cross(up, x), up])
    motion = MotionTwin(
        centre_m=tuple(middle), speed_m_s=0.05, extent_m=0.02, wobble_deg=1.0, tremor_mm=0.2,
        tremor_deg=0.2,
    )  # fmt: skip
    twin = TurnsTwin(
        1, R, t, (0, 1), motion, DECK_M, np.tile([0.0, 0, 1], (4, 1)), (level, np.zeros(3)), up=up,
        duration_s=12.0, incidence_deg=85.0, dropout=0.05, reflections=0.01,
    )  # fmt: skip
    made = simulate_turns(twin)
    found = decode_light(made.light, DECK_M, None, Cleaning(), "twin")
    how = "factory", made.factories, None, "libsurvive", Priors()
    scene = Scene(found.hits, DECK_M, *how, generation=2, names=["0", "1"])
    _, _, poses = start(scene)
    assert np.degrees(np.linalg.norm(rotation.error(poses[1][0], R[1]))) < 5.0


def test_a_station_without_a_common_view_is_named() -> None:
    made, scene = given(8)
    hits, half = made.hits, np.median(made.hits.time_s)
    own = np.where(hits.station == 3, hits.time_s > half, hits.time_s < half)
    with pytest.raises(Refusal, match="station 3: no 10 moments"):
        joint(replace(scene, hits=hits.take(own)))
