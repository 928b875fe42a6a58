"""First step of a calibration: a recording, measured or simulated, checked and decoded.

`inputs`: paths of what a user names, called dump, board, factory, reference, mount, earlier,
tracked_with, points; of a twin also truth. Results have the names of `TABLES` in a folder.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.calibration.tables import DECODED
from mocap_metrology.common import files
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Row
from mocap_metrology.io.c3d.write import write_c3d
from mocap_metrology.io.units import Unit
from mocap_metrology.lighthouse import records
from mocap_metrology.lighthouse.board import COLUMNS, NORMALS, read_board, read_normals
from mocap_metrology.lighthouse.decode.chain import Decoded, decode, decode_light, dropped_share
from mocap_metrology.lighthouse.decode.factory_file import stations_from_json, stations_to_json
from mocap_metrology.lighthouse.decode.gates import Cleaning
from mocap_metrology.lighthouse.decode.wander import TurnClock
from mocap_metrology.lighthouse.export.world import read_points
from mocap_metrology.lighthouse.known_length import KnownLength, known_length
from mocap_metrology.lighthouse.records import ROLES, Factory, Hits, Inertial, Station
from mocap_metrology.lighthouse.simulate import recording as simulated
from mocap_metrology.lighthouse.simulate.motion import motion_of
from mocap_metrology.lighthouse.simulate.network_twin import NetworkTwin, truth_json
from mocap_metrology.lighthouse.simulate.recording import sensed, simulate_mounts, write_mounts
from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin
from mocap_metrology.settings import Lighthouse

log = logging.getLogger(__name__)
Paths = Mapping[str, str]


@dataclass(frozen=True)
class Entry:
    """Entries of a calibration, as in a row of the sheet; board: the name of the tracked
    object of a libsurvive recording; sha256: of the recording, where it is known."""

    calibration: str = ""
    path: str | None = None
    format: str = "gpio-dump"
    board: str | None = None
    twin: str | None = None
    sha256: str | None = None
    reference_labels_master: Sequence[str] = ()
    reference_labels_slave: Sequence[str] = ()
    reference_unit: Unit | None = None
    tracked_with: str | None = None
    known_length: str | None = None


def decoded(entry: Entry, files: Mapping[str, str], settings: Lighthouse) -> Decoded:
    """A recording, decoded; `files` are named dump, board and factory."""
    board = str(entry.board) if entry.format == "libsurvive-rec" else files["board"]
    how = {k: getattr(settings, k) for k in ("sample_rate_hz", "active_level")}
    arguments = files["dump"], entry.format, board, files.get("factory")
    return decode(*arguments, **how, cleaning=_cleaning(settings))


def _cleaning(settings: Lighthouse) -> Cleaning:
    return Cleaning(
        gate_rad=1e-3 * settings.gate_mrad,
        gate_mad=settings.gate_mad,
        half_window=settings.still_half_window,
        n_sigma=settings.still_n_sigma,
    )


def checked(entry: Entry, inputs: Paths, settings: Lighthouse) -> tuple[dict[str, Any], Decoded]:
    """Contents of check.json, and the decoded recording; raises `Refusal` for one that cannot be
    used, and for such points in the room, where they are given."""
    if entry.sha256 and (digest := files.sha256(str(entry.path))) != entry.sha256:
        name = Path(str(entry.path)).name
        raise Refusal(f"{name}: SHA-256 is {digest}; expected {entry.sha256}")
    if "points" in inputs:
        read_points(inputs["points"])
    recording = decoded(entry, inputs, settings)
    if "points" in inputs or not str(entry.known_length).startswith("points"):
        names = [station.role for station in recording.stations]
        lengths_of(entry, inputs.get("points"), len(recording.board), names)
    then = "expected errors of centimetres"
    if recording.generation == 2:
        then = "usual ones of such stations are the first guess"
    warnings = [
        f"{station.role}: no factory values ({station.why}); {then}"
        for station in recording.stations
        if station.factory is None
    ]
    return {"ok": True, "why": "", "warnings": warnings, "notes": recording.notes}, recording


def lengths_of(
    entry: Entry, points: str | None, n_diodes: int, names: Sequence[str] = ROLES
) -> tuple[KnownLength, ...]:
    """The length that a row states; points: file of those in the room, if it names one; names: of
    the stations. Raises `Refusal` for one that cannot be used."""
    if not entry.known_length:
        return ()
    places = None if points is None else read_points(points)
    return (known_length(entry.known_length, n_diodes, places, names),)


def sweeps(entry: Entry, inputs: Paths, settings: Lighthouse, folder: Path) -> Row:
    """Check and decode a recording: check.json and `DECODED`. Raises `Refusal` for one that cannot
    be used; then nothing has been written."""
    check, recording = checked(entry, inputs, settings)
    write_decoded(entry, recording, settings, paths_in(DECODED, folder))
    files.write_json(folder / "check.json", check)
    return check


def refuse(refusal: Refusal, folder: Path) -> None:
    """check.json of a recording that cannot be used, with the reason; tables without rows."""
    why = {"ok": False, "why": str(refusal), "warnings": [], "notes": []}
    files.write_json(folder / "check.json", why)
    for name in ("pulses", "inertial", "sweeps"):
        files.write_table(folder / DECODED[name], {}, {files.REFUSED: str(refusal)})
    files.write_json(folder / DECODED["stations"], [])
    files.write_csv(folder / DECODED["board"], [], ("x_m", "y_m", "z_m"))


def paths_in(names: Mapping[str, str], folder: Path) -> dict[str, str]:
    """Paths by name of these files of a folder."""
    return {name: str(folder / file) for name, file in names.items()}


def write_decoded(entry: Entry, read: Decoded, settings: Lighthouse, paths: Paths) -> None:
    """Pulses, gyroscope and accelerometer, stations, clean hits, and the board; `paths` are named
    pulses, inertial, stations, sweeps, board."""
    origin = {
        "recording": entry.calibration,
        "source": entry.twin or Path(str(entry.path)).name,  # wherever the file was
        "twin": entry.twin,
        "sha256": None if entry.twin else files.sha256(str(entry.path)),
        "lighthouse": settings.of_one(),
        "duration_s": read.duration_s,
        "resolution_s": read.pulses.resolution_s if read.pulses else None,
        "notes": read.notes,
        "clocks": [vars(clock) for clock in read.clocks],
        **({} if read.generation == 1 else {"generation": read.generation}),
        **({} if read.host_s is None else {"host_s": read.host_s}),
        "versions": files.versions("numpy", "numba", "pyarrow"),
    }
    none: Mapping[str, Sequence[object]] = {"start_s": [], "length_us": [], "diode": []}
    table = none if read.pulses is None else records.pulse_columns(read.pulses)
    files.write_table(paths["pulses"], table, origin, records.PULSES_CODED)
    sensors = read.pulses.inertial if read.pulses else None
    files.write_table(paths["inertial"], records.inertial_columns(sensors), origin, records.PLACES)
    origin |= {"counts_by_diode": read.report, "dropped": dropped_share(read.report)}
    files.write_table(
        paths["sweeps"], records.sweep_columns(read.hits), origin, records.SWEEPS_CODED
    )
    write_board(paths["board"], read.board, read.normals)
    files.write_json(paths["stations"], stations_to_json(read.stations))
    for station in read.stations:
        log.info("%s: id %s, mode %s, %s", station.role, station.id, station.mode, station.why)
    log.info("%d hits; dropped %s; %s", len(read.hits), origin["dropped"], read.notes)


@dataclass(frozen=True)
class Recorded:
    """A decoded recording, read again: clean hits, board (n, 3) in m, directions of its diodes
    where they are known; origin: metadata of the hits; sensors of the board; lengths in the room.
    """

    hits: Hits
    stations: Sequence[Station]
    board: np.ndarray
    normals: np.ndarray | None
    origin: files.Metadata
    inertial: Inertial | None = None
    lengths: tuple[KnownLength, ...] = ()

    @property
    def names(self) -> list[str]:
        return [station.role for station in self.stations]

    @property
    def generation(self) -> int:
        return self.stations[0].generation if self.stations else 1

    @property
    def clocks(self) -> tuple[TurnClock, ...]:
        """Clocks of the turns of second-generation stations, where their light shows them."""
        return tuple(
            TurnClock(**values) for values in self.origin["clocks"] if self.generation == 2
        )

    @property
    def seen(self) -> tuple[Hits, np.ndarray, list[Factory | None]]:
        """Hits, board (n, 3) in m, and the factory values of each station, as `calibrate` takes
        them."""
        return self.hits, self.board, [station.factory for station in self.stations]


def recorded(inputs: Paths, entry: Entry | None = None) -> Recorded:
    """`inputs` are named sweeps, stations, board, inertial and points (if any); entry: of the row
    that states a length, where it is to be used."""
    columns, origin = files.read_table(inputs["sweeps"])
    stations = stations_from_json(json.loads(Path(inputs["stations"]).read_text(encoding="utf-8")))
    board, normals = read_board(inputs["board"]), read_normals(inputs["board"])
    inertial = None
    if (path := inputs.get("inertial")) is not None:
        inertial = records.inertial_of(files.read_table(path)[0])
    read = Recorded(records.hits_of(columns), stations, board, normals, origin, inertial)
    if entry is None:
        return read
    return replace(read, lengths=lengths_of(entry, inputs.get("points"), len(board), read.names))


def write_board(path: str, board: np.ndarray, normals: np.ndarray | None = None) -> None:
    """A board as a CSV file x_m,y_m,z_m in diode order; where known, with the directions in which
    the diodes look, unit vectors nx,ny,nz."""
    columns = COLUMNS if normals is None else (*COLUMNS, *NORMALS)
    rows = board if normals is None else np.hstack([board, normals])
    files.write_csv(path, [dict(zip(columns, row, strict=True)) for row in rows])


def write_twin(twin: LighthouseTwin, seed: int, paths: Paths) -> str:
    """Simulate a Lighthouse twin; write it as a dump, with what a lab would have beside it: paths
    dump, twin_board, truth, reference, mount. Returns what was made, in words."""
    seed += twin.seed
    simulation = simulated.simulate(twin, seed)
    seen = simulate_mounts(twin, seed)
    frames = np.moveaxis(seen.positions_mm, 2, 0).astype(np.float32)
    write_c3d(paths["reference"], seen.labels, seen.rate_hz, [frames], len(frames))
    write_mounts(paths["mount"], seen.labels)
    write_board(paths["twin_board"], simulation.truth.board)
    files.write_json(paths["truth"], simulated.truth_json(simulation))
    simulated.write_dump(paths["dump"], simulation.pulses)
    return f"{simulation.pulses.start_s.size} pulses in {twin.duration_s:g} s"


def network_twin(twin: NetworkTwin, seed: int, settings: Lighthouse, paths: Paths) -> Decoded:
    """Simulate a twin of the second generation and decode its light; writes what a lab would have
    beside it, `paths` named twin_board and truth."""
    from mocap_metrology.lighthouse.simulate.turns import simulate_turns

    simulation = simulate_turns(twin.turns(seed))
    write_board(paths["twin_board"], simulation.twin.board, simulation.twin.normals)
    files.write_json(paths["truth"], truth_json(simulation))
    return decode_light(simulation.light, simulation.twin.board, None, _cleaning(settings), "twin")


def with_sensors(read: Decoded, twin: LighthouseTwin, seed: int) -> Decoded:
    """The decoded dump of a twin with its gyroscope and accelerometer, of which a dump has none."""
    if twin.inertial is None or read.pulses is None:
        return read
    seed += twin.seed
    motion = motion_of(twin.motion, np.array([one.t for one in twin.stations]), seed)
    rng = np.random.default_rng([seed, simulated.SENSORS])
    series = sensed(motion, simulated.up_of(twin), twin.inertial, twin.duration_s, rng)
    return replace(read, pulses=replace(read.pulses, inertial=series))
