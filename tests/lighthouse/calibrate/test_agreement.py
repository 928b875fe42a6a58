"""The mirror decided by both stations: a deck of four diodes, 30 x 15 mm, some metres away."""

import numpy as np
import pytest

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.calibrate.agreement import IMPOSSIBLE, agree, choose, minima
from mocap_metrology.lighthouse.calibrate.reconstruction import reconstruct
from mocap_metrology.lighthouse.records import Measurements
from mocap_metrology.lighthouse.rotor import rotor_parameters

from .scenes import Scene, pose_at, scene

DECK = flat_board(2, 2, 0.03, 0.015)
IDEAL = rotor_parameters()


@pytest.fixture(scope="module")
def flown() -> Scene:
    """Ten seconds, angles with 30 urad, a tenth of the hits missing."""
    return scene(3, speed=2.0, seconds=10, noise_rad=3e-5, quantised=False, board=DECK)


def right(own: Measurements, both: tuple, station: tuple, seed: int, speed: float) -> np.ndarray:
    """Which minimum is nearer to the true rotation of the board, 0 or 1."""
    Rs, _ = station
    true, _ = pose_at(own.time_s, seed, speed)
    turned = np.einsum("ji,njk->nik", Rs, true)
    off = [np.linalg.norm(rotation.log(p.R @ turned.transpose(0, 2, 1)), axis=1) for p in both]
    return np.argmin(off, axis=0)


def test_both_stations_find_the_minima_that_one_cannot(flown: Scene) -> None:
    """K_1 of one station takes the wrong minimum in a fifth of the poses or more; both together in
    less than one in twenty."""
    given = [reconstruct(flown.hits, s, 4, order=3) for s in (0, 1)]
    both = [minima(own, DECK, IDEAL) for own in given]
    agreed = agree(*both, 3)
    assert agreed.pose is not None
    assert np.linalg.norm(rotation.error(agreed.pose[0], flown.R)) < np.radians(2)
    which = choose(*both, agreed.pose[0])
    stations = [(np.eye(3), np.zeros(3)), (flown.R, flown.t_m)]
    for own, station, taken, path in zip(both, stations, which, agreed.paths, strict=True):
        truly = right(own.measurements, own.paths, station, 3, 2.0)
        assert (truly == 1).mean() > 0.2
        assert (taken != truly).mean() < 0.05
        alone = own.paths[0].epsilon <= own.paths[1].epsilon
        assert alone.all() and (path.epsilon >= own.paths[0].epsilon).all()


def test_covariance_of_rotations_by_simulation() -> None:
    """Of four diodes the eight angles less six unknowns leave two degrees of freedom, of which the
    median square, that tells the noise, is ln 2 of the mean."""
    board = np.array([[0, 0, 0], [0.05, 0.2, 0], [0, 0, 0.2], [-0.1, 0.1, 0.1]])
    turn, rng, n = rotation.from_angles(0.2, -0.1, 0.3), np.random.default_rng(2), 1000
    place = board @ turn.T + [2.0, 0.3, -0.2]
    angles = np.arctan2(place[:, 1:], place[:, :1]) + 1e-4 * rng.standard_normal((n, 4, 2))
    found = minima(Measurements(np.arange(float(n)), angles), board, IDEAL)
    off = [rotation.error(R, turn) for R in found.paths[0].R]
    told = found.spread[0].trace(axis1=1, axis2=2).mean()
    assert told / np.square(off).sum(axis=1).mean() == pytest.approx(np.log(2), rel=0.1)


@pytest.mark.parametrize(("far_m", "seen"), [(19.0, True), (21.0, False)])
def test_no_station_is_seen_from_more_than_20_m(far_m: float, seen: bool) -> None:
    board = np.array([[0, 0, 0], [0.5, 2, 0], [0, 0, 2], [-1, 1, 1.0]])
    place = board @ rotation.from_angles(0.2, -0.1, 0.3).T + [far_m, 0, 0]
    angles = np.arctan2(place[:, 1:], place[:, :1])[None]
    found = minima(Measurements(np.zeros(1), angles), board, IDEAL)
    assert np.linalg.norm(found.paths[0].t_m) == pytest.approx(far_m, abs=0.01)
    assert (found.excess[0, 0] < IMPOSSIBLE) == seen
