"""What one photodiode sees in four cycles of two stations, flashes and sweeps (J Figure 3)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import MASTER, SLAVE
from mocap_metrology.lighthouse.timing import CYCLE_S

Columns = Mapping[str, np.ndarray]
N_CYCLES = 4
ORDER = ((MASTER, 0), (MASTER, 1), (SLAVE, 0), (SLAVE, 1))  # station and axis of each cycle
SHORTEST_FLASH_S, NEAR_S = 45e-6, 40e-6
MOST_TRIED = 400


class Sweep(NamedTuple):
    """A sweep on the diode; times from the beginning of the recording, s."""

    station: int
    axis: int
    flash_s: float  # of the station that sweeps
    start_s: float
    length_s: float
    angle_rad: float

    @property
    def middle_s(self) -> float:
        return self.start_s + self.length_s / 2

    @property
    def delta_s(self) -> float:
        """From the flash to the middle of the sweep: Delta t of J."""
        return self.middle_s - self.flash_s


class Signal(NamedTuple):
    """Four cycles of a diode: flashes (start, length, station) and sweeps."""

    diode: int
    flashes: list[tuple[float, float, int]]
    sweeps: list[Sweep]


def signal_of(pulses: Columns, sweeps: Columns) -> Signal:
    """The first four cycles in which a diode saw every flash and sweep, the master's azimuth first,
    and nothing else.

    pulses: `start_s`, `diode` and `length_us`; sweeps as in sweeps.parquet. Raises `Refusal` where
    no diode saw them all.
    """
    code = np.asarray(sweeps["cycle"], dtype=np.int64) * 4096 + np.asarray(sweeps["diode"])
    common = np.unique(code)  # first cycle and diode of four sweeps in `ORDER`, earliest first
    for k, (station, axis) in enumerate(ORDER):
        mask = (np.asarray(sweeps["station"]) == station) & (np.asarray(sweeps["axis"]) == axis)
        common = np.intersect1d(common, code[mask] - 4096 * k)
    for first in common[:MOST_TRIED]:
        hits = [int(np.flatnonzero(code == first + 4096 * k)[0]) for k in range(N_CYCLES)]
        diode = int(first % 4096)
        mask = np.asarray(pulses["diode"]) == diode
        length = 1e-6 * np.asarray(pulses["length_us"])[mask]
        start = np.asarray(pulses["start_s"], dtype=np.float64)[mask]
        signal = _read(start, length, {k: np.asarray(v)[hits] for k, v in sweeps.items()}, diode)
        if signal is not None:
            return signal
    raise Refusal(
        "pulses: no diode saw all flashes and sweeps of four cycles; expected one for Figure 3 of J"
    )


def _read(start: np.ndarray, length: np.ndarray, hits: Columns, diode: int) -> Signal | None:
    """Four cycles of a diode from its pulses and its four sweeps, None where something is missing
    or too much."""
    begin = hits["time_s"] - (hits["angle_rad"] / np.pi + 0.5) * CYCLE_S  # of a station's cycle
    first = float(begin[0])  # of the master's cycle; cycles of the slave begin later
    near = (start > first - NEAR_S) & (start < first + N_CYCLES * CYCLE_S - NEAR_S)
    start, length = start[near], length[near]
    long = length > SHORTEST_FLASH_S
    if long.sum() != 2 * N_CYCLES or (~long).sum() != N_CYCLES:
        return None
    of = N_CYCLES * (MASTER, SLAVE)  # in this order in each cycle
    flashes = list(zip(start[long].tolist(), length[long].tolist(), of, strict=True))
    sweeps = []
    for k, (station, axis) in enumerate(ORDER):
        begins = [at for at, _, by in flashes if by == station and abs(at - begin[k]) < NEAR_S]
        at, width = float(start[~long][k]), float(length[~long][k])
        if len(begins) != 1 or abs(at - hits["time_s"][k]) > NEAR_S:
            return None
        sweeps.append(Sweep(station, axis, begins[0], at, width, float(hits["angle_rad"][k])))
    return Signal(diode, flashes, sweeps)
