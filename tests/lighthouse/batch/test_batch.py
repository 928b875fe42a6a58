"""Estimator `batch` on recordings by a generator that knows nothing of it (`calibrate.scenes`) and
on simulated recordings with faults."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.calibrate.batch import Scene, by_batch
from mocap_metrology.lighthouse.records import Factory, Hits, PoseEstimate
from mocap_metrology.lighthouse.simulate.recording import Made, simulate
from mocap_metrology.lighthouse.simulate.twin import (
    FactoryValues,
    LighthouseTwin,
    MotionTwin,
    StationTwin,
)
from tests.lighthouse.calibrate import scenes

EXACT = Priors(0, 0, 0, 0, 0)
UNITS = np.r_[np.full(3, 1e3), np.full(3, 180 / np.pi)]


def by_ideal(hits: Hits, board: np.ndarray, priors: Priors) -> PoseEstimate:
    return by_batch(Scene(hits, board, "ideal", [None, None], None, "crazyflie", priors))


def off(pose: PoseEstimate, R: np.ndarray, t_m: np.ndarray) -> np.ndarray:
    """Error in mm and deg, as the covariance counts."""
    return np.r_[pose.t_m - t_m, rotation.error(pose.R, R)] * UNITS


def squared(pose: PoseEstimate, error: np.ndarray) -> float:
    return float(error @ np.linalg.solve(pose.covariance, error))


def twin(seed: int, **more: object) -> LighthouseTwin:
    slave = {"id": 2, "mode": "c", "position_m": (0.5, 2.5, 0.3), "rotation_deg": (5, 4, -40)}
    slave |= more.pop("slave", {})
    given = {"duration_s": 5.0, "common_urad": 53.0, "independent_urad": 49.0, "dropout": 0.1}
    motion = MotionTwin(centre_m=(3.0, 0.8, 0.2), tremor_mm=0.05, tremor_deg=0.014)
    return LighthouseTwin(
        seed=seed,
        master=StationTwin(id=1, mode="b", **more.pop("master", {})),
        slave=StationTwin(**slave),
        motion=motion,
        **given | more,
    )


def estimated(made: Made, hits: Hits | None = None, board: np.ndarray | None = None,
              priors: Priors = EXACT) -> PoseEstimate:  # fmt: skip
    return by_ideal(
        made.hits if hits is None else hits, made.truth.board if board is None else board, priors
    )


def test_quantised_hits_of_another_generator() -> None:
    """Five recordings of 5 s, quantised to 0.5 us, nothing else: errors below 1 mm and 0.03 deg,
    and the squared error over the covariance is of six degrees of freedom (its mean within what
    4 standard errors allow)."""
    squares = []
    for seed in range(5):
        own = scenes.scene(seed, seconds=5)
        pose = by_ideal(own.hits, own.board, EXACT)
        error = off(pose, own.R, own.t_m)
        assert np.abs(error[:3]).max() < 1.5 and np.abs(error[3:]).max() < 0.04
        assert pose.path is not None
        assert pose.details["prior_p"] == 1.0  # nothing that is known beforehand is estimated
        R, t = scenes.pose_at(pose.path.time_s, seed, 0.4)
        assert np.abs(pose.path.t_m - t).max() < 4e-3  # ends of the spline included
        assert np.abs(rotation.log(pose.path.R @ np.swapaxes(R, 1, 2))).max() < 0.02
        squares.append(squared(pose, error))
    assert np.mean(squares) == pytest.approx(6, abs=4 * np.sqrt(12 / 5))


def test_noise_that_sweeps_share() -> None:
    """Twelve recordings of 3 s with 53 urad in common and 49 of each hit: 68 % ellipsoids hold the
    truth in 8 of 12 on average, 5 to 11 at two standard errors, and errors are those that the
    covariance states."""
    squares = []
    for seed in range(12):
        made = simulate(twin(seed, duration_s=3.0))
        pose = estimated(made)
        told = pose.details
        assert told["noise_hit_urad"] == pytest.approx(49, rel=0.05)
        assert told["noise_sweep_urad"] == pytest.approx(53, rel=0.35)
        assert set(told["residual_ratios"]["station"]) == {"master", "slave"}
        assert all(0.8 < x < 1.2 for x in told["residual_ratios"]["diode"].values())
        squares.append(squared(pose, off(pose, made.truth.R, made.truth.t_m)))
    inside = np.array(squares) < chi2.ppf(0.68, 6)
    assert 5 <= inside.sum() <= 11
    assert np.mean(squares) == pytest.approx(6, abs=4 * np.sqrt(12 / 12))


def test_depth_of_the_lasers_is_estimated() -> None:
    """Lasers of both stations 10 mm apart in depth: the optical pose within 5 mm, where a model
    without depth is centimetres off; and within its own interval."""
    lasers = ((0.005, 0.0, 0.0), (-0.005, 0.0, 0.0))
    made = simulate(twin(5, master={"lasers_m": lasers}, slave={"lasers_m": lasers}))
    scene = Scene(
        made.hits, made.truth.board, "factory", [Factory(), Factory()], None, "crazyflie", EXACT
    )
    errors = []
    for depth_mm in (0.0, 10.0):
        pose = by_batch(replace(scene, priors=Priors(0, 0, depth_mm, 0, 0)))
        errors.append(off(pose, made.truth.R, made.truth.t_optical_m))
    without, with_depth = (np.linalg.norm(error[:3]) for error in errors)
    assert without > 10 and with_depth < 5
    assert squared(pose, errors[1]) < chi2.ppf(0.999, 6)


def test_a_station_that_is_bumped_shows_in_the_halves() -> None:
    """5 mm at 2.6 s of 5: the halves are 3 to 8 mm apart, far beyond chance; sound ones are not."""
    sound = simulate(twin(6))
    moved = simulate(twin(6, slave={"position_m": (0.503, 2.504, 0.3)}))
    early, late = sound.hits.time_s < 2.6, moved.hits.time_s >= 2.6
    parts = sound.hits.take(early), moved.hits.take(late)
    hits = Hits(
        **{
            name: np.concatenate([getattr(part, name) for part in parts])
            for name in Hits.__dataclass_fields__
        }
    )
    bumped = estimated(sound, hits, priors=Priors())
    assert bumped.halves.m2 > 150 and 3 < bumped.halves.mm < 8
    assert estimated(sound, priors=Priors()).halves.m2 < 30


def test_too_little_is_refused() -> None:
    own = scenes.scene(1, seconds=2)
    few = own.hits.take((own.hits.station == 0) | (own.hits.diode < 3))
    with pytest.raises(Refusal, match=r"batch, ideal: \d+ and 0 moments at which a station sees"):
        by_ideal(few, flat_board(), EXACT)


def test_unknown_rotors_are_estimated_with_the_pose() -> None:
    """Rotors as real ones, without their factory values: ideal optics err by more than 30 mm, with
    the values among the unknowns the error is below 40 mm and within its own interval."""
    of_rotors = [
        FactoryValues(
            phase=(0.03 * sign, 0.05 * sign),
            tilt=(-0.005, 0.003),
            curve=(0.002, -0.004),
            gibphase=(1.9, -0.8),
            gibmag=(0.009, -0.011),
        )
        for sign in (1, -1)
    ]
    stations = [{"factory": factory} for factory in of_rotors]
    made = simulate(twin(10, duration_s=8.0, master=stations[0], slave=stations[1]))
    scene = Scene(made.hits, made.truth.board, "ideal", [None, None], None, "crazyflie", EXACT)
    errors = []
    for optics in ("ideal", "estimated"):
        pose = by_batch(replace(scene, optics=optics))
        errors.append(off(pose, made.truth.R, made.truth.t_m))
    ideal, free = (np.linalg.norm(error[:3]) for error in errors)
    assert ideal > 30 and free < 40 and free < ideal
    assert squared(pose, errors[1]) < chi2.ppf(0.999, 6)
