"""One calibration, read from its files for its figures, and what supports it: both paths compared,
diodes seen, scatter of tracked poses.
"""

from __future__ import annotations

import json
import math
import pathlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.files import read_table
from mocap_metrology.common.types import Record
from mocap_metrology.lighthouse.assess import pose_file
from mocap_metrology.lighthouse.assess.fit_checks import BOARD, EXPECTED_URAD
from mocap_metrology.lighthouse.assess.pose_file import PoseEntry, PoseFile, matrix_and_metres
from mocap_metrology.lighthouse.board import read_board
from mocap_metrology.lighthouse.calibrate.superpose import at_times
from mocap_metrology.lighthouse.fit.board_pose import MIRRORED_RAD
from mocap_metrology.lighthouse.records import MASTER, ROLES, SLAVE, Path
from mocap_metrology.lighthouse.rotation import from_angles, log, mean, of_quaternions

Pose = tuple[np.ndarray, np.ndarray]  # R (3, 3), t (3,) in metres
Paths = tuple[Path, Path]  # of the board in the frames of master and slave
UNSEEN, SELDOM = 0.01, 0.5  # share of sweeps seen; SELDOM of the median diode's
TIMES_SIGMA = 3.0  # an error beyond so many standard deviations is more than scatter
FLAT = 0.05  # thickness of a board whose diodes all face the same way, over its width
AXES = {"mm": ("x_mm", "y_mm", "z_mm"), "deg": ("rx_deg", "ry_deg", "rz_deg")}
KINDS = {"noise": "sd_noise_", "calibration": "sd_calibration_", "total": "sd_"}
Columns = Mapping[str, np.ndarray]
N_BOARDS = 7


@dataclass(frozen=True)
class Agreement:
    """Both paths of the board in the master's frame, at times of the master's poses.

    time_s (n,), master_m, slave_m (n, 3), apart_mm (n,), turned_deg (n,): angle between the board's
    rotations; alone_s: times between them of poses that only master, only slave has.
    """

    time_s: np.ndarray
    master_m: np.ndarray
    slave_m: np.ndarray
    apart_mm: np.ndarray
    turned_deg: np.ndarray
    alone_s: tuple[np.ndarray, np.ndarray]

    @property
    def mirrored(self) -> np.ndarray:
        """Moments at which one of both poses is in the other minimum."""
        return np.asarray(self.turned_deg > np.degrees(MIRRORED_RAD))


def agreement(paths: tuple[Path, Path], pose: tuple[np.ndarray, np.ndarray]) -> Agreement:
    """p_m against R p_s + t and R_m against R R_s, p_s and R_s interpolated (J VI-C)."""
    (master, slave), (R, t) = paths, pose
    then, common = at_times(slave, master.time_s)
    _, both = at_times(master, slave.time_s)
    path, moved = master.take(common), then.t_m @ R.T + t
    trace = np.einsum("nij,ik,nkj->n", path.R, R, then.R)
    first, last = (path.time_s[0], path.time_s[-1]) if len(path) else (np.inf, -np.inf)
    alone = master.time_s[~common], slave.time_s[~both]
    apart_mm = 1e3 * np.linalg.norm(path.t_m - moved, axis=1)
    turned_deg = np.degrees(np.arccos(np.clip((trace - 1) / 2, -1, 1)))
    alone_s = tuple(t_s[(t_s > first) & (t_s < last)] for t_s in alone)
    return Agreement(path.time_s, path.t_m, moved, apart_mm, turned_deg, alone_s)


def residuals_urad(path: Path) -> np.ndarray:
    """Root mean square of C - M of each board pose, sqrt(epsilon / n_angles), in urad."""
    return np.asarray(1e6 * np.sqrt(path.epsilon / np.maximum(path.n_angles, 1)))


def seen_shares(sweeps: Columns, n_diodes: int, n: int) -> np.ndarray:
    """Share of the sweeps of each of n stations that each diode saw, (n, diodes), of those that any
    diode saw."""
    shares = []
    for station in range(n):
        of_station = np.asarray(sweeps["station"]) == station
        cycle, diode = (
            np.asarray(sweeps["cycle"])[of_station],
            np.asarray(sweeps["diode"])[of_station],
        )
        pairs = np.unique(np.column_stack([cycle, diode]).astype(np.int64), axis=0)
        counts = np.bincount(pairs[:, 1], minlength=n_diodes)[:n_diodes]
        shares.append(counts / max(np.unique(cycle).size, 1))
    return np.array(shares)


def faint_diodes(shares: np.ndarray, board: np.ndarray, station: int) -> dict[str, np.ndarray]:
    """Numbers of the diodes that are dead, that this station has not seen, and that it has seen
    less than half as often as the median one.

    shares (2, n): of the sweeps of either station that each diode saw. Those on a flat board all
    face the same way, so one that no station sees where others are seen is dead. On a board with
    depth it may face away, or something may be in the way: it is `not seen`.
    """
    seen = shares >= UNSEEN
    thickness, _, width = np.linalg.svd(board - board.mean(axis=0), compute_uv=False)[::-1]
    dead = ~seen.any(axis=0) & (thickness < FLAT * width and seen.any())
    is_seen = seen[station]
    usual = np.median(shares[station][is_seen]) if is_seen.any() else 0.0
    return {
        "dead": np.flatnonzero(dead),
        "not seen": np.flatnonzero(~is_seen & ~dead),
        "seldom": np.flatnonzero(is_seen & (shares[station] < SELDOM * usual)),
    }


def lengths(track: Columns, kind: str, unit: str) -> np.ndarray:
    """Length (n,) of the vector of standard deviations of tracked poses; kind: one of `KINDS`;
    unit: mm or deg."""
    names = [f"{KINDS[kind]}{axis}" for axis in AXES[unit]]
    squares = [np.asarray(track[name], dtype=np.float64) ** 2 for name in names]
    return np.asarray(np.sqrt(np.sum(squares, axis=0)))


def settled_poses(track: Columns) -> np.ndarray:
    """Poses (n,) of no more than twice the usual noise: not at an end, nor where hits are few."""
    noise = lengths(track, "noise", "mm")
    known = np.isfinite(noise)
    return known & (noise <= 2 * np.median(noise[known])) if known.any() else known


def deviations_mm(track: Columns) -> np.ndarray:
    """(n, 3) of the position from the mean of the `settled_poses`."""
    place = np.column_stack([track[f"{axis}_mm"] for axis in "xyz"])
    good = settled_poses(track)
    return np.asarray(place - place[good].mean(axis=0)) if good.any() else place


def jitter(track: Columns) -> tuple[float, float]:
    """Standard deviation of the `settled_poses` about their mean: lengths in mm and deg."""
    good = settled_poses(track)
    if good.sum() < 2:
        return math.nan, math.nan
    q = np.column_stack([track[name][good] for name in ("qx", "qy", "qz", "qw")])
    R = of_quaternions(q)
    both = deviations_mm(track)[good], np.degrees(log(R @ mean(R).T))
    mm, deg = (float(np.sqrt(errors.var(axis=0, ddof=1).sum())) for errors in both)
    return mm, deg


def expected_urad(pose: Record) -> float:
    """Noise of one angle that the checks went by, in µrad."""
    limit, good = limit_of(pose, "board poses")
    return EXPECTED_URAD if limit is None else limit / BOARD[0 if good else 1]


def limit_of(pose: Record, name: str) -> tuple[float | None, bool]:
    """Limit of a check and whether it is that of the word good; None where it has none."""
    check: Record = next((c for c in pose.get("checks", ()) if c["name"] == name), {})
    limit = check.get("limit")
    return (limit if isinstance(limit, int | float) else None), bool(check.get("ok"))


def deviations(entry: Record) -> np.ndarray:
    """Standard deviations (6,) in mm and deg, NaN where they are not known."""
    if entry.get("covariance") is None:
        return np.full(6, np.nan)
    variance = np.diag(np.array(entry["covariance"], dtype=np.float64))
    return np.asarray(np.sqrt(np.clip(variance, 0, None)))


def beyond_sigma(entry: Record) -> bool:
    """Whether the error of an estimate against its reference is more than three standard deviations
    in a coordinate or about an axis."""
    if entry.get("errors_mm") is None:
        return False
    off = np.abs([*entry["errors_mm"], *entry["errors_deg"]])
    return bool((off > TIMES_SIGMA * deviations(entry)).any())


def usual_points(points: np.ndarray) -> np.ndarray:
    """All but the farthest hundredth in each coordinate."""
    low, high = np.percentile(points, [0.5, 99.5], axis=0)
    inside = points[((points >= low) & (points <= high)).all(axis=1)]
    return inside if len(inside) else points


def on_the_path(points: np.ndarray) -> np.ndarray:
    """Which points are on the path: within the middle nine tenths in each coordinate and a little
    round them."""
    low, high = np.percentile(points, [5, 95], axis=0)
    room = 0.2 * (high - low).max()
    return np.asarray(((points >= low - room) & (points <= high + room)).all(axis=1))


def boards_along(path: Path, board: np.ndarray) -> list[np.ndarray]:
    """Corners (4, 3) of the board at some moments, equally far apart along its path."""
    path = path.take(on_the_path(path.t_m))
    step = np.linalg.norm(np.diff(path.t_m, axis=0), axis=1)
    far = np.concatenate([[0.0], np.cumsum(np.minimum(step, 5 * np.median(step)))])
    at = np.searchsorted(far, np.linspace(0, far.max(), N_BOARDS))
    corners = outline(board)
    which = np.unique(np.clip(at, 0, len(path) - 1))
    return [path.t_m[k] + corners @ path.R[k].T for k in which]


def outline(board: np.ndarray) -> np.ndarray:
    """Corners (4, 3) of the rectangle round a board in its principal plane, in its own frame."""
    centre = board.mean(axis=0)
    axes = np.linalg.svd(board - centre, full_matrices=False)[2][:2]
    within = (board - centre) @ axes.T
    (a, c), (b, d) = within.min(axis=0), within.max(axis=0)
    return np.asarray(centre + np.array([[a, c], [b, c], [b, d], [a, d]]) @ axes)


@dataclass(frozen=True)
class CalibrationFiles:
    """One calibration, read from its files; `twin`: name of the twin, None for a measurement."""

    name: str
    twin: str | None
    pose: PoseFile
    stations: Sequence[Record]  # stations.json, master first
    board: np.ndarray  # (n, 3), m
    sweeps: Mapping[str, np.ndarray]
    poses: Mapping[str, np.ndarray]
    duration_s: float

    @property
    def chosen(self) -> PoseEntry | None:
        return pose_file.chosen_pose(self.pose)

    @property
    def names(self) -> list[str]:
        """Names of the stations, in the order of `sweeps`: by rising channel, or master and
        slave."""
        return [str(station["role"]) for station in self.stations]

    @property
    def entries(self) -> dict[str, PoseEntry | None]:
        """Chosen pose of each station but the reference; None where every estimate failed."""
        pairs = pose_file.pairs(self.pose).items()
        return {name: pose_file.chosen_pose(one) for name, one in pairs}

    @property
    def reference_name(self) -> str:
        """Name of the station whose frame is used."""
        if pose_file.is_network(self.pose):
            return str(self.pose["reference"] or self.names[0])
        return ROLES[MASTER]

    def frames(self) -> dict[str, Pose]:
        """Poses of the stations that have one, by name, the reference first."""
        by_name = {name: matrix_and_metres(e) for name, e in self.entries.items() if e is not None}
        return {self.reference_name: (np.eye(3), np.zeros(3))} | by_name

    def paths(self, estimator: str, optics: str) -> Paths | None:
        """Board poses in the frames of master and slave, None without two of each. `batch` has one
        trajectory and no such poses: shown are those of `paper-lm`, of any number of stations the
        trajectory."""
        if pose_file.is_network(self.pose):
            only = _path(self.poses, slice(None)) if len(self.poses.get("time_s", ())) > 1 else None
            return None if only is None else (only, only)
        if estimator == "batch":
            estimator, optics = "paper-lm", "ideal" if optics == "estimated" else optics
        if not len(self.poses.get("time_s", ())):
            return None
        names = (np.asarray(self.poses[key]).astype(str) for key in ("estimator", "optics"))
        chosen = np.logical_and(*(a == b for a, b in zip(names, (estimator, optics), strict=True)))
        station = self.poses["station"]
        master, slave = (_path(self.poses, chosen & (station == k)) for k in (MASTER, SLAVE))
        return (master, slave) if min(len(master), len(slave)) > 1 else None

    def shown_paths(self) -> Paths | None:
        """Paths of the board by the chosen estimate, or by any where none is chosen."""
        if self.chosen is not None:
            return self.paths(self.chosen["estimator"], self.chosen["optics"])
        names = (np.asarray(self.poses.get(k, ())).astype(str) for k in ("estimator", "optics"))
        kinds = sorted(set(zip(*(column.tolist() for column in names), strict=True)))
        return next((paths for kind in kinds if (paths := self.paths(*kind))), None)

    def agreement(self) -> Agreement | None:
        """Both paths by the chosen estimate, compared; None without one or a common moment."""
        paths = self.shown_paths()
        if self.chosen is None or paths is None or pose_file.is_network(self.pose):
            return None
        both = agreement(paths, pose_file.matrix_and_metres(self.chosen))
        return both if both.time_s.size else None

    def estimate(self, *kind: str) -> PoseEntry | None:
        poses = self.pose["poses"]
        return next((p for p in poses if (p["estimator"], p["stage"], p["optics"]) == kind), None)

    @property
    def reference(self) -> Pose | None:
        """True pose (R, t in m) of the slave in the master's frame; None where it is unknown."""
        true = self.pose.get("reference")
        if not true or pose_file.is_network(self.pose):
            return None
        angles = [np.radians(true["rotation_deg"][k]) for k in ("alpha", "beta", "gamma")]
        return from_angles(*angles), np.array(true["translation_mm"]) / 1e3


def read_calibration(
    files: Mapping[str, str | pathlib.Path], name: str, twin: str | bool | None
) -> CalibrationFiles:
    """Read `pose`, `poses`, `sweeps`, `stations` and `board` of one calibration.

    twin: name of the twin it was simulated from; True: one of the calibration's name.
    """
    sweeps, origin = read_table(files["sweeps"])
    last = float(sweeps["time_s"].max()) if sweeps["time_s"].size else 0.0
    return CalibrationFiles(
        name,
        name if twin is True else twin or None,
        pose_file.read_pose_json(files["pose"]),
        json.loads(pathlib.Path(files["stations"]).read_text(encoding="utf-8")),
        read_board(files["board"]),
        sweeps,
        read_table(files["poses"])[0],
        float(origin.get("duration_s") or last),
    )


def _path(poses: Mapping[str, np.ndarray], rows: np.ndarray | slice) -> Path:
    table = {key: np.asarray(values)[rows] for key, values in poses.items()}
    quaternion = np.column_stack([table[k] for k in ("qx", "qy", "qz", "qw")]).astype(np.float64)
    R = of_quaternions(quaternion) if len(quaternion) else np.zeros((0, 3, 3))
    place = np.column_stack([table[k] for k in ("x_m", "y_m", "z_m")]).astype(np.float64)
    rest = table["epsilon_rad2"], table["n_angles"], table["ambiguity"]
    return Path(table["time_s"], R, place, *rest)


def usual_ends(points: np.ndarray) -> np.ndarray:
    """Ends of all but the farthest hundredth in each coordinate: mirrored poses may be far off."""
    return np.percentile(points, [0.5, 99.5], axis=0) if len(points) else points
