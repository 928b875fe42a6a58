"""Contents of <group>_points.json and rows of <group>_points.csv."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mocap_metrology.accuracy.points import Points, fit, frame_changes, left_out, residuals, rms
from mocap_metrology.common.types import Row

CLAIMED = 3.0  # standard errors from which a scale is claimed
MISFIT = 10.0  # times the noise
ALONE = 0.25  # of the rms of all points, which is left without a single one that is wrong


def points_document(
    points: Points, noise_mm: float, names: Sequence[str]
) -> tuple[dict[str, Any], np.ndarray]:
    """Contents of <group>_points.json, and what the left-out points are off by (n, 3); noise_mm: of
    reference and takes together; names: of the points. Of a frame that jumped, segments are fitted
    each for itself."""
    lever = points.has_lever
    found, scaled = fit(points, lever, False), fit(points, lever, True)
    off, others, lever_se = left_out(points, lever, False)
    off_scaled, _, of_scale = left_out(points, lever, True)
    changes = frame_changes(points)
    ppm, se = 1e6 * scaled.scale, 1e6 * float(of_scale[0])
    document: dict[str, Any] = {
        "n": len(points),
        "left_out_rms_mm": rms(off),
        "fit_rms_mm": rms(residuals(points, found)),
        "left_out_scaled_rms_mm": rms(off_scaled),
        "lever_mm": found.lever if lever else None,
        "lever_se_mm": lever_se[1:] if lever else None,
        "scale_ppm": ppm,
        "scale_se_ppm": se,
        "noise_mm": noise_mm,
        "cuts": list(changes.cuts),
        "inside_mm": changes.inside_mm,
        "jumps_mm": list(changes.jumps_mm),
    }
    codes = ["frame_changed"] if changes.cuts else []
    left_mm = changes.inside_mm if changes.cuts else document["left_out_rms_mm"]
    if left_mm > MISFIT * noise_mm:
        codes.append("does_not_fit")
    worst = int(np.argmin(others))
    alone = "does_not_fit" in codes and others[worst] < ALONE * document["fit_rms_mm"]
    document |= {"wrong_point": names[worst] if alone else None}
    document |= {"others_mm": float(others[worst])}
    codes += ["scale"] if abs(ppm) > CLAIMED * se else []
    return document | {"findings": codes}, off


def point_rows(points: Points, off_mm: np.ndarray) -> list[Row]:
    """Rows of <group>_points.csv: place in the reference's frame, what fit and left-out fit are off
    by there."""
    found = residuals(points, fit(points, points.has_lever, False))
    rows: list[Row] = []
    for place, fitted, off in zip(points.reference, found, off_mm, strict=True):
        row: Row = {f"{a}_mm": float(v) for a, v in zip("xyz", place, strict=True)}
        row |= {f"fit_{a}_mm": float(v) for a, v in zip("xyz", fitted, strict=True)}
        row |= {f"left_out_{a}_mm": float(v) for a, v in zip("xyz", off, strict=True)}
        rows.append(row | {"left_out_mm": float(np.linalg.norm(off))})
    return rows
