"""A station that is hidden for a part of the recording: what is left determines the pose."""

import numpy as np
import pytest
from scipy.stats import chi2

from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.lighthouse.simulate.recording import simulate
from tests.lighthouse.assess.test_moved_stations import SETTINGS, STATIONS, calibrate, summary
from tests.lighthouse.batch.test_batch import twin

LASTS_S = 6.0


@pytest.mark.parametrize("station", [0, 1])
@pytest.mark.parametrize("hidden", [(2 / 3, 1.0), (0.0, 0.8)])
def test_a_station_hidden_for_a_part_leaves_a_pose(station: int, hidden) -> None:
    """Its error is within what its covariance allows, which is positive."""
    blocked = ((station, *(LASTS_S * share for share in hidden)),)
    made = simulate(twin(50 + station, duration_s=LASTS_S, blocked=blocked))
    found = calibrate(made.hits, made.truth.board, [Factory(), Factory()], SETTINGS)
    document = summary(found, STATIONS).document
    pose = document["poses"][document["chosen"]]
    covariance = np.array(pose["covariance"])
    assert np.linalg.eigvalsh(covariance)[0] > 0
    off = np.array(pose["translation_mm"]) - 1e3 * made.truth.t_optical_m
    assert off @ np.linalg.solve(covariance[:3, :3], off) < chi2.ppf(0.9999, 3)
    assert np.sqrt(np.diag(covariance)[:3]).max() < 20  # mm, and no absurd limit
