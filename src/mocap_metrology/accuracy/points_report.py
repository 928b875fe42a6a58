"""What reference points show, as numbers and codes: scale, frames that changed, wrong points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
from scipy.special import fdtrc, stdtrit

from mocap_metrology.accuracy.points import (
    ALIKE,
    Points,
    Segments,
    fit,
    frame_changes,
    frame_drift,
    left_out,
    residuals,
    rms,
)
from mocap_metrology.common.types import Row

CLAIMED, SURE = 3.0, 0.995  # standard errors from which a scale is claimed, beyond Student's t
MISFIT = 10.0  # times the noise
ALONE = 0.25  # of the rms of all points, which is left without a single one that is wrong
CHANCE, MOST_LEFT = 1e-3, 0.5  # of a wrong point by chance; of the rms that others then leave
NOTABLE = 4.0  # times the noise, from which a single point is wrong
SUSPECTS = 6  # points that are off most, of which two may be exchanged
LIKELIER = 1.5  # times what segments leave: a single wrong point or exchange that leaves less
ROUNDING = 1e-6  # of the largest extent, as of coordinates of 24 bits or five digits
MISPAIRED = 0.01  # of the extent, rms: below it points are those of the reference


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
    n_places = len(np.unique(points.reference, axis=0))
    document: dict[str, Any] = {
        "n": len(points),
        "n_places": n_places,
        "left_out_rms_mm": rms(off),
        "fit_rms_mm": rms(residuals(points, rigid)),
        "left_out_scaled_rms_mm": rms(off_scaled),
        "lever_mm": rigid.lever if lever else None,
        "lever_se_mm": lever_se[1:] if lever else None,
        "turn_deg": points.turn_deg,
        "scale_ppm": ppm,
        "scale_se_ppm": se,
        "noise_mm": noise_mm,
    }
    least = max(CLAIMED, float(stdtrit(n_places - 1, SURE)))
    has_scale = abs(ppm) > least * se and abs(scaled.scale) < ALIKE - 1
    enough = max(MISFIT * noise_mm, MOST_LEFT * document["left_out_rms_mm"])
    has_scale = has_scale and document["left_out_scaled_rms_mm"] <= enough
    left_mm = document["left_out_scaled_rms_mm" if has_scale else "left_out_rms_mm"]
    document |= _misfit(points, names, off, others, left_mm, noise_mm)
    if has_scale and not (document["cuts"] or document["wrong_point"] or document["exchanged"]):
        document["findings"].insert(0, "scale")
    return document, off


def _misfit(
    points: Points,
    names: Sequence[str],
    off_mm: np.ndarray,
    others_mm: np.ndarray,
    left_mm: float,
    noise_mm: float,
) -> dict[str, Any]:
    """Why one frame does not fit: segments or a drift, unless a single wrong point or an exchange
    of two explains as much; nothing of what is only rounding. others_mm (n,) by `left_out`;
    left_mm: rms of the left-out points."""
    rounding = ROUNDING * float(np.ptp(points.reference, axis=0).max())
    gross = max(MISFIT * noise_mm, rounding)
    whole_mm = rms(residuals(points, fit(points, points.has_lever, False)))
    worst, swap, swapped_mm, simple_mm = int(np.argmin(others_mm)), list[int](), math.inf, math.inf
    if left_mm > rounding:
        swap, swapped_mm = exchanged(points, off_mm)
        simple_mm = min(float(others_mm[worst]), swapped_mm)
    changes = frame_changes(points)
    # Cuts are likelier than a drift
    drift = frame_drift(points) if left_mm > gross and not changes.cuts else None
    inside_mm = drift.inside_mm if drift else changes.inside_mm
    if left_mm <= rounding or simple_mm < LIKELIER * inside_mm:
        drift, changes = None, Segments((), whole_mm, ())
    rest_mm = changes.inside_mm if changes.cuts else drift.inside_mm if drift else left_mm
    fits = rest_mm <= gross
    is_swapped = not fits and swapped_mm < min(ALONE * whole_mm, float(others_mm[worst]))
    is_notable = float(np.linalg.norm(off_mm[worst])) > max(NOTABLE * noise_mm, rounding)
    is_wrong = not (is_swapped or changes.cuts or drift) and is_notable
    is_wrong = is_wrong and _is_wrong(points, worst, float(others_mm[worst]), whole_mm)
    codes = {"frame_changed": changes.cuts, "frame_drifts": drift, "does_not_fit": not fits}
    extent = rms(points.reference - points.reference.mean(axis=0))
    return {
        "cuts": list(changes.cuts),
        "inside_mm": changes.inside_mm,
        "jumps_mm": list(changes.jumps_mm),
        "drift_mm": drift.size_mm if drift else None,
        "rest_mm": rest_mm,
        "mispaired": bool(rest_mm > MISPAIRED * extent),
        "wrong_point": names[worst] if is_wrong else None,
        "wrong_mm": float(np.linalg.norm(off_mm[worst])),
        "others_mm": float(others_mm[worst]),
        "exchanged": [names[k] for k in swap] if is_swapped else None,
        "exchanged_mm": swapped_mm if is_swapped else None,
        "findings": [code for code, is_so in codes.items() if is_so],
    }


def _is_wrong(points: Points, worst: int, others_mm: float, whole_mm: float) -> bool:
    """Whether a place without which others_mm (rms) are left of whole_mm is off by more than
    chance: the largest of n mean shifts, by F with Bonferroni's factor [Cook and Weisberg,
    Residuals and Influence in Regression (1982), 2.2.2]; a volume that is distorted everywhere
    leaves more than half."""
    same = (points.reference == points.reference[worst]).all(axis=1)
    without, n_places = int((~same).sum()), len(np.unique(points.reference, axis=0))
    free = 3 * without - 6 - 3 * points.has_lever
    least = without * others_mm**2
    shift = len(points) * whole_mm**2 - least
    if free < 1 or others_mm > MOST_LEFT * whole_mm:
        return False
    if least <= 0:
        return True
    removed = 3 * int(same.sum())
    return float(fdtrc(removed, free, shift / removed / (least / free))) * n_places < CHANCE


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
