"""Files of one calibration for the tests of its figures, made without the project's decoder."""

import json
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from mocap_metrology.common.files import write_json, write_table
from mocap_metrology.lighthouse.board import flat_board

FILES = {
    "pose": "pose.json", "poses": "poses.parquet", "sweeps": "sweeps.parquet",
    "stations": "stations.json", "board": "board.csv",
}  # fmt: skip
TURN = Rotation.from_euler("ZYX", [-37.0, -6.0, 11.5], degrees=True)  # gamma, beta, alpha
T_M = np.array([0.396, 1.995, 0.248])
CYCLE_S = 1 / 120
COVARIANCE = np.diag([1.0, 4.0, 0.25, 1e-4, 4e-4, 9e-4])
DEAD, FLASH_S, SLAVE_LATE_S, WIDTH_S = 13, 70e-6, 416.5e-6, 5e-6


def paths(seconds: float = 8.0, rate: float = 60.0):
    """Times, and the board on a half circle to and fro: R and p in the master's frame."""
    time = np.arange(0.05, seconds - 0.05, 1 / rate)
    swing = np.pi / 2 * np.sin(2 * np.pi * 0.2 * time)
    p = np.column_stack([3.2 + 0.05 * np.cos(swing), 0.2 * np.sin(swing), 0.2 * np.cos(swing)])
    R = Rotation.from_euler("ZYX", np.column_stack([np.pi + 0.3 * swing, 0.1 * swing, 0 * swing]))
    return time, R, p


def pose_entry(estimator: str, stage: str, optics: str, off_mm=(0.0, 0.0, 0.0)) -> dict:
    gamma, beta, alpha = TURN.as_euler("ZYX", degrees=True)
    return {
        "estimator": estimator,
        "stage": stage,
        "optics": optics,
        "frame": "optical",
        "translation_mm": (1e3 * T_M + off_mm).tolist(),
        "quaternion_xyzw": TURN.as_quat().tolist(),
        "rotation_deg": {"alpha": alpha, "beta": beta, "gamma": gamma},
        "covariance": COVARIANCE.tolist(),
        "residual_rms_urad": 41.5,
        "n_angles": 16274,
        "mirrored_share": 0.0,
        "note": "",
    }


def write_calibration(folder: Path) -> dict[str, Path]:
    """Paths of the files by their names."""
    board = flat_board()
    rows = ["x_m,y_m,z_m", *(",".join(map(repr, map(float, p))) for p in board)]
    (folder / "board.csv").write_text("\n".join(rows) + "\n")
    _write_sweeps(folder, board)
    _write_poses(folder, *paths())
    _write_pose(folder)
    return {key: folder / name for key, name in FILES.items()}


def _write_poses(folder: Path, time: np.ndarray, R: Rotation, p: np.ndarray) -> None:
    parts, n, rng = [], len(time), np.random.default_rng(7)
    for estimator, optics in (("paper-lm", "factory"), ("paper", "ideal")):
        for station in (0, 1):
            own_R, own_p = (R, p) if station == 0 else (TURN.inv() * R, TURN.inv().apply(p - T_M))
            own_p = own_p + 1e-3 * rng.standard_normal(own_p.shape)
            q = own_R.as_quat()
            if station == 1:  # one moment in the other minimum
                q[100] = (own_R[100] * Rotation.from_euler("Z", 30, degrees=True)).as_quat()
            parts.append({
                "estimator": np.full(n, estimator, dtype=object),
                "optics": np.full(n, optics, dtype=object),
                "station": np.full(n, station, dtype=np.int8),
                "time_s": time + 0.0001 * station,
                **dict(zip(("x_m", "y_m", "z_m"), own_p.T, strict=True)),
                **dict(zip(("qx", "qy", "qz", "qw"), q.T, strict=True)),
                "epsilon_rad2": np.full(n, 64 * (30e-6 + 10e-6 * station) ** 2),
                "n_angles": np.full(n, 64, dtype=np.int32),
                "ambiguity": np.full(n, np.nan),
            })  # fmt: skip
    whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    write_table(folder / "poses.parquet", whole, {})


def _write_pose(folder: Path) -> None:
    gamma, beta, alpha = TURN.as_euler("ZYX", degrees=True)
    reference = {
        "source": "truth",
        "translation_mm": (1e3 * T_M + [1.0, 2.0, 3.0]).tolist(),
        "rotation_deg": {"alpha": alpha, "beta": beta, "gamma": gamma},
    }
    stations = {"master": {"id": 1031, "mode": "b"}, "slave": {"id": None, "mode": "c"}}
    write_json(folder / "pose.json", {
        "stations": stations,
        "chosen": 0,
        "verdict": {"word": "good", "reason": "All checks passed."},
        "checks": [],
        "convention": "",
        "reference": reference,
        "poses": [
            pose_entry("paper-lm", "final", "factory"),
            pose_entry("paper", "kabsch", "ideal", (7.0, -3.0, 2.0)),
        ],
    })  # fmt: skip
    zero = {k: [0.0, 0.0] for k in ("phase", "tilt", "curve", "gibphase", "gibmag")}
    told = [
        {"role": "master", "id": 1031, "mode": "b", "factory": zero, "frames_found": 9, "why": ""},
        {"role": "slave", "id": None, "mode": "c", "factory": None, "frames_found": 0,
         "why": "no whole frame"},
    ]  # fmt: skip
    (folder / "stations.json").write_text(json.dumps(told))


def angle_of(station: int, axis: int, cycle: np.ndarray, diode: np.ndarray) -> np.ndarray:
    """Any angles do: of each diode and station another."""
    return 0.01 * diode + 0.1 * station - 0.2 * axis + 0.0 * cycle


def _write_sweeps(folder: Path, board: np.ndarray) -> None:
    """Sweeps of 8 s in the order slave, slave, master, master; and the pulses of 1 s of them."""
    cycle, diode = (a.ravel() for a in np.meshgrid(np.arange(960), np.arange(len(board))))
    station, axis = 1 - (cycle % 4) // 2, cycle % 2
    kept = diode != DEAD
    kept &= ~((diode == 20) & (station == 1) & (cycle % 12 > 3))
    cycle, diode, station, axis = (a[kept] for a in (cycle, diode, station, axis))
    angle = angle_of(station, axis, cycle, diode)
    begin = cycle * CYCLE_S + station * SLAVE_LATE_S
    time = begin + (angle / np.pi + 0.5) * CYCLE_S
    order = np.argsort(time)
    columns = {
        "station": station.astype(np.int8), "axis": axis.astype(np.int8),
        "cycle": cycle.astype(np.int32), "diode": diode.astype(np.int16), "time_s": time,
        "angle_rad": angle, "width_us": np.full(time.size, 1e6 * WIDTH_S, dtype=np.float32),
    }  # fmt: skip
    columns = {name: values[order] for name, values in columns.items()}
    write_table(folder / "sweeps.parquet", columns, {"duration_s": 8.0})
    early = columns["time_s"] < 1.0
    flash = (np.arange(120)[:, None] * CYCLE_S + [0.0, SLAVE_LATE_S]).ravel()
    start = [columns["time_s"][early] - WIDTH_S / 2, np.repeat(flash, len(board))]
    length = [np.full(early.sum(), WIDTH_S), np.full(flash.size * len(board), FLASH_S)]
    on = [columns["diode"][early], np.tile(np.arange(len(board)), flash.size)]
    start, length, on = (np.concatenate(v) for v in (start, length, on))
    order = np.argsort(start)
    pulses = {"start_s": start[order], "length_us": 1e6 * length[order], "diode": on[order]}
    write_table(folder / "pulses.parquet", pulses, {})
