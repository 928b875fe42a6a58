"""Diodes that decide a still board's pose against all others."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.lighthouse.calibrate.static import without_bad
from mocap_metrology.lighthouse.records import Measurements
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters

BOARD = np.array([[0.02 * (k % 3), 0.06 * (k % 4), 0.05 * (k // 4)] for k in range(12)])
IDEAL = rotor_parameters()
R = Rotation.from_euler("zyx", [170.0, 12.0, -8.0], degrees=True).as_matrix()
SIGMA = 5e-5


def measured(seed: int, n: int = 12, off: dict[int, float] | None = None) -> Measurements:
    """Angles of n diodes with noise; some are off by so many standard deviations."""
    seen = angles(np.ascontiguousarray(BOARD @ R.T + [2.5, 0.3, -0.2]), IDEAL)
    seen = seen + SIGMA * np.random.default_rng(seed).standard_normal(seen.shape)
    seen[n:] = np.nan
    for diode, size in (off or {}).items():
        seen[diode] += size * SIGMA
    return Measurements(np.zeros(1), seen[None])


@pytest.mark.parametrize("n", [6, 7, 12])
def test_one_in_a_hundred_loses_a_diode_by_chance(n: int) -> None:
    """Of 200 without a bad one four or fewer, three standard errors and the bound of Bonferroni;
    of fewer degrees of freedom the same."""
    lost = [without_bad(measured(seed, n), BOARD, IDEAL)[1] for seed in range(200)]
    assert sum(map(bool, lost)) <= 2 + 3 * np.sqrt(2)


@pytest.mark.parametrize("off", [{4: 30.0}, {4: 30.0, 9: -40.0}, {0: 400.0, 5: 100.0, 7: 80.0}])
def test_those_off_are_left_out_up_to_a_quarter(off: dict[int, float]) -> None:
    found = [without_bad(measured(seed, off=off), BOARD, IDEAL) for seed in range(10)]
    assert [bad for _, bad in found] == [tuple(off)] * 10
    kept = np.isfinite(found[0][0].angles_rad[0]).all(axis=1)
    assert np.flatnonzero(~kept).tolist() == list(off)
