"""What is lost or added: shares within four standard errors, times exactly."""

from __future__ import annotations

import numpy as np
import pytest
from mocap_workflow.calibration_twins import twin_from_mapping

from mocap_metrology.lighthouse.simulate.recording import simulate

TWIN = {
    "seed": 21,
    "master": {"id": 11, "mode": "b"},
    "slave": {"id": 12, "mode": "c", "position_m": [0.4, 2.2, 0.1], "rotation_deg": [8, 3, -40]},
    "motion": {"pattern": "still", "centre_m": [3, 0.8, -0.1]},
    "duration_s": 1.0,
}
FULL = 120 * 32


def made(**changes):
    return simulate(twin_from_mapping({**TWIN, **changes}))


def four_errors(share, n):
    return 4 * np.sqrt(share * (1 - share) / n)


def test_nothing_is_lost_without_faults():
    assert len(made().hits) == FULL


def test_dropouts():
    kept = len(made(dropout=0.2).hits) / FULL
    assert kept == pytest.approx(0.8, abs=four_errors(0.2, FULL))


def test_reflections_are_shorter_and_near_a_hit_of_the_same_diode():
    recording = made(reflections=0.1, dropout=0.3)
    sweeps = recording.pulses.length_s < 45e-6
    n = np.count_nonzero(sweeps) - len(recording.hits)
    assert n / FULL == pytest.approx(0.1, abs=four_errors(0.1, FULL))
    middle = recording.pulses.start_s[sweeps] + recording.pulses.length_s[sweeps] / 2
    direct = np.isin(np.round(middle, 12), np.round(recording.hits.time_s, 12))
    assert np.count_nonzero(~direct) == n
    whole = made().hits
    extra = np.flatnonzero(~direct)
    for i in extra[:50]:
        own = whole.diode == recording.pulses.diode[sweeps][i]
        nearest = np.abs(whole.time_s[own] - middle[i])
        assert 30e-6 <= nearest.min() <= 800e-6
        assert recording.pulses.length_s[sweeps][i] < 0.9 * whole.width_s.max() + 1e-12


def test_blocked_station_is_dark_and_the_other_is_not():
    recording = made(blocked=[[0, 0.2, 0.5]])
    hits, pulses = recording.hits, recording.pulses
    during = (hits.time_s > 0.2) & (hits.time_s < 0.5)
    assert set(hits.station[during]) == {1}
    assert set(hits.station[~during]) == {0, 1}
    flash = pulses.start_s[(pulses.length_s > 45e-6) & (pulses.diode == 0)]
    inside = flash[(flash >= 0.2) & (flash < 0.5)]
    assert inside.size == 36 and np.allclose(np.diff(inside), 400_000 / 48e6, atol=1e-8)


def test_occlusions_take_their_share():
    """Mean share of time 60/min x 0.2 s = 1 - exp(-0.2); 40 s, two stations."""
    recording = made(occlusions_per_min=60, occlusion_s=0.2, duration_s=40)
    share = 1 - len(recording.hits) / (40 * FULL)
    dark = 1 - np.exp(-0.2)
    assert share == pytest.approx(dark, abs=4 * np.sqrt(2 * 0.2**2 * 80) / 80)


def test_missed_and_false_flashes():
    recording = made(missed_flashes=0.2, duration_s=4)
    flash = (recording.pulses.length_s > 45e-6) & (recording.pulses.diode == 0)
    assert np.count_nonzero(flash) / 960 == pytest.approx(0.8, abs=four_errors(0.2, 960))
    extra = made(false_flashes_per_s=50, duration_s=4).pulses.start_s.size
    extra = (extra - made(duration_s=4).pulses.start_s.size) / 32
    assert extra == pytest.approx(200, abs=4 * np.sqrt(200))


def test_board_turned_away_sees_nothing():
    still = {**TWIN["motion"], "turn_deg": [0, 0, 120]}
    assert made(motion=still).pulses.start_s.size == 0


def test_diode_sees_up_to_its_incidence_and_the_laser_up_to_60_deg():
    wide = made(motion={"pattern": "still", "centre_m": [1.0, 1.75, 0], "turn_deg": [0, 0, 0]})
    assert 0 not in wide.hits.station[wide.hits.axis == 0]  # azimuth 60 deg: outside 4 ms + 60 deg
    narrow = made(incidence_deg=15)
    assert len(narrow.hits) < FULL / 2


def test_analogue_bias_is_of_flashes_alone():
    one, other = made(flash_bias_us=0), made(flash_bias_us=3)
    long = one.pulses.length_s > 45e-6
    assert np.allclose((other.pulses.length_s - one.pulses.length_s)[long], 3e-6)
    assert np.allclose((other.pulses.length_s - one.pulses.length_s)[~long], 0)
