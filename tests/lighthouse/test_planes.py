"""The model of the second generation: against its formula in numpy, closed forms of two tilted
planes, and finite differences."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import planes, rotor
from mocap_metrology.lighthouse.records import Factory

FACTORY = Factory(
    *np.array([[0, -0.0047], [-0.0493, 0.046], [-0.36, 0.42], [1.83, 1.9], [-0.0087, 0.0071]]),
    *np.array([[1.57, 0.8], [-0.68, 0.28]]),
    generation=2,
)
TILTED = Factory(phase=FACTORY.phase, tilt=FACTORY.tilt, generation=2)
IDEAL = Factory(generation=2)
POINTS = np.array([[2, 0.8, -0.5], [3, -1.2, 0.9], [1.5, 0.1, 0.8], [4, -2, -1.5], [1, 2, 0.3]])
VARIANTS = ("libsurvive", "crazyflie")
COLUMNS = (rotor.TAN_TILT, rotor.CURVE)
PARTS = ((rotor.GIBMAG, rotor.GIBPHASE), (rotor.OGEEMAG, rotor.OGEEPHASE))
KERNEL = [7.6069798e-3, 5.3685255e-6, 2.8679863e-3, -8.0108022e-6]


def by_hand(p: np.ndarray, plane: int, of: Factory, variant: str) -> float:
    """theta of a point as the drivers compute it, libsurvive in its own axes and with its sines."""
    phase, tilt, curve, g, gib, o, ogee = (
        getattr(of, name)[plane]
        for name in ("phase", "tilt", "curve", "gibphase", "gibmag", "ogeephase", "ogeemag")
    )
    A = (np.pi / 6 if plane == 0 else -np.pi / 6) + tilt
    if variant == "crazyflie":
        u = np.arctan2(p[1], p[0])
        a = p[2] * np.tan(A) / np.hypot(p[0], p[1])
        return u - phase - np.arcsin(a) + gib * np.cos(u + g)
    X, Y, Z = -p[1], p[2], -p[0]
    B = np.arctan2(-Z, X)  # u + pi/2
    asin_arg = np.tan(A) * Y / np.hypot(X, Z)
    sine = Y / np.linalg.norm(p) / np.cos(A)
    s = np.arcsin(sine)
    m = sum(c * s ** (n + 2) for n, c in enumerate(KERNEL))
    d = sum((n + 2) * c * s ** (n + 1) for n, c in enumerate(KERNEL))
    k = curve + ogee * np.sin(B - np.arcsin(asin_arg) + o)
    angle = B - np.arcsin(asin_arg + m * k / (np.cos(A) - d * k * np.sin(A)))
    return angle + gib * np.sin(angle + g) - phase - np.pi / 2


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("factory", [FACTORY, TILTED, IDEAL])
def test_angles_by_hand(factory: Factory, variant: str) -> None:
    rows = rotor.rotor_parameters(factory, None, rotor.VARIANTS[variant])
    expected = [[by_hand(p, plane, factory, variant) for plane in (0, 1)] for p in POINTS]
    np.testing.assert_allclose(rotor.angles(POINTS, rows), expected, atol=1e-14)


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("factory", [FACTORY, IDEAL])
def test_derivatives_are_those_of_finite_differences(factory: Factory, variant: str) -> None:
    """By the point, tilt, curve, and both parts of gibbous and ogee."""
    rows, h = rotor.rotor_parameters(factory, None, rotor.VARIANTS[variant]), 1e-6
    for plane, p in ((plane, p) for plane in (0, 1) for p in POINTS):
        of, row = np.zeros(6), rows[plane]
        _, *by_point = planes.plane_gradient(plane, *p, row, of)

        def at(point: np.ndarray, own: np.ndarray, plane: int = plane) -> float:
            return planes.plane_gradient(plane, *point, own, np.zeros(6))[0]

        differences = [(at(p + h * e, row) - at(p - h * e, row)) / (2 * h) for e in np.eye(3)]
        np.testing.assert_allclose(by_point, differences, atol=2e-9)
        ends = []
        for sign in (h, -h):
            for column in COLUMNS:
                moved = row.copy()
                moved[column] += sign
                ends.append(at(p, moved))
            for size, phase in PARTS:
                for part in (1, 1j):
                    moved = row.copy()
                    value = row[size] * np.exp(1j * row[phase]) + sign * part
                    moved[size], moved[phase] = np.abs(value), np.angle(value)
                    ends.append(at(p, moved))
        found = (np.array(ends[:6]) - ends[6:]) / (2 * h)
        if variant == "crazyflie":
            found[[1, 4, 5]] = 0.0
        np.testing.assert_allclose(of, found, atol=2e-9)


@pytest.mark.parametrize("variant", VARIANTS)
@given(st.floats(-1.2, 1.2), st.floats(-0.7, 0.7))
def test_directions_behind_a_pair_of_angles(variant: str, azimuth: float, slope: float) -> None:
    """Over the field of view: the fan reaches 45 deg of elevation, however far aside."""
    point = np.array([[np.cos(azimuth), np.sin(azimuth), slope]])
    rows = rotor.rotor_parameters(FACTORY, None, rotor.VARIANTS[variant])
    expected = np.arctan2(point[:, 1:], point[:, :1])
    found = rotor.directions(rotor.angles(point, rows), rows)
    np.testing.assert_allclose(found, expected, atol=1e-11)


def test_values_of_no_second_generation_station_are_refused() -> None:
    for name, limit in planes.LIMITS.items():
        rotor.rotor_parameters(replace(FACTORY, **{name: np.array([0.0, -limit])}))
        for value in (1.001 * limit, np.nan):
            wrong = replace(FACTORY, **{name: np.array([0.0, value])})
            with pytest.raises(Refusal, match=f"{name} is .* second-generation"):
                rotor.rotor_parameters(wrong)
