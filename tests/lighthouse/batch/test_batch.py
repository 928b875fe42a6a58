"""Estimator `batch` on recordings by a generator that knows nothing of it (`calibrate.scenes`) and
on simulated recordings with faults."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.batch import BINS, solved
from mocap_metrology.lighthouse.calibrate.scene import Scene
from mocap_metrology.lighthouse.records import Factory, Hits, PoseEstimate
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps, simulate
from mocap_metrology.lighthouse.simulate.twin import FactoryValues
from tests.lighthouse import pairs
from tests.lighthouse.calibrate import scenes
from tests.lighthouse.pairs import EXACT, UNITS, squared, twin

FACTORIES = [Factory(), Factory()]


def of_scene(own: scenes.Scene) -> Scene:
    return Scene(own.hits, own.board, "ideal", [None] * 2, None, "crazyflie", EXACT)


def estimated(
    made: SimulatedSweeps, hits: Hits | None = None, priors: Priors = EXACT
) -> PoseEstimate:
    return solved(pairs.scene(made, hits, priors))[0]


def off(pose: PoseEstimate, R: np.ndarray, t_m: np.ndarray) -> np.ndarray:
    """Error in mm and deg, as the covariance counts."""
    return pairs.error(pose.R, pose.t_m, R, t_m) * UNITS


def test_quantised_hits_of_another_generator() -> None:
    """Five recordings of 5 s, quantised to 0.5 us, nothing else: errors below 1 mm and 0.03 deg,
    and the squared error over the covariance is of six degrees of freedom (its mean within what
    4 standard errors allow)."""
    squares = []
    for seed in range(5):
        own = scenes.scene(seed, seconds=5)
        pose = solved(of_scene(own))[0]
        error = off(pose, own.R, own.t_m)
        assert np.abs(error[:3]).max() < 1.5 and np.abs(error[3:]).max() < 0.04
        assert pose.path is not None
        assert pose.details["prior_p"] == 1.0  # nothing that is known beforehand is estimated
        R, t = scenes.pose_at(pose.path.time_s, seed, 0.4)
        assert np.abs(pose.path.t_m - t).max() < 4e-3  # ends of the spline included
        assert np.abs(rotation.log(pose.path.R @ np.swapaxes(R, 1, 2))).max() < 0.02
        squares.append(squared(error, pose.covariance))
    assert np.mean(squares) == pytest.approx(6, abs=4 * np.sqrt(12 / 5))


@pytest.mark.parametrize("optics", ["ideal", "estimated"])
@pytest.mark.parametrize("still", [False, True])
def test_hits_without_any_noise(still: bool, optics: str) -> None:
    """As of a simulation: the pose is right, no hit is lost, and the covariance is one."""
    own = scenes.scene(3, seconds=4, quantised=False, still=still)
    priors = EXACT if optics == "ideal" else Priors()
    at = Scene(own.hits, own.board, optics, [None] * 2, None, "crazyflie", priors)
    pose = solved(at)[0]
    assert pose.covariance is not None and pose.details["weight_lost"] < 0.01
    assert np.abs(pose.covariance - pose.covariance.T).max() <= 1e-9 * np.trace(pose.covariance)
    limit = 5 * np.sqrt(np.diag(pose.covariance)) + [0.1, 0.1, 0.1, 0.01, 0.01, 0.01]
    assert (np.abs(off(pose, own.R, own.t_m)) < limit).all()


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
        squares.append(squared(off(pose, made.truth.R, made.truth.t_m), pose.covariance))
    inside = np.array(squares) < chi2.ppf(0.68, 6)
    assert 5 <= inside.sum() <= 11
    assert np.mean(squares) == pytest.approx(6, abs=4 * np.sqrt(12 / 12))


def steps(pose: PoseEstimate) -> float:
    """Largest difference of mean residuals in urad, of a station and axis, late and early."""
    rows = [r for r in pose.details["residuals"]["against"] if r["against"] == "time_s"]
    assert len(rows) == 4
    means, middle = np.array([row["mean_urad"] for row in rows]), BINS // 2
    return np.abs(means[:, : middle - 1].mean(axis=1) - means[:, middle + 1 :].mean(axis=1)).max()


def test_a_station_that_is_bumped_shows_in_the_halves_and_residuals() -> None:
    """5 mm: the halves are 3 to 8 mm apart, far beyond chance, and mean residuals have a step."""
    made, hits = pairs.bumped(6)
    bumped, sound = (estimated(made, own, Priors()) for own in (hits, made.hits))
    assert bumped.halves.m2 > 150 and 3 < bumped.halves.mm < 8 and sound.halves.m2 < 30
    assert steps(bumped) > 100 > 4 * steps(sound)


def test_a_displaced_diode_has_its_residual_though_it_is_excluded() -> None:
    """4 mm along y at about 3 m are 1.3 mrad of azimuth: rms over both axes near 1 mrad."""
    made = simulate(twin(7))
    wrong = made.truth.board.copy()
    wrong[13] += [0.0, 0.004, 0.0]
    pose = solved(replace(pairs.scene(made, priors=Priors()), board=wrong))[0]
    for row in pose.details["residuals"]["by_diode"]:
        assert row["excluded"] == [13]
        rms = dict(zip(row["diode"], row["rms_urad"], strict=True))
        assert 600 < rms.pop(13) < 1600 and max(rms.values()) < 100
        assert row["n"][row["diode"].index(13)] > 200


@pytest.mark.parametrize(("station", "hidden"), [(0, (0.0, 0.8)), (1, (2 / 3, 1.0))])
def test_a_station_hidden_for_a_part_leaves_a_pose(station: int, hidden) -> None:
    """Its error is within what its covariance allows, which is positive."""
    blocked = ((station, *(6.0 * share for share in hidden)),)
    made = simulate(twin(50 + station, duration_s=6.0, blocked=blocked))
    pose = solved(replace(pairs.scene(made), optics="factory", factories=FACTORIES))[0]
    assert np.linalg.eigvalsh(pose.covariance)[0] > 0
    assert squared(off(pose, made.truth.R, made.truth.t_optical_m), pose.covariance) < chi2.ppf(
        0.9999, 6
    )
    assert np.sqrt(np.diag(pose.covariance)[:3]).max() < 20  # mm, and no absurd limit


def test_too_little_is_refused() -> None:
    own = scenes.scene(1, seconds=2)
    few = own.hits.take((own.hits.station == 0) | (own.hits.diode < 3))
    with pytest.raises(Refusal, match=r"batch, ideal: \d+ and 0 moments at which a station sees"):
        solved(replace(of_scene(own), hits=few))[0]


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
    scene = pairs.scene(made)
    errors = []
    for optics in ("ideal", "estimated"):
        pose = solved(replace(scene, optics=optics))[0]
        errors.append(off(pose, made.truth.R, made.truth.t_m))
    ideal, free = (np.linalg.norm(error[:3]) for error in errors)
    assert ideal > 30 and free < 40 and free < ideal
    assert squared(errors[1], pose.covariance) < chi2.ppf(0.999, 6)
