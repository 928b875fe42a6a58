"""Positions that stay exactly the same from frame to frame, in a real file and in made ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.io.read import read_recording
from mocap_metrology.noise.diagnosis.repeats import repeats

N, RATE = 12_000, 120.0
STEP = 1.5e-5  # of float32 near 200 mm


def still(seed: int = 0, n: int = N) -> np.ndarray:
    """Noise of a frame 0.05 mm, and a weak walk."""
    rng = np.random.default_rng(seed)
    walk = np.cumsum(rng.normal(0, 0.002, (3, n)), axis=1)
    return np.array([[100.0], [200.0], [150.0]]) + walk + rng.normal(0, 0.05, (3, n))


def walking(n: int = N) -> np.ndarray:
    """A gait trial: 1.2 m/s with swings, smooth as a filter leaves it."""
    t = np.arange(n) / RATE
    return np.stack([1200 * t, 60 * np.sin(5.6 * t), 900 + 40 * np.sin(11.2 * t)])


def held(position: np.ndarray, starts: range, frames: int) -> np.ndarray:
    out = position.copy()
    for first in starts:
        out[:, first + 1 : first + 1 + frames] = out[:, first : first + 1]
    return np.float32(out)


@pytest.mark.parametrize("seconds", [0.3, 0.7])
@pytest.mark.parametrize("moves", [False, True])
def test_held_stretches_are_found(seconds: float, moves: bool) -> None:
    frames = round(seconds * RATE)
    starts = range(1000, N - 1000, 2000)
    found = repeats("A", held(walking() if moves else still(), starts, frames), STEP)
    assert found is not None
    assert found.longest == frames
    assert found.share == pytest.approx(len(starts) * frames / N, rel=1e-3)


def test_one_held_stretch_in_a_long_recording_is_found() -> None:
    found = repeats("A", held(still(1), range(5000, 5001), 36), STEP)
    assert found is not None and found.longest == 36 and found.share == 36 / N


def test_a_rate_that_was_doubled_is_found() -> None:
    position = np.repeat(still(2, N // 2), 2, axis=1)
    found = repeats("A", position, STEP)
    assert found is not None and found.longest == 1 and found.share == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize("step", [1e-4, 0.01, 0.05, 0.1, 0.3, 1 / 12])
@pytest.mark.parametrize("told", [True, False])
def test_steps_of_a_file_make_no_repeats(step: float, told: bool) -> None:
    """Coarse files repeat by themselves, also where they do not say their steps."""
    for position in (still(3), 0.2 * still(4), walking() * [[0.001], [0.001], [1.0]]):
        coarse = step * np.round(position / step)
        assert repeats("A", coarse, step if told else STEP) is None


def test_stops_on_the_way_make_no_repeats_in_a_coarse_file() -> None:
    """A foot that stands between its steps is constant in steps of 0.1 mm."""
    t = np.arange(N) / RATE
    foot = 1200 * t - 190 * np.sin(2 * np.pi * t * 1200 / 1194)  # nearly stops once a second
    position = np.stack([foot, 0 * t + 50, 20 + 10 * np.cos(2 * np.pi * t)])
    assert repeats("A", 0.1 * np.round(position / 0.1), 0.1) is None


def test_clean_noise_and_gaps_make_no_repeats() -> None:
    position = np.float32(still(5))
    position[:, 200:300] = np.nan
    assert repeats("A", position, STEP) is None
    assert repeats("A", np.full((3, N), 5.0), STEP) is None
    assert repeats("A", np.full((3, N), np.nan), STEP) is None


def test_of_a_real_static_trial_whose_filter_held_positions(samples: Path) -> None:
    """A quarter of the frames of both heels are those before; of a real static trial of the same
    kind none is."""
    folder = samples / "c3d"
    path = folder / "btk_others/FunctionalStatic.c3d"
    recording = read_recording([path], ["LHEE", "RHEE"], second_opinion=False)
    for label, position, share in zip(
        recording.labels, recording.position_mm, (0.223, 0.268), strict=True
    ):
        found = repeats(label, position, recording.resolution_mm)
        assert found is not None and found.share == pytest.approx(share, abs=0.001)
        assert found.change_mm > 50 * recording.resolution_mm
    other = read_recording([folder / "btk_pig/PiG_Calibration3_FF.c3d"], ["LHEE"], None, False)
    assert repeats("LHEE", other.position_mm[0], other.resolution_mm) is None
