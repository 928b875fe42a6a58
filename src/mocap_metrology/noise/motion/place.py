"""Noise by place: where in the volume a rigid pair is measured worse, or longer, than elsewhere.

The distance L of two markers on something stiff does not care that it moves (S section 5). What it
does while the pair is carried through the volume is noise, where it changes from frame to frame,
and distortion of the calibrated space, where its mean changes from place to place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.special import chdtri

from mocap_metrology.common.transforms import irfft, rfft
from mocap_metrology.common.types import Record

LEAST_DIFFERENCES = 30  # of a cell: its sigma is then good to 16 % where noise is white
LEAST_OF_VISIT = 10  # differences of a visit that is compared with others
LAGS = 200  # frames: noise of filters, as far as they reach at common frame rates


def by_place(
    middle_mm: Sequence[np.ndarray],
    distance_mm: np.ndarray,
    cell_mm: float,
    least: int = LEAST_DIFFERENCES,
) -> tuple[list[Record], Visits]:
    """One row a cube of `cell_mm` with at least `least` pairs of successive frames in it; and the
    visits of all cubes.

    middle_mm (3, n) of the pair, distance_mm (n,), float64; NaN are gaps. `sigma_mm` is the Allan
    deviation of L at one frame, from successive frames within the cell:
    sqrt(sum (L_k+1 - L_k)^2 / (2 n)), with a 95 % chi-squared interval of `dof` = n `freedom(L)`/c
    degrees of freedom, c >= 1 by how much the visits of a cell differ from each other
    (`Visits.dispersion`); n_visits: those that were compared. `deviation_mm` is the cell's mean L
    less that of all frames.
    """
    cells, visits, frames, total = _visits(middle_mm, distance_mm, cell_mm)
    n_cells = cells.shape[1]
    if not n_cells:
        return [], visits
    overall, each = total.sum() / frames.sum(), freedom(distance_mm)
    each /= visits.dispersion(each)
    pairs, squares = (np.bincount(visits.cell, v, n_cells) for v in visits[1:])
    count = np.bincount(visits.cell, visits.long, n_cells)
    k = np.flatnonzero(pairs >= least)
    variance, dof = squares[k] / (2 * pairs[k]), each * pairs[k]
    columns = {
        **dict(zip(("x_mm", "y_mm", "z_mm"), (cells[:, k] + 0.5) * cell_mm, strict=True)),
        "n_frames": frames[k].astype(int),
        "n_pairs": pairs[k].astype(int),
        "n_visits": count[k].astype(int),
        "dof": dof,
        "sigma_mm": np.sqrt(variance),
        "lower_mm": np.sqrt(variance * dof / chdtri(dof, 0.025)),
        "upper_mm": np.sqrt(variance * dof / chdtri(dof, 0.975)),
        "deviation_mm": total[k] / frames[k] - overall,
    }
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows], visits


class Visits(NamedTuple):
    """Visits of cells, in order of time, each (v,): the cell's number, how many pairs of successive
    frames, and the sum of their squared differences."""

    cell: np.ndarray
    pairs: np.ndarray
    squares: np.ndarray

    @property
    def long(self) -> np.ndarray:
        """(v,) whether a visit has enough pairs to be compared."""
        return (self.pairs >= LEAST_OF_VISIT) & (self.squares > 0)

    def dispersion(self, freedom: float) -> float:
        """Times, at least 1, by which the variances of the visits of a cell scatter more than those
        of Gaussian noise that is the same all the time: heavy tails, bursts, or noise that comes
        and goes. Bartlett's statistic of the visits of each cell, sum dof_v ln(s_c^2 / s_v^2), over
        its number of visits less 1, of all cells together. freedom: of a pair."""
        cell, pairs, squares = (column[self.long] for column in self)
        repeats = cell.size - np.unique(cell).size
        if not repeats:
            return 1.0
        of_cell = np.bincount(cell, squares)[cell] / np.bincount(cell, pairs)[cell]
        left = freedom * pairs * np.log(of_cell * pairs / squares)
        return max(float(left.sum()) / repeats, 1.0)


def _visits(
    middle_mm: Sequence[np.ndarray], distance_mm: np.ndarray, cell_mm: float
) -> tuple[np.ndarray, Visits, np.ndarray, np.ndarray]:
    """(3, k) whole numbers of the cubes in which the pair was, in order, its visits of them, and of
    each cube the number of frames and the sum of their distances."""
    known = np.isfinite(distance_mm)
    for row in middle_mm:
        known &= np.isfinite(row)
    enters = np.diff(known, prepend=~known[:1])
    for row in middle_mm:
        enters[1:] |= known[1:] & known[:-1] & (np.diff(np.floor(row / cell_mm)) != 0)
    start = np.flatnonzero(enters)
    there = known[start]
    frames = np.diff(np.append(start, known.size))
    squares = np.diff(distance_mm, append=np.nan) ** 2
    squares[start - 1] = 0.0  # from one visit to the next; the last frame has none
    total, squares = (np.add.reduceat(v, start, dtype=float)[there] for v in (distance_mm, squares))
    places = np.array([np.floor(row[start[there]] / cell_mm) for row in middle_mm]).astype(int)
    cells, cell = np.unique(places, axis=1, return_inverse=True)
    visits = Visits(cell.ravel(), frames[there] - 1, squares)
    frames, total = (np.bincount(visits.cell, v, cells.shape[1]) for v in (frames[there], total))
    return cells, visits, frames, total


def freedom(series: np.ndarray) -> float:
    """Degrees of freedom that one squared successive difference of a series (n,) is worth.

    1 / (1 + 2 sum_k rho_k^2), rho_k the autocorrelation of the differences at lag k: n squares of
    Gaussian numbers scatter like n times that many independent ones (Satterthwaite; Bartlett's
    formula for the variance of a sum of squares). 2/3 for white noise, whose neighbouring
    differences share a sample; far fewer for what went through a low-pass filter. NaN are gaps;
    each estimated rho_k^2 is too large by 1/n, which is subtracted.
    """
    from scipy.fft import next_fast_len

    step = np.diff(np.asarray(series, dtype=float))
    there = np.isfinite(step)
    lags = min(LAGS, step.size // 4)
    if not lags or not np.any(step[there]):
        return 2 / 3
    size = next_fast_len(step.size + lags, real=True)
    filled = np.where(there, step, 0.0)
    sums, counts = (
        irfft(np.abs(rfft(v, size)) ** 2, size)[: lags + 1] for v in (filled, there.astype(float))
    )
    counts = np.round(counts)
    seen = counts[1:] > 0
    rho = sums[1:][seen] / counts[1:][seen] / (sums[0] / counts[0])
    return min(1 / max(1 + 2 * float(np.sum(rho**2 - 1 / counts[1:][seen])), 1.0), 1.0)


def evenness(rows: Sequence[Record], visits: Visits) -> dict[str, float]:
    """Whether the cells of `by_place` differ more than chance: `p` of one-way analysis of variance
    of the logarithms of the variances of their visits, `worst_over_best` sigma, and `bend_mm`, the
    standard deviation of the cells' mean L. p is NaN where no cell was visited twice, as place
    cannot be told from time then. (Bartlett's test of the cells takes bursts and heavy tails for
    differences between places.)"""
    from scipy.special import fdtrc

    if len(rows) < 2:
        return {"p": math.nan, "worst_over_best": math.nan, "bend_mm": math.nan}
    sigma = np.array([row["sigma_mm"] for row in rows])
    bend = float(np.std([row["deviation_mm"] for row in rows], ddof=1))
    if not (sigma > 0).all():
        return {"p": math.nan, "worst_over_best": math.inf, "bend_mm": bend}
    cell, pairs, squares = (column[visits.long] for column in visits)
    logs, (_, cell) = np.log(squares / pairs), np.unique(cell, return_inverse=True)
    count, p = np.bincount(cell), math.nan
    means = np.bincount(cell, logs) / count
    between, within = count.size - 1, cell.size - count.size
    if between > 0 and within > 0:
        of_cells = count @ (means - logs.mean()) ** 2 / between
        p = float(fdtrc(between, within, of_cells * within / np.sum((logs - means[cell]) ** 2)))
    return {"p": p, "worst_over_best": float(sigma.max() / sigma.min()), "bend_mm": bend}
