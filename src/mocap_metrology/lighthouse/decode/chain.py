"""From a recording to cleaned hits: all stages of decoding, for all formats."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.board import FEWEST_DIODES, check_count, read_board, read_normals
from mocap_metrology.lighthouse.decode.angles_csv import read_angles, read_counts
from mocap_metrology.lighthouse.decode.clean import RESOLUTION_RAD, clean_hits, clean_turn_hits
from mocap_metrology.lighthouse.decode.crazyflie import read_log, read_uart
from mocap_metrology.lighthouse.decode.dump import check_byte_order, read_dump
from mocap_metrology.lighthouse.decode.factory_file import read_factory
from mocap_metrology.lighthouse.decode.flashes import (
    expect_unbroken,
    find_flashes,
    find_hits,
    within_flashes,
)
from mocap_metrology.lighthouse.decode.gates import Cleaning
from mocap_metrology.lighthouse.decode.libsurvive import read_libsurvive
from mocap_metrology.lighthouse.decode.ootx import decode_station
from mocap_metrology.lighthouse.decode.turns import (
    PERIOD_S,
    Light,
    channels_by_period,
    decode_turns,
    find_turn_hits,
    find_turns,
    unknown_station,
)
from mocap_metrology.lighthouse.records import AXES, ROLES, Clock, Flashes, Hits, Pulses, Station
from mocap_metrology.lighthouse.timing import CYCLE_S

OF_LIGHT = {"crazyflie-uart": read_uart, "crazyflie-log": read_log}
OF_ANGLES = {"angles-csv": read_angles, "lfsr-counts": read_counts}


class _How(NamedTuple):
    """Board (n, 3) in m, file of calibrations, thresholds, and name of a recording."""

    places: np.ndarray
    factory: str | Path | None
    cleaning: Cleaning
    name: str


@dataclass(frozen=True)
class Decoded:
    """A decoded recording, of two stations or of any number of the second generation.

    pulses: None for angles-csv, in generation 2 of unknown length; clocks: of the stations, none
    for angles-csv; report: counts a diode of what was dropped and why; notes: one line each;
    normals: directions in which the diodes look, (n, 3), where the object describes them; host_s:
    time 0 by the clock of the computer, where the recording tells.
    """

    pulses: Pulses | None
    stations: list[Station]
    clocks: list[Clock]
    hits: Hits
    board: np.ndarray
    duration_s: float
    report: dict[str, list[int]]
    notes: list[str]
    generation: int = 1
    normals: np.ndarray | None = None
    host_s: float | None = None


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
    """Decode a recording of one of `lighthouse.RECORDING_FORMATS`.

    board: CSV of diodes (with their directions nx,ny,nz or without), or the name of the tracked
    object in a libsurvive recording; factory: file of calibrations, for stations whose own cannot
    be read out of the recording.

    Raises `Refusal` for a recording that is none, one station only, or fewer than four diodes.
    """
    name, cleaning = Path(path).name, cleaning or Cleaning()
    pulses: Pulses | None = None
    clocks, report, resolution_rad = list[Clock](), dict[str, list[int]](), RESOLUTION_RAD
    options = factory, cleaning, name
    normals = None if kind == "libsurvive-rec" else read_normals(board)
    if kind in OF_LIGHT:
        places = read_board(board)
        return decode_light(replace(OF_LIGHT[kind](path), normals=normals), places, *options)
    if kind in OF_ANGLES:
        places, (hits, channels) = read_board(board), OF_ANGLES[kind](path)
        last, why = int(hits.diode.max(initial=-1)), "a file of angles contains no "
        n_diodes = max(len(places), last + 1)
        if channels:
            check_count(places, n_diodes, last, name)
            of_file = [(unknown_station(k, why + "calibration frames"), None) for k in channels]
            decoded = _of_turns(hits, of_file, _How(places, *options), RESOLUTION_RAD, [])
            return replace(decoded, normals=normals)
        stations = [Station(role, why=why + "flashes") for role in ROLES]
    else:
        if kind == "libsurvive-rec":
            read, places = read_libsurvive(path, str(board))
            if isinstance(read, Light):
                return decode_light(read, places, *options)
            pulses, flashes = within_flashes(read, find_flashes(read))
            normals = pulses.normals
        else:
            pulses, places = read_dump(path, sample_rate_hz, active_level), read_board(board)
            flashes = _flashes_of_dump(pulses, name)
            expect_unbroken(pulses, flashes, name)
        if len(flashes) < 2:
            why = "flashes of one base station only; expected two, both visible from the board"
            raise Refusal(f"{name}: {why}")
        stations = [decode_station(one) for one in flashes]
        clocks = [one.clock for one in flashes]
        hits, report = find_hits(pulses, flashes)
        n_diodes = pulses.n_diodes
        resolution_rad = np.pi * pulses.resolution_s / CYCLE_S
    _check_diodes(hits, f"{name}: sweeps")
    check_count(places, n_diodes, int(hits.diode.max()), name)
    if kind == "gpio-dump":
        check_byte_order(hits, places, name)
    hits, dropped = clean_hits(hits, places, cleaning, resolution_rad)
    for station, role in enumerate(ROLES):
        for axis, called in enumerate(AXES):
            of_laser = hits.take((hits.station == station) & (hits.axis == axis))
            _check_diodes(of_laser, f"{name}: {called} sweeps of the {role}")
    stations, notes = _with_factory(stations, factory)
    notes = [*(pulses.notes if pulses else ()), *notes, *_doubts(dropped)]
    duration_s = pulses.duration_s if pulses else float(np.ptp(hits.time_s))
    decoded = Decoded(pulses, stations, clocks, hits, places, duration_s, report | dropped, notes)
    return replace(decoded, normals=normals)


def _flashes_of_dump(pulses: Pulses, name: str) -> list[Flashes]:
    """Flashes in a dump; refuses one of second-generation light with the reason."""
    try:
        return find_flashes(pulses)
    except Refusal:
        if not (channels := channels_by_period(pulses)):
            raise
    raise Refusal(
        f"{name}: no flashes, but pulses that repeat with the turns of second-generation (V2) base"
        f" stations (channel {', '.join(map(str, channels))}); expected first-generation ones: what"
        " tells the angle are bits of 167 ns, which samples of 2 MHz do not show"
    )


def decode_light(
    light: Light, places: np.ndarray, factory: str | Path | None, cleaning: Cleaning, name: str
) -> Decoded:
    """Hits, stations and clocks of stations of the second generation, from hits and begins of
    turns."""
    turns, notes = find_turns(light)
    hits, report = find_turn_hits(light, turns)
    check_count(places, light.n_diodes, int(hits.diode.max(initial=-1)), name)
    resolution_rad = 2 * np.pi * light.resolution_s / float(PERIOD_S.min())
    stations = [(decode_turns(one), one.clock) for one in turns]
    how = _How(places, factory, cleaning, name)
    decoded = _of_turns(hits, stations, how, resolution_rad, [*light.notes, *notes])
    pulses = Pulses(
        start_s=decoded.hits.time_s,
        length_s=np.full(len(decoded.hits), np.nan),
        diode=decoded.hits.diode,
        n_diodes=light.n_diodes,
        duration_s=light.duration_s,
        resolution_s=light.resolution_s,
        inertial=light.inertial,
    )
    return replace(
        decoded,
        pulses=pulses,
        duration_s=light.duration_s,
        report=report | decoded.report,
        normals=light.normals,
        host_s=None if np.isnan(light.host_s) else light.host_s,
    )


def _of_turns(
    hits: Hits,
    stations: Sequence[tuple[Station, Clock | None]],
    how: _How,
    resolution_rad: float,
    notes: Sequence[str],
) -> Decoded:
    """Clean hits of second-generation stations, of which those remain that enough diodes see."""
    hits, dropped = clean_turn_hits(hits, how.places, how.cleaning, resolution_rad)
    seen = [
        min(np.unique(hits.diode[(hits.station == k) & (hits.axis == p)]).size for p in (0, 1))
        for k in range(len(stations))
    ]
    used, few = [k for k, n in enumerate(seen) if n >= FEWEST_DIODES], list[str]()
    for k, n in enumerate(seen):
        if n < FEWEST_DIODES:
            need = f"a calibration needs at least {FEWEST_DIODES}"
            few.append(f"channel {stations[k][0].channel}: seen by {n} diodes; {need}")
    if len(used) < 2:
        why = "; ".join([*notes, *few]) or "no light of another"
        raise Refusal(
            f"{how.name}: {len(used)} usable base stations ({why}); expected at least two"
        )
    place = np.full(len(stations) + 1, -1, np.int8)
    place[used] = np.arange(len(used))
    hits = replace(hits, station=place[hits.station]).take(place[hits.station] >= 0)
    chosen, filed = _with_factory([stations[k][0] for k in used], how.factory)
    clocks = [clock for k in used if (clock := stations[k][1]) is not None]
    told = [*notes, *few, *filed, *_doubts(dropped)]
    fields = hits, how.places, float(np.ptp(hits.time_s)), dropped, told
    return Decoded(None, chosen, clocks, *fields, generation=2)


def _doubts(dropped: Mapping[str, Sequence[int]]) -> list[str]:
    """A note on diodes that lose more hits than they keep, being seen as often as others: one that
    faces away has reflections alone."""
    lost, left = np.array(dropped["sweep"]), np.array(dropped["kept"])
    often = lost + left >= np.median(lost + left) / 2
    odd = np.flatnonzero((lost > left) & often)
    if not odd.size:
        return []
    on = ", ".join(map(str, odd))
    return [f"most rejected hits are on diode {on}: is the board file right?"]


def _check_diodes(hits: Hits, sweeps: str) -> None:
    n = np.unique(hits.diode).size
    if n < FEWEST_DIODES:
        raise Refusal(f"{sweeps} on {n} diodes; a calibration needs at least {FEWEST_DIODES}")


def _with_factory(
    stations: Sequence[Station], path: str | Path | None
) -> tuple[list[Station], list[str]]:
    """Stations with the calibrations of a file where the recording has none: by id, where none was
    read by role."""
    if path is None:
        return list(stations), []
    name, result, notes = Path(path).name, [], []
    filed = read_factory(path)
    theirs, ours = filed[0].generation, stations[0].generation
    if theirs != ours:
        raise Refusal(
            f"{name}: factory values of stations of generation {theirs}; the recording is of"
            f" generation {ours}"
        )
    for station in stations:
        key = "role" if station.id is None else "id"
        same = [other for other in filed if getattr(other, key) == getattr(station, key)]
        if station.factory is None and same:
            notes.append(f"{station.role}: factory values from {name}")
            source = same[0]
            station = replace(
                station,
                id=source.id if station.id is None else station.id,
                mode=station.mode or source.mode,
                factory=source.factory,
                gravity=source.gravity if station.gravity is None else station.gravity,
                up_by_geometry=source.up_by_geometry,
                why=f"{station.why}; factory values taken from {name}",
            )
        result.append(station)
    return result, notes


def dropped_share(report: Mapping[str, Sequence[int]]) -> dict[str, float]:
    """Share of sweep pulses dropped, by reason; all diodes together."""
    reasons = ("too_long", "second_on_diode", "width", "sweep", "still")
    counts = {reason: sum(report.get(reason, [])) for reason in reasons}
    total = sum(counts.values()) + sum(report.get("kept", []))
    return {reason: count / max(total, 1) for reason, count in counts.items()}
