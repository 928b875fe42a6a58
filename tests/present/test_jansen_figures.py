"""Figures 3 and 5-8 of J: what they measure is what was put in."""

from __future__ import annotations

import numpy as np
import pytest
from calibration_inputs import (
    CYCLE_S,
    FLASH_S,
    SLAVE_LATE_S,
    T_M,
    TURN,
    WIDTH_S,
    angle_of,
    write_calibration,
)
from figure_data import check_saved, every_text
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import read_table
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.present.calibration.data import read_calibration
from mocap_metrology.present.jansen.angles import angles_figure
from mocap_metrology.present.jansen.figures import NUMBERS, jansen_figures
from mocap_metrology.present.jansen.signal import signal_of
from mocap_metrology.present.jansen.space import Projection, arc, outline

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture(scope="module")
def given(tmp_path_factory):
    files = write_calibration(tmp_path_factory.mktemp("moving"))
    pulses, _ = read_table(files["pose"].with_name("pulses.parquet"))
    return read_calibration(files, "lab-1", "twin-7"), pulses


@pytest.fixture(scope="module")
def figures(given):
    return jansen_figures(*given)


@pytest.mark.parametrize("number", NUMBERS)
def test_each_is_drawn_and_saved_whole(figures, tmp_path, number):
    texts = every_text(figures[number])
    assert any(f"J Figure {number}:" in text for text in texts)
    assert any("Simulated (twin twin-7)" in text for text in texts)
    check_saved(figures[number], tmp_path / "out")


def test_signal_has_the_times_put_in(given, figures):
    calibration, pulses = given
    signal = signal_of(pulses, calibration.sweeps)
    assert [(s.station, s.axis) for s in signal.sweeps] == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert len(signal.flashes) == 8 and {f[2] for f in signal.flashes[::2]} == {0}
    texts = every_text(figures[3])
    for sweep in signal.sweeps:
        angle = float(angle_of(sweep.station, sweep.axis, np.zeros(1), np.array([signal.diode]))[0])
        assert sweep.angle_rad == pytest.approx(angle)
        assert sweep.delta_s == pytest.approx((angle / np.pi + 0.5) * CYCLE_S, abs=1e-9)
        assert f"Δt = {1e3 * sweep.delta_s:.3f} ms" in texts
        assert sweep.length_s == pytest.approx(WIDTH_S)
    assert f"begins {1e6 * SLAVE_LATE_S:.1f} µs later" in texts
    assert f"slave's flash\n{1e6 * FLASH_S:.1f} µs" in texts


def test_signal_wants_every_sweep(given):
    calibration, pulses = given
    only_master = {k: v[calibration.sweeps["station"] == 0] for k, v in calibration.sweeps.items()}
    with pytest.raises(Refusal, match="no diode saw"):
        signal_of(pulses, only_master)


def test_angles_are_those_of_the_definition():
    point = np.array([2.0, -0.7, 0.9])
    texts = every_text(angles_figure(point, "t"))
    theta = np.degrees(np.arctan2(point[1], point[0]))
    projected = np.degrees(np.arctan2(point[2], point[0]))
    spherical = np.degrees(np.arcsin(point[2] / np.linalg.norm(point)))
    for name, value in (("θ", theta), ("φ′", projected), ("φ", spherical)):
        assert f"{name} = {value:+.2f}°".replace("-", "−") in texts
    assert not any("times as long" in t for t in texts if "drawn" in t and "1 times" in t)


@pytest.mark.parametrize("y", [-0.5, 0.5])
@pytest.mark.parametrize("z", [-0.6, 0.6])
def test_angles_in_every_quarter(tmp_path, y, z):
    check_saved(angles_figure(np.array([3.0, y, z]), "t"), tmp_path / "out")


def test_paths_and_pose_by_another_program(given, figures):
    calibration, _ = given
    master, slave = calibration.paths("paper", "ideal")
    off = T_M + np.array([7.0, -3.0, 2.0]) / 1e3  # the Kabsch stage drawn
    after = TURN.apply(slave.t_m) + off
    drawn = [line.get_xydata() for axes in figures[8].axes for line in axes.lines]
    drawn = [points for points in drawn if len(points) == len(after)]
    assert len(drawn) == 2
    views = [
        Projection(a, e) for a in (200, 215, 230, 245, 115, 130, 145, 160) for e in (20, 28, 36)
    ]
    for points, true in zip(drawn, (master.t_m, after), strict=True):
        assert min(np.abs(points - view.flat(true)).max() for view in views) < 1e-12
    said = " ".join(every_text(figures[8]))
    assert "T = (+403.0, +1\N{NARROW NO-BREAK SPACE}992.0, +250.0) mm" in said
    assert "less the reference: (+6.0, −5.0, −1.0) mm" in said
    turn = np.degrees(np.linalg.norm(TURN.as_rotvec()))
    assert f"R, {turn:.1f}°" in every_text(figures[7])
    centre_moved = next(t for t in every_text(figures[7]) if t.startswith("T, "))
    T = (TURN.apply(slave.t_m) + off - slave.t_m).mean(axis=0)
    assert float(centre_moved.split()[1]) == pytest.approx(np.linalg.norm(T), abs=0.03)


def test_projection_and_arcs():
    view = Projection(200.0, 30.0)
    points = np.eye(3)
    a, e = np.radians([200.0, 30.0])
    to_viewer = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    flat = view.flat(points)
    depth = points @ to_viewer
    np.testing.assert_allclose((flat**2).sum(axis=1) + depth**2, 1.0)
    np.testing.assert_allclose(view.flat(to_viewer), 0.0, atol=1e-12)
    way = arc(np.array([1.0, 0.0, 0.0]), TURN.as_matrix())
    np.testing.assert_allclose(way[-1], TURN.apply([1.0, 0.0, 0.0]), atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(way, axis=1), 1.0)


def test_outline_of_a_turned_board():
    turn = Rotation.from_euler("xyz", [20, 30, 40], degrees=True)
    corners = turn.inv().apply(outline(turn.apply(flat_board())))
    found = sorted(map(tuple, np.round(corners, 9)))
    assert np.allclose(found, sorted([(0, y, z) for y in (-0.12, 0.12) for z in (-0.08, 0.08)]))
