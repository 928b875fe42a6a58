"""Hits cleaned of reflections and of light that is no sweep.

Within a sweep all diodes share one motion and one error of the rotor, so a wrong hit stands out
against the others of the same sweep (`sweep_outliers`); where these are few, against the pose of
the board that this sweep and the next tell of (`pose_outliers`), as what it moves in the 8.3 ms
between them is mostly a shift along each axis, which only one of the two sweeps measures; in light
of the second generation against the turns before and after (`neighbour_outliers`). Over time a
diode is tested against itself (`still_outliers`). Nothing is replaced: an outlier is dropped.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy import ndimage

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.hampel import MAD_TO_SIGMA, hampel
from mocap_metrology.common.types import Floats
from mocap_metrology.lighthouse.decode.gates import FULL, Cleaning, gate_sweeps, gate_turns
from mocap_metrology.lighthouse.fit.board_pose import by_levenberg_marquardt
from mocap_metrology.lighthouse.records import Hits, Measurements, is_new
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters

STILL_RAD = 0.5e-3  # 1 mm at 2 m
RESOLUTION_RAD = np.pi * 0.5e-6 * 60 * 2  # one sample of 2 MHz
SINGULAR = 1e-6  # of the board's extent: thinner is flat
FEWEST_DIODES = 5  # diodes with both angles: one can be left out
WRONG_DIODES = 2  # wrong diodes of one moment
USUAL = Cleaning()


def clean_hits(
    hits: Hits,
    board: np.ndarray,
    cleaning: Cleaning = USUAL,
    resolution_rad: float = RESOLUTION_RAD,
) -> tuple[Hits, dict[str, list[int]]]:
    """Hits that pass all tests, and how many did not, a count for each diode: `sweep` (dropped by
    `sweep_outliers` or `pose_outliers`), `still` (by `still_outliers`), `kept`; board (n, 3) in
    metres."""
    highest = int(hits.diode.max(initial=-1))
    if highest >= len(board):
        raise Refusal(
            f"board: {len(board)} diodes, light on diode {highest}; expected a position for each"
        )
    wrong = sweep_outliers(hits, board, cleaning)
    left = np.flatnonzero(~wrong)
    wrong[left] = pose_outliers(hits.take(left), board, cleaning)
    return _passed(hits, wrong, board, cleaning, resolution_rad)


def _passed(
    hits: Hits, wrong: np.ndarray, board: np.ndarray, cleaning: Cleaning, resolution_rad: float
) -> tuple[Hits, dict[str, list[int]]]:
    """Those not `wrong` that pass the test over time, and the report."""
    passed = hits.take(~wrong)
    late = still_outliers(passed, cleaning, resolution_rad)
    clean = passed.take(~late)
    parts = {"sweep": hits.diode[wrong], "still": passed.diode[late], "kept": clean.diode}
    return clean, {k: np.bincount(d, minlength=len(board)).tolist() for k, d in parts.items()}


def clean_turn_hits(
    hits: Hits, board: np.ndarray, cleaning: Cleaning, resolution_rad: float
) -> tuple[Hits, dict[str, list[int]]]:
    """`clean_hits` for the tilted planes of second-generation stations: in place of the test
    against a pose, one against the turns before and after (`neighbour_outliers`).

    A plane that is tilted by A out of the axis of its rotor at angle b meets (x, y, z) where
    x sin b - y cos b + z tan A = 0. With b = b_0 + d and x', y' turned by b_0 that is
    tan d = (y' - z tan A / cos d) / x', as of an upright plane but for 1 - cos d, less than 5 mrad
    within 0.1 rad. So angles are taken from the median of their sweep.
    """
    about = replace(hits, angle_rad=hits.angle_rad - sweep_medians(hits))
    wrong = neighbour_outliers(hits, board, cleaning)
    left = np.flatnonzero(~wrong)
    wrong[left] = sweep_outliers(about.take(left), board, cleaning, perspective=1.0)
    return _passed(hits, wrong, board, cleaning, resolution_rad)


def sweep_medians(hits: Hits) -> np.ndarray:
    """Median angle of the sweep of each hit."""
    if not len(hits):
        return hits.angle_rad
    order, first = hits.by_sweep()
    sweep = np.empty(len(hits), np.int64)
    sweep[order] = np.repeat(np.arange(first.size), np.diff(first, append=order.size))
    return np.asarray(ndimage.median(hits.angle_rad, sweep, np.arange(first.size)))[sweep]


def sweep_outliers(
    hits: Hits, board: np.ndarray, cleaning: Cleaning = USUAL, perspective: float = 0.0
) -> np.ndarray:
    """Hits off the others of their sweep by more than max(gate_rad, gate_mad MAD); bool, (n,).

    A plane of light meets diode X where tan(angle) = (a0 + a.X) / (1 + c.X), exact for a board that
    stands still while it is swept. With three hits more than unknowns this is fitted, else its
    affine part, tan(angle) = a0 + a.X, in the two or three directions that the board has; both in
    the least sum of |residuals| (iterated weights), of which a few outliers bend nothing. A sweep
    with no hit more than unknowns decides nothing and passes; with one more, an outlier shows but
    not which it is, and all its hits go if the residuals sum to more than ten times the gate: what
    perspective leaves of a board of four diodes at 1 m is 10 mrad. perspective: what the affine
    part may leave, in squares of the span of the sweep; it is added to the gate.
    """
    order, first = hits.by_sweep()
    wrong = np.zeros(len(hits), np.bool_)
    if order.size:
        tangent, where = np.tan(hits.angle_rad[order]), _directions(board)[hits.diode[order]]
        ends = np.append(first, order.size)
        wrong[order] = gate_sweeps(tangent, where, ends, cleaning, perspective)
    return wrong


def neighbour_outliers(hits: Hits, board: np.ndarray, cleaning: Cleaning) -> np.ndarray:
    """Hits off their sweep and the two before and after it, of the same station and axis, by more
    than max(gate_rad, gate_mad MAD); bool, (n,).

    Where sweeps of two stations collide, most of their hits are lost and some of the others are of
    the other station (with 16 stations up to one in four): a sweep alone does not tell which. n
    turns from this sweep, tan(angle) = a0 + a.X + b n + c n^2, in the least sum of |residuals|; the
    gate is widened by the square of the span of the sweep, which the affine part leaves.
    """
    order = np.lexsort((hits.cycle, hits.axis, hits.station))
    wrong = np.zeros(len(hits), np.bool_)
    if order.size:
        cycle = hits.cycle[order].astype(np.int64)
        laser = 2 * hits.station[order].astype(np.int64) + hits.axis[order]
        first = np.flatnonzero(is_new(laser, cycle))
        angle, where = hits.angle_rad[order], _directions(board)[hits.diode[order]]
        sweeps = cycle[first], laser[first], np.append(first, order.size)
        wrong[order] = gate_turns(angle, where, *sweeps, cleaning)
    return wrong


def _directions(board: np.ndarray) -> np.ndarray:
    """The board along its own two or three directions, scaled to about 1."""
    centred = board - board.mean(axis=0)
    _, extent, axes = np.linalg.svd(centred, full_matrices=False)
    used = extent > SINGULAR * extent[0]
    return np.ascontiguousarray(centred @ axes[used].T / (extent[0] / np.sqrt(len(board))))


def still_outliers(hits: Hits, cleaning: Cleaning, resolution_rad: float) -> np.ndarray:
    """Outliers of a diode's angle among its own in time, by station and axis; bool, (n,). Only
    where the board is still: the sliding robust spread of the offsets of its sweeps is below
    `STILL_RAD`."""
    wrong = np.zeros(len(hits), np.bool_)
    half_window = cleaning.half_window
    for station, axis in np.unique(np.column_stack([hits.station, hits.axis]), axis=0):
        chosen = np.flatnonzero((hits.station == station) & (hits.axis == axis))
        if chosen.size > 2 * half_window:
            table, row = _table(hits, chosen)
            still = _still(table, half_window) <= STILL_RAD
            for diode in np.flatnonzero(np.isfinite(table).any(axis=0)):
                series = np.where(still, table[:, diode], np.nan)
                filtered = hampel(series, half_window, cleaning.n_sigma, "mask", resolution_rad)
                of_diode = hits.diode[chosen] == diode
                wrong[chosen[of_diode]] = filtered.outlier[row[of_diode]]
    return wrong


def _table(hits: Hits, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angles of one laser, sweeps x diodes, NaN where missing; and the sweep of each hit."""
    sweeps, row = np.unique(hits.cycle[chosen], return_inverse=True)
    table = np.full((sweeps.size, int(hits.diode[chosen].max()) + 1), np.nan)
    table[row, hits.diode[chosen]] = hits.angle_rad[chosen]
    return table, row


def _still(table: np.ndarray, half_window: int) -> np.ndarray:
    """Sliding robust standard deviation of the sweeps' offsets, (sweeps,)."""
    seen = np.isfinite(table).any(axis=0)
    offset = np.nanmedian(table[:, seen] - np.nanmedian(table[:, seen], axis=0), axis=1)
    padded = np.pad(offset, half_window, mode="reflect" if offset.size > half_window else "edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half_window + 1)
    middle = np.median(windows, axis=1, keepdims=True)
    return MAD_TO_SIGMA * np.median(np.abs(windows - middle), axis=1)


def pose_outliers(hits: Hits, board: np.ndarray, cleaning: Cleaning) -> np.ndarray:
    """Hits off the board pose of their moment by more than max(gate_rad, gate_mad MAD); bool, (n,).

    Of sweeps with fewer hits than `sweep_outliers` needs for perspective, 8, of a deep board 10. A
    moment is an azimuth sweep and the elevation sweep of the next cycle; MAD is that of all of
    them, so that a wrong board file or unknown optics, which no leaving out of hits mends, widen
    the gate. Where the pose does not fit, each diode is left out in turn: it may be the one if the
    rest then fit.
    """
    few = FULL + 2 * _directions(board).shape[1]
    wrong = np.zeros(len(hits), np.bool_)
    for station in (0, 1):
        table, rows = _moments(hits, station, len(board), few)
        if not len(table):
            continue
        off = _residuals(table, board)
        limit = max(cleaning.gate_rad, cleaning.gate_mad * float(np.nanmedian(np.abs(off))))
        for _ in range(WRONG_DIODES):
            suspect = np.flatnonzero(np.nanmax(np.abs(off), axis=(1, 2), initial=0) > limit)
            for moment in suspect:
                for diode in _culprits(table[moment], board, limit):
                    rest = table[[moment]].copy()
                    rest[:, diode] = np.nan
                    predicted = _predicted(rest, board)[0, diode]
                    alone = predicted - table[moment, diode]
                    wrong[rows[moment, diode, np.abs(alone) > limit]] = True
                table[moment, np.isin(rows[moment], np.flatnonzero(wrong)).any(axis=1)] = np.nan
                off[moment] = np.nan
                if np.isfinite(table[moment, :, 0]).sum() >= FEWEST_DIODES:
                    off[moment] = _residuals(table[[moment]], board)[0]
    return wrong


def _moments(hits: Hits, station: int, n_diodes: int, few: int) -> tuple[np.ndarray, np.ndarray]:
    """Both angles at each moment, (n, diodes, 2), NaN where either is missing; rows of the hits."""
    of_station = np.flatnonzero(hits.station == station)
    sweeps = [of_station[hits.axis[of_station] == axis] for axis in (0, 1)]
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
    enough = (both >= FEWEST_DIODES) & (count < few)
    return table[enough], rows[enough]


def _predicted(table: Floats, board: Floats) -> Floats:
    """Angles (n, diodes, 2) of the board in the poses that the measured ones, `table`, fit best."""
    measured = Measurements(np.arange(len(table), dtype=float), table)
    path = by_levenberg_marquardt(measured, board, rotor_parameters())
    places = board @ path.R.transpose(0, 2, 1) + path.t_m[:, None]
    flat = angles(np.ascontiguousarray(places.reshape(-1, 3)), rotor_parameters())
    return flat.reshape(*places.shape[:2], 2)


def _residuals(table: Floats, board: Floats) -> Floats:
    return table - _predicted(table, board)


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
