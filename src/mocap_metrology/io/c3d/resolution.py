"""The smallest step between two coordinates that a file can tell."""

from __future__ import annotations

import numpy as np

STEPS_MM = (1, 0.5, 0.1, 0.05, 0.01, 0.005, 0.001, 0.0005, 0.0001)
SAMPLE = 10_000  # values of each coordinate that are tested for rounding


def float_step_mm(position_mm: np.ndarray, mm_per_unit: float) -> float:
    """Largest float32 spacing of the stored coordinates, in mm; `position_mm` may hold NaN.

    NaN where no coordinate is valid.
    """
    largest = max(
        np.fmax.reduce(position_mm, axis=None, initial=np.nan),
        -np.fmin.reduce(position_mm, axis=None, initial=np.nan),
    )
    return float(np.spacing(np.float32(largest / mm_per_unit))) * mm_per_unit


def rounding_step_mm(position_mm: np.ndarray, mm_per_unit: float) -> float | None:
    """The coarsest of `STEPS_MM` that all sampled coordinates are multiples of, or None.

    `position_mm` (n_points, 3, n_frames), NaN where invalid; of each coordinate the first 10,000
    valid values are tested, to within one float32 spacing of the stored number. A step counts as
    found only where chance is ruled out: a value v of arbitrary fraction passes with probability
    2 spacing(v) / step, and the product over all different values must be below 1e-9. That also
    rules out steps close to the spacing, and coordinates that hardly change.
    """
    values = []
    for series in (axis for point in position_mm for axis in point):
        # Valid frames may start late: skip gaps a piece at a time rather than copy the series.
        taken: list[np.ndarray] = []
        for start in range(0, len(series), 4 * SAMPLE):
            piece = series[start : start + 4 * SAMPLE]
            taken.append(piece[np.isfinite(piece)])
            if sum(len(t) for t in taken) >= SAMPLE:
                break
        values.append(np.unique(np.concatenate(taken)[:SAMPLE].astype(float)))
    distinct = np.concatenate(values)
    if len(distinct) == 0:
        return None
    tolerance = np.spacing(np.abs(distinct / mm_per_unit).astype(np.float32)) * mm_per_unit
    evidence = np.concatenate([v[1:] for v in values])  # a constant coordinate proves nothing
    chance = np.spacing(np.abs(evidence / mm_per_unit).astype(np.float32)) * mm_per_unit
    for step in STEPS_MM:
        if np.all(np.abs(distinct - step * np.round(distinct / step)) <= tolerance):
            odds = np.log10(np.minimum(1.0, 2 * chance / step)).sum()
            return float(step) if odds < -9 else None
    return None
