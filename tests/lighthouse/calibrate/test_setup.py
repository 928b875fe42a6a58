"""Several recordings of a setup in one estimate."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.calibrate.batch import Scene, by_batch
from mocap_metrology.lighthouse.calibrate.setup import by_setup
from mocap_metrology.lighthouse.simulate.recording import Made, simulate
from mocap_metrology.lighthouse.simulate.twin import (
    FactoryValues,
    LighthouseTwin,
    MotionTwin,
    StationTwin,
)

UNITS = np.r_[np.full(3, 1e3), np.full(3, 180 / np.pi)]
ROTORS = (
    FactoryValues(phase=(0.03, 0.05), tilt=(-0.004, 0.002), curve=(-0.003, 0.001),
                  gibphase=(1.9, -0.8), gibmag=(0.011, -0.011)),
    FactoryValues(phase=(0.01, 0.02), tilt=(0.003, -0.005), curve=(0.004, -0.002),
                  gibphase=(2.2, 1.1), gibmag=(0.008, -0.012)),
)  # fmt: skip
PLACES = ((3.0, 0.8, 0.2), (3.6, 0.3, -0.4), (2.5, 1.3, 0.5), (3.3, 1.5, -0.1), (2.7, 0.2, 0.4))


def made(k: int, at: tuple[float, ...] = (0.5, 2.5, 0.3), factory: bool = True) -> Made:
    """Recording k of a setup, at a place of its own."""
    master, slave = ROTORS if factory else (None, None)
    return simulate(
        LighthouseTwin(
            seed=40 + k,
            duration_s=4.0,
            common_urad=53.0,
            independent_urad=49.0,
            dropout=0.1,
            master=StationTwin(id=1, mode="b", factory=master),
            slave=StationTwin(id=2, mode="c", factory=slave, position_m=at,
                              rotation_deg=(5, 4, -40)),
            motion=MotionTwin(centre_m=PLACES[k], tremor_mm=0.05, tremor_deg=0.014),
        )
    )  # fmt: skip


def scene(own: Made, optics: str = "ideal") -> Scene:
    variant = "crazyflie"
    return Scene(own.hits, own.truth.board, optics, [None, None], None, variant, Priors())


def off(pose, own: Made) -> np.ndarray:
    """Error in mm and deg."""
    return np.r_[pose.t_m - own.truth.t_optical_m, rotation.error(pose.R, own.truth.R)] * UNITS


def test_three_recordings_are_better_than_one_and_agree() -> None:
    """Of equal recordings the variance of the noise would be a third; the whole error is within its
    95 % ellipsoid, and so is each recording's from the others."""
    recordings = [made(k, factory=False) for k in range(3)]
    scenes = {str(k): scene(own) for k, own in enumerate(recordings)}
    found = by_setup(scenes)
    alone = [np.trace(by_batch(one).covariance_noise[:3, :3]) for one in scenes.values()]
    assert np.trace(found.pose.covariance_noise[:3, :3]) < 0.6 * min(alone)
    error = off(found.pose, recordings[0])
    assert error @ np.linalg.solve(found.pose.covariance, error) < chi2.ppf(0.95, 6)
    assert set(found.predicted["slave"]) == set(scenes)
    assert all(
        pair.recordings and pair.m2 < chi2.ppf(0.999, 6)
        for pair in found.predicted["slave"].values()
    )
    assert found.pose.n_angles == sum(len(own.hits) for own in recordings)


def test_a_station_moved_between_recordings_is_found() -> None:
    recordings = [made(k, factory=False) for k in range(2)]
    recordings.append(made(2, (0.505, 2.5, 0.3), factory=False))
    found = by_setup({str(k): scene(own) for k, own in enumerate(recordings)})
    assert max(pair.m2 for pair in found.predicted["slave"].values()) > 10 * chi2.ppf(0.999, 6)
    assert found.pose.halves.m2 == max(pair.m2 for pair in found.predicted["slave"].values())


def test_a_bad_recording_is_left_out_by_name_and_one_is_too_few() -> None:
    own, other = scene(made(0, factory=False)), scene(made(1, factory=False))
    short = replace(other, hits=other.hits.take(other.hits.time_s < other.hits.time_s.min() + 0.2))
    with pytest.raises(Refusal, match=r"1 recordings of the setup can be used; .*short: "):
        by_setup({"own": own, "short": short})
    found = by_setup({"own": own, "other": other, "short": short})
    assert found.why[0].startswith("short: ") and set(found.predicted["slave"]) == {"own", "other"}
