"""Rigid clusters of markers, found by distances that stay, and scale along their way."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.accuracy.statistics import (
    effective_number,
    huber_fit,
    random_effects,
    robust_sd,
)

SAMPLED = 4000  # frames that distances are taken from
FEW = 64  # of them, that show most pairs that part
SAME_MM = 2.0  # distance of two markers, at least; less has one marker under two labels
LEAST_FRAMES = 100  # in which both markers of a pair are seen
PARTS = 20  # of a take, in none of which a distance may differ for long
LEAST_WAY_M = 1.0  # along which a scale can slope


@dataclass(frozen=True)
class Cluster:
    """Markers by their numbers; spread_mm: the largest of any pair; pair: the longest one, seen
    together in n_frames."""

    markers: tuple[int, ...]
    spread_mm: float
    pair: tuple[int, int]
    n_frames: int


def distances(position_mm: np.ndarray, pairs: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """(pairs, n) mm of positions (markers, 3, n)."""
    first, second = pairs
    step = position_mm[first].astype(float) - position_mm[second]
    return np.asarray(np.sqrt(np.einsum("pkn,pkn->pn", step, step)))


def rigid_clusters(position_mm: np.ndarray, cut_mm: float) -> list[Cluster]:
    """Clusters of two markers or more, those of three or more first, then by how often the longest
    pair is seen, then as in the file.

    position_mm (markers, 3, n), NaN where not seen. Complete linkage by the spread of a distance,
    (p97.5 - p2.5) / 4, which is the standard deviation of normal noise; so no pair of a cluster
    spreads by more than `cut_mm`. A distance whose median over one of PARTS parts of the take is
    4 cuts from the whole median is of two objects that part company: it spreads too far.
    """
    from scipy.cluster.hierarchy import fcluster, linkage

    n_markers, n = position_mm.shape[0], position_mm.shape[2]
    if n_markers < 2:
        return []
    step = max(n // SAMPLED, 1)
    some, pairs = position_mm[:, :, ::step], np.triu_indices(n_markers, 1)
    spread, middle = np.full(pairs[0].size, 1e3 * cut_mm), np.zeros(pairs[0].size)
    for marker in range(n_markers - 1):  # of hundreds all distances at once are many gigabytes
        among = np.flatnonzero(pairs[0] == marker)
        apart = distances(some, (pairs[0][among], pairs[1][among]))
        seen = np.isfinite(apart).sum(axis=1) * step >= LEAST_FRAMES
        for k in np.flatnonzero(seen & ~_part_company(apart, cut_mm)):
            spread[among[k]], middle[among[k]] = _spread_and_median(apart[k])
    twice = np.unique(pairs[1][(spread <= cut_mm) & (middle < SAME_MM)])
    spread[np.isin(pairs, twice).any(axis=0)] = 1e3 * cut_mm
    number = fcluster(linkage(spread, "complete"), cut_mm, "distance")
    rigid = (number[pairs[0]] == number[pairs[1]]) & (spread <= cut_mm)
    clusters = []
    for one in np.unique(number[pairs[0][rigid]]):
        inside = np.flatnonzero(rigid & (number[pairs[0]] == one))
        longest = inside[np.argmax(middle[inside])]
        pair = int(pairs[0][longest]), int(pairs[1][longest])
        n_seen = int(np.isfinite(position_mm[list(pair)]).all(axis=(0, 1)).sum())
        markers = tuple(np.flatnonzero(number == one).tolist())
        clusters.append(Cluster(markers, float(spread[inside].max()), pair, n_seen))
    return sorted(clusters, key=lambda c: (len(c.markers) < 3, -c.n_frames, c.markers))


def _part_company(apart: np.ndarray, cut_mm: float) -> np.ndarray:
    """Which distances (pairs, n) need not be looked at closely, as the inner half of a few of their
    values alone spans more than a rigid pair's."""
    few = np.sort(apart[:, :: max(apart.shape[1] // FEW, 1)], axis=1)  # NaN last
    known, rows = np.isfinite(few).sum(axis=1), np.arange(len(few))
    span = few[rows, np.minimum(3 * known // 4, few.shape[1] - 1)] - few[rows, known // 4]
    return np.asarray((known >= FEW // 2) & (span > 4 * cut_mm))


def _spread_and_median(apart: np.ndarray) -> tuple[float, float]:
    known = np.isfinite(apart)
    values = np.sort(apart[known])
    low, middle, high = np.quantile(values, (0.025, 0.5, 0.975))
    parts = (np.array_split(one, PARTS) for one in (apart, known))
    blocks = (part[rows] for part, rows in zip(*parts, strict=True))
    off = max((abs(np.median(b) - middle) for b in blocks if b.size * 2 * PARTS >= apart.size),
              default=0.0)  # fmt: skip
    return float(max((high - low) / 4, off / 4)), float(middle)


@dataclass(frozen=True)
class ScaleSlope:
    """Relative length error per metre of way, ppm/m, over all pairs of a cluster, with its
    standard error and 95 % interval; between: standard deviation of the slopes of pairs beyond
    their errors; way_m: length of the way; pairs: numbers of markers, slope and standard error."""

    slope: float
    se: float
    lower: float
    upper: float
    between: float
    way_m: float
    pairs: Sequence[tuple[int, int, float, float]]


def scale_slope(position_mm: np.ndarray, markers: Sequence[int]) -> ScaleSlope | None:
    """Common slope of (|p_i - p_j| / L_ij - 1) along the main axis of the cluster's way, by random
    effects: bodies bend, so slopes of single pairs differ by more than their errors
    [DerSimonian & Laird 1986]. None of fewer than three markers, which show no bending, or on a way
    below LEAST_WAY_M. position_mm (markers, 3, n)."""
    if len(markers) < 3:
        return None
    places = position_mm[list(markers)].astype(float)
    seen = np.isfinite(places).all(axis=1)
    with np.errstate(invalid="ignore"):
        middle = np.where(seen[:, None], places, 0.0).sum(axis=0) / seen.sum(axis=0)
    way = along_main_axis(middle) / 1000
    if not np.isfinite(way).any() or np.ptp(way[np.isfinite(way)]) < LEAST_WAY_M:
        return None
    pairs = np.triu_indices(len(markers), 1)
    rows = []
    for k, apart in enumerate(distances(places, pairs)):
        slope, error = slope_of(way, apart / np.nanmedian(apart) - 1)
        if error > 0:
            ends = markers[int(pairs[0][k])], markers[int(pairs[1][k])]
            rows.append((*ends, 1e6 * slope, 1e6 * error))
    if len(rows) < 3:
        return None
    slope, se, half, between = _common_slope(places, np.array(rows), list(markers))
    way_m = float(np.nanmax(way) - np.nanmin(way))
    return ScaleSlope(slope, se, slope - half, slope + half, between, way_m, rows)


def _common_slope(
    own_mm: np.ndarray, table: np.ndarray, markers: list[int]
) -> tuple[float, float, float, float]:
    """Mean slope, its standard error, half its 95 % interval, sd between pairs.

    Weights 1 / (v + tau^2) of random effects. Pairs with a common marker err together: of markers
    that err independently and alike in all directions, pairs with unit vectors u have the
    correlation of the rows of J, with -u and u at their ends. With V of these correlations and the
    variances v + tau^2, the residual form A = W - w w^T / sum(w) has the mean tr(A V), by which Q
    is scaled, and 2 tr(AV)^2 / tr(AVAV) / 2 degrees of freedom [Satterthwaite].
    """
    from scipy.special import stdtrit

    x, error = table[:, 2], table[:, 3]
    between = random_effects(x, error**2).between
    seen = np.flatnonzero(np.isfinite(own_mm).all(axis=(0, 1)))
    shape = own_mm[:, :, seen[seen.size // 2]] if seen.size else np.eye(len(markers), 3)
    jacobian = np.zeros((x.size, 3 * len(markers)))
    for row, (a, b) in enumerate(table[:, :2].astype(int)):
        i, j = markers.index(a), markers.index(b)
        u = (shape[j] - shape[i]) / np.linalg.norm(shape[j] - shape[i])
        jacobian[row, 3 * i : 3 * i + 3], jacobian[row, 3 * j : 3 * j + 3] = -u, u
    variance = error**2 + between**2
    cov = jacobian @ jacobian.T / 2 * np.sqrt(np.outer(variance, variance))
    w = 1 / variance
    mean = float(w @ x / w.sum())
    form = np.diag(w) - np.outer(w, w) / w.sum()
    spread = form @ cov
    trace = float(np.trace(spread))
    scale = float(x @ form @ x) / trace
    free = trace**2 / float(np.trace(spread @ spread))
    se = math.sqrt(max(scale, 1.0) * float(w @ cov @ w)) / float(w.sum())
    return mean, se, float(stdtrit(free, 0.975)) * se, between


def along_main_axis(middle_mm: np.ndarray) -> np.ndarray:
    """(n,) coordinate along the main axis of a way (3, n), NaN in gaps; it rises from the first to
    the last frame."""
    known = np.isfinite(middle_mm).all(axis=0)
    if known.sum() < LEAST_FRAMES:
        return np.full(known.size, np.nan)
    centred = middle_mm - middle_mm[:, known].mean(axis=1, keepdims=True)
    axis = np.linalg.svd(centred[:, known] @ centred[:, known].T)[0][:, 0]
    way = axis @ centred
    first, last = way[known][[0, -1]]
    return np.asarray(way if last >= first else -way)


def slope_of(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Robust slope of y over x and its standard error, with the effective number of what is
    left."""
    known = np.isfinite(x) & np.isfinite(y)
    if known.sum() < LEAST_FRAMES:
        return math.nan, math.nan
    centred = x - x[known].mean()
    design = np.stack([np.ones(int(known.sum())), centred[known]], axis=1)
    level, slope = huber_fit(design, y[known])
    rest = np.where(known, y - level - slope * centred, np.nan)
    worth = max(effective_number(rest) - 2, 1.0)
    return float(slope), robust_sd(rest) / float(centred[known].std()) / math.sqrt(worth)
