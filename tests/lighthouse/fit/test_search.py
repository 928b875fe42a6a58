"""Costs, derivatives and both searches, against numpy, finite differences and scipy."""

import numpy as np
import pytest
from scipy.optimize import least_squares, minimize
from scipy.spatial.transform import Rotation

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.fit.levenberg_marquardt import PoseProblem, minimise, turn
from mocap_metrology.lighthouse.fit.simplex import (
    BOARD,
    MATLAB,
    STATION,
    TIGHT,
    evaluate,
    nelder_mead,
    seen_at,
)
from mocap_metrology.lighthouse.records import Factory
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters

BOARD_M = flat_board()
AWAY = np.array([3.0, 0, 0])
POSE = np.array([3.1, 0.5, -0.4, 0.2, -0.15, np.pi - 0.25])
FACTORY = Factory(
    np.array([0.05, 0.024]), np.array([-0.009, 0.001]), np.array([-0.004, -0.0015]),
    np.array([1.86, -0.79]), np.array([0.011, -0.011]),
)  # fmt: skip
LASERS = np.array([[0.01, 0.005, -0.02], [-0.015, 0.01, 0.02]])
ROTORS = {
    "ideal": rotor_parameters(),
    "lasers": rotor_parameters(None, LASERS),
    "factory": rotor_parameters(FACTORY, LASERS),
}


def points_of(pose: np.ndarray, unknown: int) -> np.ndarray:
    """Diodes in the station's frame at a pose of the board or of the station."""
    R, t = rotation.from_angles(*pose[3:]), pose[:3]
    return BOARD_M @ R.T + t if unknown == BOARD else (BOARD_M + AWAY - t) @ R


def case(unknown: int, optics: str, noise: float = 4e-5):
    pose = POSE if unknown == BOARD else np.array([0.2, 0.5, -0.2, 0.1, -0.1, -0.15])
    points = BOARD_M if unknown == BOARD else BOARD_M + AWAY
    measured = angles(points_of(pose, unknown), ROTORS[optics])
    return pose, points, measured + np.random.default_rng(3).normal(0, noise, measured.shape)


@pytest.mark.parametrize("settings", [MATLAB, TIGHT])
@pytest.mark.parametrize("start", [0.02, 0.3])
def test_the_simplex_takes_the_same_steps_as_scipy(settings, start: float) -> None:
    pose, points, measured = case(BOARD, "lasers")
    x0 = pose * (1 - start)
    x0[4] = 0.0  # where the first simplex takes 0.00025
    given = seen_at(BOARD, points, measured, ROTORS["lasers"])
    ours = nelder_mead(x0, given, settings)
    peer = minimize(
        lambda x: evaluate(x, given),
        x0,
        method="Nelder-Mead",
        options={
            "xatol": settings.tol_x,
            "fatol": settings.tol_fun,
            "maxfev": settings.evaluations,
            "maxiter": 10**6,
        },
    )
    np.testing.assert_allclose(ours[0], peer.x, rtol=0, atol=1e-12)
    assert ours[1] == pytest.approx(peer.fun)
    assert ours[2] == peer.nfev


def test_a_rotation_vector_turns_as_scipys() -> None:
    R = rotation.from_angles(*POSE[3:])
    for size in (0.0, 1e-9, 1e-7, 1e-3, 1.0, 3.0):
        w = size * np.array([0.6, -0.48, 0.64])
        np.testing.assert_allclose(turn(w, R), Rotation.from_rotvec(w).as_matrix() @ R, atol=1e-9)


@pytest.mark.parametrize("optics", ROTORS)
@pytest.mark.parametrize("unknown", [BOARD, STATION])
def test_minimum_is_that_of_scipy(unknown: int, optics: str) -> None:
    pose, points, measured = case(unknown, optics)
    rotors = ROTORS[optics]
    start = pose + np.array([0.1, 0.05, -0.05, 0.05, 0.04, -0.05])

    def residuals(x: np.ndarray) -> np.ndarray:
        own = np.ascontiguousarray(points_of(x, unknown))
        return (angles(own, rotors) - measured).ravel()

    peer = least_squares(residuals, start, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    R, t, cost, converged = minimise(
        rotation.from_angles(*start[3:]), start[:3], PoseProblem(unknown, points, measured, rotors)
    )
    assert converged
    assert cost == pytest.approx(2 * peer.cost, rel=1e-9)
    np.testing.assert_allclose(t, peer.x[:3], atol=2e-6)
    np.testing.assert_allclose(R, rotation.from_angles(*peer.x[3:]), atol=2e-6)
