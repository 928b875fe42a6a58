"""Where an estimate of any number of stations starts, and which of them are connected.

Board poses in the frame of each station, their mirror decided by pairs of stations that see the
board together. A station needs no common view with the reference: the pairs with most common
moments (a maximum spanning tree) give where each station begins, and all hits decide.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
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
from mocap_metrology.lighthouse.calibrate.scene import Pose, Scene
from mocap_metrology.lighthouse.calibrate.static import static_pose
from mocap_metrology.lighthouse.fit.board_pose import both_minima, well_posed
from mocap_metrology.lighthouse.records import MASTER, Hits, Measurements, Path
from mocap_metrology.lighthouse.timing import CYCLE_S

FEWEST_MOMENTS = 10
ORDER = 3  # of interpolation between moments
STEP_S = 4 * CYCLE_S  # between moments: each axis of each station sweeps once
LONGEST_GAP_S = 8.5 * CYCLE_S  # between hits of a diode: one may be missing, not two
LONGER = (2, 4)  # times as long, where most hits are lost
WRONG_RAD = 3e-3  # residual of a board pose with a reflection; of a hand that shakes it 1.3 mrad
MOST_WRONG = 4  # diodes of a moment
HERE: Pose = (np.eye(3), np.zeros(3))

Start = tuple[Hits, Trajectory, list[Pose]]


def moments(hits: Hits, n_diodes: int, n_stations: int = 2) -> list[Measurements]:
    """Both angles of the diodes in each station's view at moments `STEP_S` apart, the same for all
    stations, by cubic splines in time; NaN where a diode was not hit just before and after, or not
    long before and after, if moments with four diodes then are more than twice as many."""
    count = max(int(np.ptp(hits.time_s) / STEP_S), 1)
    time = hits.time_s.min() + STEP_S * (0.5 + np.arange(count))
    angles = np.full((n_stations, count, n_diodes, 2), np.nan)
    gap_s = np.full(angles.shape, np.inf)
    key = (hits.station * 2 + hits.axis).astype(np.int64) * n_diodes + hits.diode
    order = np.lexsort((hits.time_s, key))
    keys, first = np.unique(key[order], return_index=True)
    for k, rows in zip(keys, np.split(order, first[1:]), strict=True):
        at, angle = hits.time_s[rows], hits.angle_rad[rows]
        if at.size < 4:
            continue
        after = np.clip(np.searchsorted(at, time), 1, at.size - 1)
        inside = (time >= at[0]) & (time <= at[-1])
        station, axis, diode = k // n_diodes // 2, k // n_diodes % 2, k % n_diodes
        angles[station, inside, diode, axis] = CubicSpline(at, angle)(time[inside])
        gap_s[station, inside, diode, axis] = (at[after] - at[after - 1])[inside]
    for of_station, gap in zip(angles, gap_s.max(axis=3), strict=True):
        longest, n = LONGEST_GAP_S, _full(gap <= LONGEST_GAP_S)
        for times in LONGER:
            if (more := _full(gap <= times * LONGEST_GAP_S)) > 2 * n:
                longest, n = times * LONGEST_GAP_S, more
        of_station[~(gap <= longest)] = np.nan
    return [Measurements(time, of_station) for of_station in angles]


def _full(seen: np.ndarray) -> int:
    """Moments (n, diodes) at which four diodes are seen."""
    return int(np.count_nonzero(seen.sum(axis=1) >= FEWEST_DIODES))


@dataclass(frozen=True)
class Network:
    """Stations by name, the reference first: those that are connected; for the others what would
    connect them; moments that each shares with another; joint covariance, 6 (n - 1) square in mm
    and deg, None without a pose."""

    connected: Sequence[str]
    apart: Mapping[str, str]
    common: Mapping[str, int]
    covariance: np.ndarray | None = None


def look(scene: Scene, views: Sequence[Measurements] | None = None) -> list[Minima | None]:
    """Both minima of the board poses of each station; None of one that sees four diodes at less
    than `FEWEST_MOMENTS` moments."""
    optics, every = scene.seen(_views(scene) if views is None else views), list[Minima | None]()
    for measured, rotors in zip(optics.measurements, optics.rotors, strict=True):
        measured = (
            _without_wrong(measured, scene.board, rotors) if scene.generation == 2 else measured
        )
        every.append(
            None if len(measured) < FEWEST_MOMENTS else minima(measured, scene.board, rotors)
        )
    return every


def _without_wrong(measured: Measurements, board: np.ndarray, rotors: np.ndarray) -> Measurements:
    """Without the diodes of a moment that the others contradict, as reflections are, each time the
    one whose absence lowers K_1 most; and without moments that still have such, if enough remain.
    """
    for left in reversed(range(MOST_WRONG + 1)):
        pose = both_minima(measured, board, rotors)[0]
        wrong = pose.epsilon > WRONG_RAD**2 * np.maximum(pose.n_angles - 6, 1)
        more = np.flatnonzero(wrong & (measured.seen.sum(axis=1) > FEWEST_DIODES + 1))
        if not (left and more.size):
            break
        row, diode = np.nonzero(measured.seen[more])
        without = measured.take(more[row])
        without.angles_rad[np.arange(row.size), diode] = np.nan
        order = np.lexsort((both_minima(without, board, rotors)[0].epsilon, row))
        best = order[np.unique(row[order], return_index=True)[1]]
        angles = measured.angles_rad.copy()
        angles[more, diode[best]] = np.nan
        measured = well_posed(Measurements(measured.time_s, angles), board)
    return measured if (~wrong).sum() < FEWEST_MOMENTS else measured.take(~wrong)


def views(hits: Hits, board: np.ndarray, n_stations: int = 2) -> list[Measurements]:
    """Moments at which a station sees four diodes that span a surface, of each."""
    every = moments(hits, len(board), n_stations)
    enough = (measured.seen.sum(axis=1) >= FEWEST_DIODES for measured in every)
    return [well_posed(one.take(seen), board) for one, seen in zip(every, enough, strict=True)]


def _views(scene: Scene) -> list[Measurements]:
    return views(scene.hits, scene.board, len(scene.factories))


def placed(scene: Scene) -> np.ndarray:
    """Whether a station sees four diodes near the time of each hit, without which the place of the
    board is not sought; bool (hits,)."""
    seen_s = np.sort(np.concatenate([view.time_s for view in _views(scene)]))
    near = np.searchsorted(seen_s, scene.hits.time_s[:, None] + [-FARTHEST_S, FARTHEST_S])
    return near[:, 0] < near[:, 1]


def shared_moments(seen: Sequence[Minima | None]) -> np.ndarray:
    """At how many moments each two stations have a board pose, (n, n), 0 below `FEWEST_MOMENTS`."""
    time_s = [
        np.zeros(0) if of_station is None else of_station.measurements.time_s for of_station in seen
    ]
    both = np.array([[np.isin(a, b).sum() for b in time_s] for a in time_s])
    return np.where(both >= FEWEST_MOMENTS, both, 0)


def islands(shared: np.ndarray) -> list[list[int]]:
    """Stations by what connects them: the island of the first station, then the others."""
    _, island = connected_components(shared > 0, directed=False)
    return [np.flatnonzero(island == k).tolist() for k in np.unique(island)]


def network_of(names: Sequence[str], shared: np.ndarray) -> tuple[list[int], Network]:
    """The stations that are connected with the reference (or, if none is, most stations)."""
    parts = islands(shared)
    members = parts[0] if len(parts[0]) > 1 else max(parts, key=len)
    moments = (shared - np.diag(np.diag(shared))).max(axis=1)
    apart = {
        names[k]: _unconnected(k, names, parts, members) for p in parts if p != members for k in p
    }
    common = dict(zip(names, moments.tolist(), strict=True))
    return members, Network([names[k] for k in members], apart, common)


def _unconnected(
    k: int, names: Sequence[str], parts: Sequence[Sequence[int]], members: Sequence[int]
) -> str:
    """Why a station has no pose, and what would change that."""
    with_it = [names[j] for part in parts if k in part for j in part if j != k]
    connected = ", ".join(names[j] for j in members)
    beside = f" (connected with {', '.join(with_it)} only)" if with_it else ""
    join = " or ".join([names[k], *with_it])
    return (
        f"station {names[k]}{beside} shares no view of the board with {connected}: move the board"
        f" where {join} and one of these see four diodes at a time, for a second or more"
    )


def start(scene: Scene, seen: Sequence[Minima | None] | None = None) -> Start:
    """Hits where the board's poses are known, a trajectory near these, and poses of the stations;
    seen: what `look` returns. Raises `Refusal` where the stations are not connected."""
    if seen is None:
        views = _views(scene)
        counts = [len(view) for view in views]
        if len(counts) == 2 and min(counts) < FEWEST_MOMENTS:
            raise Refusal(
                f"{scene.title}: {counts[0]} and {counts[1]} moments at which a station sees"
                f" four diodes; expected at least {FEWEST_MOMENTS}"
            )
        seen = look(scene, views)
    poses, paths = [HERE] * len(seen), list[Path]()
    for known, new in _tree(shared_moments(seen)):
        first, other = seen[known], seen[new]
        assert first is not None and other is not None
        agreed = agree(first, other, ORDER, roughly=True)
        if agreed.pose is None:
            raise Refusal(f"{scene.title}: the stations never see the board at once")
        (R, t), (turn, shift) = poses[known], agreed.pose
        poses[new] = R @ turn, R @ shift + t
        master, slave = agreed.paths
        both = [slave.seen_from(turn, shift)]
        both = both if paths else [master, *both]
        paths += both if known == MASTER else [path.seen_from(R, t) for path in both]
    path = Path.joined(paths)
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
        if scene.generation == 2 and pose.open_mirror:
            why = "and its mirrored pose fits as well: move it through the room"
            raise Refusal(f"{scene.title}: the board did not move, {why}")
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
