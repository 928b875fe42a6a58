"""Columns in which pulses, hits and poses are stored: units, quaternions, and the way back."""

from pathlib import Path

import numpy as np

from mocap_metrology.common.files import read_table, write_table
from mocap_metrology.lighthouse.assess.summary import refused
from mocap_metrology.lighthouse.records import (
    PLACES,
    SWEEPS_CODED,
    Hits,
    Inertial,
    Station,
    hits_of,
    inertial_columns,
    inertial_of,
    sweep_columns,
)


def hits() -> Hits:
    return Hits(
        station=np.array([0, 1, 0], np.int8),
        axis=np.array([0, 0, 1], np.int8),
        cycle=np.array([4, 4, 5], np.int32),
        diode=np.array([31, 0, 2], np.int16),
        time_s=np.array([0.0367, 0.0451, 0.0534]),
        angle_rad=np.array([-0.25, 0.125, 0.5]),
        width_s=np.array([4.5e-6, 7e-6, 12.25e-6]),
    )


def test_hits_come_back_out_of_their_file(tmp_path: Path) -> None:
    whole = hits()
    write_table(tmp_path / "sweeps.parquet", sweep_columns(whole), {}, SWEEPS_CODED)
    columns, _ = read_table(tmp_path / "sweeps.parquet")
    assert columns["width_us"].tolist() == [4.5, 7.0, 12.25]
    back = hits_of(columns)
    for name in Hits.__dataclass_fields__:
        np.testing.assert_allclose(getattr(back, name), getattr(whole, name), rtol=1e-15)
        assert getattr(back, name).dtype == getattr(whole, name).dtype


def test_sensors_come_back_out_of_their_file(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    whole = Inertial(
        np.arange(5) / 250, rng.normal(size=(5, 3)), rng.normal(size=(5, 3)), rng.normal(size=3)
    )
    for given in (whole, None):
        write_table(tmp_path / "inertial.parquet", inertial_columns(given), {}, PLACES)
        back = inertial_of(read_table(tmp_path / "inertial.parquet")[0])
        assert (back is None) == (given is None)
        for name in Inertial.__dataclass_fields__ if back is not None else ():
            np.testing.assert_array_equal(getattr(back, name), getattr(whole, name))


def test_a_calibration_that_cannot_be_has_no_pose_and_a_reason() -> None:
    made = refused([Station("master", 11), Station("slave", 12)], "sweeps on 3 diodes")
    assert made.document["poses"] == [] and made.document["chosen"] is None
    assert (made.verdict.word, made.verdict.why_none) == ("failed", "sweeps on 3 diodes")
    assert made.document["stations"]["slave"]["id"] == 12
