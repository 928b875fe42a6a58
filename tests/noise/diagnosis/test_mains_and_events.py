"""Mains that a frame rate folds, and the time round bursts, by hand."""

from __future__ import annotations

from types import SimpleNamespace as Event

import numpy as np
import pytest

from mocap_metrology.noise.diagnosis.events import inside_events
from mocap_metrology.noise.diagnosis.periodic import mains_of


@pytest.mark.parametrize(
    ("f_0", "rate", "true", "mains"),
    [
        (50.0, 1000.0, 50.0, 50.0),
        (120.0, 1000.0, 120.0, 60.0),
        (200.0, 1000.0, 200.0, 50.0),
        (240.0, 1000.0, 240.0, 60.0),
        (20.0, 120.0, 100.0, 50.0),  # folded: 120 - 100
        (30.0, 70.0, 100.0, 50.0),
        (48.0, 98.0, 50.0, 50.0),
        (20.0, 100.0, 120.0, 60.0),
        (250.0, 1000.0, None, None),  # the fifth harmonic
        (45.0, 1000.0, None, None),
        (0.9, 49.1, None, None),  # so slow a line may be anything
    ],
)
def test_mains_and_lamps_that_would_show(f_0, rate, true, mains) -> None:
    found = mains_of(f_0, rate, 0.0)
    assert (found and (found.f_hz, found.mains_hz)) == (true and (true, mains))
    if found and true is not None:
        assert found.folded_at_hz == (rate if true > rate / 2 else None)


def test_pieces_in_a_burst_or_within_a_second_of_it() -> None:
    burst = Event(kind="burst", time_s=10.2, stop_s=12.3)
    early = Event(kind="burst", time_s=0.4, stop_s=0.5)
    level = Event(kind="level", time_s=20.0, stop_s=20.0)
    assert np.flatnonzero(inside_events([burst, level], 40, 1.0)).tolist() == [9, 10, 11, 12, 13]
    assert np.flatnonzero(inside_events([burst], 40, 0.5)).tolist() == list(range(18, 27))
    assert np.flatnonzero(inside_events([early], 40, 1.0)).tolist() == [0, 1]
    assert not inside_events([], 40, 1.0).any()
    assert inside_events([burst], 12, 1.0).sum() == 3
