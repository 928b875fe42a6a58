"""Where an estimate of any number of stations starts, and which of them are connected.

Board poses in the frame of each station, their mirror decided by pairs of stations that see the
board together. A station needs no common view with the reference: the pairs with most common
moments (a maximum spanning tree) give where each station begins, and all hits decide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.batch.trajectory import (
    FARTHEST_S,
    Trajectory,
    at_rest,
    trajectory_of,
)
from mocap_metrology.lighthouse.board import FEWEST_DIODES
from mocap_metrology.lighthouse.calibrate.agreement import Minima, agree, minima
from mocap_metrology.lighthouse.calibrate.moments import joined, moments
from mocap_metrology.lighthouse.calibrate.scene import Pose, Scene
from mocap_metrology.lighthouse.calibrate.static import static_pose
from mocap_metrology.lighthouse.fit.board_pose import well_posed
from mocap_metrology.lighthouse.records import MASTER, Hits, Measurements, Path

FEWEST_MOMENTS = 10
ORDER = 3  # of interpolation between moments
NOTHING = Measurements(np.zeros(0), np.zeros((0, 1, 2)))
HERE: Pose = (np.eye(3), np.zeros(3))

Start = tuple[Hits, Trajectory, list[Pose]]


def look(scene: Scene, views: Sequence[Measurements] | None = None) -> list[Minima | None]:
    """Both minima of the board poses of each station; None of one that sees four diodes at less
    than `FEWEST_MOMENTS` moments."""
    optics = scene.seen(_views(scene) if views is None else views)
    return [
        None if len(own) < FEWEST_MOMENTS else minima(own, scene.board, rotors)
        for own, rotors in zip(optics.measurements, optics.rotors, strict=True)
    ]


def _views(scene: Scene) -> list[Measurements]:
    """Moments at which a station sees four diodes that span a surface, of each."""
    found = []
    for own in moments(scene.hits, len(scene.board), len(scene.factories)):
        seen = own.seen.sum(axis=1) >= FEWEST_DIODES
        kept = Measurements(own.time_s[seen], own.angles_rad[seen])
        found.append(well_posed(kept, scene.board))
    return found


def placed(scene: Scene) -> np.ndarray:
    """Whether a station sees four diodes near the time of each hit, without which the place of the
    board is not sought; bool (hits,)."""
    seen_s = np.sort(np.concatenate([own.time_s for own in _views(scene)]))
    near = np.searchsorted(seen_s, scene.hits.time_s[:, None] + [-FARTHEST_S, FARTHEST_S])
    return near[:, 0] < near[:, 1]


def shared_moments(seen: Sequence[Minima | None]) -> np.ndarray:
    """At how many moments each two stations have a board pose, (n, n), 0 below `FEWEST_MOMENTS`."""
    time_s = [np.zeros(0) if own is None else own.measurements.time_s for own in seen]
    both = np.array([[np.isin(a, b).sum() for b in time_s] for a in time_s])
    return np.where(both >= FEWEST_MOMENTS, both, 0)


def islands(shared: np.ndarray) -> list[list[int]]:
    """Stations by what connects them: the island of the first station, then the others."""
    _, island = connected_components(shared > 0, directed=False)
    return [np.flatnonzero(island == k).tolist() for k in np.unique(island)]


def start(scene: Scene, seen: Sequence[Minima | None] | None = None) -> Start:
    """Hits where the board's poses are known, a trajectory near these, and poses of the stations;
    seen: what `look` returns. Raises `Refusal` where the stations are not connected."""
    if seen is None:
        views = _views(scene)
        counts = [len(own) for own in views]
        if len(counts) == 2 and min(counts) < FEWEST_MOMENTS:
            raise Refusal(
                f"{scene.title}: {counts[0]} and {counts[1]} moments at which a station sees"
                f" four diodes; expected at least {FEWEST_MOMENTS}"
            )
        seen = look(scene, views)
    rotors_of = scene.seen([NOTHING] * len(seen)).rotors
    poses, paths = [HERE] * len(seen), list[Path]()
    for known, new in _tree(shared_moments(seen)):
        own, other = seen[known], seen[new]
        assert own is not None and other is not None
        rotors = rotors_of[known], rotors_of[new]
        agreed = agree(own, other, scene.board, rotors, ORDER, roughly=True)
        if agreed.R is None or agreed.t_m is None:
            raise Refusal(f"{scene.title}: the stations never see the board at once")
        R, t = poses[known]
        poses[new] = R @ agreed.R, R @ agreed.t_m + t
        both = joined(agreed)
        if paths:
            both = both.take(np.arange(len(agreed.paths[0]), len(both)))
        paths.append(both if known == MASTER else _moved(both, R, t))
    names = Path.__dataclass_fields__
    path = Path(**{k: np.concatenate([getattr(p, k) for p in paths]) for k in names})
    time_s = scene.hits.time_s
    trajectory = trajectory_of(path, time_s.min(), time_s.max())
    return scene.hits.take(trajectory.known(time_s)), trajectory, poses


def still_start(
    scene: Scene, still: Sequence[Measurements]
) -> tuple[Hits, Trajectory, list[Pose], str]:
    """Hits without those of diodes that the others contradict, one pose of the board, those of the
    stations, and a note; still: median angles of each station."""
    optics = scene.seen(still)
    hits, poses, notes, board = scene.hits, [HERE], [], None
    for station in range(1, len(still)):
        of, rotors = optics.measurements, optics.rotors
        pair = [of[0], of[station]]
        pose = static_pose(pair, scene.board, [rotors[0], rotors[station]])
        if pose is None:
            raise Refusal(f"{scene.title}: a station sees fewer than four diodes")
        for k, out in zip((0, station), pose.left_out, strict=True):
            hits = hits.take((hits.station != k) | ~np.isin(hits.diode, out))
        poses.append((pose.R, pose.t_m))
        notes += pose.notes if len(still) == 2 else []
        board = board or at_rest(pose.board_R, pose.board_t_m)
    assert board is not None
    return hits, board, poses, "; ".join(notes)


def _tree(shared: np.ndarray) -> Sequence[tuple[int, int]]:
    """Pairs of a station that is connected to the reference and a new one, by most moments."""
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


def _moved(path: Path, R: np.ndarray, t: np.ndarray) -> Path:
    """Poses in the frame of a station with pose R, t, in the reference's."""
    return replace(path, R=R @ path.R, t_m=path.t_m @ R.T + t)
