"""Parts of a figure of a fit: names with values, and the curve of a series with gaps."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.present.fits import parts as fit_parts

MAIN = "likelihood"


def test_a_line_that_wanders_is_named_with_its_width() -> None:
    values = {"h_0": 1e-4, "A_s": 0.015, "f_0": 50.0, "width_f": 0.018}
    rows = [
        {
            "parameter": name,
            "value": value,
            "std_error": value / 10,
            "status": "ok",
            "model": "sampled",
        }
        for name, value in values.items()
    ]
    fit = fit_parts.fit_of(MAIN, [row | {"estimator": MAIN} for row in rows])
    (line,) = [part for part in fit.parts if part.name == "sinusoid"]
    assert "$width_f$ 0.0180 Hz" in line.text
    assert "$A_s$ 0.0150 mm" in line.text


@pytest.mark.parametrize("share", [0.0, 0.3])
def test_the_curve_knows_how_long_its_series_is(share) -> None:
    rng = np.random.default_rng(1)
    series = rng.normal(size=5000)
    series[rng.random(5000) < share] = np.nan
    m = np.array([1, 10, 100, 1000])
    columns = {"m": m, "n_terms": allan_variance(series, m).n_terms}
    assert fit_parts.recorded_s(columns, 100.0) == pytest.approx(50)
    assert fit_parts.recorded_s({k: v[:0] for k, v in columns.items()}, 100.0) == 0
