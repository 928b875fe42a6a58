"""A length that was measured in the room, and how a cell states it."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import ROLES

SD = r"(?P<length>\d{1,3}(?:\.\d{1,9})?) (?P<sd>\d(?:\.\d{1,9})?)"
MOMENT = r"diode \d{1,4} at \d{1,6}(?:\.\d{1,6})? s"
STATIONS = re.compile(rf"stations (?:(?P<one>\d{{1,2}})-(?P<other>\d{{1,2}}) )?{SD}")
DIODES = re.compile(f"(?P<first>{MOMENT}) - (?P<second>{MOMENT}) {SD}")
POINTS = re.compile(r"points(?: (\d(?:\.\d{1,9})?))?")
PLACE = re.compile(r"diode (\d{1,4})(?: at (\d{1,6}(?:\.\d{1,6})?) s)?")
FORM = re.sub(r"\?P<\w+>", "?:", f"{STATIONS.pattern}|{DIODES.pattern}|{POINTS.pattern}")
POINTS_SD_M = 0.005  # of a coordinate
LARGEST_M = 100.0
EXPECTED = (
    "`stations 4.330 0.005`, `stations 3-11 4.330 0.005` (channels),"
    " `diode 0 at 2.0 s - diode 0 at 7.0 s 2.000 0.002` or `points` (m, then"
    " its standard deviation)"
)


@dataclass(frozen=True)
class Place:
    """A station, or a diode at a moment."""

    station: int | None = None
    diode: int = -1
    time_s: float = 0.0


@dataclass(frozen=True)
class KnownLength:
    """Size of the figure of some places, the root of the sum of their squared distances from their
    mean, and its standard deviation, m."""

    places: tuple[Place, ...]
    size_m: float
    sd_m: float

    def among(self, stations: Sequence[int]) -> KnownLength:
        """The length with its stations numbered among these; refuses others."""

        def of_member(place: Place) -> Place:
            if place.station is None:
                return place
            if place.station not in stations:
                raise Refusal("known_length: a station that is not connected with the reference")
            return replace(place, station=list(stations).index(place.station))

        return replace(self, places=tuple(map(of_member, self.places)))

    @classmethod
    def between(cls, first: Place, second: Place, length_m: float, sd_m: float) -> KnownLength:
        """The distance of two places."""
        return cls((first, second), length_m / np.sqrt(2), sd_m / np.sqrt(2))

    @classmethod
    def of_points(cls, points: Sequence[tuple[Place, np.ndarray]], sd_m: float) -> KnownLength:
        """sd_m: of a coordinate."""
        places, known = zip(*points, strict=True)
        size = np.linalg.norm(known - np.mean(known, axis=0))
        return cls(places, float(size), sd_m)


def known_length(
    text: str,
    n_diodes: int,
    points: Mapping[str, np.ndarray] | None = None,
    names: Sequence[str] = ROLES,
) -> KnownLength:
    """The length that a cell states: see `EXPECTED`; points: places in the room by label, in m;
    names: of the stations. Raises `Refusal` for anything else, for diodes that the board has not,
    and for `points` without a file of these."""
    if (cell := POINTS.fullmatch(text)) and float(cell[1] or POINTS_SD_M):
        if points is None:
            raise Refusal(f"known_length: {text!r}; expected a file of points (world_points)")
        places = [(_parsed_place(label, n_diodes, names), at) for label, at in points.items()]
        return KnownLength.of_points(places, float(cell[1] or POINTS_SD_M))
    cell = STATIONS.fullmatch(text) or DIODES.fullmatch(text)
    if cell is None or not 0 < float(cell["sd"]) < float(cell["length"]) <= LARGEST_M:
        raise Refusal(f"known_length: {text!r}; expected {EXPECTED}")
    ends = cell.groupdict()
    keys = ("first", "one", names[0]), ("second", "other", names[-1])
    labels = [ends.get(diode) or ends.get(station) or usual for diode, station, usual in keys]
    if cell.re is STATIONS and ends["one"] is None and len(names) > 2:
        raise Refusal(f"known_length: {text!r}; expected two of the stations {', '.join(names)}")
    first, second = (_parsed_place(label, n_diodes, names) for label in labels)
    return KnownLength.between(first, second, float(cell["length"]), float(cell["sd"]))


def _parsed_place(label: str, n_diodes: int, names: Sequence[str]) -> Place:
    if label in names:
        return Place(station=list(names).index(label))
    match = PLACE.fullmatch(label)
    if match is None and label.isdigit():
        raise Refusal(f"known_length: {label!r}; expected one of the stations {', '.join(names)}")
    if match is None or int(match[1]) >= n_diodes:
        raise Refusal(f"known_length: {label!r}: the board has the diodes 0 to {n_diodes - 1}")
    return Place(diode=int(match[1]), time_s=float(match[2] or 0))
