"""Figures 3 and 5-8 of J: what they measure is what was put in."""

from __future__ import annotations

import dataclasses
from itertools import combinations

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
from figure_data import check, check_saved, every_text
from matplotlib.backends.backend_agg import FigureCanvasAgg
from mpl_toolkits.mplot3d import proj3d
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import read_table
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.records import ROLES
from mocap_metrology.present.calibration.calibration_files import read_calibration
from mocap_metrology.present.jansen.angles import angles_figure
from mocap_metrology.present.jansen.jansen_figures import NUMBERS, jansen_figures
from mocap_metrology.present.jansen.paths import (
    Superposed,
    paths_figure,
    slave_figure,
    superposition_figure,
)
from mocap_metrology.present.jansen.signal import signal_of
from mocap_metrology.present.jansen.space import VIEWS, View, arc, clearest, outline
from mocap_metrology.present.plot.figure import styled

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
    assert any(f"Jansen et al. 2019, Figure {number}:" in text for text in texts)
    assert any("simulated stand-in (twin) twin-7" in text for text in texts)
    check_saved(figures[number], tmp_path / "out")


def test_signal_has_the_times_put_in(given, figures):
    calibration, pulses = given
    signal = signal_of(pulses, calibration.sweeps)
    assert [(s.station, s.axis) for s in signal.sweeps] == [(0, 0), (0, 1), (1, 0), (1, 1)]
    assert len(signal.flashes) == 8 and {f[2] for f in signal.flashes[::2]} == {0}
    texts = [line for text in every_text(figures[3]) for line in text.split("\n")]
    for sweep in signal.sweeps:
        angle = float(angle_of(sweep.station, sweep.axis, np.zeros(1), np.array([signal.diode]))[0])
        assert sweep.angle_rad == pytest.approx(angle)
        assert sweep.delta_s == pytest.approx((angle / np.pi + 0.5) * CYCLE_S, abs=1e-9)
        assert f"$\\Delta t$ = {1e3 * sweep.delta_s:.3f} ms" in texts
        assert sweep.length_s == pytest.approx(WIDTH_S)
    assert f"begins {1e6 * SLAVE_LATE_S:.1f} µs later" in texts
    assert "slave's flash" in texts and f"{1e6 * FLASH_S:.1f} µs" in texts


def test_signal_wants_every_sweep(given):
    calibration, pulses = given
    only_master = {k: v[calibration.sweeps["station"] == 0] for k, v in calibration.sweeps.items()}
    with pytest.raises(Refusal, match="no diode saw"):
        signal_of(pulses, only_master)


def test_angles_are_those_of_the_definition():
    point = np.array([2.0, -0.7, 0.9])
    drawn = angles_figure(point, "t", "s")
    texts = every_text(drawn)
    theta = np.degrees(np.arctan2(point[1], point[0]))
    projected = np.degrees(np.arctan2(point[2], point[0]))
    spherical = np.degrees(np.arcsin(point[2] / np.linalg.norm(point)))
    for name, value in ((r"\theta", theta), (r"\phi'", projected), (r"\phi", spherical)):
        shown = f"${name}$ = {value:+.2f}°".replace("-", "−")
        assert sum(text.startswith(shown) for text in texts) == 1
    assert "times as long" in angles_figure(np.array([3.0, 0.3, 0.4]), "t", "s").caption
    assert "times as long" not in angles_figure(np.array([2.0, -1.7, 1.9]), "t", "s").caption


@pytest.mark.parametrize("y", [-0.5, 0.5])
@pytest.mark.parametrize("z", [-0.6, 0.6])
def test_angles_in_every_quarter(tmp_path, y, z):
    check_saved(angles_figure(np.array([3.0, y, z]), "t", "s"), tmp_path / "out")


def test_paths_and_pose_by_another_program(given, figures):
    calibration, _ = given
    master, slave = calibration.paths("paper", "ideal")
    off = T_M + np.array([7.0, -3.0, 2.0]) / 1e3  # the Kabsch stage drawn
    after = TURN.apply(slave.t_m) + off
    (axes,) = figures[8].figure.axes
    drawn = [np.column_stack(line.get_data_3d()) for line in axes.lines]
    drawn = [points for points in drawn if len(points) == len(after)]
    for points, true in zip(drawn, (master.t_m, after), strict=True):
        np.testing.assert_allclose(points, true, atol=1e-12)
    said = " ".join(every_text(figures[8]))
    assert "T = (+403.0, +1\N{NARROW NO-BREAK SPACE}992.0, +250.0) mm" in said
    assert "reference; from it T is off by (+6.0, −5.0, −1.0) mm" in said
    turn = np.degrees(np.linalg.norm(TURN.as_rotvec()))
    assert f"R, {turn:.1f}°" in every_text(figures[7])
    named = "shift of the centroid, "
    told = next(t for t in every_text(figures[7]) if t.startswith(named))
    shift = (TURN.apply(slave.t_m) + off - slave.t_m).mean(axis=0)
    assert float(told.removeprefix(named).split()[0]) == pytest.approx(
        np.linalg.norm(shift), abs=0.03
    )
    assert "T" not in every_text(figures[7])  # it is that of Figure 8


def posed(given, turn, t, off=(0.0, 0.0, 0.0), share=0.67):
    """The slave elsewhere: its path so that both agree; the reference by an offset."""
    calibration, _ = given
    master, _ = calibration.paths("paper", "ideal")
    R = turn.as_matrix()
    slave = dataclasses.replace(master, t_m=(master.t_m - t) @ R, R=R.T @ master.R)
    pose, true = (R, np.asarray(t)), (R, np.asarray(t) + off)
    return Superposed((master, slave), calibration.board, pose, true, "A label.", share)


def boxes_of(picture):
    """Names in the first axes of a figure and their boxes on the page."""
    picture.figure.set_dpi(80)
    canvas = FigureCanvasAgg(picture.figure)
    with styled():
        canvas.draw()
        texts = picture.figure.axes[0].texts
        return [(t.get_text(), t.get_window_extent(canvas.get_renderer())) for t in texts]


def on_page(axes, points):
    """Where points (n, 3) are on the page, in pixels."""
    x, y, _ = proj3d.proj_transform(*np.asarray(points).T, axes.get_proj())
    return axes.transData.transform(np.column_stack([x, y]))


@pytest.mark.parametrize("seed", range(8))
def test_axes_and_letters_of_any_pose_are_on_the_page_and_apart(given, seed):
    rng = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(rng.uniform(-1.5, 1.5, 3))
    t = rng.uniform([-1, -3, -0.5], [2, 3, 2.5])
    picture = slave_figure(posed(given, turn, t, rng.uniform(-0.3, 0.3, 3)), "t", "s")
    check(picture)
    named = [(s, box) for s, box in boxes_of(picture) if s in ("x", "y", "z", "T", *ROLES)]
    assert len(named) == 9
    (axes,) = picture.figure.axes
    low, high = picture.figure.bbox.min, picture.figure.bbox.max
    for line in axes.lines:
        if len(line.get_data_3d()[0]):
            points = on_page(axes, np.column_stack(line.get_data_3d()))
            assert (points >= low).all() and (points <= high).all()
    for (one, a), (other, b) in combinations(named, 2):
        assert not a.padded(-1).overlaps(b.padded(-1)), (one, other)


def test_the_master_on_the_way_of_T_keeps_its_letter(given):
    """T along the master's y axis, as in the paper: its y stands beside, not on the arrow."""
    t = np.array([0.0, 3.0, 0.0])
    picture = slave_figure(posed(given, TURN, t), "t", "s")
    boxes = boxes_of(picture)  # sets the resolution
    way = on_page(picture.figure.axes[0], np.linspace(0, 1, 200)[:, None] * t)
    for text, box in boxes:
        if text in ("x", "y", "z", "master", "slave", "T"):
            assert not any(box.padded(-1).contains(*at) for at in way), text


def test_enlarged_panels_count_what_they_leave_out(given):
    scattered = posed(given, TURN, np.array([0.4, 2.0, 0.2]))
    master, slave = scattered.paths
    wild = master.t_m.copy()
    wild[::60] += [0.5, 1.5, 1.0]
    scattered = dataclasses.replace(scattered, paths=(dataclasses.replace(master, t_m=wild), slave))
    outside = len(wild[::60])
    for draw, n_panels in ((paths_figure, 1), (superposition_figure, 2)):
        picture = draw(scattered, "t", "s")
        check(picture)
        assert picture.caption.count(f"{outside} dots are outside of") == n_panels
        assert "67 % here" in picture.caption
        whole, *near = picture.figure.axes
        for axes in near:
            ranges = [np.ptp(getattr(axes, f"get_{k}lim")()) for k in "xyz"]
            own = [np.ptp(getattr(whole, f"get_{k}lim")()) for k in "xyz"]
            assert max(ranges) < max(own)
            boxed = axes.get_box_aspect() if axes._box_aspect is None else axes._box_aspect
            np.testing.assert_allclose(
                boxed / np.linalg.norm(boxed), ranges / np.linalg.norm(ranges)
            )


@pytest.mark.parametrize("point", [(3.441, -0.595, 0.59), (3.81, 1.53, 1.124), (3, 0.5, -0.6)])
def test_names_of_figure_5_keep_off_its_lines(point):
    picture = angles_figure(np.array(point), "t", "s")
    (axes,) = picture.figure.axes
    boxes = [(s, box) for s, box in boxes_of(picture) if s]
    assert len(boxes) == 8
    for (one, a), (other, b) in combinations(boxes, 2):
        assert not a.padded(-1).overlaps(b.padded(-1)), (one, other)
    for line in [line for line in axes.lines if line.get_linestyle() in ("-", "--")]:
        points = np.column_stack(line.get_data_3d())
        if len(points) < 2:
            continue
        steps = np.linspace(0, len(points) - 1, 400)
        way = np.column_stack([np.interp(steps, range(len(points)), v) for v in points.T])
        for text, box in boxes:
            inside = [box.padded(-1.5).contains(*at) for at in on_page(axes, way)]
            assert not any(inside), text


def test_projection_and_arcs():
    view = View(200.0, 30.0)
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


def test_the_view_on_the_page_is_matplotlibs():
    from matplotlib.figure import Figure

    axes = Figure().add_subplot(projection="3d", proj_type="ortho")
    axes.set(xlim=(0, 1), ylim=(0, 1), zlim=(0, 1), box_aspect=(1, 1, 1))
    points = np.random.default_rng(1).uniform(0, 1, (20, 3))
    for view in VIEWS:
        axes.view_init(view.elevation_deg, view.azimuth_deg)
        x, y, _ = proj3d.proj_transform(*points.T, axes.get_proj())
        flat = view.flat(points)
        known = np.column_stack([x, y])
        scale = np.linalg.norm(known[1] - known[0]) / np.linalg.norm(flat[1] - flat[0])
        np.testing.assert_allclose(known - known[0], scale * (flat - flat[0]), atol=1e-9)


def test_the_clearest_view_keeps_points_apart():
    ends = np.array([[0.0, 0, 0], [1.0, 0, 0], [0, 1.0, 0]])
    view = clearest(ends)
    apart = [
        min(np.linalg.norm(a - b) for a, b in combinations(one.flat(ends), 2)) for one in VIEWS
    ]
    assert apart[VIEWS.index(view)] == max(apart)
