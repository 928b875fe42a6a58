"""Angle at which a rotor's laser meets a point: one model for simulation and estimation.

In the frame of a rotor, (a, b, c) = (x, y, z) for axis 0 and (x, z, -y) for axis 1, seen from its
own laser,

    u = atan2(b, a),  v = atan2(c, a),  r = sqrt(a^2 + b^2)
    theta = u - phase - asin(c tan(tilt) / r) + gibmag sin(g + gibphase) - curve v^2.

Without factory values this is J Eq. 1, theta = atan2(y, x) and phi = atan2(z, x) about each laser.
Open-source drivers agree in the first three terms and differ in three choices, named in `Variant`;
the defaults are those of the Crazyflie firmware. A rotor of the second generation has two tilted
planes, see `planes`; which model a row of parameters is of stands in the row.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.lighthouse import planes
from mocap_metrology.lighthouse.planes import ideal_direction, plane_gradient
from mocap_metrology.lighthouse.records import Factory

# Columns of the parameters of a rotor, as kernels read them; those after them are of `planes`.
PHASE, TAN_TILT, CURVE, GIBPHASE, GIBMAG, X, Y, Z, GIB_CORRECTED, IMPERFECT = range(10)
OGEEPHASE, OGEEMAG, GENERATION = range(10, 13)
COLUMNS = 13
LIMITS = {"phase": 0.3, "tilt": 0.3, "curve": 0.1}  # second-generation curves are near 0.2


@dataclass(frozen=True)
class Variant:
    """The signs and arguments in which the rotor models of drivers differ.

    curve_sign: -1 (Crazyflie, Astrobee) or +1 (libsurvive); gib_argument: `geometric`, g = u
    (Crazyflie), or `corrected`, g = u - phase - tilt term (libsurvive, Astrobee);
    tilt: `tangent` or `angle` (libsurvive puts the tilt itself for its tangent).
    """

    curve_sign: int = -1
    gib_argument: str = "geometric"
    tilt: str = "tangent"


CRAZYFLIE = Variant()
LIBSURVIVE = Variant(curve_sign=1, gib_argument="corrected", tilt="angle")
ASTROBEE = Variant(gib_argument="corrected")
VARIANTS = {"crazyflie": CRAZYFLIE, "libsurvive": LIBSURVIVE, "astrobee": ASTROBEE}


def rotor_parameters(
    factory: Factory | None = None,
    lasers_m: np.ndarray | None = None,
    variant: Variant = CRAZYFLIE,
) -> np.ndarray:
    """Parameters of both rotors, or planes, for the kernels here, shape (2, 13).

    factory None means ideal optics of the first generation; lasers_m (2, 3) are the positions of
    the lasers of axis 0 and axis 1 in the station's frame, metres, default its origin.

    Raises `Refusal` where the values cannot be of a station of that generation.
    """
    if factory is not None and factory.generation == 2:
        return planes.parameters(factory, full=variant != CRAZYFLIE)
    parameters = np.zeros((2, COLUMNS))
    if factory is not None:
        check(factory)
        parameters[:, PHASE] = factory.phase
        parameters[:, TAN_TILT] = (
            np.tan(factory.tilt) if variant.tilt == "tangent" else factory.tilt
        )
        parameters[:, CURVE] = variant.curve_sign * factory.curve
        parameters[:, GIBPHASE] = factory.gibphase
        parameters[:, GIBMAG] = factory.gibmag
        parameters[:, GIB_CORRECTED] = variant.gib_argument == "corrected"
        parameters[:, IMPERFECT] = parameters[:, :GIB_CORRECTED].any(axis=1)
    if lasers_m is not None:
        parameters[:, X : Z + 1] = lasers_m
    return parameters


def check(factory: Factory) -> None:
    """Refuse values that no first-generation station has."""
    planes.check_within(
        factory, LIMITS, " (values of second-generation stations mean something else)"
    )


@njit(inline="always")
def turned(R: np.ndarray, x: float, y: float, z: float) -> tuple[float, float, float]:
    """R (x, y, z)."""
    return (
        R[0, 0] * x + R[0, 1] * y + R[0, 2] * z,
        R[1, 0] * x + R[1, 1] * y + R[1, 2] * z,
        R[2, 0] * x + R[2, 1] * y + R[2, 2] * z,
    )


@njit(inline="always")
def angle_gradient(
    axis: int, x: float, y: float, z: float, p: np.ndarray, of: np.ndarray
) -> tuple[float, float, float, float]:
    """Angle in rad of `axis`, or plane, for a point in the station's frame, and its derivatives by
    x, y and z in rad/m; p: a row of the parameters.

    Unless `of` is empty, those by tan(tilt), the curve with its sign, gibmag cos(gibphase) and
    gibmag sin(gibphase) go into it, of a plane those of `plane_gradient`.
    """
    if p[GENERATION] == 2.0:
        return plane_gradient(axis, x, y, z, p, of)
    a, b, c = x - p[X], y - p[Y], z - p[Z]
    if axis == 1:
        b, c = c, -b
    r2 = a * a + b * b
    theta = math.atan2(b, a)
    da, db, dc = -b / r2, a / r2, 0.0
    if p[IMPERFECT] != 0.0 or of.size > 0:
        r, v = math.sqrt(r2), math.atan2(c, a)
        s = c * p[TAN_TILT] / r
        k = 1.0 / math.sqrt(1.0 - s * s)
        ta, tb, tc = -k * s * a / r2, -k * s * b / r2, k * p[TAN_TILT] / r
        base = theta - p[PHASE] - math.asin(s)
        g = base if p[GIB_CORRECTED] else theta
        inner = 1.0 + p[GIBMAG] * math.cos(g + p[GIBPHASE])
        theta = base + p[GIBMAG] * math.sin(g + p[GIBPHASE]) + p[CURVE] * v * v
        if p[GIB_CORRECTED]:
            da, db, dc = inner * (da - ta), inner * (db - tb), -inner * tc
        else:
            da, db, dc, inner = inner * da - ta, inner * db - tb, -tc, 1.0
        q = 2.0 * p[CURVE] * v / (a * a + c * c)
        da, dc = da - q * c, dc + q * a
        if of.size > 0:
            of[0], of[1] = inner * (-c / (r * math.sqrt(1.0 - s * s))), v * v
            of[2], of[3] = math.sin(g), math.cos(g)
    if axis == 1:
        return theta, da, -dc, db
    return theta, da, db, dc


@njit
def angles(points: np.ndarray, parameters: np.ndarray) -> np.ndarray:
    """C(L, P) of J Eq. 2: both angles in rad of points (n, 3) in the station's frame, (n, 2)."""
    out, none = np.empty((points.shape[0], 2)), np.empty(0)
    for i in range(points.shape[0]):
        x, y, z = points[i]
        for axis in range(2):
            out[i, axis] = angle_gradient(axis, x, y, z, parameters[axis], none)[0]
    return out


def directions(measured: np.ndarray, parameters: np.ndarray) -> np.ndarray:
    """Ideal angles behind measured ones, (..., 2) in rad: the inverse of the model, lasers assumed
    at one point, to 1e-12 rad by Newton's method on (1, tan theta, tan phi). NaN for both where
    either is."""
    measured = np.asarray(measured, dtype=np.float64)
    flat = np.ascontiguousarray(measured.reshape(-1, 2))
    without_place = parameters.copy()
    without_place[:, X : Z + 1] = 0.0
    return _directions(flat, without_place).reshape(measured.shape)


@njit
def _directions(measured: np.ndarray, parameters: np.ndarray) -> np.ndarray:
    out, of = np.empty_like(measured), np.empty(0)
    for i in range(measured.shape[0]):
        y, z = math.tan(measured[i, 0]), math.tan(measured[i, 1])
        if parameters[0, GENERATION] == 2.0:
            first, second = parameters[:, PHASE]
            y, z = ideal_direction(measured[i, 0] + first, measured[i, 1] + second)
        for _ in range(12):
            t0, _, a, b = angle_gradient(0, 1.0, y, z, parameters[0], of)
            t1, _, c, d = angle_gradient(1, 1.0, y, z, parameters[1], of)
            e0, e1 = measured[i, 0] - t0, measured[i, 1] - t1
            det = a * d - b * c
            y += (d * e0 - b * e1) / det
            z += (a * e1 - c * e0) / det
            if abs(e0) + abs(e1) < 1e-13:
                break
        out[i, 0], out[i, 1] = math.atan(y), math.atan(z)
    return out
