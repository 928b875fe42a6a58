"""Errors that depend on the direction of light, knots that follow a hand, and wrong hits: against
what the hits were made with."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.batch.parts import halves
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.batch import joint
from mocap_metrology.lighthouse.calibrate.static import median_angles
from tests.lighthouse.batch import planes_scene
from tests.lighthouse.batch.planes_scene import Made, made

REAL = {"place_mm": 0.15, "cover": (-0.75e-3, 1.55e-3), "priors": Priors(phase_mrad=0.0)}


def squared(given: Made, still: bool = False) -> tuple[float, float]:
    """Error of station 1 over its covariance, and chi squared of the halves, 0 of a still board."""
    scene = given.scene
    at_rest = [median_angles(scene.hits, k, len(scene.board)) for k in (0, 1)] if still else None
    found, _ = joint(scene, at_rest)
    R, t = given.poses[1]
    off = np.r_[found.state.t_m[1] - t, rotation.error(found.state.R[1], R)]
    apart = None if still else halves(found)
    value = float(off @ np.linalg.solve(found.pose_covariance(), off))
    return value, apart.m2 if apart else 0.0


def test_intervals_hold_where_diodes_are_seen_aside_by_direction() -> None:
    """Three recordings of 4 s, sum of squares below its 99.5 % point; halves no more apart than
    chance (99.9 % of the worst of three splits)."""
    found = np.array([squared(made(2, seed, 4.0, slow_mm=0.1, **REAL)) for seed in range(3)])
    assert found[:, 0].sum() < chi2.ppf(0.995, 18)
    assert found[:, 1].max() < chi2.isf(1e-3 / 9, 6)


def test_intervals_hold_of_a_board_at_rest() -> None:
    """Whose hits are thousands from one direction: by their number alone, errors were 25 sigma."""
    total = sum(
        squared(made(2, seed, 4.0, slow_mm=0.07, still=True, **REAL), still=True)[0]
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
