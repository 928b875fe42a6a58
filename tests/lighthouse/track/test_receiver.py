"""A receiver tracked with calibrated stations, against the simulator's truth."""

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.batch import solved
from mocap_metrology.lighthouse.records import Measurements
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps, simulate
from mocap_metrology.lighthouse.track.receiver import (
    Calibrated,
    Track,
    columns,
    poses_along,
    track,
    triangulated,
)
from tests.lighthouse.batch import planes_scene
from tests.lighthouse.pairs import UNITS, scene, twin

MM_DEG = np.r_[np.full(3, 1e-3), np.full(3, np.pi / 180)]  # 1 mm, 1 deg in m and rad


def made(seed: int, duration_s: float = 2.0) -> SimulatedSweeps:
    steady = {"tremor_mm": 0.0, "tremor_deg": 0.0}
    return simulate(twin(seed, duration_s=duration_s, motion=steady))


def exact(own: SimulatedSweeps, covariance: np.ndarray | None = None) -> Calibrated:
    nothing = np.zeros((6, 6)) if covariance is None else covariance
    return Calibrated(own.truth.R, own.truth.t_m, nothing, False)


def turned(R: np.ndarray, of: np.ndarray) -> np.ndarray:
    """Left rotation vectors (n, 3) from rotations to others."""
    return rotation.log(R @ np.swapaxes(of, 1, 2))


def errors(own: SimulatedSweeps, found: Track) -> np.ndarray:
    """(n, 6) of position in m and left rotation vector in rad."""
    R, t = own.truth.motion.poses(found.time_s)
    seen = found.hits.any(axis=1)
    off = np.full((found.time_s.size, 6), np.nan)
    off[seen] = np.c_[(found.t_m - t)[seen], turned(found.R[seen], R[seen])]
    return off


def test_errors_are_those_stated() -> None:
    """Six recordings of 2 s with their own calibration: the mean squared error of each
    coordinate over its variance is 1; it varies by 0.1 from recording to recording, as errors 50 ms
    apart are independent (40 a recording, four to six of which a calibration moves together)."""
    squares, ends, parts = [], [], []
    for seed in range(6):
        own = made(seed)
        pose, joint = solved(scene(own))
        known = Calibrated(pose.R, pose.t_m, pose.covariance / np.outer(UNITS, UNITS), True)
        found = poses_along(joint, scene(own), known, "")
        square = (errors(own, found) / found.sd.total) ** 2
        squares.append(np.nanmean(square, axis=0))
        ends.append(np.nanmean(square[np.r_[:3, -3:0]], axis=0))
        held = track(scene(own), known)
        apart = np.c_[held.t_m - found.t_m, turned(held.R, found.R)] / found.sd.total
        assert np.sqrt(np.nanmean(apart[6:-6] ** 2)) < 0.25
        np.testing.assert_allclose(held.sd.total, found.sd.total, rtol=0.03)
        parts.append(found.sd.noise**2 + found.sd.calibration**2 - found.sd.total**2)
    assert np.mean(squares, axis=0) == pytest.approx(np.ones(6), abs=0.35)
    assert (np.mean(ends, axis=0) < 1.8).all()
    assert np.nanmax(np.abs(parts)) < 1e-3 * np.nanmean(found.sd.total[:, :3] ** 2)


def test_an_error_of_the_calibration_moves_the_receiver_as_stated() -> None:
    """Slave poses drawn about the truth with 4 mm and 0.1 deg, far above the noise: errors have the
    stated size, within what 15 draws of six numbers show and a misfit beyond the noise changes."""
    own = made(1)
    sd = MM_DEG * np.r_[4, 4, 4, 0.1, 0.1, 0.1]
    rng, squares = np.random.default_rng(3), []
    for _ in range(15):
        d = sd * rng.normal(size=6)
        R, t = rotation.exp(d[3:]) @ own.truth.R, own.truth.t_m + d[:3]
        found = track(scene(own), Calibrated(R, t, np.diag(sd**2), False))
        squares.append(np.nanmean((errors(own, found) / found.sd.total) ** 2, axis=0))
    assert (np.mean(squares, axis=0) > 0.25).all() and (np.mean(squares, axis=0) < 2.5).all()
    assert np.mean(squares) == pytest.approx(1.0, abs=0.5)
    assert np.nanmean(found.sd.calibration[:, 0]) > np.nanmean(found.sd.noise[:, 0])


def test_one_station_and_none() -> None:
    """Seen by the master alone the sd rises along the line of sight; seen by none there is no
    pose."""
    own = made(2, 3.0)
    hits = own.hits
    time = hits.time_s
    kept = ((time < 1.0) | (time > 1.6) | (hits.station == 0)) & ((time < 2.0) | (time > 2.4))
    found = track(scene(own, hits.take(kept)), exact(own))
    both = (found.hits > 0).all(axis=1)
    one = (found.hits[:, 0] > 0) & (found.hits[:, 1] == 0)
    none = ~found.hits.any(axis=1)
    assert one.sum() > 25 and none.sum() > 15 and both.sum() > 100
    assert np.isnan(found.t_m[none]).all() and np.isnan(found.sd.total[none]).all()
    assert np.isfinite(found.t_m[~none]).all()
    sd = found.sd.total[:, 0]
    assert np.median(sd[one]) > 3 * np.median(sd[both])
    assert np.nanmean((errors(own, found)[one] / found.sd.total[one]) ** 2) < 3
    table = columns(found)
    assert {len(values) for values in table.values()} == {found.time_s.size}
    assert np.isnan(table["qw"][none]).all() and np.isnan(table["sd_x_mm"][none]).all()
    assert table["sd_noise_rx_deg"][both][0] == pytest.approx(
        np.degrees(found.sd.noise[both][0, 3])
    )
    assert {name: len(values) for name, values in columns(None).items()} == dict.fromkeys(table, 0)


def test_two_diodes_are_refused() -> None:
    own = made(3, 1.0)
    with pytest.raises(Refusal, match="both stations see three of its diodes"):
        track(scene(own, own.hits.take(own.hits.diode < 2)), exact(own))
    with pytest.raises(Refusal, match="both stations see three of its diodes"):
        track(scene(own, own.hits.take(slice(0, 0))), exact(own))


def test_poses_from_the_rays_of_both_stations() -> None:
    """Exact angles of twelve diodes give the exact pose; of two no pose."""
    own = made(5, 1.0)
    R, t = own.truth.motion.poses(np.array([0.2, 0.5]))
    points = np.einsum("nij,dj->ndi", R, own.truth.board) + t[:, None]
    seen = []
    for Rs, ts in ((np.eye(3), np.zeros(3)), (own.truth.R, own.truth.t_m)):
        both = [angles((p - ts) @ Rs, rotor_parameters()) for p in points]
        given = np.array(both)
        given[:, 12:] = given[1, 2:] = np.nan
        seen.append(Measurements(np.array([0.2, 0.5]), given))
    path = triangulated(seen, own.truth.board, own.truth.R, own.truth.t_m)
    assert path.time_s.tolist() == [0.2]
    np.testing.assert_allclose(path.R[0], R[0], atol=1e-9)
    np.testing.assert_allclose(path.t_m[0], t[0], atol=1e-9)


def test_stations_that_are_known_show_the_size_of_a_board() -> None:
    """0.4 % larger than its file, whose standard deviation this is: places are as near as stated,
    and three times as near as where its file were believed (0.16 mm rms)."""
    priors = Priors(0.0, 0.0, board_scale=4e-3, board_position_mm=0.0)
    given = planes_scene.made(2, 1, 2.0, larger=4e-3, priors=priors)
    found = track(given.scene, Calibrated(*given.poses[1], np.zeros((6, 6)), False))
    (R, t), (_, place) = planes_scene.room(2, 1)[0], planes_scene.motion(found.time_s, 1)
    off = (found.t_m - (place - t) @ R)[found.hits.any(axis=1)]
    stated = found.sd.total[found.hits.any(axis=1), :3]
    assert np.mean((off / stated) ** 2) < 1.5
    assert np.sqrt(np.sum(off**2, axis=1).mean()) < 0.08e-3


def test_a_board_at_rest_is_placed_as_well_in_a_longer_recording() -> None:
    """What errors by direction leave of a pose does not depend on how long others were taken: of
    8 s as of 2 s (sigma of the noise was twice as large). Its places scatter by less."""
    stated = []
    for seconds in (2.0, 8.0):
        given = planes_scene.made(2, 3, seconds, still=True, place_mm=0.1)
        found = track(given.scene, Calibrated(*given.poses[1], np.zeros((6, 6)), False))
        seen = found.hits.any(axis=1)
        stated.append(np.sqrt(np.mean(found.sd.noise[seen, :3] ** 2)))
        assert found.t_m[seen].std(axis=0).max() < stated[-1]
    assert stated[1] == pytest.approx(stated[0], rel=0.1)
