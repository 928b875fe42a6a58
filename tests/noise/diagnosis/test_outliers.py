"""Frames that are off: medians by scipy, rules written out, tails of known kurtosis."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from scipy.ndimage import median_filter

from mocap_metrology.noise.diagnosis.outliers import (
    drawn_in,
    heavy_tails,
    isolated,
    medians_of_five,
    off_frames,
    spread,
    without,
)

N = 60_000
MAD = 1.4826  # median absolute deviation to standard deviation


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("n", [1, 4, 5, 6, 7, 1000])
def test_medians_of_five_are_those_of_scipy(n: int, kind: type) -> None:
    """With equal samples, with infinite ones, and with gaps."""
    draw = np.random.default_rng(n)
    series = draw.normal(size=n).round(1).astype(kind)
    infinite, gaps = series.copy(), series.copy()
    infinite[draw.random(n) < 0.1] = np.inf
    gaps[draw.random(n) < 0.1] = np.nan
    for values in (series, infinite, gaps):
        found = medians_of_five(values)
        assert found.dtype == kind
        np.testing.assert_array_equal(found, median_filter(values, 5))


@pytest.mark.parametrize("walk", [0.0, 1.0])
def test_frames_that_are_off(walk: float) -> None:
    """Farther than so many scales from the median of five: that of these distances, or of steps
    over sqrt(2), or half a step of the file."""
    rng = np.random.default_rng(1)
    series = rng.normal(0, 1, 2000) + walk * np.cumsum(rng.normal(0, 2, 2000))
    assert spread(series) == pytest.approx(MAD * stats.median_abs_deviation(series))
    distance = series - median_filter(series, 5)
    of_steps = stats.median_abs_deviation(np.diff(series)) * MAD / math.sqrt(2)
    own = stats.median_abs_deviation(distance) * MAD
    for step in (0.0, 6.0):
        scale = max(own, of_steps, step / 2)
        expected = np.flatnonzero(np.abs(distance) > 2 * scale)
        np.testing.assert_array_equal(off_frames(series, 2.0, step), expected)
    assert off_frames(np.ones(50), 3.0).size == 0


FRAMES = st.lists(st.integers(0, 20), unique=True, max_size=8).map(sorted)


@given(FRAMES, FRAMES, FRAMES)
def test_isolated_frames_by_their_rule(x1: list[int], y1: list[int], x2: list[int]) -> None:
    """One or two frames long, no frame of another marker off within two frames."""
    off = {"x1": x1, "y1": y1, "x2": x2}
    found = isolated({k: np.array(v, int) for k, v in off.items()}, {"x1": 1, "y1": 1, "x2": 2})
    for name, frames in off.items():
        others = x2 if name != "x2" else {*x1, *y1}
        expected = []
        for f in frames:
            group = [f]
            while group[-1] + 1 in frames:
                group.append(group[-1] + 1)
            while group[0] - 1 in frames:
                group.insert(0, group[0] - 1)
            alone = all(abs(g - o) > 2 for g in group for o in others)
            expected += [f] if len(group) <= 2 and alone else []
        assert found[name].tolist() == expected


def test_straight_lines_over_frames_and_gaps_stay() -> None:
    series = np.arange(60.0) ** 2
    series[[30, 31]] = np.nan
    off = np.array([0, 10, 11, 29, 45])
    found, expected = without(series, off), series.copy()
    there = np.setdiff1d(np.flatnonzero(np.isfinite(series)), off)
    expected[off] = np.interp(off, there, series[there])
    np.testing.assert_allclose(found, expected)


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


@pytest.mark.parametrize("n", range(1, 12))
def test_a_handful_of_frames_keeps_its_length(n: int) -> None:
    """Shorter than the widest window, with a frame that is far off."""
    x = np.arange(n) % 2 * 1e-3
    x[n // 2] = 5.0
    drawn = drawn_in({"x1": x, "y1": x[::-1].copy()})
    assert [values.shape for values in drawn.values()] == [(n,), (n,)]
