"""Angles of a board at rest as series over time, one for each rotor and diode.

A rotor of the first generation sweeps once in four cycles (30 Hz), a plane of the second once in a
turn (50 to 53 Hz), so its sweeps are samples at equal steps, and a missed hit is a gap. With x_kd
the deviation of diode d from its own mean at sweep k, and n_k diodes seen,

    common_k = mean_d x_kd,   independent_kd = sqrt(n_k / (n_k - 1)) (x_kd - common_k),

where the factor restores the variance that subtracting the mean takes from independent noise. The
common part still contains 1 / n_k of the independent variance.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.records import AXES, ROLES, Hits
from mocap_metrology.lighthouse.timing import CYCLE_S

PLANES = ("plane0", "plane1")
SWEEP_CYCLES = 4  # between sweeps of one axis of one of two stations
FEWEST_SWEEPS = 30
LEAST_SEEN = 0.5  # of the sweeps, by a diode that counts
FEWEST_DIODES = 2  # in a sweep that has a common part


@dataclass(frozen=True)
class StillAngles:
    """Angles of one axis of one station: diodes (n,), deviation (k, n) in rad from the mean of each
    diode, NaN where it was not hit; sweeps follow each other at `rate_hz`; rad_per_s: speed of the
    angle. name: such as `master_azimuth`, or `3_plane0` of channel 3."""

    name: str
    rate_hz: float
    rad_per_s: float
    diodes: np.ndarray
    deviation: Floats

    @property
    def seen(self) -> np.ndarray:
        """Diodes (k,) in each sweep."""
        return np.isfinite(self.deviation).sum(axis=1)

    @property
    def common(self) -> Floats:
        """(k,) mean over the diodes of a sweep, NaN with fewer than two."""
        total = np.nansum(self.deviation, axis=1)
        return np.where(self.seen >= FEWEST_DIODES, total / np.maximum(self.seen, 1), np.nan)

    @property
    def independent(self) -> Floats:
        """(k, n) of each diode, as in the module's formula."""
        seen = self.seen[:, None]
        scale = np.sqrt(seen / np.maximum(seen - 1, 1))
        return scale * (self.deviation - self.common[:, None])


def still_angles(
    hits: Hits, names: Sequence[str] = ROLES, generation: int = 1
) -> Iterator[StillAngles]:
    """Series of every axis of every station with enough sweeps; names: of the stations."""
    for station, name in enumerate(names):
        for axis, title in enumerate(AXES if generation == 1 else PLANES):
            own = hits.take((hits.station == station) & (hits.axis == axis))
            if len(own) < FEWEST_SWEEPS:
                continue
            found = _series(own, f"{name}_{title}", generation)
            if found is not None:
                yield found


def _series(own: Hits, name: str, generation: int) -> StillAngles | None:
    cycle = own.cycle.astype(np.int64) - own.cycle.min()
    if generation == 1:
        step, rate_hz, speed = SWEEP_CYCLES, 1 / (SWEEP_CYCLES * CYCLE_S), np.pi / CYCLE_S
    else:
        last = int(np.argmax(cycle))
        step, rate_hz = 1, float(cycle[last] / (own.time_s[last] - own.time_s[np.argmin(cycle)]))
        speed = 2 * np.pi * rate_hz
    row, rest = np.divmod(cycle, step)
    own, row = own.take(rest == 0), row[rest == 0]
    table = np.full((int(row.max()) + 1, int(own.diode.max()) + 1), np.nan)
    table[row, own.diode] = own.angle_rad
    counts = np.isfinite(table).sum(axis=0)
    diodes = np.flatnonzero(counts >= max(FEWEST_SWEEPS, LEAST_SEEN * len(table)))
    if not diodes.size:
        return None
    angles = table[:, diodes]
    return StillAngles(name, rate_hz, speed, diodes, angles - np.nanmean(angles, axis=0))
