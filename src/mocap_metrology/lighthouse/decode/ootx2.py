"""Calibration of a second-generation station (OOTX) out of the bits of its turns."""

from __future__ import annotations

from mocap_metrology.lighthouse.decode.turns import Turns
from mocap_metrology.lighthouse.records import Station


def decode_turns(turns: Turns) -> Station:
    """Calibration of the station whose turns these are."""
    return Station(
        str(turns.channel),
        why="no calibration frame",
        generation=2,
        channel=turns.channel,
    )
