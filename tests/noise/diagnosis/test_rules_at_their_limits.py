"""Rules of a diagnosis at their limits, one at a time."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from mocap_metrology.noise.diagnosis.export import bands
from mocap_metrology.noise.diagnosis.filtering import averaging, filters
from mocap_metrology.noise.diagnosis.levels import Blocks, blocks, compare, trends
from mocap_metrology.noise.diagnosis.software import processed

RATE = 200.0


def names(cutoffs: list[float], lines: list[float], width: float) -> list[str]:
    return [one.name for one in filters(RATE, cutoffs, lines, width)]


def test_low_passes_well_below_nyquist_and_notches_that_have_room() -> None:
    """Below 0.95 of 100 Hz; a notch, as wide as its frequency at most, ends below 100 Hz."""
    assert names([10.0, 94.9, 95.0, 120.0], [], 1.0) == [
        "none", "Butterworth 10 Hz", "Butterworth 94.9 Hz"
    ]  # fmt: skip
    assert names([], [50.0, 99.4, 99.5, 99.6], 1.0)[1:] == ["notch 50 Hz", "notch 99.4 Hz"]
    assert names([], [66.0, 67.0], 500.0)[1:] == ["notch 66 Hz"]
    notch = filters(RATE, [], [50.0], 4.0)[1]
    assert notch.gain(np.array([48.0, 50.0, 52.0]), RATE) == pytest.approx([0.5, 0, 0.5], abs=0.03)
    low = filters(RATE, [20.0], [], 4.0)[1]
    assert low.gain(np.array([0.0, 20.0]), RATE) == pytest.approx([1.0, 0.5])


def test_averaging_times_of_a_filter_end_at_a_tenth_of_the_recording() -> None:
    m = averaging(5000, RATE)
    assert (m[0], m[-1]) == (1, 500)
    assert (np.diff(m) > 0).all()
    assert averaging(9, RATE).tolist() == [1]


def some(sd: float, n: int, seed: int = 0) -> Blocks:
    return blocks(sd * np.random.default_rng(seed).standard_normal(100 * n), 100.0)


def test_sides_without_noise_are_not_compared() -> None:
    still = Blocks(np.zeros(30), np.zeros(30), 1.0)
    for before, after in ((still, some(1, 30)), (some(1, 30), still)):
        assert compare("x1", before, after, 0.01).word == "unknown"


def test_blocks_with_half_of_their_samples() -> None:
    x = np.arange(300.0)
    x[100:150], x[200:251] = np.nan, np.nan
    found = blocks(x, 100.0)
    assert found.mean.tolist()[:2] == [49.5, 174.5]
    for block, n in enumerate((100.0, 50.0)):
        assert found.variance[block] == pytest.approx(np.var(np.arange(n), ddof=1))
    assert np.isnan(found.mean[2]) and np.isnan(found.variance[2])
    assert found.between(1.0, 3.0).mean.size == 1
    assert found.between(0.0, 2.0).mean.size == 2
    assert found.between(0.0, 1.9).mean.size == 1


@pytest.mark.parametrize(("n_smooth", "is_told"), [(1, False), (2, True), (4, True)])
def test_software_is_told_of_where_half_of_the_coordinates_agree(n_smooth, is_told) -> None:
    rng = np.random.default_rng(5)
    series = {f"{axis}{k}": rng.standard_normal(60_000) for k in (1, 2) for axis in "xy"}
    for name in list(series)[:n_smooth]:
        series[name] = lfilter([0.05], [1, -0.95], series[name])
    spectra = {name: bands(x, RATE) for name, x in series.items()}
    found = [one for one in processed(series, spectra, RATE, 0.0) if one.code == "smoothed"]
    assert [one.series for one in found] == (list(series)[:n_smooth] if is_told else [])


@pytest.mark.parametrize(("points", "is_told"), [(12, True), (11, False)])
def test_a_trend_of_noise_has_twelve_points(points: int, is_told: bool) -> None:
    """Means of ten blocks each; noise that grows tenfold."""
    n = 10 * points
    growing = np.geomspace(1, 10, 100 * n) * np.random.default_rng(6).standard_normal(100 * n)
    found = trends({"x1": blocks(growing, 100.0)}, np.zeros(n, bool), [])
    assert bool(found) == is_told
    if found:
        assert found[0].change == pytest.approx(9.0, rel=0.25)
        assert found[0].direction == "rises" and found[0].matters
