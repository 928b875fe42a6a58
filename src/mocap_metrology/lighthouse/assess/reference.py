"""The true pose of the slave, as another system measured it, and the errors against it.

A reference is a pose file (JSON) or the markers on mounts of both housings, seen by a motion
capture system: Kabsch's algorithm on the known geometry of a mount gives the pose of its housing,
and R = R_m^T R_s, t = R_m^T (t_s - t_m) the slave in the master's frame. It is the pose of the
housings; an estimate is of the optical frames, whose origin is the assumed place of the lasers.

Stations are known by the id in their flashes: poses of different ones are never compared.
"""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, SupportsInt

import numpy as np

from mocap_metrology.common.documents import load_json, text_of
from mocap_metrology.common.errors import UNREADABLE, Refusal
from mocap_metrology.common.types import Row
from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.board import narrowness_m, read_places
from mocap_metrology.lighthouse.calibrate.superpose import kabsch
from mocap_metrology.lighthouse.decode.factory_file import crazyflie_geometry, finite, is_crazyflie
from mocap_metrology.lighthouse.decode.libsurvive_solution import read_solution, solution_pose
from mocap_metrology.lighthouse.records import ROLES, Hits, Station

ID = re.compile(r"\s*[+-]?(0[xX][0-9a-fA-F]{1,16}|[0-9]{1,20})\s*")
LARGEST_RESIDUAL_MM = 5.0
LARGEST_MOTION_MM = 5.0  # standard deviation of a marker that ought to be at rest
LONGEST_M, SHORTEST_M = 30.0, 0.1  # baselines outside are given in the wrong unit
LARGEST_MOUNT_M = 1.0
NARROWEST_M = 3e-3  # spread of markers off their line, root of the sum of squares
Ids = tuple[int | None, int | None]  # of master and slave, None where unknown


@dataclass(frozen=True)
class Reference:
    """True pose of the slave in the master's frame.

    R (3, 3), t_m (3,) in metres; ids of master and slave, None where the source names none;
    residual_mm: rms of the markers about each mount's geometry, master and slave, NaN for a pose
    file; n_markers likewise; source: where it comes from, in words.
    """

    R: np.ndarray
    t_m: np.ndarray
    ids: tuple[int | None, int | None] = (None, None)
    source: str = ""
    residual_mm: tuple[float, float] = (math.nan, math.nan)
    n_markers: tuple[int, int] = (0, 0)


def errors(R: np.ndarray, t_m: np.ndarray, reference: Reference) -> tuple[np.ndarray, np.ndarray]:
    """Error of a pose in the master's axes: t - t_true in mm (3,), and the rotation vector of R
    R_true^T in deg (3,)."""
    turn = rotation.error(np.asarray(R), reference.R)
    return 1e3 * (np.asarray(t_m) - reference.t_m), np.degrees(turn)


def optical(reference: Reference, lasers_m: np.ndarray) -> Reference:
    """The reference in the frames that angles alone determine, for lasers at known places.

    lasers_m (2 stations, 2 axes, 3) in the housings, metres. With o of `optical_origins`, the
    slave's optical origin is t + R o_slave - o_master in the master's.
    """
    origin = optical_origins(lasers_m)
    return replace(reference, t_m=reference.t_m + reference.R @ origin[1] - origin[0])


def optical_origins(lasers_m: np.ndarray) -> np.ndarray:
    """Optical origins (n, 3) of stations in their housings, from lasers_m (n, 2 axes, 3) in m.

    Azimuth depends on x and y of its laser, elevation on x and z of its own: a station's optical
    origin is (mean x, y of axis 0, z of axis 1).
    """
    lasers = np.asarray(lasers_m, dtype=np.float64)
    return np.stack([lasers[:, :, 0].mean(axis=1), lasers[:, 0, 1], lasers[:, 1, 2]], axis=1)


def reconstruction_errors(
    hits: Hits, board: np.ndarray, true_rotation: np.ndarray, true_position_m: np.ndarray
) -> dict[str, tuple[float, float]]:
    """Lengths of the errors of the slave's pose, mm and deg, by each of J's three ways of
    completing measurements (IV), linear interpolation and ideal optics, against the truth R (3, 3),
    t (3,) in m. By `paper-lm`, which finds the minimum of J's cost: his simplex would add its own
    error. A way that is refused is left out."""
    from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate
    from mocap_metrology.lighthouse.calibrate.reconstruction import METHODS

    truth, by_way = Reference(true_rotation, true_position_m), {}
    for way in METHODS:
        settings = CalibrationSettings(
            ("paper-lm",), ("ideal",), reconstruction=way, lm_interpolation="linear"
        )
        try:
            estimates = calibrate(hits, board, (None, None), settings).estimates
        except Refusal:
            continue
        last = next(e for e in estimates if e.stage in ("final", "static"))
        offset, turn = errors(last.R, last.t_m, truth)
        by_way[way] = float(np.linalg.norm(offset)), float(np.linalg.norm(turn))
    return by_way


def check_ids(reference: Reference, stations: Sequence[Station]) -> str:
    """`check_same_ids` of a reference; stations: master first."""
    ids = (stations[0].id, stations[1].id)
    return check_same_ids(reference.ids, ids, "reference", "the recording")


def pose_reference(path: str | Path) -> Reference:
    """Reference from a file of JSON, a Crazyflie's system configuration or libsurvive's.

    JSON: `R` (3 x 3) or `quaternion_xyzw`; `t_m` or `t` in metres, or `translation_mm`; the ids in
    `stations`, {"master": id, "slave": id}.

    Raises `Refusal` for a missing or impossible entry and for a translation in the wrong unit.
    """
    name = Path(path).name
    text = text_of(path, "a pose file")
    document = _of_crazyflie(text, name) or _of_libsurvive(path, text) or of_json(text, name)
    if not isinstance(document, dict):
        raise Refusal(f"{name}: expected an object with R, t_m and stations")
    stations = document.get("stations", document)
    if not isinstance(stations, dict) or not all(role in stations for role in ROLES):
        raise Refusal(f'{name}: no station ids; expected "stations": {{"master": id, "slave": id}}')
    master, slave = (station_id(stations[role], f"{name}: {role}") for role in ROLES)
    R, t_m = rotation_in(document, name), translation_in(document, name)
    baseline = float(np.linalg.norm(t_m))
    if not SHORTEST_M <= baseline <= LONGEST_M:
        raise Refusal(
            f"{name}: the translation puts the stations {baseline:g} m apart; expected"
            f" {SHORTEST_M:g} to {LONGEST_M:g} m (is the unit right?)"
        )
    return Reference(R, t_m, (master, slave), f"pose file {name}")


def of_json(text: str, name: str) -> Any:
    try:
        return load_json(text)
    except UNREADABLE as error:
        raise Refusal(f"{name}: cannot be read as JSON ({error}); expected a pose file") from None


def is_libsurvive(text: str) -> bool:
    """Whether a text is libsurvive's configuration, which has no outer braces."""
    return '"lighthouse' in text and not text.lstrip().startswith("{")


def _of_crazyflie(text: str, name: str) -> Row | None:
    """Entries of a pose file from a Crazyflie's system configuration; None for any other text."""
    if not is_crazyflie(text):
        return None
    (uid, _, t), (uid_s, _, t_s) = (geos := crazyflie_geometry(text, name, 1)).values()
    R, R_s = (
        rotation_in({"R": geometry[1]}, f"{name}: geos.{k}.rotation")
        for k, geometry in geos.items()
    )
    return {"R": R.T @ R_s, "t_m": R.T @ (t_s - t), "stations": {"master": uid, "slave": uid_s}}


def _of_libsurvive(path: str | Path, text: str) -> Row | None:
    if not is_libsurvive(text):
        return None
    solved = read_solution(path)
    R, t = solution_pose(solved)
    ids = {station.index: station.id for station in solved}
    return {"R": R, "t_m": t, "stations": {"master": ids[1], "slave": ids[0]}}


def rotation_in(entry: Mapping[str, object], name: str) -> np.ndarray:
    """Rotation (3, 3) of a pose file."""
    if "R" in entry:
        R = finite(entry["R"], (3, 3), f"{name}: R")
        off = float(np.abs(R @ R.T - np.eye(3)).max())
        if off > 1e-3 or np.linalg.det(R) < 0:
            kind = "a mirror image" if off <= 1e-3 else f"{off:.2g} off at most in R R^T"
            raise Refusal(f"{name}: R is no rotation ({kind}); expected R R^T = 1, det R = 1")
        U, _, Vt = np.linalg.svd(R)
        return U @ Vt
    if "quaternion_xyzw" not in entry:
        raise Refusal(f"{name}: no rotation; expected R (3 x 3) or quaternion_xyzw")
    q = finite(entry["quaternion_xyzw"], (4,), f"{name}: quaternion_xyzw")
    if abs(np.linalg.norm(q) - 1) > 1e-2:
        raise Refusal(f"{name}: quaternion_xyzw has norm {np.linalg.norm(q):.4g}; expected 1")
    return rotation.of_quaternions(q)


def translation_in(entry: Mapping[str, object], name: str) -> np.ndarray:
    """Translation (3,) of a pose file in m, by whatever name."""
    key = next((k for k in ("t_m", "t", "translation_mm") if k in entry), None)
    if key is None:
        raise Refusal(f"{name}: no translation; expected t_m (metres) or translation_mm")
    t = finite(entry[key], (3,), f"{name}: {key}")
    return t * (1e-3 if key == "translation_mm" else 1.0)


def read_mount(path: str | Path) -> dict[str, np.ndarray]:
    """Geometry of a mount, label -> position (3,) in m in the housing's frame; raises as
    `read_places`."""
    return read_places(path, "marker", LARGEST_MOUNT_M, "the housing's origin")


def reference_from_markers(
    positions_mm: np.ndarray,
    labels: Sequence[str],
    labels_master: Sequence[str],
    labels_slave: Sequence[str],
    mount: Mapping[str, np.ndarray],
    source: str = "markers",
) -> Reference:
    """Reference from the markers on both mounts, at rest.

    positions_mm (markers, 3, frames), NaN in gaps, each averaged over the frames it is seen in;
    labels: of these; mount: label -> place in the housing's frame in m. It lists the labels of a
    housing, or, shared by both, others of its own in the order of the labels.

    Raises `Refusal` for unknown labels, fewer than three markers or all on a line, a marker that
    moves more than 5 mm, and a residual above 5 mm rms, naming the marker.
    """
    poses, residuals = [], []
    for role, names in zip(ROLES, (labels_master, labels_slave), strict=True):
        where = f"reference, mount of the {role}"
        known = _geometry(names, mount, where)
        seen = np.array([_marker_place(positions_mm, labels, label, where) for label in names])
        R, t, rms = _fit(known, seen, list(names), where)
        poses.append((R, t))
        residuals.append(rms)
    (R_m, t_m), (R_s, t_s) = poses
    return Reference(
        R_m.T @ R_s,
        R_m.T @ (t_s - t_m),
        source=source,
        residual_mm=(residuals[0], residuals[1]),
        n_markers=(len(labels_master), len(labels_slave)),
    )


def _geometry(labels: Sequence[str], mount: Mapping[str, np.ndarray], where: str) -> np.ndarray:
    """Places (k, 3) in m of a housing's labels in its frame."""
    if len(labels) < 3 or len(set(labels)) < len(labels):
        raise Refusal(
            f"{where}: labels are {';'.join(labels)!r}; expected at least three, all different"
        )
    missing = [label for label in labels if label not in mount]
    if not missing:
        return np.array([mount[label] for label in labels])
    if len(missing) == len(labels) == len(mount):  # shared: its own labels, in order
        return np.array(list(mount.values()))
    raise Refusal(
        f"{where}: {missing[0]} is not in the mount's geometry ({', '.join(mount)}); expected all"
        f" {len(labels)} labels there, or as many others in the same order"
    )


def _marker_place(
    positions_mm: np.ndarray, labels: Sequence[str], label: str, where: str
) -> np.ndarray:
    if label not in labels:
        raise Refusal(f"{where}: marker {label} is not in the recording ({', '.join(labels)})")
    track = np.asarray(positions_mm[list(labels).index(label)], dtype=np.float64)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # no frame at all
        mean = np.nanmean(track, axis=1)
        motion = math.sqrt(np.nansum(np.nanvar(track, axis=1)))
    if not np.isfinite(mean).all():
        raise Refusal(f"{where}: marker {label} is not visible in any frame; expected it in some")
    if motion > LARGEST_MOTION_MM:
        raise Refusal(
            f"{where}: marker {label} moves by {motion:.1f} mm rms; expected a housing at rest"
            f" (below {LARGEST_MOTION_MM:g} mm)"
        )
    return 1e-3 * mean


def _fit(
    known: np.ndarray, seen: np.ndarray, labels: list[str], where: str
) -> tuple[np.ndarray, np.ndarray, float]:
    """Pose R, t (m) of a housing in the laboratory, and the rms distance of its markers in mm."""
    for points in (known, seen):
        if narrowness_m(points) < NARROWEST_M:
            raise Refusal(f"{where}: {', '.join(labels)} lie on one line; expected a triangle")
    R, t, off = _residuals(known, seen)
    rms = 1e3 * float(np.sqrt(np.mean(off**2)))
    if rms > LARGEST_RESIDUAL_MM:
        worst = int(np.argmax(off))
        if len(labels) > 3:  # the marker without which the others fit best
            others = [np.delete(np.arange(len(labels)), k) for k in range(len(labels))]
            left = [np.mean(_residuals(known[o], seen[o])[2] ** 2) for o in others]
            worst = int(np.argmin(left))
        raise Refusal(
            f"{where}: markers are {rms:.1f} mm rms from the mount's geometry; expected at most "
            f"{LARGEST_RESIDUAL_MM:g} mm; check marker {labels[worst]} first"
        )
    return R, t, rms


def _residuals(known: np.ndarray, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Kabsch, and the distance (k,) in m of each marker from where the mount has it."""
    R, t = kabsch(known, seen)
    return R, t, np.linalg.norm(known @ R.T + t - seen, axis=1)


def station_id(value: object, where: str) -> int | None:
    """Id from a number, a text of one (decimal, or hexadecimal after 0x), or an entry with `id`."""
    if isinstance(value, Mapping):
        value = value.get("id")
    if value is None:
        return None
    try:
        if isinstance(value, str):
            if not ID.fullmatch(value):
                raise ValueError
            return int(value, 0)
        if isinstance(value, (bool, float)) or not isinstance(value, SupportsInt):
            raise ValueError
        return int(value)
    except (TypeError, ValueError):
        raise Refusal(f"{where}: id is {str(value)[:30]!r}; expected a whole number") from None


def check_same_ids(theirs: Ids, ours: Ids, what: str, where: str) -> str:
    """Refuse `what` when its stations are not those of `where`, or have their roles swapped.
    Returns a sentence on the ids that are unknown and so unchecked; empty if both are known."""
    swapped = ours[::-1]
    if None not in ours and ours[0] != ours[1] and theirs == swapped:
        raise Refusal(
            f"{what}: master and slave are swapped: it names {theirs[0]} as master and {theirs[1]}"
            f" as slave, {where} the other way round; expected the pose of {ours[1]} in {ours[0]}"
            " (exchange the ids and invert the pose: R^T, -R^T t)"
        )
    for role, its, known in zip(("master", "slave"), theirs, ours, strict=True):
        if its is not None and known is not None and its != known:
            raise Refusal(
                f"{what}: its {role} is station {its}, that of {where} is {known};"
                " expected a pose of the same two stations"
            )
    unknown = [
        f"{role} of {source}"
        for source, ids in ((what, theirs), (where, ours))
        for role, one in zip(("master", "slave"), ids, strict=True)
        if one is None
    ]
    return f"Station ids not compared: unknown for {', '.join(unknown)}." if unknown else ""
