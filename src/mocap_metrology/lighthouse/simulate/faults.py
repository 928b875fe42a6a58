"""What keeps light from a diode, and light that is no direct hit."""

from __future__ import annotations

import numpy as np

from mocap_metrology.lighthouse.simulate.twin import LighthouseTwin

REFLECTED_LATER_S = (30e-6, 800e-6)  # before or after the direct hit
REFLECTED_WIDTH = (0.3, 0.9)  # of the direct pulse
FALSE_FLASH_S = (50e-6, 150e-6)
MOST_FALSE = 100_000


def blocked_intervals(
    twin: LighthouseTwin, rng: np.random.Generator
) -> list[tuple[int, float, float]]:
    """Times (station, from, to) in which a station cannot be seen: those of the twin, and
    occlusions that come at random (Poisson) and last exponentially."""
    intervals = list(twin.blocked)
    for station in range(len(twin.stations)):
        n = rng.poisson(twin.occlusions_per_min * twin.duration_s / 60)
        begin = rng.uniform(0, twin.duration_s, n)
        intervals += [
            (station, b, b + d)
            for b, d in zip(begin, rng.exponential(twin.occlusion_s, n), strict=True)
        ]
    return intervals


def is_open(
    intervals: list[tuple[int, float, float]], station: np.ndarray, time_s: np.ndarray
) -> np.ndarray:
    """True where nothing stands between the station and the board, by station and time."""
    seen = np.ones(time_s.shape, dtype=bool)
    for which, begin, end in intervals:
        seen &= ~((station == which) & (time_s >= begin) & (time_s < end))
    return seen


def reflections(
    twin: LighthouseTwin,
    time_s: np.ndarray,
    width_s: np.ndarray,
    diode: np.ndarray,
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middle, width and diode of second pulses: shorter ones, some time before or after a hit."""
    chosen = np.flatnonzero(rng.random(time_s.size) < twin.reflections)
    apart = rng.uniform(*REFLECTED_LATER_S, chosen.size) * rng.choice([-1.0, 1.0], chosen.size)
    width = width_s[chosen] * rng.uniform(*REFLECTED_WIDTH, chosen.size)
    return time_s[chosen] + apart, width, diode[chosen]


def false_flashes(twin: LighthouseTwin, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Start and length of light of other origin that all diodes see."""
    n = min(rng.poisson(twin.false_flashes_per_s * twin.duration_s), MOST_FALSE)
    return rng.uniform(0, twin.duration_s, n), rng.uniform(*FALSE_FLASH_S, n)
