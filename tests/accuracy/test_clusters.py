"""Rigid clusters on a real sprint and on drawn bodies; slopes of scale by Monte Carlo."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from mocap_metrology.accuracy.clusters import rigid_clusters, scale_slope
from mocap_metrology.io.read import labels_of, read_recording

SPRINT = Path(__file__).parents[3] / "shared/data/metrology/kinematics_basket_sprint.c3d"


@pytest.mark.skipif(not SPRINT.exists(), reason="the recording of a sprint is not here")
def test_of_a_real_sprint() -> None:
    """Both bodies of the wheelchair, whole and first; nothing else in them. Their common slopes
    agree within their errors, 182 +- 82 and 106 +- 55 ppm/m elsewhere."""
    labels = labels_of(SPRINT)
    recording = read_recording([SPRINT], labels)
    start = time.process_time()
    found = rigid_clusters(recording.position_mm, 1.5)
    names = [{labels[k] for k in one.markers} for one in found]
    bodies = [{f"{body}:Marker{k}" for k in (1, 2, 3, 4)} for body in ("SWL", "WheelchairL")]
    assert names[:2] == bodies
    slopes = [scale_slope(recording.position_mm, one.markers) for one in found[:2]]
    assert time.process_time() - start < 4
    for slope in slopes:
        assert slope is not None
        print(slope)
