"""Figures 3 and 5-8 of J: what they measure is what was put in."""

import numpy as np
import pytest
from calibration_inputs import CYCLE_S, FLASH_S, SLAVE_LATE_S, T_M, TURN, WIDTH_S

from calibration_inputs import angle_of, write_calibration  # isort: skip
from figure_data import check, check_saved, every_text
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import proj3d

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import read_table
from mocap_metrology.lighthouse.assess.calibration_files import read_calibration
from mocap_metrology.lighthouse.assess.signal import signal_of
from mocap_metrology.present.jansen import paths, space

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture(scope="module")
def calibration(tmp_path_factory):
    files = write_calibration(tmp_path_factory.mktemp("moving"))
    pulses, _ = read_table(files["pose"].with_name("pulses.parquet"))
    return read_calibration(files, "lab-1", "twin-7"), pulses


@pytest.fixture(scope="module")
def figures(calibration):
    return paths.jansen_figures(*calibration)


@pytest.mark.parametrize("number", [3, 5, 6, 7, 8])
def test_each_is_drawn_and_saved_whole(figures, tmp_path, number):
    texts = " ".join(every_text(figures[number]))
    assert f"Jansen et al. 2019, Figure {number}:" in texts
    assert "simulated stand-in (twin) twin-7" in texts
    check_saved(figures[number], tmp_path / "out")


def test_signal_has_the_times_put_in(calibration, figures):
    files, pulses = calibration
    signal = signal_of(pulses, files.sweeps)
    assert [(s.station, s.axis) for s in signal.sweeps] == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert len(signal.flashes) == 8 and {f[2] for f in signal.flashes[::2]} == {0}
    assert {f[2] for f in signal.flashes[1::2]} == {1}
    texts = [line for text in every_text(figures[3]) for line in text.split("\n")]
    for sweep in signal.sweeps:
        angle = float(angle_of(sweep.station, sweep.axis, np.zeros(1), np.array([signal.diode]))[0])
        assert sweep.angle_rad == pytest.approx(angle)
        assert sweep.delta_s == pytest.approx((angle / np.pi + 0.5) * CYCLE_S, abs=1e-9)
        assert f"$\\Delta t$ = {1e3 * sweep.delta_s:.3f} ms" in texts
        assert sweep.length_s == pytest.approx(WIDTH_S)
    assert {f"begins {1e6 * SLAVE_LATE_S:.1f} µs later", "slave's flash"} <= set(texts)
    assert f"{1e6 * FLASH_S:.1f} µs" in texts
    master = {k: v[files.sweeps["station"] == 0] for k, v in files.sweeps.items()}
    with pytest.raises(Refusal, match="no diode saw"):
        signal_of(pulses, master)


@pytest.mark.parametrize(
    ("point", "stretch"),
    [((2.0, -0.7, 0.9), True), ((3.0, 0.3, -0.4), True), ((2.0, 1.7, 1.9), False),
     ((3.8, -1.6, -1.6), False)],
)  # fmt: skip
def test_angles_are_those_of_the_definition(point, stretch):
    x, y, z = point
    drawn = space.angles_figure(np.array(point), "s")
    spherical = np.arcsin(z / np.linalg.norm(point))
    for name, value in ((r"\theta", np.arctan2(y, x)), (r"\phi'", np.arctan2(z, x)),
                        (r"\phi", spherical)):  # fmt: skip
        shown = f"${name}$ = {np.degrees(value):+.2f}°".replace("-", "−")
        assert sum(text.startswith(shown) for text in every_text(drawn)) == 1
    assert ("times as long" in drawn.caption) == stretch
    check(drawn)


def test_paths_and_pose_by_another_program(calibration, figures):
    master, slave = calibration[0].paths("paper", "ideal")
    after = TURN.apply(slave.t_m) + T_M + np.array([7.0, -3.0, 2.0]) / 1e3  # the Kabsch stage
    (axes,) = figures[8].figure.axes
    drawn = [np.column_stack(line.get_data_3d()) for line in axes.lines]
    drawn = [points for points in drawn if len(points) == len(after)]
    for points, true in zip(drawn, (master.t_m, after), strict=True):
        np.testing.assert_allclose(points, true, atol=1e-12)
    said = " ".join(every_text(figures[8]))
    assert "T = (+403.0, +1\N{NARROW NO-BREAK SPACE}992.0, +250.0) mm" in said
    assert "reference; from it T is off by (+6.0, −5.0, −1.0) mm" in said
    texts = every_text(figures[7])
    assert f"R, {np.degrees(np.linalg.norm(TURN.as_rotvec())):.1f}°" in texts
    (length,) = (t.split()[4] for t in texts if t.startswith("shift of the centroid, "))
    shift = np.linalg.norm((after - slave.t_m).mean(axis=0))
    assert float(length) == pytest.approx(shift, abs=0.03)


def test_projection_is_matplotlibs_and_arcs_are_those_of_scipy():
    axes = Figure().add_subplot(projection="3d", proj_type="ortho")
    axes.set(xlim=(0, 1), ylim=(0, 1), zlim=(0, 1), box_aspect=(1, 1, 1))
    points = np.random.default_rng(1).uniform(0, 1, (20, 3))
    for view in space.VIEWS:
        axes.view_init(view[1], view[0])
        x, y, _ = proj3d.proj_transform(*points.T, axes.get_proj())
        flat, known = space.flat(points, view), np.column_stack([x, y])
        scale = np.linalg.norm(known[1] - known[0]) / np.linalg.norm(flat[1] - flat[0])
        np.testing.assert_allclose(known - known[0], scale * (flat - flat[0]), atol=1e-9)
    way = space.arc(np.array([1.0, 0.0, 0.0]), TURN.as_matrix())
    np.testing.assert_allclose(way[-1], TURN.apply([1.0, 0.0, 0.0]), atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(way, axis=1), 1.0)
