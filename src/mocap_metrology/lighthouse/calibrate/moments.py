"""From hits to where a joint estimate starts: board poses at common moments, and the slave's pose.

Each diode's angles are interpolated in time by a cubic spline, so that both stations have both
angles of all diodes at the same moments, however many hits are missing.
"""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from mocap_metrology.lighthouse.calibrate.agreement import Agreed
from mocap_metrology.lighthouse.records import MASTER, SLAVE, Hits, Measurements, Path
from mocap_metrology.lighthouse.timing import CYCLE_S

STEP_S = 4 * CYCLE_S  # each axis of each station sweeps once
LONGEST_GAP_S = 8.5 * CYCLE_S  # between hits of a diode: one may be missing, not two


def moments(hits: Hits, n_diodes: int, n_stations: int = 2) -> list[Measurements]:
    """Both angles of the diodes in each station's view at moments `STEP_S` apart, the same for all
    stations; NaN where a diode was not hit just before and after."""
    count = max(int(np.ptp(hits.time_s) / STEP_S), 1)
    time = hits.time_s.min() + STEP_S * (0.5 + np.arange(count))
    angles = np.full((n_stations, count, n_diodes, 2), np.nan)
    key = (hits.station * 2 + hits.axis).astype(np.int64) * n_diodes + hits.diode
    order = np.lexsort((hits.time_s, key))
    own, first = np.unique(key[order], return_index=True)
    for k, rows in zip(own, np.split(order, first[1:]), strict=True):
        at, angle = hits.time_s[rows], hits.angle_rad[rows]
        if at.size < 4:
            continue
        after = np.clip(np.searchsorted(at, time), 1, at.size - 1)
        inside = (time >= at[0]) & (time <= at[-1])
        inside &= at[after] - at[after - 1] <= LONGEST_GAP_S
        station, axis, diode = k // n_diodes // 2, k // n_diodes % 2, k % n_diodes
        angles[station, inside, diode, axis] = CubicSpline(at, angle)(time[inside])
    angles[~np.isfinite(angles).all(axis=3)] = np.nan
    return [Measurements(time, of_station) for of_station in angles]


def joined(agreed: Agreed) -> Path:
    """Board poses of both stations in the master's frame."""
    own, other = agreed.paths[MASTER], agreed.paths[SLAVE]
    R, t = agreed.R, agreed.t_m
    assert R is not None and t is not None
    turned = {"R": R @ other.R, "t_m": other.t_m @ R.T + t}
    parts = {
        name: (getattr(own, name), turned.get(name, getattr(other, name)))
        for name in Path.__dataclass_fields__
    }
    return Path(**{name: np.concatenate(part) for name, part in parts.items()})
