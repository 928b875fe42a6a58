"""Nelder-Mead simplex on K_1 and K_2, as MATLAB's fminsearch does it (J V-A, Eq. 3 and 5).

J names the algorithm and neither its settings nor its program; the defaults here are those of
fminsearch: the first simplex is the start and, for each unknown, the start with 5 % more of it
(0.00025 where it is zero); reflection 1, expansion 2, contraction 1/2, shrinking 1/2; the end is
where the simplex is below TolX in every coordinate and below TolFun in cost, or after 200
evaluations an unknown. scipy's `Nelder-Mead` takes the same steps, and a test compares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.lighthouse.calibrate.cost import cost

N = 6


@dataclass(frozen=True)
class SimplexSettings:
    """Where a search ends: TolX in m and rad, TolFun in rad^2, evaluations of the cost."""

    tol_x: float = 1e-4
    tol_fun: float = 1e-4
    evaluations: int = 200 * N


MATLAB = SimplexSettings()
TIGHT = SimplexSettings(tol_x=1e-6, tol_fun=1e-14, evaluations=1000 * N)


@njit
def _sort(simplex: np.ndarray, f: np.ndarray) -> None:
    """Insertion sort by cost; equal costs keep their order."""
    row = np.empty(N)
    for i in range(1, N + 1):
        row[:], value = simplex[i], f[i]
        j = i
        while j > 0 and f[j - 1] > value:
            simplex[j], f[j] = simplex[j - 1], f[j - 1]
            j -= 1
        simplex[j], f[j] = row, value


@njit
def _small(simplex: np.ndarray, f: np.ndarray, tol_x: float, tol_fun: float) -> bool:
    for i in range(1, N + 1):
        if abs(f[i] - f[0]) > tol_fun:
            return False
        for j in range(N):
            if abs(simplex[i, j] - simplex[0, j]) > tol_x:
                return False
    return True


@njit
def nelder_mead(
    x0: np.ndarray,
    unknown: int,
    points: np.ndarray,
    measured: np.ndarray,
    trig: np.ndarray,
    rotors: np.ndarray,
    tol_x: float,
    tol_fun: float,
    evaluations: int,
) -> tuple[np.ndarray, float, int]:
    """Minimise K_1 or K_2 (see `cost`) from x0: the pose (6,), its cost in rad^2, evaluations."""
    R = np.empty((3, 3))
    simplex, f = np.empty((N + 1, N)), np.empty(N + 1)
    middle, x, y = np.empty(N), np.empty(N), np.empty(N)
    for i in range(N + 1):
        simplex[i] = x0
        if i > 0:
            simplex[i, i - 1] = 1.05 * x0[i - 1] if x0[i - 1] != 0.0 else 0.00025
        f[i] = cost(simplex[i], unknown, points, measured, trig, rotors, R)
    used = N + 1
    _sort(simplex, f)
    while used < evaluations and not _small(simplex, f, tol_x, tol_fun):
        for j in range(N):
            middle[j] = simplex[:N, j].sum() / N
        x[:] = 2.0 * middle - simplex[N]
        fx = cost(x, unknown, points, measured, trig, rotors, R)
        used += 1
        if f[0] <= fx < f[N - 1]:
            simplex[N], f[N] = x, fx
        elif fx < f[0]:
            y[:] = 3.0 * middle - 2.0 * simplex[N]
            fy = cost(y, unknown, points, measured, trig, rotors, R)
            used += 1
            if fy < fx:
                simplex[N], f[N] = y, fy
            else:
                simplex[N], f[N] = x, fx
        else:
            if fx < f[N]:
                y[:] = 1.5 * middle - 0.5 * simplex[N]
            else:
                y[:] = 0.5 * middle + 0.5 * simplex[N]
            fy = cost(y, unknown, points, measured, trig, rotors, R)
            used += 1
            if (fx < f[N] and fy <= fx) or (fx >= f[N] and fy < f[N]):
                simplex[N], f[N] = y, fy
            else:
                for i in range(1, N + 1):
                    simplex[i] = simplex[0] + 0.5 * (simplex[i] - simplex[0])
                    f[i] = cost(simplex[i], unknown, points, measured, trig, rotors, R)
                used += N
        _sort(simplex, f)
    return simplex[0].copy(), f[0], used


def search(
    x0: np.ndarray,
    unknown: int,
    points: np.ndarray,
    measured: np.ndarray,
    rotors: np.ndarray,
    settings: SimplexSettings = MATLAB,
) -> tuple[np.ndarray, float, int]:
    """`nelder_mead` for callers outside kernels."""
    from mocap_metrology.lighthouse.calibrate.cost import trig_of

    measured = np.ascontiguousarray(measured, dtype=np.float64)
    return nelder_mead(
        np.asarray(x0, dtype=np.float64),
        unknown,
        np.ascontiguousarray(points, dtype=np.float64),
        measured,
        trig_of(measured),
        rotors,
        settings.tol_x,
        settings.tol_fun,
        settings.evaluations,
    )
