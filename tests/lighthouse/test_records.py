"""Columns in which pulses, hits and poses are stored: units, quaternions, and the way back."""

import numpy as np

from mocap_metrology.lighthouse.assess.summary import refused
from mocap_metrology.lighthouse.records import (
    Hits,
    Station,
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


def test_a_calibration_that_cannot_be_has_no_pose_and_a_reason() -> None:
    made = refused([Station("master", 11), Station("slave", 12)], "sweeps on 3 diodes")
    assert made.document["poses"] == [] and made.document["chosen"] is None
    assert (made.verdict.word, made.verdict.why_none) == ("failed", "sweeps on 3 diodes")
    assert made.document["stations"]["slave"]["id"] == 12
