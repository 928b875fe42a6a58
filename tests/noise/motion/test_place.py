"""Noise by place: of a few frames by hand, scipy's tests, and Monte Carlo."""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.signal import butter, lfilter

from mocap_metrology.noise.motion.place import Visits, by_place, evenness, freedom


def carried(rng: np.random.Generator, sigma: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
    time = np.arange(6000) / 100
    middle = np.stack([800 * np.sin(time / 3), 500 * np.cos(time / 2), 0 * time + 1000])
    return middle, 300 + sigma * rng.standard_normal(time.size)


def low_pass(cut_hz: float) -> np.ndarray:
    """Impulse response (500,) of a Butterworth filter of second order at 100 Hz."""
    return lfilter(*butter(2, cut_hz / 50), np.eye(1, 500)[0])


@pytest.mark.parametrize("taps", [[1.0], low_pass(6.0)], ids=range(2))
def test_even_volumes_look_even(taps: np.ndarray) -> None:
    """150 recordings of equal noise, white or low-pass filtered: 95 % intervals hold in 92 to 98 %,
    p < 0.05 in 10 % at most, of white noise 2 % at least; the true Allan deviation by the filter's
    response."""
    rng = np.random.default_rng(4)
    truth = 0.1 * np.sqrt(np.sum(np.diff(taps, prepend=0, append=0) ** 2) / 2)
    held, alarms = [], 0
    for _ in range(150):
        middle, white = carried(rng, 0.1)
        rows, visits = by_place(middle, np.convolve(white - 300, taps)[: white.size], 250.0)
        held += [row["lower_mm"] < truth < row["upper_mm"] for row in rows]
        alarms += evenness(rows, visits)["p"] < 0.05
    assert 0.92 < np.mean(held) < 0.98
    assert (0.02 if len(taps) == 1 else 0) <= alarms / 150 <= 0.1


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


@pytest.mark.parametrize(
    ("kind", "least", "most"), [("bursts", 0, 4), ("t", 0, 4), ("place", 38, 40)]
)
def test_bursts_are_no_places(kind: str, least: int, most: int) -> None:
    """40 recordings with three bursts, or noise with Student's t distribution, or of twice the
    noise where x > 300 mm: p < 0.01 (Bartlett's test of the cells: in all of each)."""
    rng, found = np.random.default_rng(8), 0
    for _ in range(40):
        middle, length = carried(rng, 0.1)
        noise = 0.06 * rng.standard_t(3, length.size) if kind == "t" else length - 300
        for start in rng.integers(0, length.size - 200, 3 * (kind == "bursts")):
            noise[start : start + 200] *= 5
        noise[middle[0] > 300] *= 2 if kind == "place" else 1
        found += evenness(*by_place(middle, 300 + noise, 500.0))["p"] < 0.01
    assert least <= found <= most


def test_evenness_is_a_one_way_analysis_of_variance() -> None:
    """Of the logarithms of the visits' variances, by scipy; a visit of nine pairs is too short."""
    rng = np.random.default_rng(2)
    logs = [rng.normal(m, 0.3, n) for m, n in ((0.0, 4), (0.3, 6), (-0.1, 5))]
    rows = [{"sigma_mm": np.exp(one.mean() / 2), "deviation_mm": one.mean()} for one in logs]
    cell = np.repeat([0, 1, 2], [len(one) for one in logs])
    pairs, short = rng.integers(10, 90, cell.size), (1, 9, 900.0)
    columns = cell, pairs, pairs * np.exp(np.concatenate(logs))
    visits = Visits(*(np.append(a, b) for a, b in zip(columns, short, strict=True)))
    assert evenness(rows, visits)["p"] == pytest.approx(stats.f_oneway(*logs).pvalue)
    once = Visits(*(column[[0, 4, 10]] for column in columns))
    assert math.isnan(evenness(rows, once)["p"]) and once.dispersion(1.0) == 1.0
    assert all(map(math.isnan, evenness(rows[:1], visits).values()))
    rows[0]["sigma_mm"] = 0.0
    assert math.isnan(evenness(rows, visits)["p"])
    assert evenness(rows, visits)["worst_over_best"] == math.inf


LENGTHS = np.array([1.0, 3, 2, 8, 4, 4, 7, np.nan, 5, 6])
X = np.array([5.0, 6, 7, 55, 56, 57, 58, 59, 9, 8])


def test_cells_their_pairs_and_their_means() -> None:
    """Of 50 mm: frames 0 to 2 and 8, 9 in the first, 3 to 6 in the second; pairs within a cell
    alone, none over a gap; deviations from the mean of all nine."""
    middle = np.array([X, 0 * X - 1, 0 * X + 120])
    (first, second), visits = by_place(middle, LENGTHS, 50.0, least=3)
    assert [first[f"{axis}_mm"] for axis in "xyz"] == [25.0, -25.0, 125.0]
    assert [second[f"{axis}_mm"] for axis in "xyz"] == [75.0, -25.0, 125.0]
    assert (first["n_frames"], first["n_pairs"]) == (5, 3)
    assert (second["n_frames"], second["n_pairs"]) == (4, 3)
    assert first["sigma_mm"] == pytest.approx(np.sqrt((4 + 1 + 1) / 6))
    assert second["sigma_mm"] == pytest.approx(np.sqrt((16 + 0 + 9) / 6))
    overall = np.nanmean(LENGTHS)
    assert first["deviation_mm"] == pytest.approx(17 / 5 - overall)
    assert second["deviation_mm"] == pytest.approx(23 / 4 - overall)
    bend = evenness([first, second], visits)["bend_mm"]  # their distance over sqrt(2)
    assert bend == pytest.approx((23 / 4 - 17 / 5) / np.sqrt(2))
    assert by_place(middle, LENGTHS, 50.0, least=4)[0] == []
    assert by_place(middle * np.nan, LENGTHS, 50.0, least=1)[0] == []
