"""Board poses: both minima of a flat board, statistics, boards in any frame."""

import numpy as np
import pytest

from mocap_metrology.lighthouse import rotation
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.fit.board_pose import (
    MIRRORED_RAD,
    START_M,
    angle_between,
    by_levenberg_marquardt,
    by_nelder_mead,
    first_guesses,
    upright,
)
from mocap_metrology.lighthouse.fit.levenberg_marquardt import PoseProblem, normal_equations
from mocap_metrology.lighthouse.fit.simplex import BOARD, TIGHT
from mocap_metrology.lighthouse.records import Measurements, Path
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters

SIGMA = 4e-5
IDEAL = rotor_parameters()


def poses(n: int, board: np.ndarray, seed: int, tilt: float = 0.3) -> tuple[Measurements, Path]:
    """n unrelated poses 2 to 6 m away, a tenth of the diodes unseen, and the truth."""
    rng = np.random.default_rng(seed)
    measured, R, t = np.empty((n, len(board), 2)), np.empty((n, 3, 3)), np.empty((n, 3))
    for i in range(n):
        d = np.array([1, *rng.uniform(-0.6, 0.6, 2)])
        t[i] = rng.uniform(2, 6) * d / np.linalg.norm(d)
        R[i] = upright(-t[i : i + 1])[0] @ rotation.exp(rng.normal(0, tilt, 3))
        measured[i] = angles(board @ R[i].T + t[i], IDEAL) + rng.normal(0, SIGMA, (len(board), 2))
    measured[rng.random(measured.shape[:2]) < 0.1] = np.nan
    time = np.arange(n) / 60
    truth = Path(time, R, t, np.zeros(n), np.zeros(n), np.zeros(n))
    return Measurements(time, measured), truth


BOARDS = {
    "flat": flat_board(),
    "uneven": flat_board() + np.outer(np.resize([0.01, -0.01, -0.01], 32), [1, 0, 0]),
    "solid": np.random.default_rng(0).uniform(-0.1, 0.1, (24, 3)),
}


@pytest.mark.parametrize("kind", BOARDS)
def test_poses_are_right_and_as_good_as_the_angles_allow(kind: str) -> None:
    """Cramer-Rao bound: sigma^2 (J^T J)^-1. Of 300 poses less than 1 % in the wrong minimum; the
    errors of the others over the bound's standard deviation have rms 1 within 6 %."""
    board = BOARDS[kind]
    given, truth = poses(300, board, seed=4)
    found = by_levenberg_marquardt(given, board, IDEAL)
    good = angle_between(found, truth) < MIRRORED_RAD
    assert good.mean() >= 0.99
    ratios = []
    H, g = np.empty((6, 6)), np.empty(6)
    for i in np.flatnonzero(good):
        seen = given.seen[i]
        own = np.ascontiguousarray(given.angles_rad[i, seen])
        normal_equations(
            truth.R[i], truth.t_m[i], PoseProblem(BOARD, board[seen], own, IDEAL), H, g
        )
        sd = SIGMA * np.sqrt(np.diag(np.linalg.inv(H)))
        error = np.r_[found.t_m[i] - truth.t_m[i], rotation.error(found.R[i], truth.R[i])]
        ratios.append(error / sd)
    assert np.sqrt(np.mean(np.square(ratios))) == pytest.approx(1, abs=0.06)


def test_first_guess_of_j() -> None:
    """In the direction of the mean angles, 3 m away, upright, x axis towards the station."""
    given, _ = poses(20, BOARDS["flat"], seed=6, tilt=0.1)
    R, t = first_guesses(given, BOARDS["flat"], START_M)
    mean = np.nanmean(given.angles_rad, axis=1)
    np.testing.assert_allclose(np.arctan2(t[:, 1], t[:, 0]), mean[:, 0], atol=1e-12)
    np.testing.assert_allclose(np.arctan2(t[:, 2], t[:, 0]), mean[:, 1], atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(t, axis=1), 3.0)
    np.testing.assert_allclose(R[:, :, 0], -t / 3, atol=1e-12)
    np.testing.assert_allclose(R[:, 2, 1], 0, atol=1e-12)


@pytest.mark.parametrize("turned", [(0, 0, np.pi / 2), (np.pi / 2, 0, 0), (0.3, np.pi / 2, 1.0)])
def test_a_board_may_lie_in_its_frame_as_it_likes(turned: tuple[float, ...]) -> None:
    """The paper's start fits any frame of the board: K_1 ends as low as in J's frame."""
    given, _ = poses(12, BOARDS["uneven"], seed=7, tilt=0.15)
    own = by_nelder_mead(given, BOARDS["uneven"], IDEAL, TIGHT)
    R = rotation.from_angles(*turned)
    other = by_nelder_mead(given, BOARDS["uneven"] @ R.T, IDEAL, TIGHT)
    good = own.epsilon < 1e-6
    assert good.mean() > 0.7
    assert (other.epsilon < 1e-6).mean() >= good.mean() - 0.15


def test_a_pose_of_diodes_on_a_line_does_not_spoil_the_others() -> None:
    """The first row of the board alone is seen, exactly on a line: others are as without it."""
    board = flat_board()
    given, _ = poses(8, board, seed=9)
    others = np.arange(8) != 3
    alone = by_levenberg_marquardt(
        Measurements(given.time_s[others], given.angles_rad[others]), board, IDEAL
    )
    given.angles_rad[3, np.abs(board[:, 2] - board[0, 2]) > 1e-9] = np.nan
    path = by_levenberg_marquardt(given, board, IDEAL)
    np.testing.assert_allclose(path.t_m[others], alone.t_m, atol=1e-6)
