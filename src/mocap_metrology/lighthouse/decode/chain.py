"""From a recording to cleaned hits: all stages of decoding, for the three formats."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.board import FEWEST_DIODES, check_count, read_board
from mocap_metrology.lighthouse.decode.angles_csv import read_angles
from mocap_metrology.lighthouse.decode.clean import (
    GATE_MAD,
    GATE_RAD,
    HALF_WINDOW,
    N_SIGMA,
    clean_hits,
)
from mocap_metrology.lighthouse.decode.dump import check_byte_order, read_dump
from mocap_metrology.lighthouse.decode.factory_file import read_factory
from mocap_metrology.lighthouse.decode.flashes import find_flashes, within_flashes
from mocap_metrology.lighthouse.decode.libsurvive import read_libsurvive
from mocap_metrology.lighthouse.decode.ootx import decode_station
from mocap_metrology.lighthouse.decode.sweeps import find_hits
from mocap_metrology.lighthouse.records import (
    MASTER,
    ROLES,
    SLAVE,
    Clock,
    Hits,
    Pulses,
    Station,
)
from mocap_metrology.lighthouse.timing import CYCLE_S

FORMATS = ("gpio-dump", "libsurvive-rec", "angles-csv")


@dataclass(frozen=True)
class Cleaning:
    """Thresholds of `clean_hits`."""

    gate_rad: float = GATE_RAD
    gate_mad: float = GATE_MAD
    half_window: int = HALF_WINDOW
    n_sigma: float = N_SIGMA


@dataclass(frozen=True)
class Decoded:
    """A decoded recording of two stations.

    pulses: None for angles-csv; clocks: of master and slave, none for angles-csv; report: counts a
    diode of what was dropped and why; notes: one line each.
    """

    pulses: Pulses | None
    stations: list[Station]
    clocks: list[Clock]
    hits: Hits
    board: np.ndarray
    duration_s: float
    report: dict[str, list[int]]
    notes: list[str]


def decode(
    path: str | Path,
    kind: str,
    board: str | Path,
    factory: str | Path | None = None,
    *,
    sample_rate_hz: float = 2e6,
    active_level: int = 1,
    cleaning: Cleaning | None = None,
) -> Decoded:
    """Decode a recording of one of `FORMATS`.

    board: CSV of diodes, or the name of the tracked object in a libsurvive recording; factory: file
    of calibrations, for stations whose own cannot be read out of the recording.

    Raises `Refusal` for a recording that is none, one station only, or fewer than four diodes.
    """
    name = Path(path).name
    pulses: Pulses | None = None
    clocks: list[Clock] = []
    report: dict[str, list[int]] = {}
    if kind == "angles-csv":
        places, hits = read_board(board), read_angles(path)
        stations = [Station(role, why="a file of angles contains no flashes") for role in ROLES]
        _check_diodes(places, hits, max(len(places), int(hits.diode.max(initial=-1)) + 1), name)
    else:
        if kind == "libsurvive-rec":
            pulses, places = read_libsurvive(path, str(board))
        else:
            pulses = read_dump(path, sample_rate_hz, active_level)
            places = read_board(board)
        flashes = find_flashes(pulses)
        if kind == "libsurvive-rec":
            pulses, flashes = within_flashes(pulses, flashes)
        if len(flashes) < 2:
            raise Refusal(
                f"{name}: flashes of one base station only; expected two, both visible from the "
                "board"
            )
        stations = [replace(decode_station(f), role=ROLES[f.station]) for f in flashes]
        clocks = [f.clock for f in flashes]
        hits, report = find_hits(pulses, flashes)
        _check_diodes(places, hits, pulses.n_diodes, name)
        if kind == "gpio-dump":
            check_byte_order(hits, places, name)
    limits = asdict(cleaning or Cleaning())
    if pulses:
        limits["resolution_rad"] = np.pi * pulses.resolution_s / CYCLE_S
    hits, dropped = clean_hits(hits, places, **limits)
    _check_stations(hits, name)
    stations, notes = _with_factory(stations, factory)
    notes = [*(pulses.notes if pulses else ()), *notes, *_odd_diodes(dropped)]
    duration = pulses.duration_s if pulses else float(np.ptp(hits.time_s))
    return Decoded(pulses, stations, clocks, hits, places, duration, report | dropped, notes)


def _odd_diodes(dropped: Mapping[str, Sequence[int]]) -> list[str]:
    """Diodes that most sweeps contradict: a fault, or in the wrong place of the board file."""
    pairs = enumerate(zip(dropped["sweep"], dropped["kept"], strict=True))
    odd = [str(diode) for diode, (out, kept) in pairs if out > kept]
    return (
        [f"most rejected hits are on diode {', '.join(odd)}: is the board file right?"]
        if odd
        else []
    )


def _check_diodes(board: np.ndarray, hits: Hits, n_diodes: int, name: str) -> None:
    if len(np.unique(hits.diode)) < FEWEST_DIODES:
        raise Refusal(
            f"{name}: sweeps on {len(np.unique(hits.diode))} diodes;"
            f" a calibration needs at least {FEWEST_DIODES}"
        )
    check_count(board, n_diodes, int(hits.diode.max()), name)


def _check_stations(hits: Hits, name: str) -> None:
    for station in (MASTER, SLAVE):
        for axis, called in enumerate(("azimuth", "elevation")):
            own = (hits.station == station) & (hits.axis == axis)
            if np.unique(hits.diode[own]).size < FEWEST_DIODES:
                raise Refusal(
                    f"{name}: {called} sweeps of the {ROLES[station]} on"
                    f" {np.unique(hits.diode[own]).size} diodes; expected at least {FEWEST_DIODES}"
                    " for both axes of both stations"
                )


def _with_factory(
    stations: Sequence[Station], path: str | Path | None
) -> tuple[list[Station], list[str]]:
    """Stations with the calibrations of a file where the recording has none: by id, where none was
    read by role."""
    if path is None:
        return list(stations), []
    filed = read_factory(path)
    result, notes = [], []
    for station in stations:
        own = [
            other
            for other in filed
            if (other.id == station.id if station.id is not None else other.role == station.role)
        ]
        if station.factory is None and own:
            notes.append(f"{station.role}: factory values from {Path(path).name}")
            given = own[0]
            station = replace(
                station,
                id=station.id if station.id is not None else given.id,
                mode=station.mode or given.mode,
                factory=given.factory,
                gravity=station.gravity if station.gravity is not None else given.gravity,
                up_by_geometry=given.up_by_geometry,
                why=f"{station.why}; factory values taken from {Path(path).name}",
            )
        result.append(station)
    return result, notes


def dropped_share(report: Mapping[str, Sequence[int]]) -> dict[str, float]:
    """Share of sweep pulses dropped, by reason; all diodes together."""
    reasons = ("too_long", "second_on_diode", "width", "sweep", "still")
    counts = {reason: sum(report.get(reason, [])) for reason in reasons}
    total = sum(counts.values()) + sum(report.get("kept", []))
    return {reason: count / total if total else 0.0 for reason, count in counts.items()}
