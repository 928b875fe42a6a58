"""What supports a calibration, of paths, hits and tracks made by hand."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mocap_metrology.lighthouse.assess import calibration_files as evidence
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.records import Path

TURN, SHIFT = Rotation.from_rotvec([0.2, -0.4, 1.1]), np.array([1.0, -2.0, 0.5])


def path(time_s: np.ndarray, turn_deg: float = 0.0) -> Path:
    """Of a board that goes along y and turns about z, in the frame of the slave."""
    t = np.column_stack([3 + 0 * time_s, time_s, 0 * time_s])
    R = Rotation.from_rotvec(np.outer(0.3 * time_s + np.radians(turn_deg), [0, 0, 1])).as_matrix()
    n = np.arange(time_s.size)
    return Path(time_s, R, t, 4e-8 * n, n, np.full(n.size, np.inf))


def by_master(of: Path, off_m: tuple[float, float, float] = (0, 0, 0)) -> Path:
    R = TURN.as_matrix()
    return replace(of, R=R @ of.R, t_m=of.t_m @ R.T + SHIFT + off_m)


def test_both_paths_agree_where_the_pose_is_right() -> None:
    time = np.arange(0.0, 4.0, 0.1)
    slave = path(time)
    master = by_master(path(time + 0.05))
    found = evidence.agreement((master, slave), (TURN.as_matrix(), SHIFT))
    assert found.time_s.tolist() == pytest.approx((time[:-1] + 0.05).tolist())
    assert found.apart_mm.max() < 1e-6
    assert found.turned_deg.max() < 1e-4
    assert not found.mirrored.any()
    assert found.slave_m == pytest.approx(found.master_m)


def test_residual_of_a_pose_is_of_one_angle() -> None:
    """sqrt(4e-8 k / k) rad; a pose without angles has none."""
    assert evidence.residuals_urad(path(np.arange(4.0))) == pytest.approx([0, 200, 200, 200])


def test_shares_of_the_sweeps_that_a_diode_saw() -> None:
    """Of two stations with 4 and 2 sweeps; a second hit of a sweep on a diode counts once."""
    rows = [(0, 0, 0), (0, 0, 1), (0, 0, 1), (0, 3, 0), (0, 5, 0), (0, 8, 2), (1, 1, 2), (1, 2, 2)]
    station, cycle, diode = np.array(rows).T
    found = evidence.seen_shares({"station": station, "cycle": cycle, "diode": diode}, 4, 2)
    assert found.tolist() == [[0.75, 0.25, 0.25, 0.0], [0, 0, 1.0, 0]]


def test_diodes_that_are_dead_hidden_or_seldom_seen() -> None:
    shares = np.full((2, 8), 0.8)
    shares[:, 1] = 0.005
    shares[0, 2], shares[0, 3], shares[0, 4] = 0.009, 0.39, 0.41
    flat = evidence.faint_diodes(shares, flat_board(4, 2), 0)
    assert {k: v.tolist() for k, v in flat.items()} == {"dead": [1], "not seen": [2], "seldom": [3]}
    deep = flat_board(4, 2) + np.outer(np.arange(8) % 2, [0.02, 0, 0])
    found = evidence.faint_diodes(shares, deep, 0)
    assert {k: v.tolist() for k, v in found.items()} == {
        "dead": [], "not seen": [1, 2], "seldom": [3]
    }  # fmt: skip
    dark = evidence.faint_diodes(0 * shares, flat_board(4, 2), 1)
    assert {k: v.size for k, v in dark.items()} == {"dead": 0, "not seen": 8, "seldom": 0}
