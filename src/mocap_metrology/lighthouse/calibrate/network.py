"""Any number of base stations through the board that they see, in one estimate by `batch`.

A station needs no common view with the master: pairs that see the board together most often (a
maximum spanning tree) give where each station begins, and all hits decide. First-generation
hardware has two stations; this is what a room with more needs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.sparse.csgraph import breadth_first_order, minimum_spanning_tree

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.batch.estimate import Joint, determined, estimate
from mocap_metrology.lighthouse.batch.recording import Given
from mocap_metrology.lighthouse.batch.trajectory import KNOT_S, Trajectory, trajectory_of
from mocap_metrology.lighthouse.board import FEWEST_DIODES
from mocap_metrology.lighthouse.calibrate.batch import FEWEST_MOMENTS, Pose, Scene, start
from mocap_metrology.lighthouse.calibrate.moments import moments
from mocap_metrology.lighthouse.records import MASTER, Path


def by_network(scene: Scene) -> Joint:
    """Poses of all stations of a scene, `factories` of each, in the frame of the first, and the
    board's trajectory; `Joint.pose_covariance(k)` is that of station k.

    Raises `Refusal` where the stations are not connected by moments at which two see the board, or
    the search does not converge.
    """
    n = len(scene.factories)
    poses: list[Pose] = [(np.eye(3), np.zeros(3))] * n
    paths = []
    for known, new in _tree(_shared(scene, n)):
        with determined(f"{scene.title}, stations {known} and {new}"):
            _, trajectory, (R, t) = start(_pair(scene, known, new))
        R_known, t_known = poses[known]
        poses[new] = R_known @ R, R_known @ t + t_known
        paths.append(_moved(trajectory, *poses[known]))
    names = Path.__dataclass_fields__
    path = Path(**{k: np.concatenate([getattr(p, k) for p in paths]) for k in names})
    time_s = scene.hits.time_s
    trajectory = trajectory_of(path, time_s.min(), time_s.max())
    hits = scene.hits.take(trajectory.known(time_s))
    both = [pose[0] for pose in poses], [pose[1] for pose in poses]
    with determined(scene.title):
        given = [Given(hits, trajectory, scene.sensors.inertial)]
        priors, ups = scene.used_priors, scene.sensors.ups
        found = estimate(given, *both, scene.rotors, scene.board, priors, ups=ups)
    return found.sure(scene.title)


def _shared(scene: Scene, n: int) -> np.ndarray:
    """At how many moments each two of n stations see four diodes, (n, n)."""
    seen = np.array(
        [own.seen.sum(axis=1) >= FEWEST_DIODES for own in moments(scene.hits, len(scene.board), n)]
    )
    both: np.ndarray = seen.astype(int) @ seen.T.astype(int)
    return np.where(both >= FEWEST_MOMENTS, both, 0)


def _tree(shared: np.ndarray) -> Sequence[tuple[int, int]]:
    """Pairs of a station that is connected to the master and a new one, by most moments."""
    n = len(shared)
    tree = minimum_spanning_tree(-np.triu(shared, 1).astype(float))
    order, before = breadth_first_order(tree, MASTER, directed=False)
    if len(order) < n:
        lost = ", ".join(str(k) for k in range(n) if k not in order)
        raise Refusal(
            f"station {lost}: no {FEWEST_MOMENTS} moments at which it and another station that is"
            " connected to the master see four diodes"
        )
    return [(int(before[k]), int(k)) for k in order[1:]]


def _pair(scene: Scene, first: int, second: int) -> Scene:
    """Two of the stations, the first as master."""
    hits = scene.hits.take(np.isin(scene.hits.station, (first, second)))
    own = replace(hits, station=(hits.station == second).astype(hits.station.dtype))
    return replace(scene, hits=own, factories=[scene.factories[k] for k in (first, second)])


def _moved(trajectory: Trajectory, R: np.ndarray, t: np.ndarray) -> Path:
    """Poses along a trajectory in the frame of a station with pose R, t, in the master's."""
    at = trajectory.begin_s + KNOT_S * (np.arange(len(trajectory.control) - 3) + 0.5)
    at = at[trajectory.known(at)]
    R_own, t_own = trajectory.poses(at)
    none = np.zeros(at.size)
    return Path(at, R @ R_own, t_own @ R.T + t, none, none, none)
