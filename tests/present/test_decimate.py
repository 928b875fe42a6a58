"""What a figure has room for: ranges and means of columns, outliers, limits, bins of spectra."""

import numpy as np
import pytest

from mocap_metrology.noise.trace import columns, trace_of
from mocap_metrology.present.plot.curves import log_bins

pytestmark = pytest.mark.filterwarnings("error")


def test_columns_are_what_numpy_finds_one_by_one():
    rng = np.random.default_rng(2)
    values = 1e4 + rng.standard_normal(300_001)
    values[1000:1700], values[5], values[250_000] = np.nan, np.inf, np.nan
    reduced = columns(values, 883)
    assert reduced["first"].iloc[0] == 0 and reduced["stop"].iloc[-1] == values.size
    assert np.array_equal(reduced["first"][1:], reduced["stop"][:-1])
    for row in reduced.itertuples():
        part = values[row.first : row.stop]
        part = part[np.isfinite(part)]
        assert row.n_valid == part.size
        expected = (part.min(), part.max(), part.mean()) if part.size else (np.nan,) * 3
        assert (row.low, row.high, row.mean) == pytest.approx(expected, abs=1e-9, nan_ok=True)
    assert len(columns(values[:7], 883)) == 7 and columns(values[:0], 883).empty


def trace(values, outlier=None, clean=None):
    outlier = np.zeros(values.size, bool) if outlier is None else outlier
    return trace_of("x1", values, values if clean is None else clean, outlier, 120.0, 600)


def test_outliers_and_samples_beyond_the_axis_are_counted():
    """White noise of 0.01 mm about 1 m: outliers of 5 and 7 sigma, one of 9 mm, a gap."""
    rng, n = np.random.default_rng(1), 12_000
    clean = 1000 + 0.01 * rng.standard_normal(n)
    clean[5000:5100] = np.nan
    raw, outlier = clean.copy(), np.zeros(n, bool)
    for at, size in ((100, 0.05), (200, 0.07), (300, 9.0)):
        raw[at], outlier[at] = 1000 + size, True
    one = trace(raw, outlier, clean)
    assert (one.n, one.n_missing, one.n_outliers) == (n, 100, 3)
    assert one.centre == pytest.approx(1000, abs=1e-3) and one.mean_s == 1 and len(one.means) == 100
    assert one.marked.index.tolist() == [200, 300]
    assert one.marked.to_numpy() == pytest.approx([0.07, 9.0], abs=1e-3)
    assert one.beyond == pytest.approx([9.0], abs=1e-3) and 0.07 < one.limits[1] < 0.12
    assert one.core == pytest.approx(0.07, rel=0.1)  # from the 1 to the 99 % quantile of ranges
    assert len(trace(clean[:900]).means) == 0 and trace(clean[:1200]).means["n_valid"].sum() == 1200


@pytest.mark.parametrize(
    ("values", "limits"),
    [
        (
            np.r_[0.0, 1.0, np.zeros(98)],
            (-0.0109, 0.0059),
        ),  # its 99 % quantile is 0.01, its mean too
        (np.full(5, 3.0), (-5e-4, 5e-4)),  # 1 µm at least
        (np.full(5, np.nan), (-5e-4, 5e-4)),
        (np.arange(11.0), (-5.6, 5.6)),  # 6 % on either side
    ],
)
def test_limits(values, limits):
    assert trace(values).limits == pytest.approx(limits)


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


def test_values_of_which_none_is_clean_are_drawn_as_they_are():
    raw = 1000 + np.random.default_rng(3).standard_normal(2000)
    one = trace(raw, np.ones(2000, bool), np.full(2000, np.nan))
    assert one.raw["low"].min() == raw.min() and one.raw["high"].max() == raw.max()
