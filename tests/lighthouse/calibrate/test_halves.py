"""Parts of a recording: sound ones agree, before and after a bump they do not."""

import numpy as np
import pytest

from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.calibrate.weighted_station import by_gauss_newton, evidence, halves
from mocap_metrology.lighthouse.fit.board_pose import by_levenberg_marquardt
from mocap_metrology.lighthouse.records import Measurements
from mocap_metrology.lighthouse.rotation import exp
from mocap_metrology.lighthouse.rotor import angles, rotor_parameters

R, T = exp(np.array([0.05, -0.1, -1.2])), np.array([0.3, 2.4, -0.2])
ROTORS = rotor_parameters()


def seen(n: int, bump_m: np.ndarray, at: float, rng: np.random.Generator):
    """Evidence of a board carried on a curve, its path by the master's angles; 60 urad of noise."""
    board, time = flat_board(), np.linspace(0, 8, n)
    place = np.c_[2.6 + 0.3 * np.sin(time), 1.2 + 0.3 * np.cos(1.3 * time), 0.2 * np.sin(2 * time)]
    turn = [exp(np.array([0.2 * np.sin(t), 0.2 * np.cos(1.7 * t), 0.3 * np.sin(0.9 * t)]))
            for t in time]  # fmt: skip
    points = np.array([board @ r.T + p for r, p in zip(turn, place, strict=True)])
    there = T + np.where(time[:, None] < at, 0, bump_m)
    of_slave = (points - there[:, None]) @ R
    both = [
        angles(np.ascontiguousarray(p.reshape(-1, 3)), ROTORS).reshape(n, -1, 2)
        + 60e-6 * rng.normal(size=(n, len(board), 2))
        for p in (points, of_slave)
    ]
    master = Measurements(time, both[0])
    path = by_levenberg_marquardt(master, board, ROTORS)
    return evidence(path, Measurements(time, both[1]), master, board, ROTORS)


@pytest.mark.parametrize("at", [2.5, 4.0, 5.0])
def test_a_bump_shows_in_the_parts(at: float) -> None:
    """By its own size, 5 mm, where a split is near; sound recordings differ by chance."""
    rng = np.random.default_rng(int(10 * at))
    sound = [seen(200, np.zeros(3), at, rng) for _ in range(4)]
    bumped = [seen(200, 5e-3 * v, at, rng) for v in np.eye(3)]
    worst = []
    for given in (*sound, *bumped):
        pose_R, pose_t, _ = by_gauss_newton(R, T, given, ROTORS)
        worst.append(halves(pose_R, pose_t, given, ROTORS))
    assert max(one.m2 for one in worst[:4]) < 60
    assert min(one.m2 for one in worst[4:]) > 200
    if at == 4.0:
        assert all(one.mm == pytest.approx(5, abs=3) for one in worst[4:])


def test_nothing_is_said_of_too_little() -> None:
    given = seen(4, np.zeros(3), 4.0, np.random.default_rng(1))
    assert halves(R, T, given, ROTORS) is None
