"""Errors of the begins of turns in the covariance of the stations."""

from dataclasses import replace

import numpy as np
import pytest

from mocap_metrology.lighthouse.calibrate.batch import joint
from mocap_metrology.lighthouse.decode.wander import TurnClock, Wander
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
