"""Medians of five frames against scipy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import median_filter

from mocap_metrology.noise.diagnosis.outliers import medians_of_five


@pytest.mark.parametrize("kind", [np.float32, np.float64])
@pytest.mark.parametrize("n", [1, 4, 5, 6, 7, 1000])
def test_medians_of_five_are_those_of_scipy(n: int, kind: type) -> None:
    """With equal samples, with infinite ones, and with gaps."""
    draw = np.random.default_rng(n)
    series = draw.normal(size=n).round(1).astype(kind)
    infinite, gaps = series.copy(), series.copy()
    infinite[draw.random(n) < 0.1] = np.inf
    gaps[draw.random(n) < 0.1] = np.nan
    for given in (series, infinite, gaps):
        found = medians_of_five(given)
        assert found.dtype == kind
        np.testing.assert_array_equal(found, median_filter(given, 5))
