"""Frames that are off: medians by scipy, rules written out, tails of known kurtosis."""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.ndimage import median_filter

from mocap_metrology.common.hampel import hampel, own_step
from mocap_metrology.noise.diagnosis.one_series import multiples_of
from mocap_metrology.noise.diagnosis.outliers import (
    _dense_frames,
    drawn_in,
    heavy_tails,
    off_frames,
)

N = 60_000
MAD = 1.4826  # median absolute deviation to standard deviation


@pytest.mark.parametrize("size", [20.0, 3.5])
def test_heavy_tails_are_made_light_but_not_what_happened(size: float) -> None:
    """Alone, a frame is moved to three scales from the median of five; of many together none."""
    rng = np.random.default_rng(2)
    series = {f"{axis}1": rng.normal(0, 1, N) for axis in "xyz"}
    series["x1"][1000] = size
    for values in series.values():
        values[30_000:30_003] += 20
    found, distance = drawn_in(series), series["x1"] - median_filter(series["x1"], 5)
    reach = 3 * MAD * stats.median_abs_deviation(distance)
    moved = np.clip(distance, -reach, reach) - distance
    assert found["x1"][1000] == pytest.approx(series["x1"][1000] + moved[1000])
    alone = moved[:29_000] != 0
    assert (found["x1"][:29_000] != series["x1"][:29_000])[alone].mean() > 0.9
    for name, values in series.items():
        np.testing.assert_array_equal(found[name][30_000:30_003], values[30_000:30_003])


def test_heavy_tails_of_known_kurtosis() -> None:
    """Laplace: 3, of the differences of two half as much; an excess of 0.2 at least; a Gaussian,
    whatever its level: none. Student's t of blocks of 1000 differences, by scipy's kurtosis."""
    rng, time = np.random.default_rng(1), np.linspace(0, 1, N)
    series = rng.laplace(size=N)
    (found,) = heavy_tails({"x1": series}, 0.0)
    assert found.lower < 1.5 < found.upper
    rows = np.diff(series)[:59_000].reshape(59, 1000)
    excess = stats.kurtosis(rows, axis=1) + 6 / 1000
    reach = stats.t.ppf(0.975, 58) * excess.std(ddof=1) / math.sqrt(59)
    ends = [excess.mean(), excess.mean() - reach, excess.mean() + reach]
    assert [found.excess, found.lower, found.upper] == pytest.approx(ends)
    for n in (8000, 8001):  # eight blocks
        assert len(heavy_tails({"x1": series[:n]}, 0.0)) == (n == 8001)
    for dof, count in ((60.0, 0), (12.0, 1)):  # of a difference 3 / (dof - 4): 0.05, 0.38
        assert len(heavy_tails({"x1": rng.standard_t(dof, 4 * N)}, 0.0)) == count
    for seed in range(20):
        draw = np.random.default_rng(seed)
        level = np.where(time > 0.5, 3.0, 1.0)
        assert not heavy_tails({f"x{k}": level * draw.normal(size=N) for k in range(3)}, 1.5e-5)
    x = 0.05 * rng.normal(size=N)
    for silent in (np.round(x / 0.2) * 0.2, np.full(N, np.nan), np.full(N, 3.0)):
        assert not heavy_tails({"x1": silent}, 0.2)
    assert not heavy_tails({"x1": np.repeat(x[::2], 2)}, 1.5e-5)


def test_one_axis_in_coarse_steps_has_no_outliers() -> None:
    """Of Gaussian noise in steps of two standard deviations 0.27 % are two steps off the middle;
    the distances of the others are of one step."""
    rng = np.random.default_rng(7)
    x = 300 + 0.04 * np.round(0.02 * rng.standard_normal(50_000) / 0.04)
    assert own_step(np.float32(x)) == pytest.approx(0.04, rel=1e-3)
    assert own_step(np.float32(300 + 0.02 * rng.standard_normal(50_000))) == 0
    assert multiples_of(np.float32(x)) == pytest.approx(0.04, rel=1e-3)
    held, band = np.empty(50_000), 0.03  # a value is sent when it has changed by so much
    for k, value in enumerate(300 + 0.02 * rng.standard_normal(50_000)):
        held[k] = value if k == 0 or abs(value - held[k - 1]) > band else held[k - 1]
    assert own_step(held) > band and multiples_of(held) == 0
    assert off_frames(x, 6.0).size == 0
    assert hampel(x, 60, 6.0, resolution=own_step(x)).share == 0


@pytest.mark.parametrize("n", [3, 12, 29, 90, 200])
def test_a_few_gaussian_values_have_no_steps_and_no_outliers(n: int) -> None:
    """Of 300 series at most one by chance, which is how rare either is in six coordinates."""
    series = 0.05 * np.random.default_rng(n).standard_normal((300, n))
    assert sum(own_step(one) > 0 for one in series) <= 1
    assert sum(off_frames(one, 6.0).size > 0 for one in series) <= 1


def test_frames_of_a_loud_stretch_are_not_off() -> None:
    """Of Gaussian noise whose level falls at once one frame in 10^8 is; in either part one is. Nor
    are frames of Gaussian noise that each come twice."""
    x = np.random.default_rng(4).standard_normal(60_000)
    x[40_500:] /= 10
    assert off_frames(x, 6.0).size == 0
    x[[20_000, 50_000]] += 15
    assert off_frames(x, 6.0).tolist() == [20_000, 50_000]
    twice = np.float32(0.02 * np.repeat(np.random.default_rng(5).standard_normal(30_000), 2))
    assert off_frames(twice, 6.0, 1e-4).size == 0
    off = np.where(np.arange(10_000) % 200 == 50, 1, 0)  # of six series
    off[[2000, 5000]] = 2, 3  # which chance makes 0.1 and 1e-4 times [binomial]
    assert np.flatnonzero(_dense_frames(off, 6)).tolist() == [5000]


def test_tails_as_heavy_as_cauchy_are_drawn_in() -> None:
    """Of five clipped Cauchy values three are beyond three scales to one side in 1 %, which five
    cannot show; of fifteen eight are in 1 of 50 000 [binomial]."""
    rng = np.random.default_rng(5)
    series = {f"{axis}1": np.clip(rng.standard_cauchy(N), -20, 20) for axis in "xyz"}
    drawn = drawn_in(series)
    for values in drawn.values():
        assert np.mean(np.abs(values) > 8) < 1e-3 < 0.05 < np.mean(np.abs(series["x1"]) > 8)
    gaps = np.zeros(N, bool)
    gaps[rng.integers(0, N // 2, 300)] = True
    holes = {name: np.where(gaps, np.nan, values) for name, values in series.items()}
    for name, values in drawn_in(holes).items():  # as without, but near a gap and in the scale
        far = np.convolve(gaps, np.ones(31), "same") == 0
        np.testing.assert_allclose(values[far], drawn[name][far], rtol=0.02, atol=0.05)
