"""Stations of the second generation, any number of them, in one estimate: against the poses that
the hits were made with."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import chi2

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.batch.estimate import Joint
from mocap_metrology.lighthouse.batch.parts import halves
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.batch.trajectory import trajectory_of
from mocap_metrology.lighthouse.calibrate.batch import joint
from mocap_metrology.lighthouse.calibrate.fits import well_fitted
from mocap_metrology.lighthouse.calibrate.network import islands, look, shared_moments, start
from mocap_metrology.lighthouse.calibrate.scene import Scene
from mocap_metrology.lighthouse.calibrate.static import median_angles
from mocap_metrology.lighthouse.decode.chain import decode_light
from mocap_metrology.lighthouse.decode.gates import Cleaning
from mocap_metrology.lighthouse.decode.wander import TurnClock, Wander
from mocap_metrology.lighthouse.records import Path
from mocap_metrology.lighthouse.simulate.motion import facing_to
from mocap_metrology.lighthouse.simulate.turns import TurnsTwin, simulate_turns, stations_around
from mocap_metrology.lighthouse.simulate.twin import MotionTwin
from tests.lighthouse.batch import planes_scene
from tests.lighthouse.batch.planes_scene import TICKS, Made, made, motion, room

COVER_M = (-0.75e-3, 1.55e-3)
TURNED = np.diag([1.0, -1.0, -1.0])


def errors(found: Joint, given: Made) -> np.ndarray:
    """(stations - 1, 6) in m and rad."""
    own = zip(found.state.R[1:], found.state.t_m[1:], given.poses[1:], strict=True)
    return np.array([np.r_[t - t0, rotation.error(R, R0)] for R, t, (R0, t0) in own])


def squared(found: Joint, off: np.ndarray) -> float:
    """Of all stations together, over their joint covariance."""
    rows = np.concatenate([found.pose(k) for k in range(1, len(off) + 1)])
    return float(off.ravel() @ np.linalg.solve(found.covariance[np.ix_(rows, rows)], off.ravel()))


def test_poses_from_nothing_are_as_near_as_the_covariance_says() -> None:
    """Three recordings of four stations; the sum of squares within its 99 % interval, noise as it
    was made."""
    total, freedom = 0.0, 0
    for seed in range(3):
        given = made(4, seed, seconds=4.0)
        found, _ = joint(given.scene)
        total += squared(found, off := errors(found, given))
        freedom += off.size
        assert np.linalg.norm(off[:, :3], axis=1).max() < 1e-3
        noise = found.recordings[0].noise
        assert 1e6 * noise.hit == pytest.approx(20.0, rel=0.03)
        assert 1e6 * noise.sweep == pytest.approx(15.0, rel=0.15)
    assert chi2.ppf(0.005, freedom) < total < chi2.ppf(0.995, freedom)


def test_errors_of_board_cover_and_factory_values_are_in_the_covariance() -> None:
    """Factory values are known of one station of three."""
    total, freedom = 0.0, 0
    for seed in range(2):
        given = made(
            3, seed, 4.0, place_mm=0.2, cover=COVER_M, known=False, priors=Priors(board_scale=1e-3)
        )
        found, _ = joint(replace(given.scene, factories=[None, given.factories[1], None]))
        assert found.state.cover == pytest.approx(COVER_M, abs=4e-4)
        total += squared(found, off := errors(found, given))
        freedom += off.size
    assert total < chi2.ppf(0.995, freedom)


def test_poses_by_ideal_planes() -> None:
    given = made(2, 3, 2.0, ideal=True)
    found, _ = joint(replace(given.scene, optics="ideal"))
    assert squared(found, errors(found, given)) < chi2.ppf(0.999, 6)


def test_reflections_onto_diodes_that_face_away_are_left_out() -> None:
    """Beyond 75 deg of incidence: such hits are some mrad off."""
    given = made(2, 4, 4.0, cover=COVER_M, priors=Priors(), farthest_deg=100.0)
    hits, rng = given.scene.hits, np.random.default_rng(0)
    found, _ = joint(given.scene)
    kept = found.recordings[0].sweeps.hits
    assert 0.6 * len(hits) < len(kept) < 0.9 * len(hits)
    aside = ~np.isin(hits.time_s, kept.time_s)
    wrong = hits.angle_rad + np.where(aside, rng.uniform(-8e-3, 8e-3, len(hits)), 0.0)
    again, _ = joint(replace(given.scene, hits=replace(hits, angle_rad=wrong)))
    np.testing.assert_allclose(errors(again, given), errors(found, given), atol=6e-4)


def test_stretches_that_begin_with_wrong_poses_keep_their_hits() -> None:
    """Turned upside down for 0.2 and 0.4 s; with true poses all along the result is the same."""
    given = made(2, 6, 4.0, cover=COVER_M, priors=Priors(), wrong=0.03)
    hits, found = given.scene.hits, []
    time_s = np.arange(hits.time_s.min(), hits.time_s.max(), 0.01)
    R, t = motion(time_s, 6)
    R0, t0 = room(2, 6)[0]
    R, t, nothing = R0.T @ R, (t - t0) @ R0, np.zeros(time_s.size)
    for stretches in ((), ((1.0, 1.2), (2.5, 2.9))):
        turned = np.any([(time_s > a) & (time_s < b) for a, b in stretches] or [nothing], axis=0)
        path = Path(time_s, np.where(turned[:, None, None], R @ TURNED, R), t, *3 * [nothing])
        near = trajectory_of(path, hits.time_s.min(), hits.time_s.max())
        found.append(well_fitted(given.scene, hits, near, given.poses)[0])
    true, wrong = found
    kept = [len(one.recordings[0].sweeps.hits) for one in found]
    assert kept[1] > 0.999 * kept[0] > 0.8 * len(hits)
    np.testing.assert_allclose(errors(wrong, given), errors(true, given), atol=1e-4)
    assert squared(wrong, errors(wrong, given)) < chi2.ppf(0.999, 6)


@pytest.mark.parametrize("bad", [(), (7,)])
def test_a_diode_that_is_off_twice_as_much_is_named(bad: tuple[int, ...]) -> None:
    given = made(2, 7, 4.0, cover=COVER_M, place_mm=0.15, slow_mm=0.07, priors=Priors())
    hits, rng = given.scene.hits, np.random.default_rng(1)
    more = 75e-6 * rng.standard_normal(len(hits)) * np.isin(hits.diode, bad)
    near, how = start(given.scene), replace(hits, angle_rad=hits.angle_rad + more)
    _, note = well_fitted(given.scene, how, *near[1:])
    assert note == ("diode 7 excluded: the others contradict it" if bad else "")


def test_ten_moments_in_common_connect_two_stations() -> None:
    times = [np.arange(first, first + 40.0) for first in (0, 30, 61)]
    seen = [SimpleNamespace(measurements=SimpleNamespace(time_s=time)) for time in times]
    expected = [[40, 10, 0, 0], [10, 40, 0, 0], [0, 0, 40, 0], [0, 0, 0, 0]]
    assert shared_moments([*seen, None]).tolist() == expected


def test_a_station_without_a_common_view_is_an_island() -> None:
    """Stations 0 and 1 see the board first, 2 and 3 afterwards; 1 alone sees it all the time."""
    early, late = (0.0, 0.45), (0.55, 1.0)
    apart = made(4, 5, 4.0, keep=[early, early, late, late]).scene
    assert islands(shared_moments(look(apart))) == [[0, 1], [2, 3]]
    with pytest.raises(Refusal, match="station 2, 3: no 10 moments"):
        start(apart)
    given = made(4, 5, 4.0, keep=[early, (0.0, 1.0), late, late])
    assert islands(shared_moments(look(given.scene))) == [[0, 1, 2, 3]]
    found, _ = joint(given.scene)
    off = errors(found, given)
    assert squared(found, off) < chi2.ppf(0.999, off.size)


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
    flown = simulate_turns(twin)
    found = decode_light(flown.light, DECK_M, None, Cleaning(), "twin")
    how = "factory", flown.factories, None, "libsurvive", Priors()
    scene = Scene(found.hits, DECK_M, *how, generation=2, names=["0", "1"])
    _, _, poses = start(scene)
    assert np.degrees(np.linalg.norm(rotation.error(poses[1][0], R[1]))) < 5.0


OF_BEGINS = Wander(1e-6, 3000.0, 2.0, 1.0)  # as of slow wander: errors of 0.2 us for half a second


def with_errors(given: Made, seed: int) -> Made:
    """Both planes of a turn are off by the error of its begin, drawn with its covariance."""
    rng, scene = np.random.default_rng([seed, 77]), given.scene
    angle, hits = scene.hits.angle_rad.copy(), scene.hits
    clocks = []
    for k in range(len(scene.names)):
        period = TICKS[k] / 48e6
        turn = np.arange(hits.cycle[hits.station == k].max() + 1)
        clock = TurnClock(0.0, period, 0.0, **vars(OF_BEGINS), told=(0, int(turn[-1])))
        covariance = clock.error_of(np.eye(turn.size), turn)
        off = rng.multivariate_normal(np.zeros(turn.size), covariance) * 2 * np.pi / period
        own = hits.station == k
        angle[own] += off[hits.cycle[own]]
        clocks.append(clock)
    sensors = replace(scene.sensors, clocks=tuple(clocks))
    return replace(
        given, scene=replace(scene, hits=replace(hits, angle_rad=angle), sensors=sensors)
    )


def test_errors_of_begins_are_as_the_covariance_says() -> None:
    """Six of six runs on average; more than twice that without what the clocks tell."""
    own, without = [], []
    for seed in range(6):
        given = with_errors(made(2, seed, 4.0, hit_urad=5.0, sweep_urad=0.0), seed)
        found, _ = joint(given.scene)
        off = errors(found, given)
        own.append(squared(found, off))
        without.append(squared(replace(found, begins=0.0), off))
    assert np.mean(own) == pytest.approx(6.0, abs=3 * np.sqrt(12 / 6))
    assert np.mean(without) > 12


REAL = {"place_mm": 0.15, "cover": (-0.75e-3, 1.55e-3), "priors": Priors(phase_mrad=0.0)}


def pose_and_halves(given: Made, still: bool = False) -> tuple[float, float]:
    """Squared error of station 1, and that of the halves, 0 of a still board."""
    scene = given.scene
    at_rest = [median_angles(scene.hits, k, len(scene.board)) for k in (0, 1)] if still else None
    found, _ = joint(scene, at_rest)
    apart = None if still else halves(found)
    return squared(found, errors(found, given)), apart.m2 if apart else 0.0


def test_intervals_hold_where_diodes_are_seen_aside_by_direction() -> None:
    """Three recordings of 4 s, sum of squares below its 99.5 % point; halves no more apart than
    chance (99.9 % of the worst of three splits)."""
    found = np.array(
        [pose_and_halves(made(2, seed, 4.0, slow_mm=0.1, **REAL)) for seed in range(3)]
    )
    assert found[:, 0].sum() < chi2.ppf(0.995, 18)
    assert found[:, 1].max() < chi2.isf(1e-3 / 9, 6)


def test_intervals_hold_of_a_board_at_rest() -> None:
    """Whose hits are thousands from one direction: by their number alone, errors were 25 sigma."""
    total = sum(
        pose_and_halves(made(2, seed, 4.0, slow_mm=0.07, still=True, **REAL), still=True)[0]
        for seed in range(3)
    )
    assert total < chi2.ppf(0.995, 18)


def test_knots_follow_a_hand_that_shakes(monkeypatch: pytest.MonkeyPatch) -> None:
    """8 Hz of 15 mm: knots 50 ms apart leave more than the noise of 25 urad."""
    smooth = planes_scene.motion

    def shaken(time_s: np.ndarray, seed: int, still: bool = False) -> tuple[np.ndarray, np.ndarray]:
        R, t = smooth(time_s, seed, still)
        t[..., 1] += 0.015 * np.sin(2 * np.pi * 8 * np.asarray(time_s))
        return R, t

    monkeypatch.setattr(planes_scene, "motion", shaken)
    given = made(2, 2, 4.0)
    found, _ = joint(given.scene)
    assert found.recordings[0].trajectory.knot_s < 0.03
    assert 1e6 * found.recordings[0].noise.hit == pytest.approx(20.0, rel=0.1)
    assert np.linalg.norm(found.state.t_m[1] - given.poses[1][1]) < 2e-3


def test_wrong_hits_leave_once_the_pose_is_known() -> None:
    """3 % of the hits 2 to 10 mrad off."""
    given = made(2, 3, 4.0, wrong=0.03, **REAL)
    clean = made(2, 3, 4.0, **REAL).scene.hits
    wrong = np.isin(given.scene.hits.time_s, clean.time_s)
    wrong &= np.abs(given.scene.hits.angle_rad - clean.angle_rad) > 1e-3
    found, _ = joint(given.scene)
    kept = found.recordings[0].sweeps.hits
    assert wrong.sum() > 100
    assert not np.isin(given.scene.hits.time_s[wrong], kept.time_s).any()
    assert len(kept) > 0.93 * (len(clean) - wrong.sum())
    without = replace(given.scene, hits=clean)
    off = joint(without)[0].state.t_m[1] - found.state.t_m[1]
    assert np.linalg.norm(off) < 1e-3
