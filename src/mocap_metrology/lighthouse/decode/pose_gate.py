"""Hits that no pose of the board allows: a second gate for sweeps of few hits.

Where a sweep has too few hits for perspective, `clean.sweep_outliers` fits its affine part only,
which on a deep board leaves milliradians. But an azimuth sweep and the elevation sweep after it see
one board, of six unknowns. What it moves in the 8.3 ms between them is mostly a shift along each
axis, which only one of the two sweeps tells of.
"""

from __future__ import annotations

import numpy as np

from mocap_metrology.lighthouse.calibrate.board_pose import Path, by_levenberg_marquardt
from mocap_metrology.lighthouse.calibrate.reconstruction import Measurements
from mocap_metrology.lighthouse.records import Hits
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters

FEWEST = 5  # diodes with both angles: one can be left out
ROUNDS = 2  # wrong diodes of one moment


def pose_outliers(
    hits: Hits, board: np.ndarray, few: int, gate_rad: float, gate_mad: float
) -> np.ndarray:
    """Hits off the board pose of their moment by more than max(gate_rad, gate_mad MAD); bool, (n,).

    board (n, 3) in metres; few: sweeps of fewer hits are looked at. A moment is an azimuth sweep
    and the elevation sweep of the next cycle; MAD is that of all of them, so that a wrong board
    file or unknown optics, which no leaving out of hits mends, widen the gate. Where the pose does
    not fit, each diode is left out in turn: it may be the one if the rest then fit.
    """
    wrong = np.zeros(len(hits), np.bool_)
    for station in (0, 1):
        table, rows = _moments(hits, station, len(board), few)
        if not len(table):
            continue
        off = _residuals(table, board)
        limit = max(gate_rad, gate_mad * float(np.nanmedian(np.abs(off))))
        for _ in range(ROUNDS):
            suspect = np.flatnonzero(np.nanmax(np.abs(off), axis=(1, 2), initial=0) > limit)
            for moment in suspect:
                for diode in _culprits(table[moment], board, limit):
                    rest = table[[moment]].copy()
                    rest[:, diode] = np.nan
                    alone = _predicted(_fit(rest, board), board)[0, diode] - table[moment, diode]
                    wrong[rows[moment, diode, np.abs(alone) > limit]] = True
                table[moment, np.isin(rows[moment], np.flatnonzero(wrong)).any(axis=1)] = np.nan
                off[moment] = np.nan
                if np.isfinite(table[moment, :, 0]).sum() >= FEWEST:
                    off[moment] = _residuals(table[[moment]], board)[0]
    return wrong


def _moments(hits: Hits, station: int, n_diodes: int, few: int) -> tuple[np.ndarray, np.ndarray]:
    """Both angles at each moment, (n, diodes, 2), NaN where either is missing; rows of the hits."""
    own = np.flatnonzero(hits.station == station)
    sweeps = [own[hits.axis[own] == axis] for axis in (0, 1)]
    first = np.intersect1d(hits.cycle[sweeps[0]], hits.cycle[sweeps[1]] - 1)
    table = np.full((first.size, n_diodes, 2), np.nan)
    rows = np.zeros(table.shape, np.int64)
    for axis, chosen in enumerate(sweeps):
        cycle = hits.cycle[chosen] - axis
        there = np.isin(cycle, first)
        at = np.searchsorted(first, cycle[there]), hits.diode[chosen[there]], axis
        table[at], rows[at] = hits.angle_rad[chosen[there]], chosen[there]
    count = np.isfinite(table).sum(axis=1).min(axis=1)
    table[~np.isfinite(table).all(axis=2)] = np.nan
    both = np.isfinite(table[:, :, 0]).sum(axis=1)
    kept = (both >= FEWEST) & (count < few)
    return table[kept], rows[kept]


def _fit(table: np.ndarray, board: np.ndarray) -> Path:
    given = Measurements(np.arange(len(table), dtype=float), table)
    return by_levenberg_marquardt(given, board, rotor_parameters())


def _predicted(path: Path, board: np.ndarray) -> np.ndarray:
    """Angles (n, diodes, 2) of the board in these poses."""
    places = board @ path.R.transpose(0, 2, 1) + path.t_m[:, None]
    flat = angles(np.ascontiguousarray(places.reshape(-1, 3)), rotor_parameters())
    return flat.reshape(*places.shape[:2], 2)


def _residuals(table: np.ndarray, board: np.ndarray) -> np.ndarray:
    return table - _predicted(_fit(table, board), board)


def _culprits(moment: np.ndarray, board: np.ndarray, limit: float) -> np.ndarray:
    """Diodes of a moment (diodes, 2) without any one of which the others fit; or the one without
    which they fit far better than without any other."""
    seen = np.flatnonzero(np.isfinite(moment[:, 0]))
    without = np.repeat(moment[None], seen.size, axis=0)
    without[np.arange(seen.size), seen] = np.nan
    worst = np.nanmax(np.abs(_residuals(without, board)), axis=(1, 2))
    fits = worst <= limit
    best, second = np.argsort(worst)[:2]
    if not fits.any() and worst[best] < 0.5 * worst[second]:
        fits[best] = True
    return seen[fits]
