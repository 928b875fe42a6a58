"""What supports a diagnosis: the event that shows best, its view, a broad peak."""

from types import SimpleNamespace as Some

import numpy as np

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
    windows = [Some(x=np.array([1.0, 9.0, 2.0]), hop_s=5.0, window_s=8.0, tau_s=0.1)]
    window = evidence.view_of(found(dynamics={"x1": windows}, n_windows=40), None)
    assert (window.first_s, window.last_s) == (5.0, 13.0)
    assert evidence.View("level", "L_1_2", 0.0, 1.0).names == ["L_1_2"]
