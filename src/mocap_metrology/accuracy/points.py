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
from itertools import combinations, pairwise
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation
from scipy.special import stdtrit

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.types import Row

ROUNDS, TURNS = 100, 6
LEAST_TURN_DEG = 3.0  # of attitudes, below which a lever is not seen
LEAST_POINTS, LEAST_WITH_LEVER = 5, 6
LEAST_SEGMENT = 4  # points
LEAST_FREE = 12  # degrees of freedom that segments leave; a lever counts twice
PARAMETERS = 7  # a segment adds: six of a rigid fit, and its place
ON_A_LINE = 1e-2  # of the largest extent
ALIKE = 1.25  # factor between the extents of places and reference
CLAIMED, SURE = 3.0, 0.995  # standard errors from which a scale is claimed, beyond Student's t
MISFIT = 10.0  # times the noise
ALONE = 0.25  # of the rms of all points, which is left without a single one that is wrong
SUSPECTS = 6  # points that are off most, of which two may be exchanged
LIKELIER = 1.5  # times what segments leave: a single wrong point or exchange that leaves less
ROUNDING = 1e-9  # of the largest extent
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
    def has_lever(self) -> bool:
        """Whether the attitudes differ enough to show a lever."""
        turns = Rotation.from_matrix(self.turns)
        angles = np.degrees((turns.mean().inv() * turns).magnitude())
        return bool(angles.max() > LEAST_TURN_DEG)


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


def exchanged(points: Points, off_mm: np.ndarray) -> tuple[list[int], float]:
    """The two of the points that are off most whose exchange leaves the least rms, and this rms."""
    worst = np.argsort(-np.linalg.norm(off_mm, axis=1))[:SUSPECTS]
    best: tuple[list[int], float] = [], math.inf
    for i, j in combinations(sorted(worst.tolist()), 2):
        reference = points.reference.copy()
        reference[[i, j]] = reference[[j, i]]
        swapped = replace(points, reference=reference)
        left = rms(residuals(swapped, fit(swapped, points.has_lever, False)))
        best = min(best, ([i, j], left), key=lambda one: one[1])
    return best


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

    Reported where they leave LEAST_FREE, the rms falls below half of that of one fit and each jump
    exceeds four times the rms inside; no cuts otherwise.
    """
    cuts: tuple[int, ...] = ()
    whole = rms(residuals(points, fit(points, points.has_lever, scale=False)))
    for _ in range(TURNS):
        lever = lever_of(points, cuts) if points.has_lever else np.zeros(3)
        moved = replace(points, places=points.places + points.turns @ lever)
        before, (cuts, squares) = cuts, _segmented(moved)
        if cuts == before:
            break
    inside = math.sqrt(squares / len(points))
    bounds = pairwise((0, *cuts, len(moved)))
    frames = [fit(moved.only(slice(a, b)), False, False) for a, b in bounds]
    placed = [one.applied(moved.places, moved.turns) for one in frames]
    jumps = tuple(rms(after - before) for before, after in pairwise(placed))
    free = 3 * (len(points) - 2 * points.has_lever) - 6 * len(frames)
    if free < LEAST_FREE or inside > whole / 2 or any(jump < 4 * inside for jump in jumps):
        return Segments((), whole, ())
    return Segments(cuts, inside, jumps)


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


def points_document(
    points: Points, noise_mm: float, names: Sequence[str]
) -> tuple[dict[str, Any], np.ndarray]:
    """Contents of <group>_points.json, and what the left-out points are off by (n, 3); noise_mm: of
    reference and takes together; names: of the points. Of a frame that jumped, segments are fitted
    each for itself."""
    lever = points.has_lever
    rigid, scaled = fit(points, lever, False), fit(points, lever, True)
    off, others, lever_se = left_out(points, lever, False)
    off_scaled, _, of_scale = left_out(points, lever, True)
    ppm, se = 1e6 * scaled.scale, 1e6 * float(of_scale[0])
    document: dict[str, Any] = {
        "n": len(points),
        "left_out_rms_mm": rms(off),
        "fit_rms_mm": rms(residuals(points, rigid)),
        "left_out_scaled_rms_mm": rms(off_scaled),
        "lever_mm": rigid.lever if lever else None,
        "lever_se_mm": lever_se[1:] if lever else None,
        "scale_ppm": ppm,
        "scale_se_ppm": se,
        "noise_mm": noise_mm,
    }
    least = max(CLAIMED, float(stdtrit(len(np.unique(points.reference, axis=0)) - 1, SURE)))
    has_scale = abs(ppm) > least * se and abs(scaled.scale) < ALIKE - 1
    left_mm = document["left_out_scaled_rms_mm" if has_scale else "left_out_rms_mm"]
    document |= _misfit(points, names, off, others, left_mm, noise_mm)
    codes = document["findings"] + ["scale"] * has_scale
    return document | {"findings": codes}, off


def _misfit(
    points: Points,
    names: Sequence[str],
    off_mm: np.ndarray,
    others_mm: np.ndarray,
    left_mm: float,
    noise_mm: float,
) -> dict[str, Any]:
    """Why one frame does not fit: segments, unless a single wrong point or an exchange of two
    explains as much; nothing of what is only rounding. others_mm (n,) by `left_out`; left_mm: rms
    of the left-out points."""
    rounding = ROUNDING * float(np.ptp(points.reference, axis=0).max())
    gross = max(MISFIT * noise_mm, rounding)
    whole_mm = rms(residuals(points, fit(points, points.has_lever, False)))
    worst, swap, swapped_mm, simple_mm = int(np.argmin(others_mm)), list[int](), math.inf, math.inf
    if left_mm > gross:
        swap, swapped_mm = exchanged(points, off_mm)
        simple_mm = min(float(others_mm[worst]), swapped_mm)
    changes = frame_changes(points)
    if left_mm <= rounding or simple_mm < LIKELIER * changes.inside_mm:
        changes = Segments((), whole_mm, ())
    fits = (changes.inside_mm if changes.cuts else left_mm) <= gross
    is_simple = not fits and simple_mm < ALONE * whole_mm
    is_swapped = is_simple and swapped_mm == simple_mm
    return {
        "cuts": list(changes.cuts),
        "inside_mm": changes.inside_mm,
        "jumps_mm": list(changes.jumps_mm),
        "wrong_point": names[worst] if is_simple and not is_swapped else None,
        "others_mm": float(others_mm[worst]),
        "exchanged": [names[k] for k in swap] if is_swapped else None,
        "exchanged_mm": swapped_mm if is_swapped else None,
        "findings": ["frame_changed"] * bool(changes.cuts) + ["does_not_fit"] * (not fits),
    }


def point_rows(points: Points, off_mm: np.ndarray) -> list[Row]:
    """Rows of <group>_points.csv: place in the reference's frame, what fit and left-out fit are off
    by there."""
    residual = residuals(points, fit(points, points.has_lever, False))
    rows: list[Row] = []
    for place, fitted, off in zip(points.reference, residual, off_mm, strict=True):
        row: Row = {f"{a}_mm": float(v) for a, v in zip("xyz", place, strict=True)}
        row |= {f"fit_{a}_mm": float(v) for a, v in zip("xyz", fitted, strict=True)}
        row |= {f"left_out_{a}_mm": float(v) for a, v in zip("xyz", off, strict=True)}
        rows.append(row | {"left_out_mm": float(np.linalg.norm(off))})
    return rows
