"""A simulated take and its facility against normal equations, numerical derivatives, a non-linear
solver, and scipy's Wishart."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import yaml
from mocap_workflow.recording_twins import AnyTwin, recording_twin, take_twin_from_mapping
from scipy.optimize import least_squares

from benchmarks.failing_camera import wishart_blocks
from mocap_metrology.common.faults import Faults
from mocap_metrology.noise.cameras.diagnosis import additions, diagnose, moments
from mocap_metrology.noise.twins.take import (
    Facility,
    Take,
    TakeTwin,
    centroid_errors,
    facility,
    gain_matrices,
    jacobians,
    joint_covariance,
    motion,
    random_facility,
    simulate_take,
)
from tests.noise.model.textbook import allan_variance


def project(facility: Facility, points_mm: np.ndarray) -> np.ndarray:
    """(n, 2) pixels at which the cameras see one point (3,), or each its own (n, 3)."""
    seen = np.einsum("nij,nj->ni", facility.rotations, points_mm - facility.origins_mm)
    return facility.focal_px[:, None] * seen[:, :2] / seen[:, 2:]


def triangulate(
    facility: Facility, pixels: np.ndarray, subset: Sequence[int], start_mm: np.ndarray
) -> np.ndarray:
    """(3,) point with the least sum of squared residuals (two a camera). pixels: (n, 2)."""
    own = list(subset)

    def residual(point: np.ndarray) -> np.ndarray:
        return (project(facility, point)[own] - pixels[own]).ravel()

    return least_squares(residual, start_mm, x_scale=1.0, xtol=1e-15, ftol=1e-15, gtol=1e-15).x


LABELS = ("Wand1", "Wand2")
DRIFT = {"Wand1": (3.0, 0.0, -2.0)}
TAKE = Take("T40", 6, 5, 0.05, 0.2, h_m2=5e-8, drift_mm_per_h=DRIFT)
FEW = TakeTwin("few", TAKE, (2, 6, 3), 11, duration_s=5.0)
MANY = replace(FEW, name="many", camera_ids=(2, 6, 3, 1, 4))


@pytest.mark.parametrize("twin", [FEW, MANY])
def test_positions_solve_the_normal_equations_of_errors_that_subsets_share(twin) -> None:
    made, n = simulate_take(twin).position_mm, 600
    hall, _ = facility(TAKE)
    moved = motion(TAKE, LABELS, twin.seed, 120.0, n)
    for marker in (0, 1):
        rows = np.concatenate([jacobians(hall, marker)[i - 1] for i in twin.camera_ids])
        errors = [list(centroid_errors(TAKE, twin.seed, i, n))[marker] for i in twin.camera_ids]
        solved = np.linalg.lstsq(rows, np.concatenate(errors), rcond=None)[0]
        expected = hall.markers_mm[marker][:, None] + moved[marker] + solved
        assert np.abs(made[marker] - expected).max() < 1e-10


def test_covariance_of_subsets_is_that_of_the_formula() -> None:
    still = replace(TAKE, h_m2=0.0, drift_mm_per_h={})
    pair = [replace(twin, take=still, duration_s=300.0) for twin in (FEW, MANY)]
    made = [simulate_take(twin) for twin in pair]
    hall, noise = facility(still)
    subsets = [[i - 1 for i in twin.camera_ids] for twin in pair]
    for marker in (0, 1):
        found = np.cov(np.concatenate([m.position_mm[marker] for m in made]))
        expected = joint_covariance(hall, marker, noise, subsets)
        scale = np.sqrt(np.diag(expected))
        assert np.abs((found - expected) / np.outer(scale, scale)).max() < 5 / np.sqrt(36_000)
        told = [made[0].truth["coefficients"][f"{axis}{marker + 1}"]["h_0"] for axis in "xyz"]
        assert np.array(told) * 120 / 2 == pytest.approx(np.diag(expected)[:3])


def test_motion_cancels_between_subsets_and_is_a_random_walk_with_drift() -> None:
    still = replace(TAKE, h_m2=0.0, drift_mm_per_h={})
    moving, resting = (
        np.subtract(*(simulate_take(replace(t, take=take)).position_mm for t in (FEW, MANY)))
        for take in (TAKE, still)
    )
    assert np.abs(moving - resting).max() < 1e-11
    path = motion(TAKE, LABELS, 3, 120.0, 120_000)
    assert not path[:, :, 0].any()
    m = 24
    # (2 pi)^2 / 6 h tau of a continuous walk; of its samples, 1 + 1 / (2 m^2) times that
    expected = (2 * np.pi) ** 2 / 6 * TAKE.h_m2 * (m / 120) * (1 + 1 / (2 * m**2))
    found = np.mean([allan_variance(path[k, j], m) for k in (0, 1) for j in range(3)])
    assert found == pytest.approx(expected, rel=0.05)
    bare = motion(replace(TAKE, drift_mm_per_h={}), LABELS, 3, 120.0, 120_000)
    hours = 119_999 / 120 / 3600
    assert (path - bare)[0, :, -1] == pytest.approx(np.array(DRIFT["Wand1"]) * hours)
    assert np.array_equal(path[1], bare[1])


@pytest.fixture(scope="module")
def entries(root) -> dict[str, AnyTwin]:
    text = (root / "config/twins.yaml").read_text(encoding="utf-8")
    document = yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    defaults = document["defaults"]["recording"]
    found = {k: v for k, v in document["twins"].items() if "take" in v}
    return {name: recording_twin(entry, name, defaults) for name, entry in found.items()}


def test_the_failing_camera_of_the_example_is_named_within_two_minutes(entries) -> None:
    twins = {
        name: replace(entry, duration_s=120.0, seed=entry.seed + 2019)
        for name, entry in entries.items()
    }
    ids = {name: twin.camera_ids for name, twin in twins.items()}
    assert [len(i) for i in ids.values()] == [4, 5, 6, 7, 8]
    made = {name: simulate_take(t).position_mm for name, t in twins.items()}
    found = additions(ids)
    read = lambda name, marker: made[name][marker - 1].astype(np.float32).astype(float)  # noqa: E731
    told = diagnose(moments(found, read, 2, 120.0, 14_400), found, ids)
    added = [addition.added for addition in found]
    assert added == [(2,), (7,), (6,), (4,)] and told.together.all()
    take = twins["hall-8"].take
    noise = facility(take)[1] / np.median(facility(take)[1])
    low, high = told.noise.interval(0.999)
    for k, (camera,) in enumerate(added):
        assert low[0, k] < noise[camera - 1] < high[0, k], camera
    assert told.noise.factor[0].argmax() == 2 and low[0, 2] > 1.5
    p = told.largest.p_value()[:, 0]
    rises = told.largest.factor[:, 0]
    assert np.all(rises[:, 2] > 1.05) and np.all(p[:, 2] < 1e-3)
    assert np.all(np.delete(rises, 2, axis=1) < 1.01)


GOOD = {
    "take": {"camera_type": "T40", "cameras": 4, "layout_seed": 1, "centroid_px": 0.1},
    "camera_ids": [1, 2],
    "seed": 1,
}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"published": {}}, "unknown key 'published'"),
        ({"camera_ids": [1]}, "camera_ids: [1], expected two or more different whole numbers"),
        ({"camera_ids": [1, 1]}, "from 1 to 4"),
        ({"camera_ids": [1, 5]}, "from 1 to 4"),
        ({"labels": ["a"]}, "labels: ['a'], expected two names"),
        ({"take": {"camera_type": "T40"}}, "take: cameras, layout_seed, centroid_px is missing"),
        ({"take.cameras": 10**9}, "expected a whole number from 2 to 1000"),
        ({"take.failing": {"camera": 5, "times": 2}}, "failing.camera: 5, expected one from 1 to"),
        ({"take.failing": {"camera": 1}}, "take.failing: times is missing"),
        ({"take.drift_mm_per_h": {"A": [0, 0, 1]}}, "unknown key 'A', expected one of Wand1"),
    ],
)
def test_a_wrong_entry_is_one_line(changes: dict[str, Any], message: str) -> None:
    assert take_twin_from_mapping(GOOD).camera_ids == (1, 2)
    entry: dict[str, Any] = GOOD | {k: v for k, v in changes.items() if "." not in k}
    inner = {k.split(".")[1]: v for k, v in changes.items() if "." in k}
    if inner:
        entry["take"] = GOOD["take"] | inner
    with pytest.raises(Faults) as refusal:
        take_twin_from_mapping(entry, "hall")
    assert str(refusal.value).startswith("twin hall: ") and message in str(refusal.value)


def test_linear_errors_are_those_of_non_linear_triangulation() -> None:
    rng = np.random.default_rng(3)
    facility, subset = random_facility(rng, 6), [0, 2, 3, 5]
    marker = facility.markers_mm[0]
    for _ in range(20):
        error = rng.normal(0, 0.05, (6, 2))
        linear = np.einsum("idk,kd->i", gain_matrices(facility, 0, [subset])[0], error)
        solved = triangulate(facility, project(facility, marker) + error, subset, marker + 5)
        assert np.linalg.norm(solved - marker - linear) < 2e-3 * np.linalg.norm(linear)


def test_wishart_scatters_as_scipy_says() -> None:
    from scipy.stats import wishart

    covariance, dof = np.array([[2.0, 0.6, 0.1], [0.6, 1.0, -0.2], [0.1, -0.2, 0.5]]), 30.0
    drawn = wishart_blocks(np.random.default_rng(5), covariance, dof * 20_000, 20_000)
    truth = wishart(dof, covariance / dof)
    assert drawn.mean(axis=0) == pytest.approx(truth.mean(), abs=0.01)
    assert drawn.var(axis=0) == pytest.approx(truth.var(), rel=0.06)
