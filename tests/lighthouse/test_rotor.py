"""The measurement model, its derivatives and its inverse: against its formula in numpy, each term
as the drivers state it, finite differences and scipy."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal
from mocap_metrology.lighthouse import rotation, rotor, timing
from mocap_metrology.lighthouse.decode.factory_file import FACTORY_NAMES
from mocap_metrology.lighthouse.records import Factory

FACTORY = Factory(
    *np.array([[0.05, 0.02], [-0.03, 0.02], [-0.04, 0.05], [1.9, -0.8], [0.02, 0.03]])
)
LASERS = np.array([[0.004, -0.006, 0.002], [-0.003, 0.005, 0.008]])
POINTS = np.array([[2.0, 0.8, -0.5], [3.0, -1.2, 0.9], [1.5, 0.1, 1.1], [4.0, -2.0, -1.5]])
CASES = [(name, lasers) for name in rotor.VARIANTS for lasers in (None, LASERS)]
NONE = np.empty(0)  # no derivatives by factory values


def by_hand(p: np.ndarray, axis: int, factory: Factory, lasers: object, variant: str) -> float:
    """theta of one point. libsurvive: + curve, gibbous term of the corrected angle, tilt itself;
    Astrobee: gibbous term of the corrected angle; Crazyflie: of the geometric angle."""
    x, y, z = p - (np.zeros(3) if lasers is None else lasers[axis])
    across, along = (y, z) if axis == 0 else (z, -y)
    u, v = np.arctan2(across, x), np.arctan2(along, x)
    phase, tilt, curve, gibphase, gibmag = (
        getattr(factory, name)[axis] for name in ("phase", "tilt", "curve", "gibphase", "gibmag")
    )
    slope = tilt if variant == "libsurvive" else np.tan(tilt)
    corrected = u - phase - np.arcsin(along * slope / np.hypot(x, across))
    of = u if variant == "crazyflie" else corrected
    bend = curve * v**2
    return corrected + gibmag * np.sin(of + gibphase) + (bend if variant == "libsurvive" else -bend)


def parameters(variant: str, lasers: object, factory: Factory = FACTORY) -> np.ndarray:
    return rotor.rotor_parameters(factory, lasers, rotor.VARIANTS[variant])


@pytest.mark.parametrize("only", [*FACTORY_NAMES, "all"])
@pytest.mark.parametrize(("variant", "lasers"), CASES)
def test_angles_by_hand_of_each_term_alone_and_of_all(variant, lasers, only) -> None:
    factory = FACTORY if only == "all" else Factory(**{only: getattr(FACTORY, only)})
    expected = [[by_hand(p, axis, factory, lasers, variant) for axis in (0, 1)] for p in POINTS]
    found = rotor.angles(POINTS, parameters(variant, lasers, factory))
    np.testing.assert_allclose(found, expected, atol=1e-14)


@pytest.mark.parametrize("factory", [FACTORY, None])
@pytest.mark.parametrize(("variant", "lasers"), CASES)
def test_gradients_are_those_of_finite_differences(variant, lasers, factory) -> None:
    rotors = rotor.rotor_parameters(factory, lasers, rotor.VARIANTS[variant])
    h = 1e-6
    for axis, p in ((axis, p) for axis in (0, 1) for p in POINTS):
        _, *gradient = rotor.angle_gradient(axis, *p, rotors[axis], NONE)
        ends = [
            [rotor.angle_gradient(axis, *(p + s * h * e), rotors[axis], NONE)[0] for e in np.eye(3)]
            for s in (1, -1)
        ]
        np.testing.assert_allclose(gradient, np.subtract(*ends) / (2 * h), atol=1e-9)


@pytest.mark.parametrize(("variant", "lasers"), CASES)
def test_gradient_by_the_factory_values(variant, lasers) -> None:
    """By tangent of the tilt, signed curve, and both parts of the gibbous term."""
    rotors, h, found = parameters(variant, lasers), 1e-6, np.empty(4)
    for axis, p in ((axis, p) for axis in (0, 1) for p in POINTS):
        rotor.angle_gradient(axis, *p, rotors[axis], found)
        for k, column in enumerate((rotor.TAN_TILT, rotor.CURVE, None, None)):
            ends = []
            for sign in (1, -1):
                row = rotors[axis].copy()
                if column is None:
                    part = row[rotor.GIBMAG] * np.exp(1j * row[rotor.GIBPHASE])
                    part += sign * h * (1, 1j)[k - 2]
                    row[rotor.GIBMAG], row[rotor.GIBPHASE] = np.abs(part), np.angle(part)
                else:
                    row[column] += sign * h
                ends.append(rotor.angle_gradient(axis, *p, row, NONE)[0])
            assert found[k] == pytest.approx((ends[0] - ends[1]) / (2 * h), abs=1e-8)


@pytest.mark.parametrize(("name", "limit"), [("phase", 0.3), ("tilt", 0.3), ("curve", 0.1)])
def test_values_of_no_first_generation_station_are_refused(name: str, limit: float) -> None:
    for value, refused in ((limit, False), (-limit, False), (1.001 * limit, True), (np.nan, True)):
        factory = replace(FACTORY, **{name: np.array([0.0, value])})
        if refused:
            with pytest.raises(Refusal, match=f"{name} is .* expected within"):
                rotor.rotor_parameters(factory)
        else:
            rotor.rotor_parameters(factory)


@given(st.tuples(*[st.floats(-3.1, 3.1)] * 3))
def test_rotations_are_those_of_scipy(angles: tuple[float, float, float]) -> None:
    a, b, c = angles[0], angles[1] / 2.1, angles[2]
    R = rotation.from_angles(a, b, c)
    scipy = Rotation.from_euler("ZYX", [c, b, a])
    np.testing.assert_allclose(R, scipy.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(rotation.to_angles(R), [a, b, c], atol=1e-6)
    v = scipy.as_rotvec()
    np.testing.assert_allclose(rotation.exp(v), R, atol=1e-12)
    np.testing.assert_allclose(rotation.exp(rotation.log(R)), R, atol=1e-12)
    np.testing.assert_allclose(
        rotation.error(rotation.exp(np.array([0.1, 0.2, -0.3])) @ R, R), [0.1, 0.2, -0.3], atol=1e-9
    )


def test_codes_of_flashes_are_the_published_ones() -> None:
    """vive-diy-position-sensor: length, skip, data and axis of each; 62.5 us to 135 us."""
    table = [  # ticks, skip, data, axis
        (3000, 0, 0, 0), (3500, 0, 0, 1), (4000, 0, 1, 0), (4500, 0, 1, 1),
        (5000, 1, 0, 0), (5500, 1, 0, 1), (6000, 1, 1, 0), (6500, 1, 1, 1),
    ]  # fmt: skip
    for code, (ticks, skip, data, axis) in enumerate(table):
        assert timing.flash_length(code) * 48e6 == pytest.approx(ticks)
        assert timing.code_of(axis, data, skip) == code
        found = timing.skip_of(code), timing.data_of(code), timing.axis_of(code)
        assert found == (skip, data, axis)
    assert pytest.approx(1 / 120) == timing.CYCLE_S
    assert pytest.approx(416.67e-6, abs=5e-9) == timing.SLAVE_OFFSET_S
