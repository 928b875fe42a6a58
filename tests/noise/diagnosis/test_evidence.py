"""What supports a diagnosis: the event or window that shows best, the surest line, both halves."""

from __future__ import annotations

import math
from types import SimpleNamespace as Some

import numpy as np
import pytest

from mocap_metrology.noise.diagnosis import evidence
from mocap_metrology.noise.diagnosis.levels import blocks


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


def test_without_an_event_the_window_that_noise_explains_least() -> None:
    """Chance: of n windows one as unusual has a probability of n exp(-x)."""
    quiet = Some(x=np.array([1.0, 2.0]), hop_s=0.5, window_s=1.0, tau_s=0.01)
    loud = Some(x=np.array([0.0, 1.0, 0.5, 7.0]), hop_s=0.25, window_s=2.0, tau_s=0.08)
    both = found(dynamics={"x1": [quiet], "L": [quiet, loud]}, n_windows=10)
    view = evidence.view_of(both, None)
    assert (view.kind, view.series, view.first_s, view.last_s) == ("window", "L", 0.75, 2.75)
    assert (view.tau_s, view.chance) == (0.08, pytest.approx(10 * math.exp(-7.0)))
    only = evidence.view_of(found(dynamics={"x1": [quiet]}, n_windows=10), None)
    assert (only.first_s, only.chance) == (0.5, 1.0)
    assert evidence.view_of(found(dynamics={"x1": []}, n_windows=0), None) is None


def test_a_line_that_shows_in_the_allan_deviation_comes_first() -> None:
    lines = [
        Some(in_adev=shows, line=Some(gain=gain), series=name)
        for shows, gain, name in ((False, 90.0, "x1"), (True, 5.0, "y1"), (True, 8.0, "z1"))
    ]
    assert evidence.series_of_surest_line(found(lines=lines)) == "z1"
    assert evidence.series_of_surest_line(found(lines=lines[:1])) == "x1"
    assert evidence.series_of_surest_line(found(lines=[])) is None


def test_halves_are_compared_by_their_noise() -> None:
    """Twice the noise from the middle on, in one of two series; 120 s each."""
    rng, n = np.random.default_rng(4), 6000
    x, y = rng.standard_normal((2, 2 * n))
    x[n:] *= 2
    levels = {"x1": blocks(x, 100.0), "y1": blocks(y, 100.0)}
    first, second = evidence.halves(found(levels=levels), 2 * n / 100)
    assert first.ratio == pytest.approx(2.0, rel=0.03)
    assert first.changed and not second.changed
    assert second.lower < 1 < second.upper
    assert evidence.halves(found(levels={}), 10.0) == ()


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
