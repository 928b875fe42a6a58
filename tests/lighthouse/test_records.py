"""Columns in which pulses, hits and poses are stored: units, quaternions, and the way back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.common.files import read_table, write_table
from mocap_metrology.lighthouse.assess.summary import refused
from mocap_metrology.lighthouse.decode.chain import dropped_share
from mocap_metrology.lighthouse.records import (
    PLACES,
    PULSES_CODED,
    SWEEPS_CODED,
    Hits,
    Inertial,
    Pulses,
    Station,
    hits_of,
    inertial_columns,
    inertial_of,
    pose_columns,
    pulse_columns,
    sweep_columns,
)
from mocap_metrology.lighthouse.records import Path as BoardPath


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


def test_lengths_of_pulses_are_stored_in_microseconds(tmp_path: Path) -> None:
    pulses = Pulses(
        np.array([0.5, 0.75]), np.array([62.5e-6, 104e-6]), np.array([3, 0], np.int16), 32, 1, 5e-7
    )
    write_table(tmp_path / "pulses.parquet", pulse_columns(pulses), {}, PULSES_CODED)
    columns, _ = read_table(tmp_path / "pulses.parquet")
    assert {name: values.tolist() for name, values in columns.items()} == {
        "start_s": [0.5, 0.75],
        "length_us": [62.5, 104.0],
        "diode": [3, 0],
    }


def test_poses_are_stored_with_the_quaternions_of_their_matrices() -> None:
    """A quarter turn about z is (0, 0, sin 45°, cos 45°), a half turn about x (1, 0, 0, 0)."""
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    turned = np.stack([quarter, np.diag([1.0, -1, -1])])
    path = BoardPath(
        np.array([0.1, 0.2]),
        turned,
        np.array([[1.0, 2, 3], [4, 5, 6]]),
        np.array([1e-9, 2e-9]),
        np.array([40, 64]),
        np.array([5.0, np.inf]),
    )
    none = path.take(np.zeros(2, bool))
    columns = pose_columns(
        {("paper", "ideal"): (path, none), ("paper-lm", "factory"): (none, path)}
    )
    assert list(columns["estimator"]) == ["paper"] * 2 + ["paper-lm"] * 2
    assert list(columns["optics"]) == ["ideal"] * 2 + ["factory"] * 2
    assert columns["station"].tolist() == [0, 0, 1, 1]
    assert columns["y_m"].tolist() == [2, 5, 2, 5]
    assert columns["n_angles"].tolist() == [40, 64, 40, 64]
    quaternions = np.stack([columns[name] for name in ("qx", "qy", "qz", "qw")], axis=1)
    expected = np.array([[0, 0, 0.5**0.5, 0.5**0.5], [1, 0, 0, 0]])
    np.testing.assert_allclose(quaternions, np.tile(expected, (2, 1)), atol=1e-15)


def test_share_of_dropped_pulses() -> None:
    """Of 100 pulses on two diodes 80 are kept; a reason that nothing was dropped for is there."""
    found = dropped_share({"kept": [50, 30], "width": [4, 0], "too_long": [1, 15]})
    assert found == {
        "too_long": pytest.approx(0.16),
        "second_on_diode": 0.0,
        "width": pytest.approx(0.04),
        "sweep": 0.0,
        "still": 0.0,
    }
    assert set(dropped_share({}).values()) == {0.0}


def test_a_calibration_that_cannot_be_has_no_pose_and_a_reason() -> None:
    made = refused([Station("master", 11), Station("slave", 12)], "sweeps on 3 diodes")
    assert made.document["poses"] == [] and made.document["chosen"] is None
    assert (made.verdict.word, made.verdict.why_none) == ("failed", "sweeps on 3 diodes")
    assert made.document["stations"]["slave"]["id"] == 12
