"""Errors of the begins of turns in the covariance of the stations."""

from dataclasses import replace

import numpy as np
import pytest

from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.batch import joint
from mocap_metrology.lighthouse.calibrate.scene import Scene, Sensors
from mocap_metrology.lighthouse.decode.chain import decode_light
from mocap_metrology.lighthouse.decode.clean import Cleaning
from mocap_metrology.lighthouse.decode.wander import TurnClock, Wander
from mocap_metrology.lighthouse.rotation import error
from mocap_metrology.lighthouse.simulate.turns import TurnsTwin, simulate_turns, stations_around
from mocap_metrology.lighthouse.simulate.twin import MotionTwin
from tests.lighthouse.batch.planes_scene import TICKS, Made, made
from tests.lighthouse.batch.test_planes_batch import errors, squared

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


def test_squared_errors_are_as_the_covariance_says() -> None:
    """Six of ten runs on average; more than twice that without what the clocks tell."""
    own, without = [], []
    for seed in range(10):
        given = with_errors(made(2, seed, 4.0, hit_urad=5.0, sweep_urad=0.0), seed)
        found, _ = joint(given.scene)
        off = errors(found, given)
        own.append(squared(found, off))
        without.append(squared(replace(found, begins=0.0), off))
    assert np.mean(own) == pytest.approx(6.0, abs=3 * np.sqrt(12 / 10))
    assert np.mean(without) > 12


def test_begins_of_the_first_second_only() -> None:
    """A station whose begins are told in 1 s of 4: the line beyond them is off by up to 0.1 mrad,
    which is as stated in six recordings together."""
    squares = []
    for seed in range(6):
        R, t, middle, up = stations_around(2, np.random.default_rng([seed, 3]))
        motion = MotionTwin(centre_m=tuple(middle), speed_m_s=0.5, extent_m=0.8)
        twin = TurnsTwin(seed, R, t, (0, 1), motion, up=up, duration_s=4.0, place_mm=0.0)
        given = simulate_turns(twin)
        told = (given.light.begin_channel == 0) | (given.light.begin_s < 1.0)
        names = ("begin_channel", "begin_s", "begin_bit")
        light = replace(given.light, **{k: getattr(given.light, k)[told] for k in names})
        found = decode_light(light, twin.board, None, Cleaning(), "twin")
        how = "factory", given.factories, None, "libsurvive", Priors(0, 0, 0, 0, 0)
        sensors = Sensors(clocks=tuple(found.clocks))
        scene = Scene(found.hits, twin.board, *how, sensors=sensors, generation=2, names=["0", "1"])
        own, _ = joint(scene)
        off = np.r_[own.state.t_m[1] - t[1], error(own.state.R[1], R[1])]
        squares.append(float(off @ np.linalg.solve(own.pose_covariance(), off)))
    assert np.mean(squares) == pytest.approx(6.0, abs=3 * np.sqrt(12 / 6))
