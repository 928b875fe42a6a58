"""Angle at which a rotor of the second generation meets a point: two tilted planes on one rotor.

In the station's frame, of plane p with the factory values phase, tilt, curve, gibphase g, gibmag G,
ogeephase o and ogeemag O,

    A = +-pi/6 + tilt (+ of plane 0),  u = atan2(y, x),  r = sqrt(x^2 + y^2),  R = sqrt(r^2 + z^2)
    a = z tan(A) / r,  w = asin(a),  s = asin(z / (R cos A))
    m = c2 s^2 + c3 s^3 + c4 s^4 + c5 s^5,  d = dm/ds,  k = curve + O cos(u - w + o)
    b = u - asin(a + m k / (cos A - d k sin A))
    theta = b + G cos(b + g) - phase

[libsurvive, src/survive_reproject_gen2.c; there the azimuth is u + pi/2]. The Crazyflie firmware
leaves curve and ogee out, and its argument of G is u + g [lighthouse_calibration.c].
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse.records import Factory

# Columns of the parameters of a plane; those of a rotor of the first generation are in `rotor`.
PHASE, TILT, CURVE, GIBPHASE, GIBMAG = range(5)
GIB_CORRECTED, OGEEPHASE, OGEEMAG, GENERATION = 8, 10, 11, 12
C2, C3, C4, C5 = 7.6069798e-3, 5.3685255e-6, 2.8679863e-3, -8.0108022e-6
LIMITS = {"phase": 0.05, "tilt": 0.1, "curve": 1.5, "gibmag": 0.1, "ogeemag": 2.0}
MOST = 1.0 - 1e-9  # of a sine: points that no plane meets
PLANE_RAD = math.pi / 6


def check_within(factory: Factory, limits: Mapping[str, float], hint: str) -> None:
    """Refuse values that no such station has."""
    for name, limit in limits.items():
        values = np.asarray(getattr(factory, name))
        if not (np.abs(values) <= limit).all():
            said = f"factory calibration: {name} is {values.tolist()}; expected within +-{limit}"
            raise Refusal(said + hint)


def parameters(factory: Factory, full: bool) -> np.ndarray:
    """Rows (2, 13) of both planes for the kernels; full: by libsurvive's formula, else by that of
    the Crazyflie. Raises `Refusal` for values that no such station has."""
    check_within(factory, LIMITS, " (of a second-generation station)")
    rows = np.zeros((2, 13))
    rows[:, PHASE], rows[:, TILT] = factory.phase, factory.tilt
    rows[:, GIBPHASE], rows[:, GIBMAG] = factory.gibphase, factory.gibmag
    if full:
        rows[:, CURVE] = factory.curve
        rows[:, OGEEPHASE], rows[:, OGEEMAG] = factory.ogeephase, factory.ogeemag
    rows[:, GIB_CORRECTED], rows[:, GENERATION] = full, 2
    return rows


@njit(inline="always")
def _asin(x: float) -> tuple[float, float]:
    """asin of a sine cut to those that exist, and its derivative."""
    x = min(max(x, -MOST), MOST)
    return math.asin(x), 1.0 / math.sqrt(1.0 - x * x)


@njit
def plane_gradient(
    plane: int, x: float, y: float, z: float, p: np.ndarray, of: np.ndarray
) -> tuple[float, float, float, float]:
    """Angle in rad, and its derivatives by x, y and z in rad/m; p: a row of the parameters.

    Those by tilt, curve, G cos g, G sin g, O cos o and O sin o go into `of`, (6,) or empty.
    """
    A = (PLANE_RAD if plane == 0 else -PLANE_RAD) + p[TILT]
    cA, sA = math.cos(A), math.sin(A)
    tA, r2 = sA / cA, x * x + y * y
    r, R2 = math.sqrt(r2), r2 + z * z
    R = math.sqrt(R2)
    u, a = math.atan2(y, x), z * tA / r
    w, da = _asin(a)
    # Derivatives by x, y, z and tilt of u, w, s; then of k, v, b.
    u_x, u_y = -y / r2, x / r2
    w_x, w_y, w_z, w_A = -da * a * x / r2, -da * a * y / r2, da * tA / r, da * z / (r * cA * cA)
    G, g = p[GIBMAG], p[GIBPHASE]
    if p[GIB_CORRECTED] == 0.0:
        inner = 1.0 - G * math.sin(u + g)
        if of.size > 0:
            of[0], of[1], of[4], of[5] = -w_A, 0.0, 0.0, 0.0
            of[2], of[3] = math.cos(u), -math.sin(u)
        theta = u - w + G * math.cos(u + g) - p[PHASE]
        return theta, inner * u_x - w_x, inner * u_y - w_y, -w_z
    q = z / (R * cA)
    s, ds = _asin(q)
    s_x, s_y, s_z, s_A = -ds * q * x / R2, -ds * q * y / R2, ds * r2 / (R * R2 * cA), ds * q * tA
    m = s * s * (C2 + s * (C3 + s * (C4 + s * C5)))
    d = s * (2 * C2 + s * (3 * C3 + s * (4 * C4 + s * 5 * C5)))
    dd = 2 * C2 + s * (6 * C3 + s * (12 * C4 + s * 20 * C5))
    psi, og, o = u - w, p[OGEEMAG], p[OGEEPHASE]
    k, turn = p[CURVE] + og * math.cos(psi + o), -og * math.sin(psi + o)
    n = cA - d * k * sA
    v, dv = _asin(a + m * k / n)
    by_k = m * cA / (n * n)  # of v
    by_s = k * (d / n + m * dd * k * sA / (n * n))
    by_w = math.cos(w) - turn * by_k  # a = sin(w)
    v_A = by_w * w_A + by_s * s_A + m * k * (sA + d * k * cA) / (n * n)
    b_x = u_x - dv * (by_w * w_x + by_s * s_x + turn * by_k * u_x)
    b_y = u_y - dv * (by_w * w_y + by_s * s_y + turn * by_k * u_y)
    b_z = -dv * (by_w * w_z + by_s * s_z)
    b = u - v
    inner = 1.0 - G * math.sin(b + g)
    if of.size > 0:
        of[0], of[1] = -inner * dv * v_A, -inner * dv * by_k
        of[2], of[3] = math.cos(b), -math.sin(b)
        of[4], of[5] = of[1] * math.cos(psi), -of[1] * math.sin(psi)
    return b + G * math.cos(b + g) - p[PHASE], inner * b_x, inner * b_y, inner * b_z


@njit(inline="always")
def ideal_direction(t0: float, t1: float) -> tuple[float, float]:
    """(y, z) of the direction (1, y, z) behind angles of both ideal planes, rad:

    y = tan((t0 + t1) / 2),  z = sin(t1 - t0) / (tan(pi/6) (cos t0 + cos t1)).
    """
    z = math.sin(t1 - t0) / (math.tan(PLANE_RAD) * (math.cos(t0) + math.cos(t1)))
    return math.tan((t0 + t1) / 2), z
