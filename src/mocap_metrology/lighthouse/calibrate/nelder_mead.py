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
from mocap_metrology.lighthouse.calibrate.cost import cost, trig_of

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
    for i in range(1, N + 1):
        j = i
        while j > 0 and f[j - 1] > f[j]:
            f[j - 1], f[j] = f[j], f[j - 1]
            for k in range(N):
                simplex[j - 1, k], simplex[j, k] = simplex[j, k], simplex[j - 1, k]
            j -= 1


@njit
def _along(middle: np.ndarray, simplex: np.ndarray, share: float, x: np.ndarray) -> None:
    """x = middle + share (middle - worst point)."""
    for j in range(N):
        x[j] = (1.0 + share) * middle[j] - share * simplex[N, j]


@njit
def _put(simplex: np.ndarray, f: np.ndarray, x: np.ndarray, fx: float) -> None:
    """In place of the worst point."""
    f[N] = fx
    for j in range(N):
        simplex[N, j] = x[j]


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
    R, room = np.empty((3, 3)), np.empty((4, points.shape[1]))
    simplex, f = np.empty((N + 1, N)), np.empty(N + 1)
    middle, x, y = np.empty(N), np.empty(N), np.empty(N)
    for i in range(N + 1):
        simplex[i] = x0
        if i > 0:
            simplex[i, i - 1] = 1.05 * x0[i - 1] if x0[i - 1] != 0.0 else 0.00025
        f[i] = cost(simplex[i], unknown, points, measured, trig, rotors, R, room)
    used = N + 1
    _sort(simplex, f)
    while used < evaluations and not _small(simplex, f, tol_x, tol_fun):
        for j in range(N):
            total = 0.0
            for i in range(N):
                total += simplex[i, j]
            middle[j] = total / N
        _along(middle, simplex, 1.0, x)
        fx = cost(x, unknown, points, measured, trig, rotors, R, room)
        used += 1
        if f[0] <= fx < f[N - 1]:
            _put(simplex, f, x, fx)
        elif fx < f[0]:
            _along(middle, simplex, 2.0, y)
            fy = cost(y, unknown, points, measured, trig, rotors, R, room)
            used += 1
            if fy < fx:
                _put(simplex, f, y, fy)
            else:
                _put(simplex, f, x, fx)
        else:
            _along(middle, simplex, 0.5 if fx < f[N] else -0.5, y)
            fy = cost(y, unknown, points, measured, trig, rotors, R, room)
            used += 1
            if (fx < f[N] and fy <= fx) or (fx >= f[N] and fy < f[N]):
                _put(simplex, f, y, fy)
            else:
                for i in range(1, N + 1):
                    simplex[i] = simplex[0] + 0.5 * (simplex[i] - simplex[0])
                    f[i] = cost(simplex[i], unknown, points, measured, trig, rotors, R, room)
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
    """`nelder_mead` for callers outside kernels: points (n, 3), measured (n, 2)."""
    measured = np.ascontiguousarray(np.transpose(measured), dtype=np.float64)
    return nelder_mead(
        np.asarray(x0, dtype=np.float64),
        unknown,
        np.ascontiguousarray(np.transpose(points), dtype=np.float64),
        measured,
        trig_of(measured),
        rotors,
        settings.tol_x,
        settings.tol_fun,
        settings.evaluations,
    )


def warm_up() -> None:
    """Compile the kernels."""
    from mocap_metrology.lighthouse.rotor import rotor_parameters

    search(np.ones(N), 0, np.ones((4, 3)), np.ones((4, 2)), rotor_parameters())
