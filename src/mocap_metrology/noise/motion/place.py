"""Noise by place: where in the volume a rigid pair is measured worse, or longer, than elsewhere.

The distance L of two markers on something stiff does not care that it moves (S section 5). What it
does while the pair is carried through the volume is noise, where it changes from frame to frame,
and distortion of the calibrated space, where its mean changes from place to place.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, TypedDict

import numpy as np
from scipy.special import chdtri

from mocap_metrology.common.transforms import irfft, rfft

LEAST_DIFFERENCES = 30  # of a cell: its sigma is then good to 16 % where noise is white
LEAST_OF_VISIT = 10  # differences of a visit that is compared with others
BLOCK = 1 << 18  # frames worked on at a time, so that long recordings need little memory
LAGS = 200  # frames: noise of filters, as far as they reach at common frame rates


class PlaceRow(TypedDict):
    """Noise of one cube: see `by_place`."""

    x_mm: float
    y_mm: float
    z_mm: float
    n_frames: int
    n_pairs: int
    n_visits: int
    dof: float
    sigma_mm: float
    lower_mm: float
    upper_mm: float
    deviation_mm: float


def by_place(
    middle_mm: Sequence[np.ndarray],
    distance_mm: np.ndarray,
    cell_mm: float,
    least: int = LEAST_DIFFERENCES,
) -> tuple[list[PlaceRow], Visits]:
    """One row a cube of `cell_mm` with at least `least` pairs of successive frames in it; and the
    visits of all cubes.

    middle_mm (3, n) of the pair, distance_mm (n,), float64; NaN are gaps. `sigma_mm` is the Allan
    deviation of L at one frame, from successive frames within the cell:
    sqrt(sum (L_k+1 - L_k)^2 / (2 n)), with a 95 % chi-squared interval of `dof` = n `freedom(L)`/c
    degrees of freedom, c >= 1 by how much the visits of a cell differ from each other
    (`Visits.dispersion`); n_visits: those that were compared. `deviation_mm` is the cell's mean L
    less that of all frames.
    """
    cells, number = _cells(middle_mm, distance_mm, cell_mm)
    known, n_cells = number >= 0, cells.shape[1]
    if not n_cells:
        return [], Visits(*np.zeros((3, 0)))
    frames, mean, visits = _tally(number, distance_mm, n_cells)
    overall, each = float(distance_mm[known].mean()), freedom(np.where(known, distance_mm, np.nan))
    each /= visits.dispersion(each)
    pairs, squares = (np.bincount(visits.cell, v, n_cells) for v in visits[1:])
    count = np.bincount(visits.cell, visits.long, n_cells).astype(int)
    rows: list[PlaceRow] = []
    for k in np.flatnonzero(pairs >= least):
        variance, dof = squares[k] / (2 * pairs[k]), each * pairs[k]
        low, high = (dof / chdtri(dof, p) for p in (0.025, 0.975))
        centre = (cells[:, k] + 0.5) * cell_mm
        rows.append(
            {
                "x_mm": float(centre[0]),
                "y_mm": float(centre[1]),
                "z_mm": float(centre[2]),
                "n_frames": int(frames[k]),
                "n_pairs": int(pairs[k]),
                "n_visits": int(count[k]),
                "dof": float(dof),
                "sigma_mm": math.sqrt(variance),
                "lower_mm": math.sqrt(variance * low),
                "upper_mm": math.sqrt(variance * high),
                "deviation_mm": float(mean[k]) - overall,
            }
        )
    return rows, visits


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


def _tally(
    number: np.ndarray, distance_mm: np.ndarray, n_cells: int
) -> tuple[np.ndarray, np.ndarray, Visits]:
    """Number of frames and mean distance of each cell, and their visits. number: `_cells`."""
    visit = np.append(0, np.cumsum(number[1:] != number[:-1]))
    of_visit = number[np.append(0, np.flatnonzero(np.diff(visit)) + 1)]
    frames, mean = np.zeros(n_cells, np.int64), np.zeros(n_cells)
    pairs, squares = np.zeros(of_visit.size, np.int64), np.zeros(of_visit.size)
    for start in range(0, number.size, BLOCK):
        cell, part = number[start : start + BLOCK + 1], distance_mm[start : start + BLOCK + 1]
        at = np.flatnonzero(cell[:BLOCK] >= 0)
        frames += np.bincount(cell[at], minlength=n_cells)
        np.add.at(mean, cell[at], part[at])
        at = np.flatnonzero((cell[:-1] >= 0) & (cell[1:] == cell[:-1]))
        pairs += np.bincount(visit[start + at], minlength=pairs.size)
        np.add.at(squares, visit[start + at], (part[at + 1] - part[at]) ** 2)
    there = of_visit >= 0
    return frames, mean / frames, Visits(of_visit[there], pairs[there], squares[there])


def _cells(
    middle_mm: Sequence[np.ndarray], distance_mm: np.ndarray, cell_mm: float
) -> tuple[np.ndarray, np.ndarray]:
    """(3, k) whole numbers of the cubes in which the pair was, in order, and (n,) the place of each
    frame's among them, -1 in gaps; a part of the frames at a time."""
    number = np.full(distance_mm.size, -1)
    cells = np.empty((3, 0), np.int64)
    for seek in (False, True):  # all cubes first, as their order decides their places
        for start in range(0, number.size, BLOCK):
            part = slice(start, start + BLOCK)
            middle = np.array([row[part] for row in middle_mm])
            known = np.isfinite(distance_mm[part]) & np.isfinite(middle).all(axis=0)
            cell = np.floor(middle[:, known] / cell_mm).astype(np.int64)
            new, index = np.unique(cell, axis=1, return_inverse=True)
            if seek:
                places = {tuple(one): k for k, one in enumerate(cells.T.tolist())}
                into = np.array([places[tuple(one)] for one in new.T.tolist()], dtype=np.int64)
                number[part][known] = into[index.ravel()]
            else:
                cells = np.unique(np.concatenate([cells, new], axis=1), axis=1)
    return cells, number


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


def evenness(rows: Sequence[PlaceRow], visits: Visits) -> dict[str, float]:
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
