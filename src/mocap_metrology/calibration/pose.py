"""Second step of a calibration: pose of the slave, tracked board, files of other programs.

`given`: paths as in `sweeps`.
"""

from __future__ import annotations

import json
import logging
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from mocap_metrology.calibration import sweeps
from mocap_metrology.calibration.angle_noise import of_calibration
from mocap_metrology.calibration.sweeps import Entry, Paths
from mocap_metrology.calibration.tables import DECODED, TABLES, TWIN
from mocap_metrology.common import files
from mocap_metrology.common.errors import Refusal, UnknownUnit
from mocap_metrology.common.files import Metadata
from mocap_metrology.common.parallel import Over, in_turn
from mocap_metrology.common.types import Row
from mocap_metrology.io.read import read_recording
from mocap_metrology.lighthouse import records
from mocap_metrology.lighthouse.assess import reference
from mocap_metrology.lighthouse.assess.comparison import ids_of
from mocap_metrology.lighthouse.assess.pose_file import (
    PoseEntry,
    PoseFile,
    chosen_pose,
    is_network,
    kind_of,
    matrix_and_metres,
    pairs,
    read_pose_json,
)
from mocap_metrology.lighthouse.assess.reference import Reference
from mocap_metrology.lighthouse.assess.summary import refused, summary
from mocap_metrology.lighthouse.batch.problem import Priors
from mocap_metrology.lighthouse.board import read_board, read_normals
from mocap_metrology.lighthouse.calibrate.batch import ESTIMATED, NAME, Scene, Sensors, by_batch
from mocap_metrology.lighthouse.calibrate.jansen import Calibration, CalibrationSettings, calibrate
from mocap_metrology.lighthouse.calibrate.variants import AUTO, COVARIANCE_UNITS, FALLBACK
from mocap_metrology.lighthouse.decode.factory_file import stations_from_json
from mocap_metrology.lighthouse.export import formats
from mocap_metrology.lighthouse.export import world as worlds
from mocap_metrology.lighthouse.known_length import KnownLength
from mocap_metrology.lighthouse.records import (
    MASTER,
    ROLES,
    SLAVE,
    Factory,
    Hits,
    PoseEstimate,
    Station,
)
from mocap_metrology.lighthouse.simulate import recording as simulated
from mocap_metrology.lighthouse.simulate import twin as twins
from mocap_metrology.lighthouse.simulate.inertial import sensed
from mocap_metrology.lighthouse.track import receiver
from mocap_metrology.present.text.calibration import pose_document, reason
from mocap_metrology.settings import Allan, Lighthouse

log = logging.getLogger(__name__)
FORMATS = {
    "crazyflie": formats.crazyflie_yaml,
    "libsurvive": formats.libsurvive_json,
    "ros2": formats.ros2_launch,
}
Pose = tuple[np.ndarray, np.ndarray]


def pose(
    entry: Entry,
    given: Paths,
    settings: Lighthouse,
    allan: Allan | None,
    folder: Path,
    over: Over = in_turn,
) -> Row:
    """Calibrate the stations by `DECODED`: `ESTIMATED`, and with `allan` the noise of the angles.
    Returns the contents of pose.json. over: as in `calibrate`."""
    paths = sweeps.paths_in(TABLES, folder)
    document = write_poses(entry, settings, {**paths, **given}, paths, over)
    if allan is None:
        Path(paths["allan"]).unlink(missing_ok=True)  # of an earlier twin of this name
    else:
        of_calibration(paths["allan"], paths["sweeps"], paths["pose"], allan)
    return document


def simulate(
    entry: Entry,
    twin: twins.LighthouseTwin,
    seed: int,
    given: Paths,
    settings: Lighthouse,
    allan: Allan | None,
    folder: Path,
) -> Row:
    """Simulate a twin as a dump, which is removed in the end, and take both steps with it: `TWIN`,
    `DECODED`, `ESTIMATED`. Returns the contents of pose.json."""
    made = sweeps.paths_in(TWIN, folder)
    with tempfile.TemporaryDirectory(dir=folder, prefix=".part-") as part:
        dump = str(Path(part) / "twin.dump")
        sweeps.write_twin(twin, seed, made | {"dump": dump})
        board = {"dump": dump, "board": made["twin_board"]}
        recording = sweeps.with_sensors(sweeps.decoded(entry, board, settings), twin, seed)
        sweeps.write_decoded(entry, recording, settings, sweeps.paths_in(DECODED, folder))
    more: dict[str, str] = {"truth": made["truth"]}
    if "reference" not in given and twin.reference == "mocap":
        more |= {"reference": made["reference"], "mount": made["mount"]}
    elif "reference" not in given:
        more["reference"] = made["truth"]
    return pose(entry, {**more, **given}, settings, allan, folder)


def write_poses(
    entry: Entry, settings: Lighthouse, given: Paths, paths: Paths, over: Over = in_turn
) -> Row:
    """sweeps.parquet, stations.json -> poses.parquet, pose.json, track.parquet: board poses, pose
    of the slave, and the board tracked with it; and the files of other programs.

    `given` are named sweeps, stations, board, and, where there are any, inertial, reference, mount,
    truth, earlier, tracked_with, points; `paths` pose, poses, track and as `FORMATS`; over: as in
    `calibrate`. Returns the contents of pose.json.
    """
    hits, origin = files.read_table(given["sweeps"])
    stations = stations_from_json(json.loads(Path(given["stations"]).read_text(encoding="utf-8")))
    factories = [station.factory for station in stations]
    found, board, placed = Calibration(), read_board(given["board"]), None
    recorded, how = (records.hits_of(hits), board, factories), calibration_settings(settings)
    names = [station.role for station in stations]
    lengths = sweeps.lengths_of(entry, given.get("points"), len(board), names)
    sensors = sensors_of(settings, stations, given.get("inertial"), lengths)
    if stations and stations[0].generation == 2:
        sensors = replace(sensors, normals=read_normals(given["board"]))
    try:
        found = calibrate(*recorded, how, log.info, over, sensors, stations)
        result = summary(
            found,
            stations,
            duration_s=origin["duration_s"],
            resolution_s=origin["resolution_s"],
            notes=origin["notes"],
            reference=reference_of(entry, given.get("reference"), given.get("mount")),
            truths=truths_of(given.get("truth")),
            earlier=given.get("earlier"),
        )
        if taken := _taken(found, result.document):
            points = given.get("points")
            placed = frame_of(found, taken, stations, board, settings.world, points)
    except Refusal as refusal:
        log.warning("%s", refusal)
        result = refused(stations, str(refusal))
    document = pose_document(result)
    verdict = {"word": result.verdict.word, "reason": reason(result.verdict)}
    log.info("%s", verdict)
    same = ("recording", "source", "twin", "sha256", "duration_s")
    origin = {key: origin[key] for key in same} | {"lighthouse": settings.of_one()}
    origin["versions"] = files.versions("numpy", "scipy", "numba")
    files.write_table(paths["poses"], records.pose_columns(found.paths), origin)
    earlier = given.get("tracked_with")
    given_to = recorded, how, origin, sensors, names
    write_track(paths["track"], entry, found, result.document, earlier, *given_to)
    world = write_exports(origin, verdict, stations, placed, how.lasers_m, paths)
    document |= {"world": world, "origin": origin}
    files.write_json(paths["pose"], document)
    return document


def calibration_settings(settings: Lighthouse) -> CalibrationSettings:
    """`CalibrationSettings` of the section lighthouse."""
    lasers = settings.lasers_mm
    return CalibrationSettings(
        estimators=settings.estimators,
        optics=settings.optics,
        simplex_optics=settings.simplex_optics,
        reconstruction=settings.reconstruction,
        lm_interpolation=settings.lm_interpolation,
        lm_weights=settings.lm_weights,
        start_distance_m=settings.start_distance_m,
        lasers_m=None if lasers is None else 1e-3 * np.reshape(lasers, (2, 2, 3)),
        variant=settings.variant,
        pnp_method=settings.pnp_method,
        priors=priors_of(settings),
    )


def sensors_of(
    settings: Lighthouse,
    stations: Sequence[Station],
    inertial: str | None,
    lengths: tuple[KnownLength, ...] = (),
) -> Sensors:
    """What a calibration uses besides hits, by the settings; inertial: path of inertial.parquet."""
    series = ups = None
    if settings.inertial and inertial is not None:
        series = records.inertial_of(files.read_table(inertial)[0])
    if settings.gravity:
        unknown = np.full(3, np.nan)
        ups = np.array([unknown if one.gravity is None else one.gravity for one in stations])
    return Sensors(series, ups, lengths)


def priors_of(settings: Lighthouse) -> Priors:
    """`Priors` of the section lighthouse."""
    return Priors(
        time_zero_us=settings.time_zero_sd_us,
        phase_mrad=settings.phase_sd_mrad,
        laser_depth_mm=settings.laser_depth_sd_mm,
        board_scale=settings.board_scale_sd,
        board_position_mm=settings.board_position_sd_mm,
    )


def reference_of(entry: Entry, path: str | None, mount: str | None) -> Reference | None:
    """The reference of a row: a pose file, or markers on both housings in a C3D file."""
    if path is None:
        return None
    if not path.lower().endswith(".c3d"):
        return reference.pose_reference(path)
    master, slave = entry.reference_labels_master, entry.reference_labels_slave
    known = reference.read_mount(str(mount))
    if not master and not slave:  # a twin's: M1 ... on the master, S1 ... on the slave
        master, slave = ([label for label in known if label.startswith(one)] for one in "MS")
    try:
        found = read_recording([path], [*master, *slave], unit=entry.reference_unit)
    except UnknownUnit as refusal:
        raise Refusal(f"{refusal} (column reference_unit of the sheet)") from None
    if found.unit_source == "assumed":
        log.warning("%s names no unit, so its coordinates are assumed to be in mm", Path(path).name)
    said = f"markers in {Path(path).name}"
    return reference.reference_from_markers(
        found.position_mm, found.labels, master, slave, known, said
    )


def truths_of(path: str | None) -> dict[str, Reference] | None:
    """What a twin was made with: between its housings, and between the origins of its optics."""
    if path is None:
        return None
    lasers = json.loads(Path(path).read_text(encoding="utf-8"))["lasers_m"]
    housing = reference.pose_reference(path)
    return {"housing": housing, "optical": reference.optical(housing, np.array(lasers))}


def _taken(found: Calibration, document: PoseFile) -> dict[str, PoseEstimate]:
    """The chosen estimate of each station but the reference, by its name."""
    chosen: object = document["chosen"]
    if isinstance(chosen, Mapping):
        return {name: found.estimates[k] for name, k in chosen.items() if k is not None}
    return {} if not isinstance(chosen, int) else {ROLES[SLAVE]: found.estimates[chosen]}


def frame_of(
    found: Calibration,
    taken: Mapping[str, PoseEstimate],
    stations: Sequence[Station],
    board: np.ndarray,
    name: str,
    points: str | None,
) -> tuple[worlds.World, list[Pose | None]]:
    """The requested frame, and the poses of the stations in it, None of one without; taken: the
    chosen ones of `found`. Raises `Refusal` for points that determine no frame."""
    pose = next(iter(taken.values()))
    reference = stations[0].role if found.network is None else found.network.connected[0]
    known = {reference: (np.eye(3), np.zeros(3))} | {k: (p.R, p.t_m) for k, p in taken.items()}
    own = sorted((s for s in stations if s.role in known), key=lambda s: s.role != reference)
    poses = [known[station.role] for station in own]
    path, both = pose.path, found.paths_of(pose)
    if path is None and both is not None:
        path = both[MASTER]
    felt = (pose.details or {}).get("inertial")
    up = -np.array(felt["gravity_m_s2"]) if isinstance(felt, Mapping) else None
    world = worlds.world_of(name, worlds.Calibrated(own, poses, board, path, up), points)
    places = {s.role: world.place(known[s.role]) for s in own}
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
        poses = _of_optics(poses, lasers_m)
        remarks.append(f"World, in metres: {described(world, stations)}.")
        export, entry = formats.Export(stations, poses, remarks), _entry(world, stations, poses)
    for name, text in FORMATS.items():
        files.write_text(paths[name], text(export))
    return entry


def described(world: worlds.World, stations: Sequence[Station]) -> str:
    """The frame in words, with what limits it."""
    words = worlds.frame_words(world.name, stations)
    if world.rms_m is not None and world.residuals_m is not None:
        words += f" ({len(world.residuals_m)}, {1e3 * world.rms_m:.1f} mm rms from them)"
    return f"{words} ({world.why})" if world.why else words


def _of_optics(poses: list[Pose | None], lasers_m: np.ndarray | None) -> list[Pose | None]:
    """Poses of the stations' optics, which other programs track with; those of a calibration with
    `lasers_mm` are of the housings."""
    if lasers_m is None:
        return poses
    origins = reference.optical_origins(lasers_m)
    return [
        None if pose is None else (pose[0], pose[0] @ own + pose[1])
        for pose, own in zip(poses, origins, strict=True)
    ]


def _entry(world: worlds.World, stations: Sequence[Station], poses: Sequence[Pose | None]) -> Row:
    from scipy.spatial.transform import Rotation

    off = world.residuals_m
    return {
        "name": world.name,
        "frame": worlds.frame_words(world.name, stations),
        "why": world.why,
        "residual_rms_mm": None if world.rms_m is None else 1e3 * world.rms_m,
        "residuals_mm": None if off is None else {k: 1e3 * v for k, v in off.items()},
        "stations": {
            station.role: {
                "translation_mm": (1e3 * pose[1]).tolist(),
                "quaternion_xyzw": Rotation.from_matrix(pose[0]).as_quat(canonical=True).tolist(),
            }
            for station, pose in zip(stations, poses, strict=True)
            if pose is not None
        },
    }


def write_track(
    path: str,
    entry: Entry,
    found: Calibration,
    own: PoseFile,
    earlier: str | None,
    recorded: tuple[Hits, np.ndarray, Sequence[Factory | None]],
    settings: CalibrationSettings,
    origin: Metadata,
    sensors: Sensors,
    names: Sequence[str],
) -> None:
    """Track the board of a recording and write its poses; where that cannot be, no rows, and the
    reason in the metadata.

    own: pose.json of this recording, `found` its estimates; earlier: that of another, whose
    stations are used where the row names it; recorded: hits, board in m, factory values; sensors:
    data besides hits; names: of the stations.
    """
    more: Metadata = {"still": found.still, "tracked_with": entry.tracked_with}
    tracked = None
    try:
        used = stations_used(entry, own, earlier)
        more["stations"] = used["stations"]
        if is_network(used):
            more["reference"] = used["reference"]
        tracked = _tracked(found, used, used is own, recorded, settings, sensors, names)
        more["note"] = tracked.note
        seen = tracked.hits.any(axis=1)
        log.info("receiver: %d of %d moments have a pose", seen.sum(), seen.size)
    except Refusal as refusal:
        more["reason"] = str(refusal)
        level = logging.WARNING if entry.tracked_with else logging.INFO
        log.log(level, "not tracked: %s", refusal)
    files.write_table(path, receiver.columns(tracked), origin | more)


def stations_used(entry: Entry, own: PoseFile, earlier: str | None) -> PoseFile:
    """pose.json to track with; refused if it is of other stations, or with swapped roles."""
    if entry.tracked_with is None:
        return own
    if earlier is None:
        raise Refusal(f"calibration {entry.tracked_with}, to track with, is refused itself")
    used = read_pose_json(earlier)
    if is_network(used) != is_network(own):
        raise Refusal("the calibration to track with is of stations of the other generation")
    if is_network(used):
        for name in used["stations"].keys() & own["stations"].keys():
            first, second = (one["stations"][name]["id"] for one in (used, own))
            if None not in (first, second) and first != second:
                raise Refusal(
                    f"the calibration to track with: its station {name} is {first}, that of the"
                    f" recording is {second}"
                )
        return used
    reference.check_same_ids(
        ids_of(used), ids_of(own), "the calibration to track with", "the recording"
    )
    return used


def _tracked(
    found: Calibration,
    used: PoseFile,
    is_own: bool,
    recorded: tuple[Hits, np.ndarray, Sequence[Factory | None]],
    settings: CalibrationSettings,
    sensors: Sensors,
    names: Sequence[str],
) -> receiver.Track:
    placed = _placed(used)
    entry = next(iter(placed.values()))
    by_batch = is_own and entry["estimator"] == NAME
    if by_batch and entry["stage"] == "final":
        scene, joint = found.joints[entry["optics"]]
        return receiver.along(joint, scene, _calibrated(used, placed, by_batch), entry["note"])
    return receiver.track(*scene_before(used, is_own, recorded, settings, sensors, names))


def _placed(used: PoseFile) -> dict[str, PoseEntry]:
    """The chosen pose of each station that has one."""
    entries = {name: chosen_pose(one) for name, one in pairs(used).items()}
    placed = {name: entry for name, entry in entries.items() if entry is not None}
    if not placed:
        raise Refusal("no pose of the slave to track with")
    return placed


def scene_before(
    used: PoseFile,
    is_own: bool,
    recorded: tuple[Hits, np.ndarray, Sequence[Factory | None]],
    settings: CalibrationSettings,
    sensors: Sensors,
    names: Sequence[str],
) -> tuple[Scene, receiver.Calibrated]:
    """What `receiver.track` needs for an object before the stations of a pose.json; is_own: which
    comes from the same hits; recorded, names: as of `write_track`."""
    placed = _placed(used)
    entry = next(iter(placed.values()))
    by_batch = is_own and entry["estimator"] == NAME
    _, _, optics = kind_of(entry)
    hits, board, factories = recorded
    if optics == ESTIMATED and not is_own:
        raise Refusal("the rotors of these stations were estimated; expected factory values")
    housing = settings.lasers_m is not None
    if entry["frame"] != ("housing" if housing else "optical"):
        raise Refusal(
            f"the pose is of the {entry['frame']} frame; expected the frame that lasers_mm implies"
        )
    how = settings.lasers_m, _variant(used, settings), settings.priors
    scene = Scene(hits, board, optics, factories, *how, sensors=sensors)
    if is_network(used):
        reference = str(used["reference"])
        scene = replace(scene, names=list(names), generation=2)
        if reference not in names:
            raise Refusal(f"the recording has no light of station {reference}, the reference")
        placed = {name: own for name, own in placed.items() if name in names}
        scene = scene.of([names.index(name) for name in (reference, *placed)])
    if optics == "factory" and None in scene.factories:
        raise Refusal("the recording has no factory values of both stations, as the pose has")
    return scene, _calibrated(used, placed, by_batch)


def _calibrated(
    used: PoseFile, placed: Mapping[str, PoseEntry], is_own: bool
) -> receiver.Calibrated:
    """What is known of these stations."""
    R, t = zip(*map(matrix_and_metres, placed.values()), strict=True)
    if not is_network(used):
        given = next(iter(placed.values()))["covariance"]
        covariance = np.full((6, 6), np.nan) if given is None else np.array(given)
    else:
        order = used["covariance_joint_stations"]
        at = np.concatenate([6 * order.index(name) + np.arange(6) for name in placed])
        joint = used["covariance_joint"]
        every = np.full((6 * len(order),) * 2, np.nan) if joint is None else np.array(joint)
        covariance = every[np.ix_(at, at)]
    units = np.tile(COVARIANCE_UNITS, len(placed))
    covariance = covariance / np.outer(units, units)
    return receiver.Calibrated(np.squeeze(R), np.squeeze(t), covariance, is_own)


def _variant(used: PoseFile, settings: CalibrationSettings) -> str:
    """How factory values enter: as they did in the calibration."""
    chosen = (str(way["variant"]) for way in used.get("variants", []) if way["chosen"])
    fixed = FALLBACK if settings.variant == AUTO else settings.variant
    return next(chosen, fixed)


def warm_up() -> None:
    """Compile the kernels of `batch` and of the sensors, with what a calibration gives them."""
    master = twins.StationTwin(id=1, mode="b")
    slave = twins.StationTwin(id=2, mode="c", position_m=(0.0, 1.0, 0.0))
    motion = twins.MotionTwin(centre_m=(3.0, 0.5, 0.0))
    twin = twins.LighthouseTwin(
        seed=0,
        master=master,
        slave=slave,
        motion=motion,
        inertial=twins.InertialTwin(),
        board=twins.BoardTwin(columns=3, rows=2),
        duration_s=0.6,
        independent_urad=50.0,
    )
    made = simulated.simulate(twin)
    rng = np.random.default_rng(0)
    series = sensed(
        made.truth.motion, simulated.up_of(twin), twins.InertialTwin(), twin.duration_s, rng
    )
    how = "ideal", [None, None], None, "crazyflie", Priors()
    by_batch(Scene(made.hits, made.truth.board, *how, sensors=Sensors(series)))
