"""What figures of a calibration show: its files read, and both paths of the board compared."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mocap_metrology.common.files import read_table
from mocap_metrology.lighthouse.assess.pose_file import (
    PoseEntry,
    PoseFile,
    chosen_pose,
    matrix_and_metres,
    read_pose_json,
)
from mocap_metrology.lighthouse.board import read_board
from mocap_metrology.lighthouse.calibrate.superpose import at_times
from mocap_metrology.lighthouse.fit.board_pose import MIRRORED_RAD
from mocap_metrology.lighthouse.records import MASTER, SLAVE
from mocap_metrology.lighthouse.records import Path as BoardPath
from mocap_metrology.lighthouse.rotation import from_angles
from mocap_metrology.present.tables import Record

Pose = tuple[np.ndarray, np.ndarray]  # R (3, 3), t (3,) in metres


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
        """The estimate to use, None if there is none."""
        return chosen_pose(self.pose)

    @property
    def simulated(self) -> str:
        """Where the recording comes from, in words."""
        return f"Simulated stand-in (twin) {self.twin}." if self.twin else "Measured."

    def paths(self, estimator: str, optics: str) -> tuple[BoardPath, BoardPath] | None:
        """Board poses in the frames of master and slave, None without two of each. `batch` has one
        trajectory and no such poses: shown are those of `paper-lm`."""
        if estimator == "batch":
            estimator, optics = "paper-lm", "ideal" if optics == "estimated" else optics
        if not len(self.poses.get("time_s", ())):
            return None
        names = (np.asarray(self.poses[key]).astype(str) for key in ("estimator", "optics"))
        own = np.logical_and(*(a == b for a, b in zip(names, (estimator, optics), strict=True)))
        master, slave = (
            _path(self.poses, own & (self.poses["station"] == station))
            for station in (MASTER, SLAVE)
        )
        return (master, slave) if min(len(master), len(slave)) > 1 else None

    @property
    def kinds(self) -> list[tuple[str, str]]:
        """Estimator and optics of all board poses there are."""
        names = (np.asarray(self.poses.get(k, ())).astype(str) for k in ("estimator", "optics"))
        return sorted(set(zip(*(own.tolist() for own in names), strict=True)))

    def estimate(self, estimator: str, stage: str, optics: str) -> PoseEntry | None:
        """One of the estimates in pose.json."""
        kind = estimator, stage, optics
        every = (p for p in self.pose["poses"] if _kind(p) == kind)
        return next(every, None)

    @property
    def reference(self) -> Pose | None:
        """True pose, where one is known."""
        given = self.pose.get("reference")
        if not given:
            return None
        angles = [np.radians(given["rotation_deg"][k]) for k in ("alpha", "beta", "gamma")]
        return from_angles(*angles), np.array(given["translation_mm"]) / 1e3


def _kind(entry: PoseEntry) -> tuple[str, str, str]:
    return entry["estimator"], entry["stage"], entry["optics"]


def read_calibration(
    files: Mapping[str, str | Path], name: str, twin: str | bool | None = None
) -> CalibrationFiles:
    """Read `pose`, `poses`, `sweeps`, `stations` and `board` of one calibration.

    twin: name of the twin it was simulated from; True: one of the calibration's name.
    """
    sweeps, origin = read_table(files["sweeps"])
    poses, _ = read_table(files["poses"])
    last = float(sweeps["time_s"].max()) if sweeps["time_s"].size else 0.0
    return CalibrationFiles(
        name,
        name if twin is True else twin or None,
        read_pose_json(files["pose"]),
        json.loads(Path(files["stations"]).read_text(encoding="utf-8")),
        read_board(files["board"]),
        sweeps,
        poses,
        float(origin.get("duration_s") or last),
    )


def _path(poses: Mapping[str, np.ndarray], rows: np.ndarray) -> BoardPath:
    from scipy.spatial.transform import Rotation

    own = {key: np.asarray(values)[rows] for key, values in poses.items()}
    quaternion = np.column_stack([own[k] for k in ("qx", "qy", "qz", "qw")]).astype(np.float64)
    R = Rotation.from_quat(quaternion).as_matrix() if len(quaternion) else np.zeros((0, 3, 3))
    place = np.column_stack([own[k] for k in ("x_m", "y_m", "z_m")]).astype(np.float64)
    rest = own["epsilon_rad2"], own["n_angles"], own["ambiguity"]
    return BoardPath(own["time_s"], R, place, *rest)


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
        mirrored: np.ndarray = self.turned_deg > np.degrees(MIRRORED_RAD)
        return mirrored


def agreement(paths: tuple[BoardPath, BoardPath], pose: Pose) -> Agreement:
    """p_m against R p_s + t and R_m against R R_s, p_s and R_s interpolated (J VI-C)."""
    master, slave = paths
    R, t = pose
    then, kept = at_times(slave, master.time_s)
    _, both = at_times(master, slave.time_s)
    own = master.take(kept)
    moved = then.t_m @ R.T + t
    trace = np.einsum("nij,ik,nkj->n", own.R, R, then.R)
    alone = master.time_s[~kept], slave.time_s[~both]
    first, last = (own.time_s[0], own.time_s[-1]) if len(own) else (np.inf, -np.inf)
    return Agreement(
        own.time_s,
        own.t_m,
        moved,
        1e3 * np.linalg.norm(own.t_m - moved, axis=1),
        np.degrees(np.arccos(np.clip((trace - 1) / 2, -1, 1))),
        tuple(t_s[(t_s > first) & (t_s < last)] for t_s in alone),
    )


def pose_of(entry: PoseEntry) -> Pose:
    """R, t in metres of one of the estimates."""
    return matrix_and_metres(entry)


def residuals_urad(path: BoardPath) -> np.ndarray:
    """Root mean square of C - M of each board pose, sqrt(epsilon / n_angles), in urad."""
    residuals: np.ndarray = 1e6 * np.sqrt(path.epsilon / np.maximum(path.n_angles, 1))
    return residuals


def seen_shares(sweeps: Mapping[str, np.ndarray], station: int, n_diodes: int) -> np.ndarray:
    """Share of a station's sweeps that each diode saw, (n,), of those that any diode saw."""
    own = np.asarray(sweeps["station"]) == station
    cycle, diode = np.asarray(sweeps["cycle"])[own], np.asarray(sweeps["diode"])[own]
    pairs = np.unique(np.column_stack([cycle, diode]).astype(np.int64), axis=0)
    counts = np.bincount(pairs[:, 1], minlength=n_diodes)[:n_diodes]
    return counts / max(np.unique(cycle).size, 1)


def thinned(count: int, most: int = 1500) -> slice:
    """A stride that leaves at most so many of `count` points."""
    return slice(None, None, max(-(-count // most), 1))
