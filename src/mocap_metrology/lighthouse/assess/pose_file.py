"""pose.json: all poses of one calibration, which one to use, and how far to trust it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.common.documents import load_json, text_of
from mocap_metrology.common.errors import UNREADABLE, Refusal
from mocap_metrology.common.types import Record, Row
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.assess.fit_checks import Check
from mocap_metrology.lighthouse.assess.reference import Reference, errors
from mocap_metrology.lighthouse.assess.validation import Verdict
from mocap_metrology.lighthouse.calibrate.network import Network
from mocap_metrology.lighthouse.records import ROLES, SLAVE, PoseEstimate, Station

CONVENTION = (
    "Pose of the slave in the master's frame: p_master = R p_slave + t. A station looks along "
    "its x axis, y to its own left, z up; the master is the station whose flash comes first. R = "
    "Rz(gamma) Ry(beta) Rx(alpha). Covariance: t_x, t_y, t_z in mm, then a left rotation vector "
    "in master axes in deg. Errors: t - t_true in mm and the rotation vector of R R_true^T in "
    "deg, in master axes. Mirrored share: share of the board poses of an estimate that are "
    "mirrored. Residual: of the slave's angles to the master's path. Noise gain: factor by which "
    "errors of the path increase the noise of an angle in the residual. Weighted: residual that "
    "these errors do not explain."
)
NETWORK_CONVENTION = (
    "Poses of stations in the frame of the one that `reference` names: p_reference = R p_station +"
    " t; stations are named by their channel, counted from 0. A station looks along its x axis, y"
    " to its own left, z up. R = Rz(gamma) Ry(beta) Rx(alpha). Covariances: t_x, t_y, t_z in mm,"
    " then a left rotation vector in axes of the reference in deg; covariance_joint: of all poses"
    " together, six rows for each of covariance_joint_stations in that order."
)
KIND = "estimator", "stage", "optics"
LARGEST_OFF_UNIT = 1e-2  # of the length of a quaternion


# Contents of pose.json, and one of its `poses`: keys as `pose_json` and `_entry` write them.
PoseFile = dict[str, Any]
PoseEntry = dict[str, Any]


def pose_json(
    poses: Sequence[PoseEstimate],
    stations: Sequence[Station],
    chosen: Mapping[str, int],
    verdict: Verdict,
    diagnostics: Mapping[str, object] | None = None,
    true: Mapping[str, Reference] | None = None,
    network: Network | None = None,
) -> PoseFile:
    """Contents of pose.json but for its sentences. stations: master first; chosen: index into
    `poses` of each station that has one, by name; true: poses that a lab measured, likewise;
    network: of any number of stations of the second generation.

    Of a PoseEstimate all is written but `seconds`, which changes from run to run; of the chosen one
    also what a later calibration is compared by. With a reference, each pose has `errors_mm` and
    `errors_deg`.
    """
    true = true or {}
    references = {name: _reference(one) for name, one in true.items()}
    entries = [_entry(pose, true.get(pose.station)) for pose in poses]
    for index in chosen.values():
        _add_for_later(entries[index], poses[index])
    document: PoseFile = {
        "stations": {one.role: {"id": one.id, "mode": one.mode} for one in stations},
        "chosen": chosen.get(ROLES[SLAVE]),
        "verdict": {"word": verdict.word},
        "checks": [check_row(check) for check in verdict.checks],
        "convention": CONVENTION,
        "reference": references.get(ROLES[SLAVE]),
        "diagnostics": dict(diagnostics or {}),
        "poses": entries,
    }
    if network is None:
        return document
    for entry, pose in zip(entries, poses, strict=True):
        entry["station"] = pose.station
    reference, joint = network.connected[0], network.covariance
    rest = [station.role for station in stations if station.role != reference]
    document |= {
        "stations": {one.role: {"id": one.id, "mode": str(one.channel)} for one in stations},
        "reference": reference,
        "chosen": {name: chosen.get(name) for name in rest},
        "convention": NETWORK_CONVENTION,
        "covariance_joint": None if joint is None else joint.tolist(),
        "covariance_joint_stations": [name for name in network.connected if name != reference],
        "station_verdicts": dict(verdict.words),
    }
    if references:
        keys = ("source", "translation_mm", "rotation_deg")
        document["reference_poses"] = {
            name: {key: one[key] for key in keys} for name, one in references.items()
        }
    return document


def is_network(document: PoseFile) -> bool:
    """Whether it is of any number of stations, named by their channels, not of a master and a
    slave."""
    return bool(document["stations"]) and all(name.isdigit() for name in document["stations"])


def pairs(document: PoseFile) -> dict[str, PoseFile]:
    """For each station but the reference, by name, its pose.json as that of a slave, with the
    reference as master; of two stations of the first generation the file itself."""
    if not is_network(document):
        return {ROLES[1]: document}
    stations, taken = document["stations"], document["chosen"]
    reference = str(document["reference"] or next(iter(stations)))
    by_name: dict[str, PoseFile] = {}
    for name in stations:
        if name == reference:
            continue
        rows = [k for k, entry in enumerate(document["poses"]) if entry.get("station") == name]
        index = None if taken is None else taken[name]
        both = {ROLES[0]: stations[reference], ROLES[1]: stations[name]}
        by_name[name] = {
            **document,
            "stations": both,
            "poses": [document["poses"][k] for k in rows],
            "chosen": None if index is None else rows.index(index),
            "reference": None,
        }
    return by_name


def check_row(check: Check) -> Row:
    """A check of pose.json, but for its sentence."""
    limit = check.limit
    return {
        "name": check.name,
        "value": check.value,
        "unit": check.unit,
        "limit": "{:.3g} mm, {:.3g}°".format(*limit) if isinstance(limit, tuple) else limit,
        "ok": check.ok,
        "level": check.level,
    }


def pose_row(R: np.ndarray, t_m: np.ndarray) -> Row:
    """A pose as it stands in pose.json: translation in mm, quaternion x, y, z, w."""
    q = rotation.quaternions(R).tolist()
    return {"translation_mm": (1e3 * np.asarray(t_m)).tolist(), "quaternion_xyzw": q}


def _angles(R: np.ndarray) -> Row:
    angles = np.degrees(rotation.to_angles(R)).tolist()
    return dict(zip(("alpha", "beta", "gamma"), angles, strict=True))


def _reference(reference: Reference) -> Row:
    return {
        "source": reference.source,
        "translation_mm": (1e3 * reference.t_m).tolist(),
        "rotation_deg": _angles(reference.R),
        "residual_rms_mm": dict(zip(ROLES, reference.residual_mm, strict=True)),
        "n_markers": dict(zip(ROLES, reference.n_markers, strict=True)),
    }


def _entry(pose: PoseEstimate, reference: Reference | None) -> PoseEntry:
    names = "residual_rms_urad", "n_angles", "mirrored_share", "weighted_rms_urad", "noise_gain"
    covariance = None if pose.covariance is None else np.asarray(pose.covariance).tolist()
    entry: PoseEntry = {name: getattr(pose, name) for name in (*KIND, "frame")}
    entry |= pose_row(pose.R, pose.t_m)
    entry |= {"rotation_deg": _angles(pose.R), "covariance": covariance}
    entry |= {name: getattr(pose, name) for name in names}
    entry |= {"halves": pose.halves and asdict(pose.halves), "note": pose.note}
    if pose.details is not None:
        entry["details"] = dict(pose.details)
    if reference is not None:
        mm, deg = errors(pose.R, pose.t_m, reference)
        entry |= {"errors_mm": mm.tolist(), "errors_deg": deg.tolist()}
    return entry


def _add_for_later(entry: PoseEntry, pose: PoseEstimate) -> None:
    """Noise, and errors that a later recording of the same board and stations shares."""
    if pose.covariance_noise is None or pose.shared is None:
        return
    shared = pose.shared

    def group(rows: np.ndarray) -> Row:
        effect = [[float(f"{value:.5g}") for value in row] for row in shared.effect[rows]]
        return {"sd": shared.sd[rows].tolist(), "effect": effect}

    entry["covariance_noise"] = np.asarray(pose.covariance_noise).tolist()
    entry["shared_errors"] = {
        "digest": shared.board,
        "stations": group(~shared.of_board),
        "board": group(shared.of_board),
    }


def read_pose_json(path: str | Path) -> PoseFile:
    """A pose.json as written by this project. Raises `Refusal` for anything else."""
    path = Path(path)
    text = text_of(path, "a pose.json")
    try:
        document: PoseFile = load_json(text)
    except UNREADABLE as error:
        raise Refusal(f"{path.name}: cannot be read ({error}); expected a pose.json") from None
    try:
        names = tuple(document["stations"]) if is_network(document) else ROLES
        for role in names:
            _ = document["stations"][role]["id"]
        for entry in document["poses"]:
            kind_of(entry)
            matrix_and_metres(entry)
            _check_covariance(entry.get("covariance"))
            _check_covariance(entry.get("covariance_noise"))
            _check_shared(entry.get("shared_errors"))
        for variant in document.get("variants", []):
            _check_variant(variant)
        for one in pairs(document).values():
            chosen = one["chosen"]
            if chosen is not None and not (type(chosen) is int and 0 <= chosen < len(one["poses"])):
                raise ValueError(f"chosen is {chosen!r} of {len(one['poses'])} poses")
    except UNREADABLE as error:
        raise Refusal(
            f"{path.name}: is no pose.json ({type(error).__name__}: {error}); expected stations,"
            " chosen and poses as this project writes them"
        ) from None
    return document


def matrix_and_metres(entry: PoseEntry) -> tuple[np.ndarray, np.ndarray]:
    """R (3, 3) and t (3,) in metres of one of the `poses`."""
    t = np.array(entry["translation_mm"], dtype=np.float64) / 1e3
    if t.shape != (3,) or not np.isfinite(t).all():
        raise ValueError(f"translation_mm is {entry['translation_mm']!r}")
    q = np.array(entry["quaternion_xyzw"], dtype=np.float64)
    if q.shape != (4,) or not abs(np.linalg.norm(q) - 1) <= LARGEST_OFF_UNIT:
        raise ValueError(f"quaternion_xyzw is {entry['quaternion_xyzw']!r}")
    return rotation.of_quaternions(q), t


def _check_covariance(rows: object) -> None:
    covariance = np.zeros((6, 6)) if rows is None else np.array(rows, dtype=np.float64)
    if covariance.shape != (6, 6) or not np.allclose(covariance, covariance.T, rtol=1e-6):
        raise ValueError("a covariance is no symmetric matrix of 6 x 6 finite numbers")


def _check_variant(variant: Record) -> None:
    _ = variant["chosen"], variant["standing"], hash(variant["variant"])
    R = np.array(variant["rotation_matrix"], dtype=np.float64)
    t = np.array(variant["translation_mm"], dtype=np.float64)
    if R.shape != (3, 3) or t.shape != (3,) or not np.allclose(R @ R.T, np.eye(3), atol=1e-6):
        raise ValueError(f"variant {variant['variant']!r} has no pose")
    if not np.isfinite(t).all():
        raise ValueError(f"translation_mm of variant {variant['variant']!r} is {t.tolist()}")


def _check_shared(shared: Record | None) -> None:
    if shared is None:
        return
    _ = shared["digest"]
    for name, group in (("stations", shared["stations"]), ("board", shared["board"])):
        sd = np.array(group["sd"], dtype=np.float64)
        effect = np.array(group["effect"], dtype=np.float64)
        right = sd.ndim == 1 and effect.size == 6 * sd.size and np.isfinite(effect).all()
        if not (right and np.isfinite(sd).all() and (sd > 0).all()):
            raise ValueError(f"shared_errors: {name} is no list of errors and their effects")


def chosen_pose(document: PoseFile) -> PoseEntry | None:
    """The pose to use, None if there is none; of any number of stations that of the first other
    than the reference."""
    if is_network(document):
        entries = (chosen_pose(one) for one in pairs(document).values())
        return next((entry for entry in entries if entry is not None), None)
    return None if document["chosen"] is None else document["poses"][document["chosen"]]


def kind_of(entry: PoseEntry) -> tuple[str, str, str]:
    """Estimator, stage and optics of a pose."""
    estimator, stage, optics = (entry[name] for name in KIND)
    return estimator, stage, optics
