"""What the scripts of calibrations share: what files are made from, and settings.

`given` and `files` are paths by name; each function reads what it needs from the disk.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

    from mocap_metrology.lighthouse.assess.reference import Reference
    from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings
    from mocap_metrology.lighthouse.decode.chain import Decoded
    from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin

Paths = Mapping[str, str]
Values = Mapping[str, Any]  # cells of a row by column, or a section of the configuration


def write_twin(twin: LighthouseTwin, seed: int, files: Paths) -> str:
    """Simulate a Lighthouse twin; write it as a dump, with what a lab would have beside it.

    `files` are named dump, twin_board, truth, reference, mount. Returns what was made, in words.
    """
    import numpy as np

    from mocap_metrology.common.files import write_json
    from mocap_metrology.io.c3d.write import write_c3d
    from mocap_metrology.lighthouse.simulate.mocap import simulate_mounts, write_mounts
    from mocap_metrology.lighthouse.simulate.recording import simulate, truth_json, write_dump

    seed += twin.seed
    made = simulate(twin, seed)
    seen = simulate_mounts(twin, seed)
    frames = np.moveaxis(seen.positions_mm, 2, 0).astype(np.float32)
    write_c3d(files["reference"], seen.labels, seen.rate_hz, [frames], len(frames))
    write_mounts(files["mount"], seen.mounts)
    _write_board(files["twin_board"], made.truth.board)
    write_json(files["truth"], truth_json(made))
    write_dump(files["dump"], made.pulses)
    return f"{twin.name}: {made.pulses.start_s.size} pulses in {twin.duration_s:g} s"


def write_decoded(
    row: Values, config: Values, given: Paths, files: Paths, log: logging.Logger
) -> None:
    """Dump -> pulses.parquet, stations.json, sweeps.parquet: pulses, stations, clean hits.

    `given` are named dump, board, factory; `files` pulses, stations, sweeps, board.
    """
    from mocap_metrology.common.files import sha256, versions, write_json, write_table
    from mocap_metrology.lighthouse import records
    from mocap_metrology.lighthouse.decode.chain import dropped_share
    from mocap_metrology.lighthouse.decode.factory_file import stations_to_json

    found = decoded(given, row, config)
    origin = {
        "recording": row["calibration"],
        "source": row["twin"] or row["path"],
        "twin": row["twin"],
        "sha256": None if row["twin"] else sha256(given["dump"]),
        "lighthouse": config,
        "duration_s": found.duration_s,
        "resolution_s": found.pulses.resolution_s if found.pulses else None,
        "notes": found.notes,
        "clocks": [vars(clock) for clock in found.clocks],
        "versions": versions("numpy", "numba", "pyarrow"),
    }
    if found.pulses is None:
        table = {"start_s": [], "length_us": [], "diode": []}
    else:
        table = records.pulse_columns(found.pulses)
    write_table(files["pulses"], table, origin, records.PULSES_CODED)
    origin |= {"counts_by_diode": found.report, "dropped": dropped_share(found.report)}
    write_table(files["sweeps"], records.sweep_columns(found.hits), origin, records.SWEEPS_CODED)
    _write_board(files["board"], found.board)
    write_json(files["stations"], stations_to_json(found.stations))
    for station in found.stations:
        log.info("%s: id %s, mode %s, %s", station.role, station.id, station.mode, station.why)
    log.info("%d hits; dropped %s; %s", len(found.hits), origin["dropped"], found.notes)


def write_poses(
    row: Values, config: Values, given: Paths, files: Paths, log: logging.Logger
) -> None:
    """sweeps.parquet, stations.json -> poses.parquet, pose.json: board poses and pose of the slave.

    `given` are named sweeps, stations, board, and, where there are any, reference, mount, truth,
    earlier; `files` pose, poses.
    """
    from mocap_metrology.common.errors import Refusal
    from mocap_metrology.common.files import read_table, versions, write_json, write_table
    from mocap_metrology.lighthouse import records
    from mocap_metrology.lighthouse.assess.summary import refused, summary
    from mocap_metrology.lighthouse.board import read_board
    from mocap_metrology.lighthouse.calibrate.jansen import Calibration, calibrate
    from mocap_metrology.lighthouse.decode.factory_file import stations_from_json
    from mocap_metrology.present.text.calibration import pose_document

    table, origin = read_table(given["sweeps"])
    stations = stations_from_json(json.loads(Path(given["stations"]).read_text(encoding="utf-8")))
    factories = [station.factory for station in stations]
    found, board = Calibration(), read_board(given["board"])
    try:
        found = calibrate(
            records.hits_of(table), board, factories, calibration_settings(config), log.info
        )
        result = summary(
            found,
            stations,
            duration_s=origin["duration_s"],
            resolution_s=origin["resolution_s"],
            notes=origin["notes"],
            reference=reference_of(row, given.get("reference"), given.get("mount")),
            truths=truths_of(given.get("truth")),
            earlier=given.get("earlier"),
        )
    except Refusal as refusal:
        log.warning("%s", refusal)
        result = refused(stations, str(refusal))
    document = pose_document(result)
    log.info("%s: %s", document["verdict"]["word"], document["verdict"]["reason"])
    kept = ("recording", "source", "twin", "sha256", "duration_s")
    origin = {key: origin[key] for key in kept} | {"lighthouse": config}
    origin["versions"] = versions("numpy", "scipy", "numba")
    write_table(files["poses"], records.pose_columns(found.paths), origin)
    write_json(files["pose"], document | {"origin": origin})


def _write_board(path: str, board: np.ndarray) -> None:
    """A board as a CSV file x_m,y_m,z_m in diode order."""
    from mocap_metrology.common.files import write_csv

    write_csv(path, [dict(zip(("x_m", "y_m", "z_m"), place, strict=True)) for place in board])


def decoded(files: Mapping[str, str], row: Values, config: Values) -> Decoded:
    """The recording of a row, decoded; `files` are named dump, board and factory."""
    from mocap_metrology.lighthouse.decode.chain import Cleaning, decode

    return decode(
        files["dump"],
        row["format"],
        row["board"] if row["format"] == "libsurvive-rec" else files["board"],
        files.get("factory"),
        sample_rate_hz=config["sample_rate_hz"],
        active_level=config["active_level"],
        cleaning=Cleaning(
            gate_rad=1e-3 * config["gate_mrad"],
            gate_mad=config["gate_mad"],
            half_window=config["still_half_window"],
            n_sigma=config["still_n_sigma"],
        ),
    )


def calibration_settings(config: Values) -> CalibrationSettings:
    """`CalibrationSettings` of the section lighthouse."""
    import numpy as np

    from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings

    lasers = config["lasers_mm"]
    return CalibrationSettings(
        estimators=config["estimators"],
        optics=config["optics"],
        simplex_optics=config["simplex_optics"],
        reconstruction=config["reconstruction"],
        lm_interpolation=config["lm_interpolation"],
        lm_weights=config["lm_weights"],
        start_distance_m=config["start_distance_m"],
        lasers_m=None if lasers is None else 1e-3 * np.reshape(lasers, (2, 2, 3)),
        variant=config["variant"],
        pnp_method=config["pnp_method"],
    )


def reference_of(row: Values, path: str | None, mount: str | None) -> Reference | None:
    """The reference of a row: a pose file, or markers on both housings in a C3D file."""
    from mocap_metrology.lighthouse.assess import reference

    if path is None:
        return None
    if not path.lower().endswith(".c3d"):
        return reference.pose_reference(path)
    from mocap_metrology.io.read import read_recording

    labels = [row["reference_labels_master"], row["reference_labels_slave"]]
    known = reference.read_mount(mount)
    if not any(labels):  # a twin's: M1 ... on the master, S1 ... on the slave
        labels = [[label for label in known if label.startswith(first)] for first in "MS"]
    recording = read_recording([path], [*labels[0], *labels[1]], None)
    return reference.reference_from_markers(
        recording.position_mm, recording.labels, *labels, known, f"markers in {Path(path).name}"
    )


def truths_of(path: str | None) -> dict[str, Reference] | None:
    """What a twin was made with: between its housings, and between the origins of its optics."""
    if path is None:
        return None
    import numpy as np

    from mocap_metrology.lighthouse.assess.reference import optical, pose_reference

    lasers = json.loads(Path(path).read_text(encoding="utf-8"))["lasers_m"]
    housing = pose_reference(path)
    return {"housing": housing, "optical": optical(housing, np.array(lasers))}
