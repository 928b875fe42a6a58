"""Which hits are off the others of their sweep, or of the turns about it: compiled.

A sweep is fitted in the least sum of |residuals|, by iterated weights, so that a few wrong hits
bend nothing; `clean` has the models.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.linear import solve

LEAST_PIVOT = 1e-15  # of the normal equations of a sweep: far below what one hit adds
FULL = 4  # hits of a sweep, and two a direction of the board: three more than unknowns
NEAR, FARTHEST_RAD = 2, 0.5  # turns, and angles in them, that are one board's


class Cleaning(NamedTuple):
    """Thresholds of `clean_hits`; half_window: sweeps of one laser to each side, 1 s in all."""

    gate_rad: float = 1.5e-3
    gate_mad: float = 8.0
    half_window: int = 15
    n_sigma: float = 4.0


@njit
def _fit(design: np.ndarray, value: np.ndarray, weight: np.ndarray) -> np.ndarray:
    n_hits, n = design.shape
    normal = np.zeros((n, n))
    right = np.zeros(n)
    for h in range(n_hits):
        for i in range(n):
            wx = weight[h] * design[h, i]
            right[i] += wx * value[h]
            for j in range(i + 1):
                normal[i, j] += wx * design[h, j]
    for i in range(n):  # directions that these hits do not determine remain soluble
        normal[i, i] += 1e-9 * (normal[i, i] + 1e-9)
    solve(normal, right, LEAST_PIVOT, 0.0, LEAST_PIVOT)
    return right


@njit
def _predict(
    design: np.ndarray, tangent: np.ndarray, weight: np.ndarray, n_linear: int, out: np.ndarray
) -> None:
    """tan(angle) of the fitted model, into `out`; the columns past n_linear are made anew from it,
    -tan(angle) X, so that a wrong hit bends none of its own columns."""
    n_hits, n = design.shape
    coefficients = _fit(design, tangent, weight)
    for h in range(n_hits):
        above = 0.0
        below = 1.0
        for i in range(n_linear):
            above += design[h, i] * coefficients[i]
        for i in range(n_linear, n):
            below += design[h, i - n_linear + 1] * coefficients[i]
        out[h] = above / min(max(below, 0.3), 3.0)
        for i in range(n_linear, n):
            design[h, i] = -out[h] * design[h, i - n_linear + 1]


@njit
def _least_absolute(
    design: np.ndarray, tangent: np.ndarray, n_linear: int, weight: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Residuals in rad, to first order, and tangents of the model, by iterated weights."""
    residual, predicted = np.empty(tangent.size), np.empty(tangent.size)
    for _ in range(7):
        _predict(design, tangent, weight, n_linear, predicted)
        for h in range(tangent.size):
            residual[h] = (tangent[h] - predicted[h]) / (1.0 + tangent[h] * tangent[h])
            weight[h] = 1.0 / max(abs(residual[h]), 3e-5)
    return residual, predicted


@njit
def _gate_sweep(
    tangent: np.ndarray, where: np.ndarray, gate: Cleaning, perspective: float
) -> np.ndarray:
    """Wrong hits of one sweep."""
    n_hits, n_directions = where.shape
    gate_rad, gate_mad = gate.gate_rad, gate.gate_mad
    n_linear = 1 + n_directions
    if n_hits <= n_linear:
        return np.zeros(n_hits, np.bool_)
    design = np.ones((n_hits, n_linear + n_directions))
    design[:, 1:n_linear] = where
    weight, affine = np.ones(n_hits), design[:, :n_linear].copy()
    residual, predicted = _least_absolute(affine, tangent, n_linear, weight)
    if n_hits < FULL + 2 * n_directions:
        gate_rad += perspective * (np.max(tangent) - np.min(tangent)) ** 2
    if n_hits == n_linear + 1:
        return np.full(n_hits, np.sum(np.abs(residual)) > 10 * gate_rad)
    if n_hits < FULL + 2 * n_directions:
        design = affine
    else:
        for h in range(n_hits):
            for i in range(n_directions):
                design[h, n_linear + i] = -predicted[h] * where[h, i]
        residual, predicted = _least_absolute(design, tangent, n_linear, weight)
    for _ in range(2):  # least squares of those inside, which may let some back in
        limit = max(gate_rad, gate_mad * np.median(np.abs(residual)))
        for h in range(n_hits):
            weight[h] = 1.0 if abs(residual[h]) <= limit else 1e-9
        _predict(design, tangent, weight, n_linear, predicted)
        residual = np.arctan(tangent) - np.arctan(predicted)
    return np.abs(residual) > max(gate_rad, gate_mad * np.median(np.abs(residual)))


@njit
def gate_sweeps(
    tangent: np.ndarray, where: np.ndarray, first: np.ndarray, gate: Cleaning, perspective: float
) -> np.ndarray:
    """Mask of hits that do not fit the others of their sweep; `first`: where each sweep begins."""
    wrong = np.zeros(tangent.size, np.bool_)
    for sweep in range(first.size - 1):
        low, high = first[sweep], first[sweep + 1]
        wrong[low:high] = _gate_sweep(tangent[low:high], where[low:high], gate, perspective)
    return wrong


@njit
def gate_turns(
    angle: np.ndarray,
    where: np.ndarray,
    cycle: np.ndarray,
    laser: np.ndarray,
    first: np.ndarray,
    gate: Cleaning,
) -> np.ndarray:
    """cycle, laser: of each sweep; first: where its hits begin, and the end."""
    wrong = np.zeros(angle.size, np.bool_)
    n = where.shape[1]
    for sweep in range(cycle.size):
        low, high = first[sweep], first[sweep + 1]
        begin, end = sweep, sweep + 1
        while (
            begin and laser[begin - 1] == laser[sweep] and cycle[sweep] - cycle[begin - 1] <= NEAR
        ):
            begin -= 1
        while end < cycle.size and laser[end] == laser[sweep] and cycle[end] - cycle[sweep] <= NEAR:
            end += 1
        first_row = low - first[begin]
        near = slice(first[begin], first[end])
        middle = np.median(angle[near])
        tangent = np.tan(np.clip(angle[near] - middle, -FARTHEST_RAD, FARTHEST_RAD))
        if tangent.size < 2 * (n + 3):
            continue
        design = np.ones((tangent.size, n + 3))
        design[:, 1 : n + 1] = where[near]
        for other in range(begin, end):
            turns = float(cycle[other] - cycle[sweep])
            rows = slice(first[other] - first[begin], first[other + 1] - first[begin])
            design[rows, n + 1] = turns
            design[rows, n + 2] = turns * turns
        residual, predicted = _least_absolute(design, tangent, n + 3, np.ones(tangent.size))
        here = slice(first_row, first_row + high - low)
        span = np.max(predicted[here]) - np.min(predicted[here])
        limit = max(gate.gate_rad + span * span, gate.gate_mad * np.median(np.abs(residual)))
        wrong[low:high] = np.abs(residual[here]) > limit
    return wrong
