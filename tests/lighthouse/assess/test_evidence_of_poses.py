"""What supports a calibration, of paths, hits and tracks made by hand."""

from __future__ import annotations

import math
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


def test_a_shift_and_a_turn_are_measured() -> None:
    time = np.arange(0.0, 4.0, 0.1)
    master = by_master(path(time, turn_deg=25.0), (0.003, 0, -0.004))
    found = evidence.agreement((master, path(time)), (TURN.as_matrix(), SHIFT))
    assert found.apart_mm == pytest.approx(5.0)
    assert found.turned_deg == pytest.approx(25.0)


def test_poses_that_one_station_alone_has() -> None:
    """Between the first and the last moment that both have."""
    time = np.arange(0.0, 4.0, 0.1)
    part = (time < 1.45) | (time > 2.45)
    found = evidence.agreement((by_master(path(time)), path(time[part])), (TURN.as_matrix(), SHIFT))
    alone = time[~part]
    assert np.isin(np.round(alone[1:-1], 6), np.round(found.alone_s[0], 6)).all()
    assert found.alone_s[1].size == 0
    none = evidence.agreement((by_master(path(time)), path(time + 9)), (TURN.as_matrix(), SHIFT))
    assert none.time_s.size == none.alone_s[0].size == none.alone_s[1].size == 0


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


def track(n: int, shake_mm: float, shake_deg: float) -> dict[str, np.ndarray]:
    """At rest, shaken along z and about x; the last pose is noisy and far off."""
    sign = (-1.0) ** np.arange(n)
    q = Rotation.from_rotvec(np.outer(np.radians(shake_deg) * sign, [1.0, 0, 0])).as_quat()
    out = {name: q[:, k] for k, name in enumerate(("qx", "qy", "qz", "qw"))}
    out |= {"x_mm": np.full(n, 3.0), "y_mm": np.full(n, 4.0), "z_mm": 5 + shake_mm * sign}
    out["z_mm"][-1] = 900.0
    noise = np.ones(n)
    noise[-1] = 2.5
    out |= {f"sd_noise_{a}_mm": k * noise for k, a in zip((2, 3, 6), "xyz", strict=True)}
    return out | {f"sd_r{a}_deg": k * noise for k, a in zip((1, 2, 2), "xyz", strict=True)}


def test_scatter_of_tracked_poses_that_are_settled() -> None:
    n = 21
    of = track(n, 0.5, 0.2)
    assert evidence.lengths(of, "noise", "mm")[:2].tolist() == [7.0, 7.0]
    assert evidence.lengths(of, "total", "deg")[0] == 3.0
    assert evidence.settled(of).tolist() == [True] * (n - 1) + [False]
    mm, deg = evidence.jitter(of)
    expected = math.sqrt((n - 1) / (n - 2))
    assert (mm, deg) == (pytest.approx(0.5 * expected), pytest.approx(0.2 * expected, rel=1e-6))
    off = evidence.deviations_mm(of)
    assert off[:2] == pytest.approx(np.array([[0, 0, 0.5], [0, 0, -0.5]]))


def test_of_one_settled_pose_no_scatter_is_known() -> None:
    assert all(map(math.isnan, evidence.jitter(track(1, 0.5, 0.2))))
    unknown = track(3, 0.5, 0.2) | {f"sd_noise_{a}_mm": np.full(3, np.nan) for a in "xyz"}
    assert not evidence.settled(unknown).any()
    assert evidence.deviations_mm(unknown)[0].tolist() == [3.0, 4.0, 5.5]
