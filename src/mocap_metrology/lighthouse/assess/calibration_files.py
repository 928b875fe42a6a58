"""One calibration, read from its files for its figures."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mocap_metrology.common.files import read_table
from mocap_metrology.common.types import Record
from mocap_metrology.lighthouse.assess import pose_file
from mocap_metrology.lighthouse.assess.evidence import Agreement, agreement
from mocap_metrology.lighthouse.assess.pose_file import PoseEntry, PoseFile, matrix_and_metres
from mocap_metrology.lighthouse.board import read_board
from mocap_metrology.lighthouse.records import MASTER, ROLES, SLAVE
from mocap_metrology.lighthouse.records import Path as BoardPath
from mocap_metrology.lighthouse.rotation import from_angles

Pose = tuple[np.ndarray, np.ndarray]  # R (3, 3), t (3,) in metres
Paths = tuple[BoardPath, BoardPath]  # of the board in the frames of master and slave


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
        return pose_file.chosen_pose(self.pose)

    @property
    def names(self) -> list[str]:
        """Of the stations, as in `sweeps`: by rising channel, or master and slave."""
        return [str(station["role"]) for station in self.stations]

    @property
    def entries(self) -> dict[str, PoseEntry | None]:
        """The estimate to use of each station but the reference, by name."""
        pairs = pose_file.pairs(self.pose).items()
        return {name: pose_file.chosen_pose(one) for name, one in pairs}

    @property
    def reference_name(self) -> str:
        """Of the station whose frame is used."""
        if pose_file.is_network(self.pose):
            return str(self.pose["reference"] or self.names[0])
        return ROLES[MASTER]

    def frames(self) -> dict[str, Pose]:
        """Poses of the stations that have one, by name, the reference first."""
        own = {name: matrix_and_metres(e) for name, e in self.entries.items() if e is not None}
        return {self.reference_name: (np.eye(3), np.zeros(3))} | own

    def paths(self, estimator: str, optics: str) -> Paths | None:
        """Board poses in the frames of master and slave, None without two of each. `batch` has one
        trajectory and no such poses: shown are those of `paper-lm`, of any number of stations the
        trajectory."""
        if pose_file.is_network(self.pose):
            rows = np.ones(len(self.poses.get("time_s", ())), np.bool_)
            own = _path(self.poses, rows) if rows.sum() > 1 else None
            return None if own is None else (own, own)
        if estimator == "batch":
            estimator, optics = "paper-lm", "ideal" if optics == "estimated" else optics
        if not len(self.poses.get("time_s", ())):
            return None
        names = (np.asarray(self.poses[key]).astype(str) for key in ("estimator", "optics"))
        own = np.logical_and(*(a == b for a, b in zip(names, (estimator, optics), strict=True)))
        station = self.poses["station"]
        master, slave = (_path(self.poses, own & (station == k)) for k in (MASTER, SLAVE))
        return (master, slave) if min(len(master), len(slave)) > 1 else None

    def shown_paths(self) -> Paths | None:
        """Of the chosen estimate; any where there is none."""
        if self.chosen is not None:
            return self.paths(self.chosen["estimator"], self.chosen["optics"])
        names = (np.asarray(self.poses.get(k, ())).astype(str) for k in ("estimator", "optics"))
        kinds = sorted(set(zip(*(own.tolist() for own in names), strict=True)))
        return next((paths for kind in kinds if (paths := self.paths(*kind))), None)

    def agreement(self) -> Agreement | None:
        """Both paths by the chosen estimate, compared; None without one or a common moment."""
        paths = self.shown_paths()
        if self.chosen is None or paths is None or pose_file.is_network(self.pose):
            return None
        both = agreement(paths, pose_file.matrix_and_metres(self.chosen))
        return both if both.time_s.size else None

    def estimate(self, *kind: str) -> PoseEntry | None:
        """One of the estimates in pose.json, by estimator, stage and optics."""
        poses = self.pose["poses"]
        return next((p for p in poses if (p["estimator"], p["stage"], p["optics"]) == kind), None)

    @property
    def reference(self) -> Pose | None:
        """True pose, where one is known."""
        true = self.pose.get("reference")
        if not true or pose_file.is_network(self.pose):
            return None
        angles = [np.radians(true["rotation_deg"][k]) for k in ("alpha", "beta", "gamma")]
        return from_angles(*angles), np.array(true["translation_mm"]) / 1e3


def read_calibration(
    files: Mapping[str, str | Path], name: str, twin: str | bool | None
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
        json.loads(Path(files["stations"]).read_text(encoding="utf-8")),
        read_board(files["board"]),
        sweeps,
        read_table(files["poses"])[0],
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


def usual(points: np.ndarray) -> np.ndarray:
    """Ends of all but the farthest hundredth in each coordinate: mirrored poses may be far off."""
    return np.percentile(points, [0.5, 99.5], axis=0) if len(points) else points
