"""Twins of second-generation stations: from the file of twins to pose.json."""

import json
from pathlib import Path

import numpy as np
from mocap_workflow.calibration_twins import calibration_twin
from scipy.stats import chi2

from mocap_metrology.calibration.pose import simulate
from mocap_metrology.calibration.sweeps import Entry
from mocap_metrology.common.entries import TwinsFile
from mocap_metrology.lighthouse.simulate.network_twin import NetworkTwin
from mocap_metrology.lighthouse.simulate.turns import simulate_turns
from mocap_metrology.settings import Lighthouse

FILE: TwinsFile = {
    "defaults": {"calibration": {"motion": {"centre_m": [3, 0, 0]}, "dropout": 0.5}},
    "setups": {"room": {"stations": 3, "room_seed": 4, "duration_s": 3.0}},
    "twins": {"a": {"setup": "room", "seed": 1}, "b": {"like": "a", "seed": 2},
              "c": {"seed": 1, "stations": 1}, "d": {"seed": 1, "stations": 2, "dropout": 2},
              "old": {"seed": 1, "master": {"id": 1, "mode": "A"}}},
}  # fmt: skip


def twin(name: str) -> NetworkTwin:
    found = calibration_twin(FILE, name)
    assert isinstance(found, NetworkTwin)
    return found


def test_recordings_of_a_setup_share_stations_and_object_alone() -> None:
    first, second, other = (simulate_turns(twin(name).turns(seed)) for name, seed in
                            (("a", 0), ("b", 0), ("a", 1)))  # fmt: skip
    for name in ("ids", "places"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    np.testing.assert_array_equal(first.twin.t, second.twin.t)
    assert first.ids != other.ids and len(set(first.ids)) == 3
    at = np.linspace(0, 20, 50)
    apart = first.motion.poses(at)[1] - second.motion.poses(at)[1]
    assert np.linalg.norm(apart, axis=1).min() > 0 and apart.std() > 0.05
    again = simulate_turns(twin("a").turns(0))
    np.testing.assert_array_equal(first.light.hit_s, again.light.hit_s)


def test_a_twin_is_calibrated_against_its_truth(tmp_path: Path) -> None:
    """Factory values come from its light; each error is within the 99.9 % ellipsoid."""
    given = NetworkTwin(seed=3, stations=2, duration_s=12.0)
    entry = Entry("t", twin="t", format="libsurvive-rec")
    document = simulate(entry, given, 5, {}, Lighthouse(), None, tmp_path)
    (pose,) = document["poses"]
    assert pose["optics"] == "factory" and document["origin"]["twin"] == "t"
    off = np.r_[pose["errors_mm"], pose["errors_deg"]]
    assert off @ np.linalg.solve(pose["covariance"], off) < chi2.ppf(0.999, 6)
    truth = json.loads((tmp_path / "truth.json").read_text())
    assert set(truth["stations"]) == {"0", "1"} and (tmp_path / "twin_board.csv").is_file()
