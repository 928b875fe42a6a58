"""Poses of the stations in a frame of the room, as files of other programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.common.files import write_text
from mocap_metrology.common.types import Row
from mocap_metrology.lighthouse.assess.reference import optical_origins
from mocap_metrology.lighthouse.calibrate.jansen import Calibration
from mocap_metrology.lighthouse.export.formats import (
    Export,
    crazyflie_yaml,
    libsurvive_json,
    ros2_launch,
)
from mocap_metrology.lighthouse.export.world import WORDS, Calibrated, World, world_of
from mocap_metrology.lighthouse.records import MASTER, PoseEstimate, Station

FORMATS = {"crazyflie": crazyflie_yaml, "libsurvive": libsurvive_json, "ros2": ros2_launch}
Pose = tuple[np.ndarray, np.ndarray]


def frame_of(
    found: Calibration,
    pose: PoseEstimate,
    stations: Sequence[Station],
    board: np.ndarray,
    name: str,
    points: str | None,
) -> tuple[World, list[Pose]]:
    """The requested frame, and the poses of both stations in it; pose: the chosen one of `found`.
    Raises `Refusal` for points that determine no frame."""
    poses = [(np.eye(3), np.zeros(3)), (pose.R, pose.t_m)]
    path, both = pose.path, found.paths_of(pose)
    if path is None and both is not None:
        path = both[MASTER]
    felt = (pose.details or {}).get("inertial")
    up = -np.array(felt["gravity_m_s2"]) if isinstance(felt, Mapping) else None
    world = world_of(name, Calibrated(stations, poses, board, path, up), points)
    return world, [world.place(one) for one in poses]


def write_exports(
    origin: Row,
    verdict: Mapping[str, str],
    stations: Sequence[Station],
    placed: tuple[World, list[Pose]] | None,
    lasers_m: np.ndarray | None,
    files: Mapping[str, str],
) -> Row:
    """Write the file of each program; return what pose.json holds of them under `world`.

    origin: `recording` and `twin` are names; verdict: its word and reason; placed: result of
    `frame_of`, None without a pose; lasers_m: as in `CalibrationSettings`. A failed calibration has
    no poses in any file, but its reason; `files` are named as `FORMATS`.
    """
    remarks = [f"Base stations of calibration {origin['recording']}, verdict {verdict['word']}."]
    if origin["twin"]:
        remarks.append(f"Simulated stand-in (twin) {origin['twin']}.")
    if placed is None or verdict["word"] == "failed":
        remarks.append(f"No poses, because the calibration failed: {verdict['reason']}")
        export, entry = Export(stations, None, remarks), Row(name=None, stations={})
    else:
        world, poses = placed
        poses = _of_optics(poses, lasers_m)
        remarks.append(f"World, in metres: {described(world)}.")
        export, entry = Export(stations, poses, remarks), _entry(world, stations, poses)
    for name, text in FORMATS.items():
        write_text(files[name], text(export))
    return entry


def described(world: World) -> str:
    """The frame in words, with what limits it."""
    words = WORDS[world.name]
    if world.rms_m is not None and world.residuals_m is not None:
        words += f" ({len(world.residuals_m)}, {1e3 * world.rms_m:.1f} mm rms from them)"
    return f"{words} ({world.why})" if world.why else words


def _of_optics(poses: list[Pose], lasers_m: np.ndarray | None) -> list[Pose]:
    """Poses of the stations' optics, which other programs track with; those of a calibration with
    `lasers_mm` are of the housings."""
    if lasers_m is None:
        return poses
    origins = optical_origins(lasers_m)
    return [(R, R @ own + t) for (R, t), own in zip(poses, origins, strict=True)]


def _entry(world: World, stations: Sequence[Station], poses: Sequence[Pose]) -> Row:
    from scipy.spatial.transform import Rotation

    off = world.residuals_m
    return {
        "name": world.name,
        "frame": WORDS[world.name],
        "why": world.why,
        "residual_rms_mm": None if world.rms_m is None else 1e3 * world.rms_m,
        "residuals_mm": None if off is None else {k: 1e3 * v for k, v in off.items()},
        "stations": {
            station.role: {
                "translation_mm": (1e3 * t).tolist(),
                "quaternion_xyzw": Rotation.from_matrix(R).as_quat(canonical=True).tolist(),
            }
            for station, (R, t) in zip(stations, poses, strict=True)
        },
    }
