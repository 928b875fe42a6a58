"""A dump read back by a plain loop over its words."""

from __future__ import annotations

import numpy as np
import pytest
from mocap_workflow.calibration_twins import twin_from_mapping

from mocap_metrology.lighthouse.records import Pulses
from mocap_metrology.lighthouse.simulate.recording import simulate, words_of, write_dump

TWIN = {
    "seed": 9,
    "master": {"id": 11, "mode": "b"},
    "slave": {"id": 12, "mode": "c", "position_m": [0.4, 2.2, 0.1], "rotation_deg": [8, 3, -40]},
    "motion": {"pattern": "hand", "centre_m": [3, 0.8, -0.1]},
    "duration_s": 0.2,
    "start_cycle": 1.31,
    "reflections": 0.05,
    "common_urad": 53,
}


def runs_of(words, diode):
    """First sample and length of light on a diode, sample by sample."""
    runs, since = [], None
    for k, lit in enumerate([*((words >> np.uint32(diode)) & 1).tolist(), 0]):
        if lit and since is None:
            since = k
        elif not lit and since is not None:
            runs.append((since, k - since))
            since = None
    return runs


def expected_runs(pulses, diode, n):
    """Samples k with start <= k/2e6 < end of any pulse, by set arithmetic on exact floats."""
    own = pulses.diode == diode
    ends = pulses.start_s[own] + pulses.length_s[own]
    lit = set()
    for start, end in zip(pulses.start_s[own], ends, strict=True):
        near = range(max(int(start * 2e6) - 2, 0), min(int(end * 2e6) + 3, n))
        lit |= {k for k in near if start <= k / 2e6 < end}
    return lit


def test_words_are_the_pulses_bit_by_bit(tmp_path):
    made = simulate(twin_from_mapping(TWIN))
    write_dump(tmp_path / "dump.bin", made.pulses)
    words = np.fromfile(tmp_path / "dump.bin", dtype="<u4")
    assert words.size == 400_000
    for diode in (0, 13, 31):
        runs = runs_of(words, diode)
        lit = {k for first, length in runs for k in range(first, first + length)}
        assert lit == expected_runs(made.pulses, diode, words.size)
        assert runs[0][0] > 0 or made.pulses.start_s.min() <= 0
    assert [f.name for f in tmp_path.iterdir()] == ["dump.bin"]


def test_far_sweeps_are_two_or_three_samples_wide():
    far = {**TWIN, "motion": {"pattern": "still", "centre_m": [5.9, 1.0, 0]}, "reflections": 0}
    made = simulate(twin_from_mapping(far))
    lengths = np.array([n for _, n in runs_of(words_of(made.pulses), 5)])
    assert set(lengths[lengths < 50]) <= {2, 3}


@pytest.mark.parametrize(
    ("start", "length", "samples"),
    [
        (1e-6, 1e-6, [2, 3]),  # edges on samples: the first is lit, the last is not
        (1.2e-6, 1e-6, [3, 4]),
        (-3e-6, 4.1e-6, [0, 1, 2]),  # begun before the recording
        (9.4e-6, 5e-6, [19]),  # cut off by its end
        (2.1e-6, 0.3e-6, []),  # between two samples
    ],
)
def test_edges_by_hand(start, length, samples):
    one = Pulses(np.array([start]), np.array([length]), np.array([31]), 32, 10e-6, 0.0)
    words = words_of(one)
    assert words.size == 20
    assert np.flatnonzero(words).tolist() == samples
    assert set(words[words > 0].tolist()) <= {2**31}


def test_pulses_on_one_diode_merge():
    start, length = np.array([1e-6, 2e-6]), np.array([3e-6, 4e-6])
    words = words_of(Pulses(start, length, np.array([0, 0]), 1, 10e-6, 0.0))
    assert runs_of(words, 0) == [(2, 10)]


def test_memory_of_the_board_full():
    none = np.zeros(0)
    assert words_of(Pulses(none, none, none, 32, 8.388608, 0.0)).size == 16_777_216
