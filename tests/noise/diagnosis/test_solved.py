"""Distances within rigid bodies that the software solved."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.noise.diagnosis.repeats import solved_pairs

N = 4000
PLACES = np.array([[0.0, 0, 0], [80, 10, 0], [20, 60, 5]])  # mm, of three markers of a body


def coordinates(position: np.ndarray) -> dict[str, np.ndarray]:
    """Of (n, markers, 3) mm."""
    return {f"{a}{k + 1}": position[:, k, i] for k in range(3) for i, a in enumerate("xyz")}


def solved(rng: np.random.Generator, step_mm: float = 0.0) -> np.ndarray:
    """Markers of a body whose pose has noise of 0.05 mm and 0.5 mrad."""
    R = Rotation.from_rotvec(rng.normal(0, 5e-4, (N, 3))).as_matrix()
    found = PLACES @ R.transpose(0, 2, 1) + rng.normal(0, 0.05, (N, 1, 3)) + [500, 900, 1200]
    return np.round(found / step_mm) * step_mm if step_mm else found


@pytest.mark.parametrize("step_mm", [0.0, 0.001, 0.01])
def test_markers_of_a_solved_body_keep_their_distance(step_mm: float) -> None:
    found = solved_pairs(coordinates(solved(np.random.default_rng(1), step_mm)), [(1, 2), (1, 3)])
    assert list(found) == ["L", "L_1_3"] and max(found.values()) < 0.01


def test_measured_markers_and_those_with_common_noise_do_not() -> None:
    """Of a common noise as large as that of each the ratio is a half."""
    rng = np.random.default_rng(2)
    measured = PLACES + rng.normal(0, 0.05, (N, 3, 3))
    assert solved_pairs(coordinates(measured), [(1, 2), (1, 3)]) == {}
    shaken = measured + rng.normal(0, 0.2, (N, 1, 3))
    assert solved_pairs(coordinates(shaken), [(1, 2)]) == {}


def test_gaps_and_markers_at_one_place() -> None:
    rng = np.random.default_rng(3)
    found = coordinates(solved(rng))
    found["x1"][rng.random(N) < 0.3] = np.nan
    assert list(solved_pairs(found, [(1, 2)])) == ["L"]
    assert solved_pairs({k: np.full(N, np.nan) for k in found}, [(1, 2)]) == {}
    same = coordinates(np.repeat(solved(rng)[:, :1], 3, axis=1))
    assert solved_pairs(same, [(1, 2)]) == {}
