"""Rows of gaussian.csv, and markers that move."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.noise.gaussian.two_markers import drift, gaussian_rows, median_drift
from mocap_metrology.noise.motion.movement import most_moving, movements
from mocap_metrology.noise.series import all_series, coordinate_names, pair_numbers

STILL = (2.0, 3600.0)  # range_mm, horizon_s


def recording(n_markers: int, n: int = 6000) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(1)
    start = 100.0 * np.arange(3 * n_markers)[:, None]
    values = start + 0.01 * rng.normal(size=(3 * n_markers, n))
    return dict(zip(coordinate_names(n_markers), values, strict=True))


def test_two_rows_a_pair():
    pairs = pair_numbers(["A", "B", "C"], [["A", "B"], ["C", "A"]])
    assert pairs == [(1, 2), (3, 1)]
    series = dict(all_series(recording(3), pairs))
    rows = gaussian_rows(series, ["A", "B", "C"], pairs, 120.0)
    assert [(r["pair"], r["marker_1"], r["axis"]) for r in rows] == [
        ("L", "A", "x"),
        ("L", "A", "pair"),
        ("L_3_1", "C", "x"),
        ("L_3_1", "C", "pair"),
    ]
    along = rows[1]
    assert along["mu_e_mm"] == pytest.approx(300 * np.sqrt(3), abs=0.001)
    assert along["sigma_C_mm"] == pytest.approx(along["sigma_L_mm"], rel=1e-3)
    assert along["chi2_p"] > 1e-3
    assert abs(along["drift_mm_per_h"]) < 1


def test_one_marker_has_no_distance():
    rows = gaussian_rows(recording(1), ["A"], [], 120.0)
    assert len(rows) == 1
    assert rows[0]["sigma_1_mm"] == pytest.approx(0.01, rel=0.05)
    assert np.isnan(rows[0]["mu_L_mm"])


def test_a_moving_marker_is_named():
    t = np.arange(12_000) / 120
    still, moving = np.zeros((3, 12_000)), np.zeros((3, 12_000))
    moving[1] = 0.1 * t  # 10 mm in all
    moving[0, 100] = np.nan
    assert most_moving(movements({"A": still}, 120.0, *STILL)) == {}
    found = most_moving(movements({"A": still, "B": moving}, 120.0, *STILL))
    ((label, (axis, most)),) = found.items()
    assert (label, axis) == ("B", "y")
    assert most.size_mm == pytest.approx(9.98, abs=0.005)
    assert np.isnan(most.time_s)  # it goes on


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
