"""Rigid clusters on a real sprint and on drawn bodies; slopes of scale by Monte Carlo."""

import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from mocap_metrology.accuracy.clusters import rigid_clusters, scale_slope
from mocap_metrology.accuracy.twin import gauss_markov
from mocap_metrology.io.read import labels_of, read_recording

SPRINT = Path(__file__).parents[3] / "shared/data/metrology/kinematics_basket_sprint.c3d"


@pytest.mark.skipif(not SPRINT.exists(), reason="the recording of a sprint is not here")
def test_of_a_real_sprint() -> None:
    """Both bodies of the wheelchair, whole and first; nothing else in them. Scale changes by less
    than 0.2 % over the way of 12.9 m, as other estimates found (182 +- 82 and 106 +- 55 ppm/m)."""
    labels = labels_of(SPRINT)
    recording = read_recording([SPRINT], labels)
    start = time.process_time()
    found = rigid_clusters(recording.position_mm, 1.5)
    names = [{labels[k] for k in one.markers} for one in found]
    bodies = [{f"{body}:Marker{k}" for k in (1, 2, 3, 4)} for body in ("SWL", "WheelchairL")]
    assert names[:2] == bodies
    slopes = [scale_slope(recording.position_mm, one.markers) for one in found[:2]]
    assert time.process_time() - start < 4
    for slope in slopes:
        assert slope is not None and len(slope.pairs) == 6 and 12 < slope.way_m < 13
        assert abs(slope.slope) < 200 and 30 < slope.se < 250


def body(rng: np.random.Generator, n_markers: int) -> np.ndarray:
    return rng.uniform(-250, 250, (n_markers, 3, 1))


def way(n: int) -> np.ndarray:
    """12 m along x, (3, n) mm."""
    along = np.linspace(0, 12, n)
    return np.stack([1000 * along, 200 * np.sin(along), 0 * along])


def test_drawn_bodies_are_found_whole() -> None:
    """Two bodies that turn on their own, markers on neither, noise of 0.3 mm and gaps."""
    rng = np.random.default_rng(1)
    n = 2000
    turn = np.linspace(0, 6, n)
    c, s, zero, one = np.cos(turn), np.sin(turn), 0 * turn, 0 * turn + 1
    rotation = np.array([[c, -s, zero], [s, c, zero], [zero, zero, one]])
    first = np.einsum("abn,mb->man", rotation, body(rng, 4)[:, :, 0]) + way(n)
    second = body(rng, 3) + way(n) + 800.0
    loose = way(n) + np.cumsum(rng.standard_normal((2, 3, n)), axis=2)
    position = np.concatenate([first, loose, second])
    position += 0.3 * rng.standard_normal(position.shape)
    position[:, :, :100][:4] = np.nan
    found = [set(one.markers) for one in rigid_clusters(position, 1.5)]
    assert sorted(found, key=min) == [{0, 1, 2, 3}, {6, 7, 8}]


def test_markers_hardly_seen_together_are_of_no_cluster() -> None:
    position = body(np.random.default_rng(3), 3) + way(1000)
    position[2, :, 50:] = np.nan
    assert [one.markers for one in rigid_clusters(position, 1.5)] == [(0, 1)]
    assert rigid_clusters(position[:1], 1.5) == []
    assert scale_slope(position, (0, 1)) is None


def test_one_marker_under_two_labels_is_in_a_cluster_once() -> None:
    rng = np.random.default_rng(4)
    position = body(rng, 4)[[0, 1, 1, 2, 3]] + way(1000) + 0.3 * rng.standard_normal((5, 3, 1000))
    (found,) = rigid_clusters(position, 1.5)
    assert found.markers == (0, 1, 3, 4)


def test_of_hundreds_of_markers_not_all_distances_are_kept() -> None:
    """Those of 200 markers that part would take 1.9 GB."""
    position = np.cumsum(np.random.default_rng(5).standard_normal((200, 3, 4000)), axis=2)
    tracemalloc.start()
    assert rigid_clusters(position, 1.5) == []
    assert tracemalloc.get_traced_memory()[1] < 1e8
    tracemalloc.stop()


@pytest.mark.parametrize("bend", [0.0, 0.1])
def test_interval_of_a_slope_holds(bend: float) -> None:
    """100 bodies of four markers that bend at random, 150 ppm/m: in 90 % at least, and the truth is
    the mean of all."""
    held, slopes = [], []
    for seed in range(100):
        rng = np.random.default_rng(seed)
        along = np.linspace(0, 12, 1000)
        position = way(1000) + body(rng, 4) * (1 + 150e-6 * along)
        position += bend * rng.standard_normal((4, 3, 1)) * along
        noise = [[gauss_markov(rng, 1000, 10.0) for _ in range(3)] for _ in range(4)]
        found = scale_slope(position + 0.3 * np.array(noise), range(4))
        assert found is not None
        held.append(found.lower < 150 < found.upper)
        slopes.append(found.slope)
    assert np.mean(held) >= 0.9
    assert np.mean(slopes) == pytest.approx(150, abs=3 * np.std(slopes) / 10)
