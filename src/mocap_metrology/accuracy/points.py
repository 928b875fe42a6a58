"""Reference points: places that a system and a better one measured, and the fit between them.

O_i = t + (1 + s) R (p_i + Q_i l): p_i place and Q_i attitude of the tracked body, l the lever from
its origin to the point that the reference measured, R, t, s rotation, shift and scale between the
frames. Least squares over the points; the headline is what each point is off by in a fit without
it. Lengths in mm.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal

ROUNDS, TURNS = 100, 6
LEAST_TURN_DEG = 3.0  # of attitudes, below which a lever is not seen
LEAST_POINTS, LEAST_WITH_LEVER = 5, 6
LEAST_SEGMENT = 4  # points
LEAST_FREE = 12  # degrees of freedom that segments leave; a lever counts twice
PARAMETERS = 7  # a segment adds: six of a rigid fit, and its place
FREE_OF_PLACE = 0.5  # share of the order that the place must not explain
ON_A_LINE = 1e-2  # of the largest extent
ALIKE = 1.25  # factor between the extents of places and reference
MIRRORED = 0.25  # of the rms of a rigid fit that a mirrored one leaves


@dataclass(frozen=True)
class Fit:
    """rotation (3, 3), shift (3,), scale s (a difference from 1), lever (3,)."""

    rotation: np.ndarray
    shift: np.ndarray
    scale: float
    lever: np.ndarray

    def applied(self, places: np.ndarray, turns: np.ndarray) -> np.ndarray:
        """(n, 3) of places (n, 3) and attitudes (n, 3, 3) in the frame of the reference."""
        points = places + turns @ self.lever
        return np.asarray(self.shift + (1 + self.scale) * points @ self.rotation.T)


@dataclass(frozen=True)
class Points:
    """Places (n, 3), attitudes (n, 3, 3) (identities of markers), reference (n, 3), in mm."""

    places: np.ndarray
    turns: np.ndarray
    reference: np.ndarray

    def __len__(self) -> int:
        return len(self.places)

    def only(self, which: np.ndarray | Sequence[int] | slice) -> Points:
        """Some of the places, chosen as numpy indexes an axis."""
        return Points(self.places[which], self.turns[which], self.reference[which])

    @property
    def turn_deg(self) -> float:
        """The largest angle of the attitudes from their mean."""
        turns = Rotation.from_matrix(self.turns)
        return float(np.degrees((turns.mean().inv() * turns).magnitude()).max())

    @property
    def has_lever(self) -> bool:
        """Whether the attitudes differ enough to show a lever."""
        return self.turn_deg > LEAST_TURN_DEG


def fit(points: Points, lever: bool, scale: bool) -> Fit:
    """Least squares of one frame; scale: whether s is free."""
    arm = lever_of(points, (), scale) if lever else np.zeros(3)
    bodies = points.places + points.turns @ arm
    rotation, factor = _turned(bodies, points.reference, scale)
    shift = points.reference.mean(axis=0) - factor * rotation @ bodies.mean(axis=0)
    return Fit(rotation, shift, factor - 1, arm)


def lever_of(points: Points, cuts: Sequence[int], scale: bool = False) -> np.ndarray:
    """(3,) lever common to segments that begin at `cuts`, each with a frame of its own: by turns
    the frames for the lever [Umeyama], and the lever for the frames.

    With c = (1 + s) R and all about the means of a segment, r_i = d_i - c (q_i + Q_i l), so l
    solves Q_i l = c^-1 d_i - q_i by least squares. Components that no attitude shows are 0.
    """
    bounds = (0, *cuts, len(points))
    parts = [points.only(slice(a, b)) for a, b in pairwise(bounds)]
    design = np.concatenate([(p.turns - p.turns.mean(axis=0)).reshape(-1, 3) for p in parts])
    arm = np.zeros(3)
    for _ in range(ROUNDS):
        left = []
        for part in parts:
            rotation, factor = _turned(part.places + part.turns @ arm, part.reference, scale)
            target = part.reference - part.reference.mean(axis=0)
            left.append(target @ rotation / factor - (part.places - part.places.mean(axis=0)))
        before, arm = arm, np.linalg.lstsq(design, np.concatenate(left).ravel(), rcond=1e-6)[0]
        if np.abs(arm - before).max() < 1e-6:
            break
    return arm


def _turned(points: np.ndarray, reference: np.ndarray, scale: bool) -> tuple[np.ndarray, float]:
    """Rotation and scale factor of least squares [Umeyama, IEEE PAMI 13 (1991) 376]."""
    a, b = points - points.mean(axis=0), reference - reference.mean(axis=0)
    rotation = Rotation.align_vectors(b, a)[0].as_matrix()
    factor = float((b * (a @ rotation.T)).sum() / (a**2).sum()) if scale else 1.0
    return rotation, factor


def residuals(points: Points, fitted: Fit) -> np.ndarray:
    """(n, 3) reference minus fitted."""
    return np.asarray(points.reference - fitted.applied(points.places, points.turns))


def left_out(points: Points, lever: bool, scale: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(n, 3) what each point is off by in a fit without its place; (n,) rms that such a fit leaves;
    (4,) standard errors of scale and lever by the jackknife over places, sqrt((n - 1)/n sum
    (theta_k - mean)^2)."""
    _, which = np.unique(points.reference, axis=0, return_inverse=True)
    which = which.ravel()
    n = int(which.max()) + 1  # places
    others = [points.only(which != k) for k in range(n)]
    fits = [fit(rest, lever, scale) for rest in others]
    left = np.array([rms(residuals(*both)) for both in zip(others, fits, strict=True)])
    off = np.zeros((len(points), 3))
    for k, one in enumerate(fits):
        off[which == k] = residuals(points.only(which == k), one)
    values = np.array([[one.scale, *one.lever] for one in fits])
    return off, left[which], np.sqrt((n - 1) * values.var(axis=0))


def check(points: Points, group: str) -> None:
    """Refuse points that do not determine a fit."""
    least = LEAST_WITH_LEVER if points.has_lever else LEAST_POINTS
    n = len(np.unique(points.reference, axis=0))
    if n < least:
        raise Refusal(f"{group}: {n} reference points; expected at least {least}")
    size = np.linalg.svd(points.reference - points.reference.mean(axis=0), compute_uv=False)
    if size[1] < ON_A_LINE * size[0]:
        raise Refusal(
            f"{group}: the reference points are on a line; expected points that span a plane"
        )
    a, b = (x - x.mean(axis=0) for x in (points.places, points.reference))
    times = math.sqrt(float((b**2).sum() / (a**2).sum()))
    if not 1 / ALIKE < times < ALIKE:
        what = f"the reference points are {times:.3g} times as far apart as their recordings"
        raise Refusal(f"{group}: {what}; expected mm, and which point belongs to which")
    singular = np.linalg.svd(b.T @ a, compute_uv=False)
    side, whole = np.sign(np.linalg.det(b.T @ a)), float((a**2).sum() + (b**2).sum())
    turned, mirrored = (whole - 2 * float(singular @ [1, 1, k]) for k in (side, -side))
    if mirrored < MIRRORED**2 * turned:
        what = "the reference points are a mirror image of their recordings"
        hint = "a frame that is right-handed, no axis reversed and no two columns exchanged"
        raise Refusal(f"{group}: {what}; expected {hint}")


def rms(vectors: np.ndarray) -> float:
    """Root mean square length of (n, 3)."""
    return math.sqrt(float((vectors**2).sum() / len(vectors)))


@dataclass(frozen=True)
class Segments:
    """cuts: the numbers of points after which the frame jumped; inside_mm: rms inside segments;
    jumps_mm: how far the places of all points are moved by each jump, rms."""

    cuts: tuple[int, ...]
    inside_mm: float
    jumps_mm: tuple[float, ...]


def frame_changes(points: Points) -> Segments:
    """Segments of the order, of LEAST_SEGMENT points or more, each with a rigid fit of its own and
    all with one lever: the least sum of squares S for each number k of segments by dynamic
    programming [Bai & Perron, J. Appl. Econometrics 18 (2003) 1], k by BIC,
    3 n log(S / 3n) + PARAMETERS k log(3n); lever and segments by turns.

    Reported where they leave LEAST_FREE, the rms falls below half of that of one fit, each jump
    exceeds four times the rms inside; no cuts otherwise. Of points that were taken in the order of
    their places a smooth change may explain more (`_likelier`).
    """
    cuts: tuple[int, ...] = ()
    whole = rms(residuals(points, fit(points, points.has_lever, scale=False)))
    for _ in range(TURNS):
        lever = lever_of(points, cuts) if points.has_lever else np.zeros(3)
        moved = replace(points, places=points.places + points.turns @ lever)
        before, (cuts, squares) = cuts, _segmented(moved)
        if cuts == before:
            break
    cuts = _likelier(moved, cuts, squares)
    bounds = pairwise((0, *cuts, len(moved)))
    parts = [moved.only(slice(a, b)) for a, b in bounds]
    frames = [fit(part, False, False) for part in parts]
    squares = sum(len(p) * rms(residuals(p, f)) ** 2 for p, f in zip(parts, frames, strict=True))
    inside = math.sqrt(squares / len(points))
    placed = [one.applied(moved.places, moved.turns) for one in frames]
    jumps = tuple(rms(after - before) for before, after in pairwise(placed))
    free = 3 * (len(points) - 2 * points.has_lever) - 6 * len(frames)
    if free < LEAST_FREE or inside > whole / 2 or any(jump < 4 * inside for jump in jumps):
        return Segments((), whole, ())
    return Segments(cuts, inside, jumps)


def _likelier(points: Points, cuts: tuple[int, ...], squares: float) -> tuple[int, ...]:
    """The cuts of segments that leave this sum of squares, or those of a smooth change that BIC
    prefers: a frame that drifts evenly, or at a pace that changes evenly, a volume that is bent
    (quadratic in the place), also with a drift, or with one of the cuts."""
    left, (y, once, tau) = _about(points)
    first, second = np.triu_indices(3)
    terms = np.column_stack([np.ones(len(y)), y, y[:, first] * y[:, second]])
    bent = np.kron(terms, np.eye(3)).reshape(len(y), 3, -1)
    drifts, faster = tau[:, None, None] * once, (tau**2)[:, None, None] * once
    later = [(np.arange(len(y)) >= cut)[:, None, None] * once for cut in cuts]
    rivals = [[once, drifts], [once, drifts, faster], [bent], [bent, drifts]]
    rivals += [[bent, one] for one in later]
    size = left.size
    best = size * math.log(max(squares, 1e-9)) + PARAMETERS * (len(cuts) + 1) * math.log(size), cuts
    for columns, of in zip(rivals, [(), (), (), (), *((cut,) for cut in cuts)], strict=True):
        design = np.concatenate(columns, axis=2).reshape(size, -1)
        if cuts and size - design.shape[1] >= LEAST_FREE:
            rest = left.ravel() - design @ np.linalg.lstsq(design, left.ravel(), rcond=1e-10)[0]
            bic = size * math.log(max(float(rest @ rest), 1e-9))
            best = min(best, (bic + (design.shape[1] + len(of)) * math.log(size), of))
    return best[1]


def _about(points: Points) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Residuals (n, 3) of one rigid fit; places y (n, 3) about their mean; columns (n, 3, 6) of a
    small shift and turn, t + a x y; the order, from -1/2 to 1/2."""
    left = residuals(points, fit(points, points.has_lever, scale=False))
    y = points.reference - left
    y = y - y.mean(axis=0)
    cross = np.array([[[0, z, -b], [-z, 0, a], [b, -a, 0]] for a, b, z in y])  # a x y, rows a
    once = np.concatenate([np.tile(np.eye(3), (len(y), 1, 1)), cross], axis=2)
    return left, (y, once, np.linspace(0, 1, len(y)) - 0.5)


def _segmented(points: Points) -> tuple[tuple[int, ...], float]:
    """Cuts by BIC, and the sum of squares inside."""
    n, cost = len(points), _costs(points)
    best, before = [cost[0]], []
    for _ in range(n // LEAST_SEGMENT - 1):
        sums = best[-1][:, None] + cost
        before.append(np.argmin(sums, axis=0))
        best.append(np.min(sums, axis=0))
    size = 3 * n
    penalty = PARAMETERS * math.log(size)
    bic = [size * math.log(max(one[n], 1e-9)) + penalty * k for k, one in enumerate(best)]
    chosen = int(np.argmin(bic))
    cuts: list[int] = []
    end = n
    for of in reversed(before[:chosen]):
        end = int(of[end])
        cuts.insert(0, end)
    return tuple(cuts), float(best[chosen][n])


def _costs(points: Points) -> np.ndarray:
    """(n + 1, n + 1) least sum of squares of a rigid fit of the points from a row's number to
    before a column's, infinite for fewer than LEAST_SEGMENT: |a|^2 + |b|^2 - 2 (s_1 + s_2 +-
    s_3) of the singular values of sum b a^T, a and b about their means, out of running sums."""
    n = len(points)
    a, b = (x - x.mean(axis=0) for x in (points.places, points.reference))
    start, end = np.triu_indices(n + 1, LEAST_SEGMENT)

    def total(x: np.ndarray) -> np.ndarray:
        running = np.concatenate([np.zeros((1, *x.shape[1:])), np.cumsum(x, axis=0)])
        return np.asarray(running[end] - running[start])

    sum_a, sum_b, count = total(a), total(b), (end - start)[:, None]
    products = total(b[:, :, None] * a[:, None, :])
    products = products - sum_b[:, :, None] * sum_a[:, None, :] / count[:, :, None]
    squares = total((a**2 + b**2).sum(axis=1)) - ((sum_a**2 + sum_b**2) / count).sum(axis=1)
    singular = np.linalg.svd(products, compute_uv=False)
    singular[:, 2] *= np.sign(np.linalg.det(products))
    cost = np.full((n + 1, n + 1), np.inf)
    cost[start, end] = np.maximum(squares - 2 * singular.sum(axis=1), 0.0)
    return cost


@dataclass(frozen=True)
class Drift:
    """size_mm: how far the places of all points are moved from the first to the last one, rms;
    inside_mm: rms that a frame which drifts evenly leaves."""

    size_mm: float
    inside_mm: float


def frame_drift(points: Points) -> Drift | None:
    """A frame that shifts and turns evenly from point to point: the residuals of one rigid fit by
    least squares of t + a x y + tau (v + w x y), y the places about their mean, tau from 0 to 1.

    None where it leaves more than a third of the rms (of a jump it leaves half or more), fewer
    than LEAST_FREE, or where the order follows the place, so that a bent volume looks alike.
    """
    n, (left, (y, once, tau)) = len(points), _about(points)
    design = np.concatenate([once, tau[:, None, None] * once], axis=2).reshape(3 * n, 12)
    found = np.linalg.lstsq(design, left.ravel(), rcond=1e-10)[0]
    inside = math.sqrt(float(((left.ravel() - design @ found) ** 2).sum() / n))
    by_place = np.column_stack([np.ones(n), y])
    alone = tau - by_place @ np.linalg.lstsq(by_place, tau, rcond=1e-10)[0]
    free = 3 * n - 12 - 3 * points.has_lever
    is_mixed = float(alone @ alone) < FREE_OF_PLACE * float(tau @ tau)
    if free < LEAST_FREE or is_mixed or inside > rms(left) / 3:
        return None
    return Drift(rms((once @ found[6:]).reshape(n, 3)), inside)
