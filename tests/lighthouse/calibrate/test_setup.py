"""Several recordings of a setup in one estimate."""

from dataclasses import replace

import pytest
from scipy.stats import chi2

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.batch import Scene
from mocap_metrology.lighthouse.calibrate.setup import by_setup
from mocap_metrology.lighthouse.simulate.recording import Made, simulate
from tests.lighthouse import pairs
from tests.lighthouse.pairs import twin

PLACES = ((3.0, 0.8, 0.2), (3.6, 0.3, -0.4), (2.5, 1.3, 0.5), (3.3, 1.5, -0.1), (2.7, 0.2, 0.4))


def made(k: int, **slave: object) -> Made:
    """Recording k of a setup, at a place of its own."""
    return simulate(twin(40 + k, duration_s=4.0, motion={"centre_m": PLACES[k]}, slave=slave))


def scene(own: Made) -> Scene:
    return pairs.scene(own, priors=Priors())


def test_a_station_moved_between_recordings_is_found() -> None:
    recordings = [made(k) for k in range(2)]
    recordings.append(made(2, position_m=(0.505, 2.5, 0.3)))
    found = by_setup({str(k): scene(own) for k, own in enumerate(recordings)})
    assert max(pair.m2 for pair in found.predicted["slave"].values()) > 10 * chi2.ppf(0.999, 6)
    assert found.pose.halves.m2 == max(pair.m2 for pair in found.predicted["slave"].values())


def test_a_bad_recording_is_left_out_by_name_and_one_is_too_few() -> None:
    own, other = scene(made(0)), scene(made(1))
    short = replace(other, hits=other.hits.take(other.hits.time_s < other.hits.time_s.min() + 0.2))
    with pytest.raises(Refusal, match=r"1 recordings of the setup can be used; .*short: "):
        by_setup({"own": own, "short": short})
    found = by_setup({"own": own, "other": other, "short": short})
    assert found.why[0].startswith("short: ") and set(found.predicted["slave"]) == {"own", "other"}
