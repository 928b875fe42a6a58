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
from matplotlib.colors import to_rgb
from scipy.spatial.transform import Rotation

from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import read_table
from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.records import ROLES
from mocap_metrology.present.calibration.calibration_files import read_calibration
from mocap_metrology.present.drawing.style import INK, styled
from mocap_metrology.present.jansen.jansen_figures import NUMBERS, jansen_figures
from mocap_metrology.present.jansen.paths import (
    Superposed,
    paths_figure,
    slave_figure,
    superposition_figure,
)
from mocap_metrology.present.jansen.projection import Ground, Projection, arc, outline
from mocap_metrology.present.jansen.signal import angles_figure, signal_of

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
    named = "shift of the centroid, "
    told = next(t for t in every_text(figures[7]) if t.startswith(named))
    shift = (TURN.apply(slave.t_m) + off - slave.t_m).mean(axis=0)
    assert float(told.removeprefix(named).split()[0]) == pytest.approx(
        np.linalg.norm(shift), abs=0.03
    )
    assert not any(t.startswith("T") for t in every_text(figures[7]))  # T is that of Figure 8


def posed(given, turn, t, off=(0.0, 0.0, 0.0), share=0.67):
    """The slave elsewhere: its path so that both agree; the reference by an offset."""
    calibration, _ = given
    master, _ = calibration.paths("paper", "ideal")
    R = turn.as_matrix()
    slave = dataclasses.replace(master, t_m=(master.t_m - t) @ R, R=R.T @ master.R)
    pose, true = (R, np.asarray(t)), (R, np.asarray(t) + off)
    return Superposed((master, slave), calibration.board, pose, true, "A label.", share)


def boxes_of(figure):
    """Names of a figure's largest axes and their boxes on the page."""
    figure.set_dpi(80)
    canvas = FigureCanvasAgg(figure)
    with styled():
        canvas.draw()
        texts = [t for axes in figure.axes for t in axes.texts]
        return [(t.get_text(), t.get_window_extent(canvas.get_renderer())) for t in texts]


@pytest.mark.parametrize("seed", range(8))
def test_axes_and_letters_of_any_pose_are_on_the_page_and_apart(given, seed):
    rng = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(rng.uniform(-1.5, 1.5, 3))
    t = rng.uniform([-1, -3, -0.5], [2, 3, 2.5])
    figure = slave_figure(posed(given, turn, t, rng.uniform(-0.3, 0.3, 3)), "t")
    check(figure)
    drawing = max(figure.axes, key=lambda axes: axes.bbox.height)
    low, high = (np.array(v) for v in zip(drawing.get_xlim(), drawing.get_ylim(), strict=True))
    for line in drawing.lines:
        assert (line.get_xydata() >= low).all() and (line.get_xydata() <= high).all()
    for arrow in drawing.texts:  # an annotation is an arrow's head
        if hasattr(arrow, "xy"):
            assert (np.array(arrow.xy) > low).all() and (np.array(arrow.xy) < high).all()
    named = [(s, box) for s, box in boxes_of(figure) if s in ("x", "y", "z", "T", *ROLES)]
    assert len(named) == 9
    for (one, a), (other, b) in combinations(named, 2):
        assert not a.padded(-1).overlaps(b.padded(-1)), (one, other)


def test_the_master_on_the_way_of_T_keeps_its_letter(given):
    """T along the master's y axis, as in the paper: its y stands beside, not on the arrow."""
    figure = slave_figure(posed(given, TURN, np.array([0.0, 3.0, 0.0])), "t")
    drawing = max(figure.axes, key=lambda axes: axes.bbox.height)
    arrows = [a for a in drawing.texts if getattr(a, "arrow_patch", None) is not None]
    T = next(a for a in arrows if a.arrow_patch.get_edgecolor()[:3] == to_rgb(INK))
    boxes = boxes_of(figure)  # sets the resolution
    way = drawing.transData.transform(np.linspace(T.xyann, T.xy, 200))
    for text, box in boxes:
        if text in ("x", "y", "z", "master", "slave", "T"):
            assert not any(box.padded(-1).contains(*at) for at in way), text


def test_insets_are_larger_and_count_what_they_leave_out(given):
    scattered = posed(given, TURN, np.array([0.4, 2.0, 0.2]))
    master, slave = scattered.paths
    wild = master.t_m.copy()
    wild[::60] += [0.5, 1.5, 1.0]
    scattered = dataclasses.replace(scattered, paths=(dataclasses.replace(master, t_m=wild), slave))
    outside = len(wild[::60])
    for draw, n_insets in ((paths_figure, 1), (superposition_figure, 2)):
        figure = draw(scattered, "t")
        told = [t for t in every_text(figure) if "as large" in t]
        assert len(told) == 2 and all(float(t.split("×")[0]) > 1.05 for t in told)
        assert sum(f"{outside} dots outside" in t for t in told) == n_insets
        for inset in [axes for axes in figure.axes if axes.axison]:
            (x0, x1), (y0, y1) = inset.get_xlim(), inset.get_ylim()
            for line in inset.lines:
                x, y = line.get_data()
                assert np.all((x > x0) & (x < x1) & (y > y0) & (y < y1))
        assert "67 % here" in " ".join(every_text(figure)).replace("\n", " ")


def test_a_name_gives_way_to_lines_and_other_names_and_stays_on_the_page():
    ground = Ground((60.0, 40.0))
    ground.line(np.array([[0.0, 20.0], [60.0, 20.0]]))
    first = ground.free(np.array([[30.0, 20.0]]), 12.0, 2.5)
    assert abs(first[1] - 20.0) > 1.25
    ground.box(first, 12.0, 2.5)
    second = ground.free(first[None], 12.0, 2.5)
    apart = np.abs(second - first)
    assert apart[0] > 12.0 or apart[1] > 2.5
    at_edge = ground.free(np.array([[59.0, 39.5]]), 12.0, 2.5)
    assert at_edge[0] <= 54.0 and at_edge[1] <= 38.75
    np.testing.assert_array_equal(Ground((60, 40)).free(np.array([[30.0, 9.0]]), 5, 2), [30, 9])


@pytest.mark.parametrize("point", [(3.441, -0.595, 0.59), (3.81, 1.53, 1.124), (3, 0.5, -0.6)])
def test_names_of_figure_5_keep_off_its_lines(point):
    figure = angles_figure(np.array(point), "t")
    drawing = max(figure.axes, key=lambda axes: axes.bbox.height)
    boxes = [(s, box) for s, box in boxes_of(figure) if s]
    for (one, a), (other, b) in combinations(boxes, 2):
        assert not a.padded(-1).overlaps(b.padded(-1)), (one, other)
    for line in [line for line in drawing.lines if line.get_linestyle() in ("-", "--")]:
        flat = line.get_xydata()
        steps = np.linspace(0, len(flat) - 1, 400)
        way = np.column_stack([np.interp(steps, range(len(flat)), v) for v in flat.T])
        for text, box in boxes:
            inside = [box.padded(-1.5).contains(*at) for at in drawing.transData.transform(way)]
            assert not any(inside), text


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
