"""Rows of gaussian.csv, and markers that move."""

import numpy as np
import pytest

from mocap_metrology.noise.gaussian.two_markers import drift, median_drift
from mocap_metrology.noise.motion.movement import most_moving, movements

STILL = (2.0, 3600.0)  # range_mm, horizon_s


def test_all_markers_that_move_are_found() -> None:
    t = np.arange(340) / 200
    walking = [np.stack([speed * t, 0 * t, 0 * t]) for speed in (1400.0, 1410.0, 1390.0)]
    found = most_moving(movements(dict(zip("ABC", walking, strict=True)), 200.0, *STILL))
    assert [(label, axis) for label, (axis, _) in found.items()] == [(name, "x") for name in "ABC"]
    assert max(found, key=lambda label: found[label][1].size_mm) == "B"
    assert 2300 < found["B"][1].size_mm < 2400


@pytest.mark.filterwarnings("error")
def test_wrong_samples_and_gaps_move_no_marker() -> None:
    """One of 1e9 mm in a second makes its mean 1e7 mm, and its median nothing."""
    still = 0.01 * np.random.default_rng(3).normal(size=(3, 6000))
    still[0, 1234] = 1e9
    still[1, 10::100] = -1e9
    assert drift(still[0], 100.0).range > 1e6
    assert most_moving(movements({"A": still}, 100.0, *STILL)) == {}
    still[2, 1000:4000] = np.nan
    still[2, 2000] = 1e9  # alone in its second
    still[:, ::2] = np.nan
    assert most_moving(movements({"A": still}, 100.0, *STILL)) == {}
    still[1, 3001:] += 3.0
    axis, most = most_moving(movements({"A": still}, 100.0, *STILL))["A"]
    assert (axis, most.size_mm) == ("y", pytest.approx(2.99, abs=0.005))
    assert most.time_s == pytest.approx(30.25, abs=0.005)
    assert most_moving(movements({"A": np.full((3, 500), np.nan)}, 100.0, *STILL)) == {}


@pytest.mark.parametrize("n", [0, 1, 2, 7, 30, 95, 1000])
def test_medians_as_numpy_makes_them(n: int) -> None:
    series = np.random.default_rng(n).normal(size=n)
    series[3::7] = np.nan
    found = median_drift(series, 20.0)
    width = round(found.block_s * 20)
    blocks = series[: n // width * width].reshape(-1, width)
    expected = np.ptp(np.nanmedian(blocks, axis=1)) if len(blocks) > 1 else np.nan
    assert found.range == pytest.approx(expected, nan_ok=True)
    assert width >= 5 or n < 10
