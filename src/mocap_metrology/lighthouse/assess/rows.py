"""Rows of the tables of calibrations: poses to use, tracked receivers, noise of angles at rest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from mocap_metrology.common.files import read_json
from mocap_metrology.common.types import Record
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess.calibration_files import (
    AXES,
    KINDS,
    Columns,
    jitter,
    lengths,
)
from mocap_metrology.lighthouse.assess.pose_file import is_network, pairs
from mocap_metrology.lighthouse.published import QUANTITIES

Row = dict[str, Any]

NAMED = ("calibration", "setup", "source")
CHOSEN = ("estimator", "stage", "optics")
AXIS_NAMES = AXES["mm"] + AXES["deg"]
PARTS = ("common", "independent")
OF_PART = (
    *("adev_1_urad", "adev_1_lower_urad", "adev_1_upper_urad", "exponent", "adev_min_urad"),
    *("tau_min_s", "h_0_urad2_hz"),
)
ANGLE_HEAD = (
    *(*NAMED, "rotor", "n_diodes", "n_sweeps", "sd_urad"),
    *(f"{part}_{name}" for part in PARTS for name in OF_PART),
    *("step_urad", "below_step", "independent_below_step"),
)


def records_of(rows: Sequence[Record], paths: Sequence[str]) -> list[Row]:
    """Rows of the sheet, each with the contents of its pose.json."""
    return [{**row, "pose": read_json(path)} for row, path in zip(rows, paths, strict=True)]


def calibration_rows(records: Sequence[Record]) -> list[Row]:
    """One row a calibration with the pose chosen in its pose.json, or one a station; records:
    `calibration`, `setup`, `source` and `pose` (contents of pose.json)."""
    rows = []
    for record in records:
        for name, pose in pairs(record["pose"]).items():
            row = _calibration_row({**record, "pose": pose})
            if is_network(record["pose"]):
                row["calibration"] = f"{record['calibration']}, station {name}"
            rows.append(row)
    return rows


def _calibration_row(record: Record) -> Row:
    document = record["pose"]
    pose = {} if document["chosen"] is None else document["poses"][document["chosen"]]
    row: Row = {name: record[name] for name in NAMED}
    row |= {f"{role}_id": document["stations"][role]["id"] for role in ("master", "slave")}
    row |= {name: pose.get(name) for name in CHOSEN}
    t, turn = pose.get("translation_mm", [math.nan] * 3), pose.get("rotation_deg", {})
    angles = [turn.get(name, math.nan) for name in ("alpha", "beta", "gamma")]
    row |= dict(zip(QUANTITIES, [*map(float, t), *angles], strict=True))
    row["baseline_mm"] = float(np.linalg.norm(t))
    covariance = pose.get("covariance")
    variances = np.full(6, math.nan) if covariance is None else np.diag(np.array(covariance, float))
    sigma = np.sqrt(variances).tolist()
    row |= dict(zip((f"sigma_{axis}" for axis in AXIS_NAMES), sigma, strict=True))
    row |= {name: pose.get(name) for name in ("residual_rms_urad", "n_angles", "mirrored_share")}
    unknown = [math.nan] * 3
    errors = [*(pose.get("errors_mm") or unknown), *(pose.get("errors_deg") or unknown)]
    row |= dict(zip((f"error_{axis}" for axis in AXIS_NAMES), errors, strict=True))
    row |= {"verdict": document["verdict"]["word"], "reason": document["verdict"]["reason"]}
    row["check_against"] = (document.get("check_against") or {}).get("sentence")
    return row


def track_row(named: Record, track: Columns, origin: Record) -> Row:
    """One row of tracked receivers; named: `calibration`, `setup`, `source`; track, origin: of its
    track.parquet."""
    row: Row = {name: named[name] for name in NAMED}
    row["stations"] = origin.get("tracked_with") or ""
    hits = [track[name] > 0 for name in track if name.startswith("n_hits_")]
    seen, share = np.any(hits, axis=0), 100 / max(hits[0].size, 1)
    row |= {"n_poses": int(seen.sum()), "seen_percent": share * float(seen.sum())}
    row["one_station_percent"] = share * float((np.sum(hits, axis=0) == 1).sum())
    for kind in KINDS:
        row |= {f"{kind}_{unit}": _rms(lengths(track, kind, unit)) for unit in AXES}
    row |= {name: _rms(track[name]) for name in ("gain_mm_per_mm", "gain_mm_per_deg")}
    scatter = jitter(track) if origin.get("still") else (None, None)
    row |= dict(zip(("jitter_mm", "jitter_deg"), scatter, strict=True))
    row["residual_urad"] = _rms(track["residual_urad"])
    row["note"] = origin.get("reason") or origin.get("note") or ""
    return row


def _rms(values: np.ndarray) -> float | None:
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known.astype(np.float64) ** 2))) if known.size else None


def angle_rows(named: Record, allan: Mapping[str, np.ndarray], origin: Record) -> list[Row]:
    """Rows of one calibration, one a rotor, none of a board that moved; named: `calibration`,
    `setup`, `source`; allan, origin: of its allan.parquet."""
    rows = []
    for rotor in origin["rotors"]:
        row: Row = {name: named[name] for name in NAMED}
        row |= {"rotor": rotor["rotor"].replace("_", ", "), "n_diodes": len(rotor["diodes"])}
        row |= {"n_sweeps": rotor["sweeps"], "sd_urad": 1e6 * rotor["sd_rad"]}
        for part in PARTS:
            of_part = _angle_cells(allan, f"{rotor['rotor']}_{part}")
            row |= {f"{part}_{name}": value for name, value in of_part.items()}
        step = rotor["step_rad"]
        row["step_urad"] = None if step is None else 1e6 * step
        rows.append(row | {name: rotor[name] for name in ANGLE_HEAD[-2:]})
    return rows


def _angle_cells(allan: Mapping[str, np.ndarray], series: str) -> Row:
    mask = (allan["series"] == series) & (allan["estimator"] == "oadev")
    values: Row = dict.fromkeys(OF_PART)
    if not mask.any():
        return values
    tau, adev, alpha = (allan[name][mask] for name in ("tau_s", "adev_rad", "alpha"))
    best = int(adev.argmin())
    values |= {"adev_min_urad": 1e6 * float(adev[best]), "tau_min_s": float(tau[best])}
    if allan["m"][mask][0] == 1:
        for end in ("", "_lower", "_upper"):
            values[f"adev_1{end}_urad"] = 1e6 * float(allan[f"adev{end}_rad"][mask][0])
        values["exponent"] = int(alpha[0])
        if alpha[0] == 0:  # AVAR = h_0 / (2 tau)
            values["h_0_urad2_hz"] = 2e12 * float(tau[0] * adev[0] ** 2)
    return values


def spread(poses: np.ndarray) -> tuple[np.ndarray, float, float]:
    """Mean pose of rows x, y, z in mm and alpha, beta, gamma in deg, and the largest standard
    deviations (n - 1) of a translation's component and of a rotation vector's, NaN for one row."""
    from scipy.spatial.transform import Rotation

    if not len(poses):
        return np.full(6, np.nan), np.nan, np.nan
    turns = Rotation.from_euler("xyz", poses[:, 3:], degrees=True)
    centre = Rotation.from_matrix(rotation.mean(turns.as_matrix()))
    pose = np.concatenate([poses[:, :3].mean(axis=0), centre.as_euler("xyz", degrees=True)])
    if len(poses) < 2:
        return pose, np.nan, np.nan
    vectors = np.degrees((turns * centre.inv()).as_rotvec())
    mm, deg = (float(v.std(axis=0, ddof=1).max()) for v in (poses[:, :3], vectors))
    return pose, mm, deg
