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
from mocap_metrology.lighthouse.batch.problem import GROUPS, Priors
from mocap_metrology.lighthouse.batch.recording import shared_by_direction
from mocap_metrology.lighthouse.calibrate.batch import all_solved, joint
from mocap_metrology.lighthouse.calibrate.fits import well_fitted
from mocap_metrology.lighthouse.calibrate.network import islands, look, shared_moments, start
from mocap_metrology.lighthouse.calibrate.static import median_angles
from mocap_metrology.lighthouse.records import Hits
from tests.lighthouse.batch import planes_scene
from tests.lighthouse.batch.planes_scene import Made, made

COVER_M = (-0.75e-3, 1.55e-3)


def errors(found: Joint, given: Made) -> np.ndarray:
    """(stations - 1, 6) in m and rad."""
    own = zip(found.state.R[1:], found.state.t_m[1:], given.poses[1:], strict=True)
    return np.array([np.r_[t - t0, rotation.error(R, R0)] for R, t, (R0, t0) in own])


def squared(found: Joint, off: np.ndarray) -> float:
    """Of all stations together, over their joint covariance."""
    rows = np.concatenate([found.pose(k) for k in range(1, len(off) + 1)])
    return float(off.ravel() @ np.linalg.solve(found.covariance[np.ix_(rows, rows)], off.ravel()))


def test_poses_from_nothing_are_as_near_as_the_covariance_says() -> None:
    """Two recordings of four stations; the sum of squares within its 99 % interval, noise as it
    was made."""
    total, freedom = 0.0, 0
    for seed in range(2):
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


def test_errors_of_places_count_as_large_as_they_are() -> None:
    """Of 0.1 mm, by two recordings: 0.09 mm each, with what remains open; the largest that the hits
    do not rule out, 0.11 mm, made sigma a fifth wider than errors."""
    for seed in range(2):
        given = made(2, seed, 4.0, place_mm=0.1, cover=COVER_M, priors=Priors(phase_mrad=0.0))
        found, _ = joint(given.scene)
        place = found.of.group == GROUPS.index("place")
        working, believed = found.working[place].max(), found.believed[place].max()
        assert working < believed < 1.05 * working
        assert believed == pytest.approx(1e-4, rel=0.12)


def test_reflections_on_a_fifth_of_the_diodes_of_both_stations() -> None:
    """In each stretch of 0.3 s other diodes are seen elsewhere, up to 0.3 rad off, by each station:
    poses are as near as without."""
    given, rng = made(2, 2, 3.0), np.random.default_rng(2)
    hits, shape = given.scene.hits, (2, 2, 10, len(given.scene.board))
    off = rng.uniform(-0.3, 0.3, shape) * (rng.random((2, 1, *shape[2:])) < 0.2)
    wrong = off[hits.station, hits.axis, (hits.time_s / 0.3).astype(int), hits.diode]
    found, _ = joint(replace(given.scene, hits=replace(hits, angle_rad=hits.angle_rad + wrong)))
    missed = errors(found, given)
    assert squared(found, missed) < chi2.ppf(0.999, 6)
    assert np.linalg.norm(missed[:, :3]) < 1e-3


def test_poses_by_ideal_planes() -> None:
    given = made(2, 3, 2.0, ideal=True)
    found, _ = joint(replace(given.scene, optics="ideal"))
    assert squared(found, errors(found, given)) < chi2.ppf(0.999, 6)


@pytest.mark.parametrize("bad", [(), (7,)])
def test_a_diode_that_is_off_twice_as_much_is_named(bad: tuple[int, ...]) -> None:
    given = made(2, 7, 4.0, cover=COVER_M, place_mm=0.15, slow_mm=0.07, priors=Priors())
    hits, rng = given.scene.hits, np.random.default_rng(1)
    more = 75e-6 * rng.standard_normal(len(hits)) * np.isin(hits.diode, bad)
    near, how = start(given.scene), replace(hits, angle_rad=hits.angle_rad + more)
    _, note = well_fitted(given.scene, how, *near[1:])
    assert note == ("diode 7 excluded: the others contradict it" if bad else "")


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


REAL = {"place_mm": 0.15, "cover": (-0.75e-3, 1.55e-3), "priors": Priors(phase_mrad=0.0)}


def pose_and_halves(given: Made, still: bool = False) -> tuple[float, float]:
    """Squared error of station 1, and that of the halves, 0 of a still board."""
    scene = given.scene
    at_rest = [median_angles(scene.hits, k, len(scene.board)) for k in (0, 1)] if still else None
    found, _ = joint(scene, at_rest)
    apart = None if still else halves(found)[0]
    return squared(found, errors(found, given)), apart.m2 if apart else 0.0


def test_intervals_hold_where_diodes_are_seen_aside_by_direction() -> None:
    """Two recordings of 4 s, sum of squares below its 99.5 % point; halves no more apart than
    chance (99.9 % of the worst of three splits)."""
    found = np.array(
        [pose_and_halves(made(2, seed, 4.0, slow_mm=0.1, **REAL)) for seed in range(2)]
    )
    assert found[:, 0].sum() < chi2.ppf(0.995, 12)
    assert found[:, 1].max() < chi2.isf(1e-3 / 6, 6)


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


def test_a_station_that_was_touched_and_put_back_is_as_far_off_as_stated() -> None:
    """2 mm aside for more than half of the time; by noise alone, the pose were 6 sigma off."""
    given, other = made(2, 1, 2.0), made(2, 1, 2.0, bump_mm=2.0)
    away = [np.abs(one.scene.hits.time_s - 1.0) < 0.6 for one in (given, other)]
    parts = vars(given.scene.hits.take(~away[0])), vars(other.scene.hits.take(away[1]))
    hits = Hits(**{name: np.concatenate([one[name] for one in parts]) for name in parts[0]})
    scene = replace(given.scene, hits=hits.take(np.argsort(hits.time_s, kind="stable")))
    found = joint(scene)
    off = errors(found[0], given)
    wide = all_solved(scene, known=found)[1]
    assert squared(wide, off) < chi2.ppf(0.99, 6) < squared(found[0], off) / 2


@pytest.mark.parametrize(("apart", "cells"), [(0.2, 1.6), (0.6, 1.0)])
def test_hits_from_neighbouring_directions_share_errors(apart: float, cells: float) -> None:
    """Of n hits from each of two directions, (s^2 + tau^2) / (s^2 + n tau^2) of a hit counts, with
    60 % more in n where the directions, unit vectors, are as near as 11 deg."""
    n, rng = 50, np.random.default_rng(1)
    who = np.zeros((2 * n, 4), np.int64)
    who[n:, 3] = 1
    way = np.array([[np.sin(at), np.cos(at), 0.0] for at in (0.1, 0.1 + apart)])
    path = SimpleNamespace(control=np.repeat(np.c_[-way, np.zeros((2, 3))], 4, axis=0))
    who[:, 3] *= 4  # control points of their own
    first = np.arange(0, 2 * n + 1, 10)
    seen = SimpleNamespace(
        who=who,
        basis=np.full((2 * n, 4), 0.25),
        turned=np.tile(np.eye(3), (2 * n, 1, 1)),
        sweeps=SimpleNamespace(first=first),
    )
    state = SimpleNamespace(t_m=np.zeros((1, 3)), R=np.eye(3)[None], board=np.zeros((4, 3)))
    at = seen, path, state, 2e-5 * rng.normal(size=2 * n), np.ones(2 * n), 2e-5
    share, tau, noise = shared_by_direction(*at)  # type: ignore[arg-type]
    expected = noise**2 / (noise**2 + (cells * n - 1) * tau**2)
    np.testing.assert_allclose(share, expected)
