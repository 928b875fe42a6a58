"""Twins of recordings before any number of second-generation stations.

Every field is a key of the file of twins, with its range, default and meaning.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np

from mocap_metrology.common.entries import Entry, Number, Text, Whole, one_of
from mocap_metrology.lighthouse.simulate.twin import PATTERNS, MotionTwin

if TYPE_CHECKING:  # scipy and numba, which who reads a file of twins does not need
    from mocap_metrology.lighthouse.simulate.turns import MadeTurns, TurnsTwin

COVER_MM = (-0.8, 1.6)
OF_MOTION = {"pattern", "speed_m_s", "extent_m", "wobble_deg"}  # keys as of `MotionTwin`
OF_TURNS = {  # as of `TurnsTwin`
    *("duration_s", "common_urad", "independent_urad", "begin_ns", "wander_ns", "place_mm"),
    *("dropout", "reflections"),
}
PLACES = 3  # stream of random numbers of where the board is moved


class NetworkTwin(Entry):
    """A simulated recording of an object of 32 diodes all around before second-generation stations
    on the walls of a room, which look at its middle. Factory values of the stations are drawn from
    the spread of real ones."""

    seed: Annotated[int, Whole(0, 2**31)]
    """The same seed gives the same recording."""
    stations: Annotated[int, Whole(2, 16)]
    """Number of stations, on channels 0, 1, ..."""
    setup: Text = ""
    """Name of one of `setups`, which has the keys that the twin does not set."""
    room_seed: Annotated[int, Whole(0, 2**31)] = 0
    """Seed of the stations and of the errors of the diodes' places: recordings with the same one
    are of one setup."""
    pattern: Annotated[str, one_of(PATTERNS)] = "hand"
    """Of the motion, as `motion.pattern` of the first generation."""
    speed_m_s: Annotated[float, Number(0, 5)] = 0.4
    """Largest speed on the path."""
    extent_m: Annotated[float, Number(0, 5)] = 0.6
    """Diameter, length, largest extent along an axis."""
    wobble_deg: Annotated[float, Number(0, 45)] = 12.0
    """Slow random rotation about each axis (rms)."""
    places_m: Annotated[float, Number(0, 2)] = 0.3
    """The middle of the path is so far from the middle of the room in each direction (SD)."""
    duration_s: Annotated[float, Number(1, 60)] = 20.0
    """Of 8.2 s or more, as a whole frame of factory values takes, better 12 s."""
    common_urad: Annotated[float, Number(0, 1e4)] = 15.0
    """Noise of a sweep, the same for all diodes (SD)."""
    independent_urad: Annotated[float, Number(0, 1e4)] = 15.0
    """Noise of each hit (SD)."""
    begin_ns: Annotated[float, Number(0, 1e4)] = 50.0
    """Noise of the begin of a turn as the receiver tells it (SD)."""
    wander_ns: Annotated[float, Number(0, 1e4)] = 250.0
    """How far a rotor swings, with a period of 13 turns, before and behind its line (rms)."""
    place_mm: Annotated[float, Number(0, 10)] = 0.15
    """Errors of the board's file: of each coordinate of a diode (SD)."""
    cover: bool = True
    """Whether diodes are behind covers, which shift them along their direction by -0.8 mm and
    more at larger incidence; otherwise they are bare."""
    dropout: Annotated[float, Number(0, 1)] = 0.02
    """Share of hits that are lost."""
    reflections: Annotated[float, Number(0, 1)] = 0.0
    """Share of hits that are reflections."""

    @property
    def motion(self) -> MotionTwin:
        """About the middle of the room, in the frame of the first station."""
        return self.turns(0).motion

    def turns(self, seed: int) -> TurnsTwin:
        """Stations, object and motion; seed: added to both seeds."""
        from mocap_metrology.lighthouse.simulate.turns import TurnsTwin, stations_around

        room, recording_seed = seed + self.room_seed, seed + self.seed
        R, t, middle, up = stations_around(self.stations, np.random.default_rng(room))
        centre = middle + self.places_m * np.random.default_rng(
            [recording_seed, PLACES]
        ).standard_normal(3)
        motion = MotionTwin(centre_m=tuple(centre), **self.model_dump(include=OF_MOTION))
        return TurnsTwin(
            seed=room,
            take=1 + recording_seed,
            R=R,
            t=t,
            channels=tuple(range(self.stations)),
            motion=motion,
            cover_mm=COVER_MM if self.cover else None,
            up=up,
            **self.model_dump(include=OF_TURNS),
        )


def truth_json(simulation: MadeTurns) -> dict[str, object]:
    """Poses of the stations in the frame of the first, as a file of references."""
    twin = simulation.twin
    rows = zip(twin.channels, simulation.ids, twin.R, twin.t, strict=True)
    stations = {str(c): {"id": k, "R": R.tolist(), "t_m": t.tolist()} for c, k, R, t in rows}
    return {"stations": stations}
