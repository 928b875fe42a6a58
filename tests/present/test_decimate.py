"""Decimation: extremes stay."""

from __future__ import annotations

import numpy as np
import pytest
from figure_data import (
    NINE_HOURS,
)

from mocap_metrology.present.plot.decimate import columns, log_bins, runs

pytestmark = pytest.mark.filterwarnings("error")


def test_columns_are_what_numpy_finds_one_by_one():
    rng = np.random.default_rng(2)
    values = 1e4 + rng.standard_normal(300_001)
    values[1000:1700], values[5], values[250_000] = np.nan, np.inf, np.nan
    found = columns(values, 883)
    assert found["first"].iloc[0] == 0 and found["stop"].iloc[-1] == values.size
    assert np.array_equal(found["first"][1:], found["stop"][:-1])
    for k in range(883):
        part = values[found["first"][k] : found["stop"][k]]
        part = part[np.isfinite(part)]
        assert found["n_valid"][k] == part.size
        if part.size:
            assert (found["low"][k], found["high"][k]) == (part.min(), part.max())
            assert found["mean"][k] == pytest.approx(part.mean(), abs=1e-9)
        else:
            assert found.loc[k, ["low", "high", "mean"]].isna().all()


@pytest.mark.parametrize("at", [0, 1_234_567, NINE_HOURS - 1])
def test_one_sample_in_nine_hours_is_kept(at):
    values = np.zeros(NINE_HOURS, dtype=np.float32)
    values[at] = 1
    found = columns(values, 900)
    column = at * 900 // NINE_HOURS
    assert found["high"][column] == 1 and np.count_nonzero(found["high"]) == 1
    assert found["mean"][column] == pytest.approx(1 / 4320, rel=1e-6)


def test_log_bins_keep_a_narrow_line_and_sparse_points():
    f_hz = np.arange(36_001) / 600
    psd = np.full(f_hz.size, 1e-5)
    psd[9_000] = 1.0  # 15 Hz
    bins = log_bins(f_hz, psd, 40)
    peak = int(np.argmax(bins.high))
    assert bins.high[peak] == 1.0 and abs(bins.centre[peak] / 15 - 1) < 0.06
    assert np.all(bins.median == 1e-5) and bins.centre.size < 200
    sparse = log_bins(f_hz[:10], np.arange(10.0), 40)
    assert np.allclose(sparse.centre, f_hz[1:10]) and np.array_equal(sparse.median, range(1, 10))


def test_runs():
    assert runs(np.array([1, 0, 1, 1], dtype=bool)).tolist() == [[0, 1], [2, 4]]
    assert runs(np.zeros(3, dtype=bool)).shape == (0, 2)
