"""The picture of a calibration: its numbers, its lines, and what it says where there is nothing."""

from __future__ import annotations

import numpy as np
import pytest
from calibration_inputs import COVARIANCE, DEAD, T_M, TURN, paths, write_calibration
from figure_data import check, check_saved, every_text
from scipy.spatial.transform import Rotation

from mocap_metrology.present.calibration import space
from mocap_metrology.present.calibration.data import agreement, pose_of, read_calibration
from mocap_metrology.present.calibration.figure import calibration_figure
from mocap_metrology.present.calibration.time import faint_diodes

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture(scope="module")
def moving(tmp_path_factory):
    files = write_calibration(tmp_path_factory.mktemp("moving"))
    return read_calibration(files, "lab-1", "twin-7")


@pytest.fixture(scope="module")
def figure(moving):
    return calibration_figure(moving)


def panel(figure, title: str):
    return next(a for a in figure.axes if any(t.get_text().startswith(title) for t in a.texts))


def lines_of(axes, colour: str):
    return [line for line in axes.lines if line.get_color() == colour and len(line.get_xdata()) > 9]


def test_numbers_stand_in_the_text_to_the_digit(figure):
    texts = every_text(figure)
    gamma, beta, alpha = TURN.as_euler("ZYX", degrees=True)
    for value, digits in (*((v, 2) for v in 1e3 * T_M), *((v, 3) for v in (alpha, beta, gamma))):
        shown = f"{value:+,.{digits}f}".replace("-", "−").replace(",", "\N{NARROW NO-BREAK SPACE}")
        assert shown in texts
    for value in np.sqrt(np.diag(COVARIANCE))[:3]:
        assert f"{value:.2f}" in texts
    said = " ".join(texts)
    assert "good" in texts and "All checks passed." in said
    assert f"baseline {np.linalg.norm(T_M):.3f} m" in said and "41.5 µrad" in said
    assert "master: id 1031, mode b, factory values from 9 frames" in said
    assert "slave: id unknown, mode c, no factory values: no whole frame" in said.replace("\n", " ")
    assert "Simulated (twin twin-7)" in said and "lab-1: calibration (simulated)" in said


def test_paths_are_drawn_where_another_program_puts_them(moving, figure):
    time, _, p = paths()
    slave = moving.paths("paper-lm", "factory")[1]
    moved = TURN.apply(slave.t_m) + T_M  # scipy, not the module's own product
    for title, (i, j) in (("a  Stations", (0, 1)), ("Stations from the right", (0, 2))):
        axes = panel(figure, title)
        assert axes.get_aspect() == 1
        master_line = max(lines_of(axes, space.COLOURS[0]), key=lambda one: len(one.get_xdata()))
        slave_line = max(lines_of(axes, space.COLOURS[1]), key=lambda one: len(one.get_xdata()))
        x, y = master_line.get_data()
        known = np.isfinite(x)
        assert known.sum() > 400
        np.testing.assert_allclose(x[known], p[:, i][1:][: known.sum()], atol=0.006)
        x, y = slave_line.get_data()
        known = np.isfinite(x)
        other = np.column_stack([np.interp(time[1:], slave.time_s, moved[:, k]) for k in (i, j)])
        np.testing.assert_allclose(np.column_stack([x, y])[known], other[: known.sum()], atol=1e-9)
    assert any(f"{np.linalg.norm(T_M):.2f} m" == t.get_text() for a in figure.axes for t in a.texts)


def test_disagreement_and_the_mirrored_moment(moving, figure):
    both = agreement(moving.paths("paper-lm", "factory"), pose_of(moving.chosen))
    # Two independent errors of 1 mm a coordinate; the slave's halved or so by interpolation
    assert np.sqrt(np.mean(both.apart_mm**2)) == pytest.approx(np.sqrt(6), rel=0.08)
    assert 1 <= both.mirrored.sum() <= 2  # interpolation may carry it on to the next moment
    R = Rotation.from_matrix(moving.paths("paper-lm", "factory")[0].R[1:])
    assert both.turned_deg[5] < 1 and len(R) == len(both.time_s)
    axes = panel(figure, "c  Both")
    dots = max(axes.lines, key=lambda line: len(line.get_xdata()))
    np.testing.assert_allclose(dots.get_ydata(), both.apart_mm)
    marked = [line for line in axes.lines if line.get_marker() == space.MIRRORED["marker"]]
    assert len(marked) == 1 and len(marked[0].get_xdata()) == both.mirrored.sum()
    residuals = panel(figure, "d  Single board poses")
    levels = [np.median(line.get_ydata()) for line in residuals.lines if line.get_alpha() == 0.7]
    assert sorted(levels) == pytest.approx([30.0, 40.0])


def test_the_ellipse_is_the_covariance_scaled_as_said(figure):
    from matplotlib.patches import Ellipse

    axes = panel(figure, "a  Stations")
    (ellipse,) = (patch for patch in axes.patches if isinstance(patch, Ellipse))
    said = next(t for t in every_text(figure) if "times as large" in t and "σ" in t)
    scale = int(said.split("drawn ")[1].split()[0])
    assert sorted([ellipse.width, ellipse.height]) == pytest.approx(
        [2e-3 * scale * 1.0, 2e-3 * scale * 2.0]
    )
    assert tuple(ellipse.center) == pytest.approx(tuple(T_M[:2]))


def test_dead_and_faint_diodes_are_named(figure):
    texts = every_text(figure)
    assert f"dead: {DEAD}" in texts and f"dead: {DEAD}, seldom: 20" in texts
    dead, seldom = faint_diodes(np.array([1.0, 0.9, 0.3, 0.0, 1.0]))
    assert dead.tolist() == [3] and seldom.tolist() == [2]
    assert faint_diodes(np.zeros(4))[0].size == 4


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("static", "b  Board at rest"),
        ("static-no-path", "The board was at rest: no path"),
        ("failed", "No pose of the slave: verdict failed"),
    ],
)
def test_pictures_without_a_path(tmp_path, kind, said):
    given = read_calibration(write_calibration(tmp_path / "in", kind), kind)
    drawn = calibration_figure(given)
    texts = " ".join(every_text(drawn))
    assert said in texts and "Measured." in texts
    if kind == "failed":
        assert "slave: 0 moments with both angles; expected 20" in texts
        assert "failed" in every_text(drawn) and "slave" not in [
            t.get_text() for t in panel(drawn, "a  Stations").texts
        ]
    check_saved(drawn, tmp_path / "out")


def test_saved_whole_and_readable(figure, tmp_path):
    check_saved(figure, tmp_path / "out")


def test_odd_texts_stay_on_the_page(moving):
    import dataclasses

    verdict = {"word": "doubtful", "reason": "a$b_c^2 " * 60}
    odd = dataclasses.replace(
        moving, name="n" * 150, twin=None, pose=dict(moving.pose) | {"verdict": verdict}
    )
    check(calibration_figure(odd))
