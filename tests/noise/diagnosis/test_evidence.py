"""What supports a diagnosis: the event that shows best, its view, a broad peak."""

from __future__ import annotations

from types import SimpleNamespace as Some

import numpy as np
import pytest

from mocap_metrology.noise.diagnosis import evidence


def event(kind: str, size: float, p: float, time_s: float = 20.0) -> Some:
    return Some(kind=kind, size_mm=size, p=p, time_s=time_s, stop_s=time_s + 2, largest="y2")


def found(*events: Some, **more: object) -> Some:
    return Some(events=list(events), **more)


def test_the_largest_burst_comes_before_the_surest_change_of_level() -> None:
    small, large = event("burst", 0.1, 1e-9), event("burst", 0.4, 1e-3)
    sure, unsure = event("level", 9.0, 1e-8), event("level", 9.0, 1e-4)
    assert evidence.largest_event(found(sure, small, large)) is large
    assert evidence.largest_event(found(unsure, sure)) is sure
    assert evidence.largest_event(found()) is None


def test_views_of_events() -> None:
    burst = evidence.view_of(found(), event("burst", 0.1, 1e-9))
    assert (burst.kind, burst.series, burst.first_s, burst.last_s) == ("burst", "y2", 20.0, 22.0)
    assert burst.names == ["x2", "y2", "z2"]
    level = evidence.view_of(found(), event("level", 0.1, 1e-9))
    assert (level.kind, level.first_s, level.last_s) == ("level", 15.0, 25.0)
    assert evidence.View("level", "L_1_2", 0.0, 1.0).names == ["L_1_2"]


@pytest.mark.parametrize(
    ("height", "f_0", "seen"),
    [
        *((4.0, 10.0, True), (2.0, 10.0, False)),  # three times its surroundings
        *((4.0, 1.2, False), (4.0, 85.0, False)),  # too near to an end of the axis
    ],
)
def test_a_broad_peak_of_three_times_what_lies_around(height, f_0, seen) -> None:
    f = np.geomspace(1.0, 100.0, 300)
    peak = 1 + (height - 1) * (abs(np.log10(f / f_0)) < 0.08) + 0.05 * (abs(f / f_0 - 1.05) < 0.01)
    at = evidence.broad_peak(f, 1e-6 * peak)
    assert (at is not None) == seen
    if seen:
        assert at == pytest.approx(1.05 * f_0, rel=0.02)
    assert evidence.broad_peak(f, 0 * peak) is None
    assert evidence.broad_peak(f[:0], f[:0]) is None
