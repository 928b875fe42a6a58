"""Poses of the stations in the frame that a user wants, and in the files of other programs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mocap_metrology.calibration.sweeps import Paths
from mocap_metrology.common import files
from mocap_metrology.common.types import Row
from mocap_metrology.lighthouse.assess import reference
from mocap_metrology.lighthouse.assess.pose_file import pose_row
from mocap_metrology.lighthouse.calibrate.jansen import Calibration
from mocap_metrology.lighthouse.export import formats
from mocap_metrology.lighthouse.export import world as worlds
from mocap_metrology.lighthouse.records import MASTER, PoseEstimate, Station

Pose = tuple[np.ndarray, np.ndarray]
FORMATS = {
    "crazyflie": formats.crazyflie_yaml,
    "libsurvive": formats.libsurvive_json,
    "ros2": formats.ros2_launch,
}


def frame_of(
    calibration: Calibration,
    taken: Mapping[str, PoseEstimate],
    stations: Sequence[Station],
    board: np.ndarray,
    name: str,
    points: str | None,
) -> tuple[worlds.World, list[Pose | None]]:
    """The requested frame, and the poses of the stations in it, None of one without; taken: the
    chosen ones of `calibration`. Raises `Refusal` for points that determine no frame."""
    pose = next(iter(taken.values()))
    reference = (
        stations[0].role if calibration.network is None else calibration.network.connected[0]
    )
    known = {reference: (np.eye(3), np.zeros(3))} | {k: (p.R, p.t_m) for k, p in taken.items()}
    placed = sorted((s for s in stations if s.role in known), key=lambda s: s.role != reference)
    poses = [known[station.role] for station in placed]
    path, both = pose.path, calibration.paths_of(pose)
    if path is None and both is not None:
        path = both[MASTER]
    felt = (pose.details or {}).get("inertial")
    up = -np.array(felt["gravity_m_s2"]) if isinstance(felt, Mapping) else None
    world = worlds.world_of(name, worlds.Calibrated(placed, poses, board, path, up), points)
    places = {s.role: world.place(known[s.role]) for s in placed}
    return world, [places.get(station.role) for station in stations]


def write_exports(
    origin: Row,
    verdict: Mapping[str, str],
    stations: Sequence[Station],
    placed: tuple[worlds.World, list[Pose | None]] | None,
    lasers_m: np.ndarray | None,
    paths: Paths,
) -> Row:
    """Write the file of each program; return what pose.json holds of them under `world`.

    origin: `recording` and `twin` are names; verdict: its word and reason; placed: result of
    `frame_of`, None without a pose; lasers_m: as in `CalibrationSettings`. A failed calibration has
    no poses in any file, but its reason; `paths` are named as `FORMATS`.
    """
    remarks = [f"Base stations of calibration {origin['recording']}, verdict {verdict['word']}."]
    if origin["twin"]:
        remarks.append(f"Simulated stand-in (twin) {origin['twin']}.")
    if placed is None or verdict["word"] == "failed":
        remarks.append(f"No poses, because the calibration failed: {verdict['reason']}")
        export, entry = formats.Export(stations, None, remarks), Row(name=None, stations={})
    else:
        world, poses = placed
        if lasers_m is not None:  # other programs track with the optics
            both = zip(poses, reference.optical_origins(lasers_m), strict=True)
            poses = [pose and (pose[0], pose[0] @ place + pose[1]) for pose, place in both]
        remarks.append(f"World, in metres: {frame_words(world, stations)}.")
        export, entry = formats.Export(stations, poses, remarks), _entry(world, stations, poses)
    for name, text in FORMATS.items():
        files.write_text(paths[name], text(export))
    return entry


def frame_words(world: worlds.World, stations: Sequence[Station]) -> str:
    """The frame in words, with what limits it."""
    words = worlds.frame_words(world.name, stations)
    if world.rms_m is not None and world.residuals_m is not None:
        words += f" ({len(world.residuals_m)}, {1e3 * world.rms_m:.1f} mm rms from them)"
    return f"{words} ({world.why})" if world.why else words


def _entry(world: worlds.World, stations: Sequence[Station], poses: Sequence[Pose | None]) -> Row:
    off = world.residuals_m
    return {
        "name": world.name,
        "frame": worlds.frame_words(world.name, stations),
        "why": world.why,
        "residual_rms_mm": None if world.rms_m is None else 1e3 * world.rms_m,
        "residuals_mm": None if off is None else {k: 1e3 * v for k, v in off.items()},
        "stations": {
            station.role: pose_row(*pose)
            for station, pose in zip(stations, poses, strict=True)
            if pose is not None
        },
    }
