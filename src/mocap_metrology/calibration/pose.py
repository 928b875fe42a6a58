"""Second step of a calibration: pose of the slave, tracked board, files of other programs.

`inputs`: paths as in `sweeps`.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from mocap_metrology.calibration import sweeps
from mocap_metrology.calibration.angle_noise import of_calibration
from mocap_metrology.calibration.exports import frame_of, write_exports
from mocap_metrology.calibration.sweeps import Entry, Paths
from mocap_metrology.calibration.tables import DECODED, TABLES, TWIN
from mocap_metrology.calibration.track import calibration_settings, sensors_of, write_track
from mocap_metrology.common import files
from mocap_metrology.common.errors import Refusal, UnknownUnit
from mocap_metrology.common.parallel import MapFunction, in_turn
from mocap_metrology.common.types import Row
from mocap_metrology.io.read import read_recording
from mocap_metrology.io.recording import Recording
from mocap_metrology.io.units import Unit
from mocap_metrology.lighthouse import records
from mocap_metrology.lighthouse.assess import reference
from mocap_metrology.lighthouse.assess.network_reference import NetworkReference, network_reference
from mocap_metrology.lighthouse.assess.pose_file import PoseFile
from mocap_metrology.lighthouse.assess.reference import Reference
from mocap_metrology.lighthouse.assess.summary import refused, summary, with_objects
from mocap_metrology.lighthouse.calibrate.jansen import Calibration, CalibrationSettings, calibrate
from mocap_metrology.lighthouse.calibrate.scene import Sensors
from mocap_metrology.lighthouse.calibrate.stages import PEERS, SIMPLEX
from mocap_metrology.lighthouse.decode.clean import clean_hits, neighbour_outliers
from mocap_metrology.lighthouse.decode.gates import Cleaning
from mocap_metrology.lighthouse.records import ROLES, SLAVE, PoseEstimate
from mocap_metrology.lighthouse.simulate import recording as simulated
from mocap_metrology.lighthouse.simulate import twin as twins
from mocap_metrology.lighthouse.simulate.network_twin import NetworkTwin
from mocap_metrology.lighthouse.simulate.recording import sensed
from mocap_metrology.present.text.calibration import pose_document, reason
from mocap_metrology.settings import Allan, Lighthouse

log = logging.getLogger(__name__)
MOST_REJECTED = 20.0  # % of the hits, by the others of their sweep; of reflections rarely so many


def pose(
    entry: Entry,
    inputs: Paths,
    settings: Lighthouse,
    allan: Allan | None,
    folder: Path,
    beside: Sequence[tuple[Entry, Paths]] = (),
) -> Row:
    """Calibrate the stations by `DECODED`: `ESTIMATED`, and with `allan` the noise of the angles.
    Returns the contents of pose.json. beside: as in `write_poses`."""
    paths = sweeps.paths_in(TABLES, folder)
    document = write_poses(entry, settings, {**paths, **inputs}, paths, beside=beside)
    if allan is None:
        Path(paths["allan"]).unlink(missing_ok=True)  # of an earlier twin of this name
    else:
        of_calibration(paths["allan"], paths["sweeps"], paths["pose"], allan)
    return document


def simulate(
    entry: Entry,
    twin: twins.LighthouseTwin | NetworkTwin,
    seed: int,
    inputs: Paths,
    settings: Lighthouse,
    allan: Allan | None,
    folder: Path,
) -> Row:
    """Simulate a twin, of the first generation as a dump, which is removed in the end, and take
    both steps with it: `TWIN` (`NETWORK_TWIN`), `DECODED`, `ESTIMATED`. Returns the contents of
    pose.json."""
    outputs = sweeps.paths_in(TWIN, folder)
    if isinstance(twin, NetworkTwin):
        decoded = sweeps.network_twin(twin, seed, settings, outputs)
        sweeps.write_decoded(entry, decoded, settings, sweeps.paths_in(DECODED, folder))
        truth = {"reference": outputs["truth"]}
        return pose(entry, truth | dict(inputs), settings, allan, folder)
    with files.temporary_folder(folder) as part:
        dump = str(Path(part) / "twin.dump")
        sweeps.write_twin(twin, seed, outputs | {"dump": dump})
        board = {"dump": dump, "board": outputs["twin_board"]}
        recording = sweeps.with_sensors(sweeps.decoded(entry, board, settings), twin, seed)
        sweeps.write_decoded(entry, recording, settings, sweeps.paths_in(DECODED, folder))
    more: dict[str, str] = {"truth": outputs["truth"]}
    if "reference" not in inputs and twin.reference == "mocap":
        more |= {"reference": outputs["reference"], "mount": outputs["mount"]}
    elif "reference" not in inputs:
        more["reference"] = outputs["truth"]
    return pose(entry, {**more, **inputs}, settings, allan, folder)


def write_poses(
    entry: Entry,
    settings: Lighthouse,
    inputs: Paths,
    paths: Paths,
    over: MapFunction = in_turn,
    beside: Sequence[tuple[Entry, Paths]] = (),
) -> Row:
    """sweeps.parquet, stations.json -> poses.parquet, pose.json, track.parquet: board poses, pose
    of the slave, and the board tracked with it; and the files of other programs.

    `inputs` are named sweeps, stations, board, and, where there are any, inertial, reference,
    mount, truth, earlier, tracked_with, points; `paths` pose, poses, track and as `FORMATS`; over:
    as in `calibrate`; beside: other objects of the recording (`with_objects`; first generation),
    entries and the inputs of each.
    Returns the contents of pose.json.
    """
    read, calibration, placed = sweeps.recorded(inputs, entry), Calibration(), None
    origin, stations, how = read.origin, read.stations, calibration_settings(settings)
    try:
        sensors = sensors_of(settings, read)
        calibration = calibrate(*read.seen, how, log.info, over, sensors, stations)
        calibration.why.extend([] if calibration.estimates else _contradicted(origin["dropped"]))
        result = summary(
            calibration,
            stations,
            duration_s=origin["duration_s"],
            resolution_s=origin["resolution_s"],
            notes=origin["notes"],
            reference=reference_of(
                entry, inputs.get("reference"), inputs.get("mount"), read.generation
            ),
            truths=truths_of(inputs.get("truth")),
            earlier=inputs.get("earlier"),
        )
        result = with_objects(result, dict(_of_others(beside, settings)))
        if taken := _chosen_estimates(calibration, result.document):
            points = inputs.get("points")
            placed = frame_of(calibration, taken, stations, read.board, settings.world, points)
    except Refusal as refusal:
        log.warning("%s", refusal)
        result = refused(stations, "; ".join([str(refusal), *_contradicted(origin["dropped"])]))
    document = pose_document(result)
    verdict = {"word": result.verdict.word, "reason": reason(result.verdict)}
    log.info("%s", verdict)
    same = ("recording", "source", "twin", "sha256", "duration_s")
    origin = {key: origin[key] for key in same} | {"lighthouse": settings.of_one()}
    origin["versions"] = files.versions("numpy", "scipy", "numba")
    files.write_table(paths["poses"], records.pose_columns(calibration.paths), origin)
    earlier = inputs.get("tracked_with")
    of = entry, calibration, result.document, earlier, read, settings, origin
    write_track(paths["track"], *of)
    world = write_exports(origin, verdict, stations, placed, how.lasers_m, paths)
    document |= {"world": world, "origin": origin}
    files.write_json(paths["pose"], document)
    return document


def _contradicted(dropped: Mapping[str, float]) -> list[str]:
    """What a recording without a pose says of the board; dropped: shares of hits, by reason."""
    percent = 100 * dropped["sweep"]
    said = f"{percent:.0f} % of the hits contradict others of their sweep: is the board file right?"
    return [said] if percent > MOST_REJECTED else []


def _of_others(
    beside: Sequence[tuple[Entry, Paths]], settings: Lighthouse
) -> Iterator[tuple[str, PoseFile]]:
    """Poses from other objects by the better estimators, by the names of their calibrations; none
    of the second generation. Anew, as pose.json of each row depends on the other objects."""
    how = calibration_settings(settings)
    better = [name for name in how.estimators if name not in (*SIMPLEX, *PEERS)]
    for entry, inputs in beside:
        try:
            if (read := sweeps.recorded(inputs, entry)).generation == 2:
                continue
            chosen = replace(how, estimators=better or how.estimators)
            sensors = sensors_of(settings, read)
            calibration = calibrate(*read.seen, chosen, sensors=sensors, stations=read.stations)
        except Refusal as refusal:
            log.info("%s: %s", entry.calibration, refusal)
            continue
        origin = read.origin["duration_s"], read.origin["resolution_s"]
        told = summary(calibration, read.stations, duration_s=origin[0], resolution_s=origin[1])
        yield entry.calibration, told.document


def reference_of(
    entry: Entry, path: str | None, mount: str | None, generation: int = 1
) -> Reference | NetworkReference | None:
    """The reference of a row: a pose file, or of the first generation markers on both housings in a
    C3D file."""
    if path is None:
        return None
    if generation == 2:
        return network_reference(path)
    if not path.lower().endswith(".c3d"):
        return reference.pose_reference(path)
    master, slave = entry.reference_labels_master, entry.reference_labels_slave
    known = reference.read_mount(str(mount))
    if not master and not slave:  # a twin's: M1 ... on the master, S1 ... on the slave
        master, slave = ([label for label in known if label.startswith(one)] for one in "MS")
    recording = motion_capture(path, [*master, *slave], entry.reference_unit, "reference_unit")
    said = f"markers in {Path(path).name}"
    return reference.reference_from_markers(
        recording.position_mm, recording.labels, master, slave, known, said
    )


def motion_capture(path: str, labels: Sequence[str], unit: Unit | None, column: str) -> Recording:
    """Motion capture of some markers; unit: as the column states it, where the file names none."""
    try:
        recording = read_recording([path], labels, unit=unit)
    except UnknownUnit as refusal:
        raise Refusal(f"{refusal} (column {column} of the sheet)") from None
    if recording.unit_source == "assumed":
        log.warning("%s names no unit, so its coordinates are assumed to be in mm", Path(path).name)
    return recording


def truths_of(path: str | None) -> dict[str, Reference] | None:
    """What a twin was made with: between its housings, and between the origins of its optics."""
    if path is None:
        return None
    lasers = json.loads(Path(path).read_text(encoding="utf-8"))["lasers_m"]
    housing = reference.pose_reference(path)
    return {"housing": housing, "optical": reference.optical(housing, np.array(lasers))}


def _chosen_estimates(calibration: Calibration, document: PoseFile) -> dict[str, PoseEstimate]:
    """The chosen estimate of each station but the reference, by its name."""
    chosen: object = document["chosen"]
    if isinstance(chosen, Mapping):
        return {name: calibration.estimates[k] for name, k in chosen.items() if k is not None}
    return {} if not isinstance(chosen, int) else {ROLES[SLAVE]: calibration.estimates[chosen]}


def warm_up() -> None:
    """Compile the kernels of a calibration, with what it gives them; those of the second generation
    are the same but for one."""
    master = twins.StationTwin(id=1, mode="b", factory=twins.FactoryValues(phase=(0.001, 0.001)))
    slave = twins.StationTwin(id=2, mode="c", position_m=(0.0, 1.0, 0.0))
    twin = twins.LighthouseTwin(
        seed=0,
        master=master,
        slave=slave,
        motion=twins.MotionTwin(centre_m=(3.0, 0.5, 0.0)),
        inertial=twins.InertialTwin(),
        board=twins.BoardTwin(columns=3, rows=2),
        duration_s=1.0,
        independent_urad=50.0,
    )
    simulation = simulated.simulate(twin)
    up, rng = simulated.up_of(twin), np.random.default_rng(0)
    series = sensed(simulation.truth.motion, up, twins.InertialTwin(), twin.duration_s, rng)
    hits, _ = clean_hits(simulation.hits, simulation.truth.board)
    neighbour_outliers(hits, simulation.truth.board, Cleaning())
    factories = [station.factory for station in simulation.truth.stations]
    how = CalibrationSettings(("batch", "paper", "paper-lm", "geometric"), ("factory", "ideal"))
    calibrate(hits, simulation.truth.board, factories, how, sensors=Sensors(series))
