"""Positions that stay the same from frame to frame, and distances within solved rigid bodies."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.io.read import read_recording
from mocap_metrology.noise.diagnosis.software import repeats, solved_pairs

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


def test_one_stretch_some_frames_and_a_doubled_rate_are_found() -> None:
    """Single repeats from a thousandth of the frames on. What the marker does when it leaves one,
    along the coordinate that does most (median)."""
    found = repeats("A", held(still(1), range(5000, 5001), 36), STEP)
    assert found is not None and found.longest == 36 and found.share == 36 / N
    found = repeats("A", np.repeat(still(2, N // 2), 2, axis=1), STEP)
    assert found is not None and found.longest == 1 and found.share == pytest.approx(0.5, abs=1e-3)
    for count, named in ((12, False), (13, True)):
        starts = range(500, 500 + 300 * count, 300)
        position = held(still(3) * [[1], [1], [2]], starts, 1)
        found = repeats("A", position, STEP)
        assert (found is not None) is named
    steps = np.abs(np.diff(position.astype(float)))
    leaves = [[axis[k + 1] for k in starts] for axis in steps]
    assert found is not None and found.change_mm == pytest.approx(np.median(leaves, axis=1).max())


@pytest.mark.parametrize(("count", "named"), [(100, False), (200, True)])
def test_single_repeats_of_a_coarse_file_are_named_from_four_times_chance(
    count: int, named: bool
) -> None:
    """Chance: the product over x, y, z of the step of the file over what the marker does. 100
    repeats are twice, 200 more than four times as many."""
    starts = range(100, N - 100, (N - 200) // count)
    assert (repeats("A", held(still(5), starts, 1), 0.004) is not None) is named


@pytest.mark.parametrize("step", [1e-4, 0.01, 0.05, 0.1, 0.3, 1 / 12])
@pytest.mark.parametrize("told", [True, False])
def test_steps_of_a_file_make_no_repeats(step: float, told: bool) -> None:
    """Coarse files repeat by themselves, also where they do not say their steps."""
    for position in (still(3), 0.2 * still(4), walking() * [[0.001], [0.001], [1.0]]):
        coarse = step * np.round(position / step)
        assert repeats("A", coarse, step if told else STEP) is None


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


def test_of_a_few_frames_no_distance_is_solved() -> None:
    """Of three, one distance in ten of markers that are measured apart changes by as little."""
    for seed in range(100):
        apart = np.random.default_rng(seed).normal(0, 0.05, (3, 3, 3)) + PLACES
        assert solved_pairs(coordinates(apart), [(1, 2), (1, 3)]) == {}


PLACES = np.array([[0.0, 0, 0], [80, 10, 0], [20, 60, 5]])  # mm, of three markers of a body


def coordinates(position: np.ndarray) -> dict[str, np.ndarray]:
    """Of (n, markers, 3) mm."""
    return {f"{a}{k + 1}": position[:, k, i] for k in range(3) for i, a in enumerate("xyz")}


def solved(rng: np.random.Generator, step_mm: float = 0.0) -> np.ndarray:
    """Markers of a body whose pose has noise of 0.05 mm and 0.5 mrad."""
    R = Rotation.from_rotvec(rng.normal(0, 5e-4, (4000, 3))).as_matrix()
    found = PLACES @ R.transpose(0, 2, 1) + rng.normal(0, 0.05, (4000, 1, 3)) + [500, 900, 1200]
    return np.round(found / step_mm) * step_mm if step_mm else found


@pytest.mark.parametrize("step_mm", [0.0, 0.001, 0.01])
def test_markers_of_a_solved_body_keep_their_distance(step_mm: float) -> None:
    found = solved_pairs(coordinates(solved(np.random.default_rng(1), step_mm)), [(1, 2), (1, 3)])
    assert list(found) == ["L", "L_1_3"] and max(found.values()) < 0.01


def test_without_two_frames_in_a_row_no_distance_is_kept(recwarn: pytest.WarningsRecorder) -> None:
    position = solved(np.random.default_rng(1))
    position[::2] = np.nan
    assert solved_pairs(coordinates(position), [(1, 2)]) == {} and not recwarn.list
