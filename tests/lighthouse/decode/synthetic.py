"""Light on photodiodes from first principles, for tests of the decoder: flashes and sweeps by the
published timing, edges seen at the next sample. Made apart from the package's simulator."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from mocap_metrology.lighthouse.records import Pulses

RATE = 2e6
TICK = 1 / 48e6
BOARD = np.array([[0.0, y, z] for z in (-0.08, -0.027, 0.027, 0.08) for y in np.arange(8) * 0.034])
# Right down, origin: two stations 2 m apart that face the board
PLACES = (np.array([3.0, -0.4, 0.1]), np.array([2.5, 0.7, -0.3]))
COLUMNS = ("start_s", "length_s", "diode")
MASTER_CODES = np.array([4, 5, 0, 1])  # skip * 4 + axis, by cycle


@dataclass
class Scene:
    """What a recording holds; the defaults are two stations that see a still board for 2 s."""

    seconds: float = 2.0
    begin_s: float = 1.234567e-3  # of the master's first cycle
    phase: int = 0  # of the four cycles, at the first
    cycle_s: float = 400_000 * TICK
    stations: tuple[int, ...] = (0, 1)
    alone: bool = False  # 60 Hz mode: a sweep each cycle
    below_ticks: float = 250.0  # of the longest flash of each code
    bias_s: float = 0.0
    width_s: float = 5e-6
    velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    wander: object = None  # seconds late, of (station, cycle)
    data: object = None  # data bits, (2, cycles)
    seed: int = 1
    rows: list = field(default_factory=list)
    hits: list = field(default_factory=list)

    def build(self) -> Scene:
        rng = np.random.default_rng(self.seed)
        cycles = int((self.seconds - self.begin_s) / self.cycle_s) + 2
        self.codes = np.full((2, cycles), -1)
        self.begins = np.zeros((2, cycles))
        bits = rng.integers(0, 2, (2, cycles)) if self.data is None else self.data
        for station in self.stations:
            for c in range(cycles):
                base = (c + self.phase) % 2 if self.alone else MASTER_CODES[(c + self.phase) % 4]
                base ^= 4 * (station == 1 and not self.alone)
                late = self.wander(station, c) if self.wander else 0.0
                begin = self.begin_s + c * self.cycle_s + 20_000 * TICK * station + late
                code = int(base + 2 * bits[station, c])
                self.codes[station, c], self.begins[station, c] = code, begin
                length = (3000 + 500 * code - self.below_ticks) * TICK + self.bias_s
                self.rows += [(begin, length, d) for d in range(len(BOARD))]
                if not base & 4:
                    self._sweep(station, base & 1, c, begin)
        return self

    def _sweep(self, station: int, axis: int, cycle: int, begin: float) -> None:
        angle = np.zeros(len(BOARD))
        for _ in range(4):
            hit = begin + (angle + np.pi / 2) / np.pi * self.cycle_s
            at = PLACES[station] + hit[:, None] * np.array(self.velocity)
            seen = at + BOARD * (1, -1, 1)
            angle = np.arctan2(seen[:, 1 + axis], seen[:, 0])
        for d in range(len(BOARD)):
            self.rows.append((hit[d] - self.width_s / 2, self.width_s, d))
            self.hits.append((station, axis, cycle, d, hit[d], angle[d]))

    def samples(self) -> np.ndarray:
        """First and last-but-one sample and diode of each pulse inside the recording."""
        start, length, diode = np.array(self.rows).T
        first = np.ceil(start * RATE).astype(int)
        end = np.ceil((start + length) * RATE).astype(int)
        inside = (first > 0) & (end < self.seconds * RATE) & (end > first)
        return np.stack([first, end, diode.astype(int)])[:, inside]

    def words(self) -> np.ndarray:
        words = np.zeros(round(self.seconds * RATE), np.uint32)
        for first, end, diode in self.samples().T:
            words[first:end] |= np.uint32(1 << diode)
        return words

    def pulses(self) -> Pulses:
        """What reading the words gives, as long as no two pulses of a diode touch."""
        first, end, diode = self.samples()
        order = np.lexsort((diode, first))
        return Pulses(
            start_s=first[order] / RATE,
            length_s=(end - first)[order] / RATE,
            diode=diode[order].astype(np.int16),
            n_diodes=len(BOARD),
            duration_s=self.seconds,
            resolution_s=1 / RATE,
        )


def drop(pulses: Pulses, chosen: np.ndarray) -> Pulses:
    """The pulses without the chosen ones."""
    return replace(pulses, **{name: getattr(pulses, name)[~chosen] for name in COLUMNS})


def add(pulses: Pulses, *more: object) -> Pulses:
    """The pulses and some more: start, length and diode."""
    pairs = zip((getattr(pulses, name) for name in COLUMNS), more, strict=True)
    return by_start(pulses, *(np.concatenate(pair) for pair in pairs))


def by_start(pulses: Pulses, *columns: np.ndarray) -> Pulses:
    """A recording with these starts, lengths and diodes, in order of time."""
    order = np.argsort(columns[0], kind="stable")
    start, length, diode = (column[order] for column in columns)
    return replace(pulses, start_s=start, length_s=length, diode=diode.astype(np.int16))
