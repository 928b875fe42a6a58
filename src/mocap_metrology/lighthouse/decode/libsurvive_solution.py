"""Poses and factory values that libsurvive stores beside a recording (`.json`).

libsurvive counts stations the other way round (its lighthouse 0 is the one whose flash comes
second) and looks along -Z with X to the right and Y up: x = -Z, y = -X, z = Y.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.common.documents import text_of
from mocap_metrology.common.errors import UNREADABLE, Refusal
from mocap_metrology.lighthouse.decode.libsurvive_lines import WRAP
from mocap_metrology.lighthouse.decode.turns import PERIOD_S
from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.lighthouse.rotation import of_quaternions

# Rows: x, y, z of this project in axes of libsurvive, X, Y, Z.
FROM_LIBSURVIVE = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
BLOCK = re.compile(r'"lighthouse(\d+)"\s*:\s*\{([^{}]*)\}')
ENTRY = re.compile(r'"(\w+)"\s*:\s*(?:"([^"]*)"|\[([^][]*)\])')
MODES = "Abc"  # by number
FACTORY_KEYS = {
    "phase": "fcalphase",
    "tilt": "fcaltilt",
    "curve": "fcalcurve",
    "gibphase": "fcalgibpha",
    "gibmag": "fcalgibmag",
}
FACTORY2_KEYS = {**FACTORY_KEYS, "ogeephase": "fcalogeephase", "ogeemag": "fcalogeemag"}
SECOND_NAMED = re.compile(r'"(?:configed-)?lighthouse-gen"\s*:\s*"2"')
CLIPPED_ID = 0x7FFFFFFF  # of larger ones, by some versions of libsurvive


@dataclass(frozen=True)
class SolvedStation:
    """A station in libsurvive's own solution; pose from station to world, in libsurvive's axes,
    None where it has none."""

    index: int
    id: int
    mode: str | None  # of generation 1
    factory: Factory
    pose: tuple[np.ndarray, np.ndarray] | None
    channel: int | None = None  # of generation 2


def read_solution(path: str | Path, generation: int = 1) -> list[SolvedStation]:
    """Stations in the configuration that libsurvive writes beside a recording.

    It is a list of `"key":"value"` and of blocks, not quite JSON. Ids are unsigned, which the file
    prints with a sign. Stations without a factory calibration (OOTXSet 0) are left out.
    Raises `Refusal` where there is no station of the generation in it.
    """
    name = Path(path).name
    text = text_of(path, "libsurvive's JSON")
    if (second := of_second_generation(text)) != (generation == 2):
        words = ["first-generation", "second-generation (V2)"]
        raise Refusal(f"{name}: of {words[second]} stations; expected {words[not second]} ones")
    try:
        solved = [_solved(int(i), block, generation) for i, block in BLOCK.findall(text)]
    except UNREADABLE as error:
        raise Refusal(
            f"{name}: a lighthouse block has a missing or invalid entry ({error}); expected id, "
            "mode, pose, fcal*"
        ) from None
    stations = [station for station in solved if station is not None]
    if not stations:
        raise Refusal(f"{name}: no calibrated station; expected blocks lighthouse0, lighthouse1")
    return stations


def of_second_generation(text: str) -> bool:
    """Whether a configuration is of second-generation stations: it says so, or has values that the
    first does not transmit, which are zeros there."""
    ogee = re.findall(r'"fcalogee\w*"\s*:\s*\[([^][]*)\]', text)
    return bool(SECOND_NAMED.search(text)) or any(re.search("[1-9]", values) for values in ogee)


def _solved(index: int, block: str, generation: int) -> SolvedStation | None:
    entries = {key: listed or single for key, single, listed in ENTRY.findall(block)}
    if entries.get("OOTXSet", "1") == "0":
        return None

    def numbers(key: str, count: int) -> np.ndarray:
        values = np.array([float(v.strip(' "')) for v in entries[key].split(",")])
        if values.size != count or not np.isfinite(values).all():
            raise ValueError(f"{key} is {entries[key]}")
        return values

    keys = FACTORY_KEYS if generation == 1 else FACTORY2_KEYS
    calibration: dict[str, Any] = {name: numbers(key, 2) for name, key in keys.items()}
    mode, pose = int(entries["mode"]), None
    if entries.get("PositionSet", "1") != "0":
        values = numbers("pose", 7)
        pose = of_quaternions(np.roll(values[3:], -1)), values[:3]
    if generation == 2 and not 0 <= mode < PERIOD_S.size:
        raise ValueError(f"mode is {mode}")
    return SolvedStation(
        index=index,
        id=int(entries["id"]) % WRAP,
        mode=MODES[mode] if generation == 1 and 0 <= mode < 3 else None,
        factory=Factory(**calibration, generation=generation),
        pose=pose,
        channel=mode if generation == 2 else None,
    )


def solution_pose(stations: list[SolvedStation]) -> tuple[np.ndarray, np.ndarray]:
    """Pose of the slave in the master's frame, R (3, 3) and t in metres, in this project's axes.

    The master is libsurvive's lighthouse 1. With station-to-world poses R_i, t_i and the change of
    axes C: R = C R_1^T R_0 C^T, t = C R_1^T (t_0 - t_1).
    """
    by_index = {station.index: station.pose for station in stations}
    slave, master = by_index.get(0), by_index.get(1)
    if slave is None or master is None:
        raise Refusal(
            "libsurvive's solution: expected poses of the two stations lighthouse0 and lighthouse1"
        )
    C, to_master = FROM_LIBSURVIVE, master[0].T
    return C @ to_master @ slave[0] @ C.T, C @ to_master @ (slave[1] - master[1])
