"""Noise by place, by Monte Carlo."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import butter, lfilter

from mocap_metrology.noise.motion.place import by_place, evenness, freedom


def carried(rng: np.random.Generator, sigma: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
    time = np.arange(6000) / 100
    middle = np.stack([800 * np.sin(time / 3), 500 * np.cos(time / 2), 0 * time + 1000])
    return middle, 300 + sigma * rng.standard_normal(time.size)


def test_even_volumes_look_even() -> None:
    """300 recordings of equal noise: 95 % intervals hold in 93 to 97 %, p < 0.05 in 2 to 9 %."""
    rng = np.random.default_rng(1)
    held = cells = alarms = 0
    for _ in range(300):
        rows = by_place(*carried(rng, 0.1), 250.0)
        held += sum(row["lower_mm"] < 0.1 < row["upper_mm"] for row in rows)
        cells += len(rows)
        alarms += evenness(rows)["p"] < 0.05
    assert 0.93 < held / cells < 0.97
    assert 0.02 < alarms / 300 < 0.09


def low_pass(cut_hz: float) -> np.ndarray:
    """Impulse response (500,) of a Butterworth filter of second order at 100 Hz."""
    return lfilter(*butter(2, cut_hz / 50), np.eye(1, 500)[0])


@pytest.mark.parametrize("cut_hz", [20.0, 6.0])
def test_filtered_even_volumes_look_even(cut_hz: float) -> None:
    """100 recordings of equal noise through a low-pass filter: p < 0.05 in 10 % at most (35 % and
    86 % if successive differences counted as those of white noise), 95 % intervals in 92 to 98 %;
    the true Allan deviation by the filter's response."""
    rng = np.random.default_rng(4)
    response = low_pass(cut_hz)
    truth = 0.1 * np.sqrt(np.sum(np.diff(response, prepend=0, append=0) ** 2) / 2)
    held, alarms = [], 0
    for _ in range(100):
        middle, white = carried(rng, 0.1)
        rows = by_place(middle, np.convolve(white - 300, response)[: white.size], 250.0)
        held += [row["lower_mm"] < truth < row["upper_mm"] for row in rows]
        alarms += evenness(rows)["p"] < 0.05
    assert 0.92 < np.mean(held) < 0.98
    assert alarms <= 10


@pytest.mark.parametrize("gaps", [False, True])
@pytest.mark.parametrize("taps", [[1.0], [1.0, 2.0, 1.0], low_pass(6.0)])
def test_degrees_of_freedom_of_a_difference(taps: np.ndarray, gaps: bool) -> None:
    """Of white noise through a filter, by its taps: 2/3 without one. 60,000 frames: to 5 %."""
    rng = np.random.default_rng(5)
    series = np.convolve(rng.standard_normal(60_000), taps)
    if gaps:
        series[rng.integers(0, series.size - 50, 200)[:, None] + np.arange(50)] = np.nan
    differences = np.diff(taps, prepend=0, append=0)
    rho = np.correlate(differences, differences, "full") / (differences @ differences)
    assert freedom(series) == pytest.approx(1 / np.sum(rho**2), rel=0.05)
    assert freedom(np.cumsum(rng.standard_normal(60_000))) == pytest.approx(1, rel=0.02)
    assert freedom(np.full(100, np.nan)) == freedom(np.ones(100)) == pytest.approx(2 / 3)


def test_noisy_and_bent_places_are_found() -> None:
    rng = np.random.default_rng(2)
    middle, length = carried(rng, 0.1)
    far = middle[0] > 250
    length[far] += 0.1 * rng.standard_normal(far.sum()) * np.sqrt(3) + 0.5
    rows = by_place(middle, length, 250.0)
    near = [row for row in rows if row["x_mm"] < 250]
    away = [row for row in rows if row["x_mm"] > 250]
    assert np.mean([row["sigma_mm"] for row in near]) < 0.11
    assert 0.18 < np.mean([row["sigma_mm"] for row in away]) < 0.22
    shift = np.mean([r["deviation_mm"] for r in away]) - np.mean([r["deviation_mm"] for r in near])
    assert abs(shift - 0.5) < 0.03
    even = evenness(rows)
    assert even["p"] < 1e-6 and even["worst_over_best"] > 1.7


def test_gaps_and_few_frames() -> None:
    rng = np.random.default_rng(3)
    middle, length = carried(rng, 0.1)
    assert by_place(middle, np.full_like(length, np.nan), 250.0) == []
    assert by_place(middle[:, :20], length[:20], 250.0) == []
    length[::2] = np.nan  # no two successive frames
    assert by_place(middle, length, 250.0) == []
