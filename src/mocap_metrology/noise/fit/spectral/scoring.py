"""Compiled inner loop of `whittle`: damped Fisher scoring on a binned periodogram.

Parameters p in one vector: h of every power law, then ln q_c^2 and ln T_c of every Gauss-Markov
component in turn. With weights nu/2 the gradient and the Fisher information of ln L are
sum nu/2 (P/S - 1) dlnS/dp and sum nu/2 dlnS/dp_i dlnS/dp_j.
"""

from __future__ import annotations

import math

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.noise.fit.spectral.periodogram import unit_into

LARGEST_STEP = 2.3  # of a logarithm at once
LEAST_DAMPING, MOST_DAMPING = 1e-9, 1e8
FACTOR = 8.0  # the damping falls by it after a step that climbs, else it rises
GONE = 1e-6  # information on a logarithm below which its component has vanished for good
LEAST_DENSITY = 1e-140  # its square must be a number too
STEEP = 1e-3  # derivative of a Gauss-Markov spectrum by ln T_c: from this far to either side


@njit
def spectra(
    p: np.ndarray,
    laws: np.ndarray,
    given: np.ndarray,
    where: tuple,
    density: np.ndarray,
    columns: np.ndarray,
) -> None:
    """Density (B,) and columns (p, B), its derivatives; `given` (B,) is not fitted."""
    n_h, n_bins = laws.shape
    density[:] = given
    for i in range(n_h):
        for b in range(n_bins):
            columns[i, b] = laws[i, b]
            density[b] += p[i] * laws[i, b]
    up, down = np.empty(n_bins), np.empty(n_bins)
    for k in range((p.size - n_h) // 2):
        i = n_h + 2 * k
        q2 = math.exp(p[i])
        unit_into(math.exp(p[i + 1]), where, columns[i])
        unit_into(math.exp(p[i + 1] + STEEP), where, up)
        unit_into(math.exp(p[i + 1] - STEEP), where, down)
        for b in range(n_bins):
            columns[i, b] *= q2
            columns[i + 1, b] = q2 * (up[b] - down[b]) / (2 * STEEP)
            density[b] += columns[i, b]


@njit
def density_at(
    p: np.ndarray, laws: np.ndarray, given: np.ndarray, where: tuple, density: np.ndarray
) -> None:
    """Density (B,) alone."""
    n_h, n_bins = laws.shape
    density[:] = given
    for i in range(n_h):
        for b in range(n_bins):
            density[b] += p[i] * laws[i, b]
    unit = np.empty(n_bins)
    for i in range(n_h, p.size, 2):
        unit_into(math.exp(p[i + 1]), where, unit)
        q2 = math.exp(p[i])
        for b in range(n_bins):
            density[b] += q2 * unit[b]


@njit
def deviance_of(psd: np.ndarray, weight: np.ndarray, density: np.ndarray) -> float:
    """sum nu (P/S - 1 - ln P/S); infinite where the density has vanished."""
    total = 0.0
    for b in range(psd.size):
        if not density[b] > LEAST_DENSITY:
            return np.inf
        ratio = psd[b] / density[b]
        total += weight[b] * (ratio - 1.0 - math.log(ratio))
    return total


@njit
def normal_equations(
    psd: np.ndarray,
    weight: np.ndarray,
    density: np.ndarray,
    columns: np.ndarray,
    gradient: np.ndarray,
    information: np.ndarray,
) -> None:
    """Gradient (p,) and Fisher information (p, p) of ln L."""
    gradient[:] = 0.0
    information[:] = 0.0
    n = columns.shape[0]
    for b in range(psd.size):
        half = 0.5 * weight[b] / (density[b] * density[b])
        rest = psd[b] - density[b]
        for i in range(n):
            c = half * columns[i, b]
            gradient[i] += c * rest
            for j in range(i + 1):
                information[i, j] += c * columns[j, b]
    for i in range(n):
        for j in range(i):
            information[j, i] = information[i, j]


@njit
def _trial(
    p: np.ndarray,
    n_h: int,
    gradient: np.ndarray,
    information: np.ndarray,
    damping: float,
    low: float,
    high: float,
) -> np.ndarray:
    """p after one scoring step of the parameters that are free to move.

    h stays >= 0 and ln T_c within low ... high; what lies at an end and is pulled out of it is
    held. The information is scaled to unit diagonal, so the damping has no unit.
    """
    free = np.empty(p.size, np.int64)
    n = 0
    for i in range(p.size):
        held = p[i] <= 0.0 and gradient[i] <= 0.0 if i < n_h else information[i, i] < GONE
        if i > n_h and (i - n_h) % 2 == 1:
            held = held or (p[i] <= low and gradient[i] < 0.0)
            held = held or (p[i] >= high and gradient[i] > 0.0)
        if not held:
            free[n] = i
            n += 1
    out = p.copy()
    if n == 0:
        return out
    matrix, right = np.empty((n, n)), np.empty(n)
    for i in range(n):
        a = free[i]
        scale = math.sqrt(information[a, a])
        right[i] = gradient[a] / scale
        for j in range(n):
            c = free[j]
            matrix[i, j] = information[a, c] / scale / math.sqrt(information[c, c])
        matrix[i, i] += damping
    moved = np.linalg.solve(matrix, right)
    for i in range(n):
        a = free[i]
        step = moved[i] / math.sqrt(information[a, a])
        if a < n_h:
            out[a] = max(p[a] + step, 0.0)
            continue
        out[a] = p[a] + min(max(step, -LARGEST_STEP), LARGEST_STEP)
        if (a - n_h) % 2 == 1:
            out[a] = min(max(out[a], low), high)
    return out


@njit
def ascend(
    p: np.ndarray,
    laws: np.ndarray,
    given: np.ndarray,
    where: tuple,
    psd: np.ndarray,
    weight: np.ndarray,
    bounds: tuple,
    max_steps: int,
    tolerance: float,
) -> tuple[np.ndarray, float, bool]:
    """Climb from p: the parameters, the deviance, and whether the last steps gained too little."""
    n_h, n_bins = laws.shape
    density, columns = np.empty(n_bins), np.empty((p.size, n_bins))
    gradient, information = np.empty(p.size), np.empty((p.size, p.size))
    spectra(p, laws, given, where, density, columns)
    deviance = deviance_of(psd, weight, density)
    damping, idle = 1e-3, 0
    for _ in range(max_steps):
        normal_equations(psd, weight, density, columns, gradient, information)
        while True:
            trial = _trial(p, n_h, gradient, information, damping, bounds[0], bounds[1])
            density_at(trial, laws, given, where, density)
            found = deviance_of(psd, weight, density)
            if found <= deviance or damping > MOST_DAMPING:
                break
            damping *= FACTOR
        if not found <= deviance:
            return p, deviance, True  # no direction leads up any further
        idle = idle + 1 if deviance - found < tolerance else 0
        p, deviance = trial, found
        if idle == 2:
            return p, deviance, True
        spectra(p, laws, given, where, density, columns)
        damping = max(damping / FACTOR, LEAST_DAMPING)
    return p, deviance, False
