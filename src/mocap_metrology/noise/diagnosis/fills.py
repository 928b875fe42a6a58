"""Frames that software put into gaps.

A polynomial of order p, or a spline between the same two samples, has differences of order
p + 1 that are zero up to the rounding of the file; those of noise are small only by chance. One
value of the k-th differences lies within +-delta s with a probability of 0.8 delta at most,
whatever came before, where s is the standard deviation of a frame given the past
(its innovation); so a run of a few is no chance. How often runs go on is counted, too. Straight
lines (k = 2), cubic (4) and quintic (6) polynomials, splines and held values are detected.
Copies of another marker's noise are as large as noise and are not detected; nor is what is filled
where the rounding of the file hides it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.parallel import MapFunction, in_turn

DIFFERENCES = (2, 4, 6)  # orders of those that a fill makes vanish
DENSER = 1.25  # than a Gaussian's at zero
CHANCE = 1e-13  # that a frame begins a run which is none
SEVERAL, BESIDE = 5, 1e-7  # runs beside which others may be shorter; their chance
LIKELIEST = 0.7  # chance of one, from which nothing is reported
NARROW, WIDEST = 0.02, 0.65  # delta: without rounding, and at most
# Runs that chance makes, and how many of them determine its rate
SHORT, ENOUGH, MARGIN = 4, 200, 1.5
SHORTEST, LOOSE = 6, 3  # differences of a run; frames of each end that may be noise
PIECES, SAMPLED = 16, 1 << 13  # of a series, and their frames, for s
CHUNK = 1 << 20
NEAR, FADED = 512, 0.25  # frames to each side of a run; noise there, of the usual, that fades
MANY_FILLED = 1e-2  # share of the frames from which a reader is warned


@dataclass(frozen=True)
class Rule:
    """The test of one order of differences: their limit, mm, and the probability of one within
    it."""

    order: int
    limit: float
    chance: float

    @staticmethod
    def run(chance: float, least: float = CHANCE) -> int:
        """Length of a run that chance makes with probability `least`, where it makes each frame
        with `chance`."""
        return math.ceil(math.log(least) / math.log(chance))


def innovation(series: np.ndarray) -> float:
    """s of (n,) values in their unit, at most: the least that differences of order 1 to 8 allow,
    by medians over pieces, of which a quarter may be quieter; NaN left out."""
    size = min(SAMPLED, max(series.size // PIECES, 64))
    starts = np.linspace(0, max(series.size - size, 0), PIECES).astype(int)
    scales = [_scale(series[k : k + size].astype(np.float64)) for k in np.unique(starts)]
    known = [scale for scale in scales if math.isfinite(scale)]
    return float(np.quantile(known, 0.25)) if known else math.nan


def _scale(values: np.ndarray) -> float:
    smallest = math.nan
    for order in range(1, 9):
        values = np.diff(values)
        known = np.abs(values[np.isfinite(values)])
        if known.size < 16:
            return smallest
        scale = MAD_TO_SIGMA * float(np.median(known)) / math.sqrt(math.comb(2 * order, order))
        smallest = scale if math.isnan(smallest) else min(smallest, scale)
    return smallest


def rules(innovation_mm: float, resolution_mm: float) -> list[Rule]:
    """The orders that can be detected in a file of these steps."""
    orders = []
    for order in DIFFERENCES if innovation_mm > 0 else ():
        # Each of the 2^order parts of a difference is rounded by half a step at most
        rounding = 1.05 * 2 ** (order - 1) * resolution_mm
        delta = max(NARROW, rounding / innovation_mm)
        if delta <= WIDEST:
            orders.append(Rule(order, delta * innovation_mm, 0.8 * DENSER * delta))
    return orders


def filled(series: np.ndarray, resolution_mm: float) -> np.ndarray:
    """(n,) whether a frame was filled, of (n,) values in mm, NaN in gaps."""
    resolution_mm = resolution_mm if math.isfinite(resolution_mm) else 0.0
    mask = np.zeros(series.size, bool)
    for rule in rules(innovation(series), resolution_mm):
        smooth = _smooth(series, rule)
        changes = np.flatnonzero(np.diff(np.concatenate([[0], smooth.view(np.int8), [0]])))
        edges = changes.reshape(-1, 2)
        lengths = edges[:, 1] - edges[:, 0]
        chance = max(rule.chance, _seen(lengths))
        if chance > LIKELIEST:
            continue
        ends = np.nanmin(series), np.nanmax(series)
        sure = lengths >= Rule.run(chance)
        if np.count_nonzero(sure) >= SEVERAL:
            sure = lengths >= Rule.run(chance, BESIDE)
        shorter = [
            part
            for first, last in edges[~sure & (lengths >= SHORTEST)]
            if (part := _polynomial(series, int(first), int(last), rule, resolution_mm))
        ]
        for first, last in [*edges[sure], *shorter]:  # both ends were measured,
            end = last + rule.order - 1
            held = np.all(series[first:end] == series[end])  # but of a held value the first alone
            inside = slice(first + 1, end + int(held))
            clipped = any(np.all(series[inside] == end) for end in ends)
            if not (clipped or _fading(series, first, last, rule)):
                mask[inside] = True
    return mask


def _fading(series: np.ndarray, first: int, last: int, rule: Rule) -> bool:
    """Whether differences near a run of small ones are hardly larger: of noise that fades there."""
    order, around = rule.order, series[max(first - NEAR, 0) : last + NEAR].astype(np.float64)
    near = np.abs(np.diff(around, order))
    near = near[near > rule.limit]
    usual = rule.limit / (rule.chance / (0.8 * DENSER)) * math.sqrt(math.comb(2 * order, order))
    return near.size > 16 and float(np.median(near)) < FADED * usual / MAD_TO_SIGMA


def _polynomial(
    series: np.ndarray, first: int, last: int, rule: Rule, resolution_mm: float
) -> tuple[int, int] | None:
    """The part of a run of small differences whose frames lie on one polynomial to within 3/4 of a
    step, where chance does that in `CHANCE` at most: each frame beyond the first `order` lies so
    near with a probability of 1.5 steps times the greatest density of noise."""
    innovation_mm = rule.limit / (rule.chance / (0.8 * DENSER))
    near = max(NARROW * innovation_mm, 0.75 * resolution_mm)
    chance = DENSER * 2 * near / (math.sqrt(2 * math.pi) * innovation_mm)
    if chance > LIKELIEST:
        return None
    least = Rule.run(chance)
    for cut in range(2 * LOOSE + 1):  # chance adds frames to a run, at either end
        for left in range(max(cut - LOOSE, 0), min(cut, LOOSE) + 1):
            a, b = first + left, last - (cut - left)
            if b - a < least:
                return None
            values = series[a : b + rule.order].astype(np.float64)
            t = np.linspace(-1, 1, values.size)
            basis = np.polynomial.legendre.legvander(t, rule.order - 1)
            rest = values - values.mean()
            rest = rest - basis @ np.linalg.lstsq(basis, rest, rcond=None)[0]
            if np.abs(rest).max() <= near:
                return a, b
    return None


def _seen(lengths: np.ndarray) -> float:
    """How often a run of chance continues, from the lengths of all; values that repeat, as in files
    with hidden steps, go on more often than noise."""
    count = np.bincount(np.minimum(lengths, SHORT + 1), minlength=SHORT + 2)
    often = pairwise(count[: SHORT + 1].tolist())
    return max(
        (MARGIN * (more + 2 * math.sqrt(more)) / some for some, more in often if some >= ENOUGH),
        default=0.0,
    )


def _smooth(series: np.ndarray, rule: Rule) -> np.ndarray:
    """(n - order,) whether the differences that begin there are within the limit."""
    flags = [
        np.abs(np.diff(series[k : k + CHUNK + rule.order].astype(np.float64), rule.order))
        <= rule.limit
        for k in range(0, max(series.size - rule.order, 0), CHUNK)
    ]
    return np.concatenate(flags) if flags else np.zeros(0, bool)


def filled_frames(
    position_mm: np.ndarray, resolution_mm: float, over: MapFunction = in_turn
) -> np.ndarray:
    """(markers, n) of (markers, 3, n): where any coordinate of a marker was filled, all were. over:
    how coordinates are worked on."""
    axes = (axis for marker in position_mm for axis in marker)
    mask = np.array(list(over(lambda axis: filled(axis, resolution_mm), axes)))
    return np.any(mask.reshape(position_mm.shape), axis=1)
