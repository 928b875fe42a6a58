"""The picture of a calibration: its numbers, its lines, and what it says where there is nothing."""

import dataclasses

import numpy as np
import pytest
from calibration_inputs import COVARIANCE, DEAD, T_M, TURN, paths, write_calibration
from figure_data import check_saved, every_text

from mocap_metrology.lighthouse.assess.calibration_files import read_calibration
from mocap_metrology.lighthouse.records import ROLES
from mocap_metrology.present.calibration import stations
from mocap_metrology.present.calibration.calibration_figure import calibration_figure

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture(scope="module")
def moving(tmp_path_factory):
    files = write_calibration(tmp_path_factory.mktemp("moving"))
    return read_calibration(files, "lab-1", "twin-7")


@pytest.fixture(scope="module")
def figure(moving):
    return calibration_figure(moving)


def panel(picture, title: str):
    return next(a for a in picture.figure.axes if title in a.get_title(loc="left"))


def words(picture) -> str:
    return " ".join(every_text(picture)).replace("\n", " ")


def judged(moving, word: str = "good", reason: str = "All.", checks=(), **entry):
    """The calibration with another verdict, and its chosen estimate changed."""
    poses = [dict(moving.pose["poses"][0]) | entry, *moving.pose["poses"][1:]]
    verdict = {"word": word, "reason": reason}
    pose = dict(moving.pose) | {"verdict": verdict, "checks": list(checks), "poses": poses}
    return dataclasses.replace(moving, pose=pose)


def test_numbers_stand_in_the_text_to_the_digit(figure):
    """Two digits of 2.0 mm and 0.030 deg, the largest standard deviations."""
    said = words(figure)
    (table,) = (table for axes in figure.figure.axes for table in axes.tables)
    texts = {cell.get_text().get_text() for cell in table.get_celld().values()}
    gamma, beta, alpha = TURN.as_euler("ZYX", degrees=True)
    for value, digits in (*((v, 1) for v in 1e3 * T_M), *((v, 3) for v in (alpha, beta, gamma))):
        shown = f"{value:+,.{digits}f}".replace("-", "−").replace(",", "\N{NARROW NO-BREAK SPACE}")
        assert shown in texts
    for value in np.sqrt(np.diag(COVARIANCE))[:3]:
        assert f"{value:.1f}" in texts
    middle = np.median(paths()[2], axis=0)
    for text in (
        "good All checks passed.",
        f"baseline {np.linalg.norm(T_M):.3f} m",
        "residual 42 µrad of 16 274 angles",
        f"board {np.linalg.norm(middle):.2f} m from the master, "
        f"{np.linalg.norm(middle - T_M):.2f} m from the slave",
        "master: id 1031, mode b, factory values from 9 frames",
        "slave: id unknown, mode c, no factory values: no whole frame",
        "simulated stand-in (twin) twin-7",
        "lab-1: calibration",
        f"Diodes of the slave, dead: {DEAD}; seldom: 20.",
    ):
        assert text in said, text


@pytest.mark.parametrize(("title", "i", "j"), [("(a) Stations", 0, 1), ("(b) From", 0, 2)])
def test_paths_are_drawn_where_another_program_puts_them(moving, figure, title, i, j):
    time, _, p = paths()
    slave = moving.paths("paper-lm", "factory")[1]
    moved = TURN.apply(slave.t_m) + T_M  # scipy, not the module's own product
    other = np.column_stack([np.interp(time[1:], slave.time_s, moved[:, k]) for k in (i, j)])
    axes = panel(figure, title)
    assert axes.get_aspect() == 1
    for colour, truth, error in zip(
        stations.COLOURS, (p[1:, [i, j]], other), (0.006, 1e-9), strict=True
    ):
        lines = [line for line in axes.lines if line.get_color() == colour]
        shown = np.column_stack(max(lines, key=lambda one: len(one.get_xdata())).get_data())
        known = np.isfinite(shown).all(axis=1)
        assert known.sum() > 400
        np.testing.assert_allclose(shown[known], truth[: known.sum()], atol=error)


def test_the_path_of_a_network_is_the_whole_trajectory(moving):
    network = dataclasses.replace(moving, pose=moving.pose | {"stations": {"3": {}, "12": {}}})
    path, other = network.paths("batch", "estimated")
    assert path is other
    expected = np.column_stack([moving.poses[k] for k in ("time_s", "x_m", "y_m", "z_m")])
    np.testing.assert_array_equal(np.column_stack([path.time_s, path.t_m]), expected)


@pytest.mark.parametrize(("title", "i", "j"), [("(c) Slave", 0, 1), ("(d) Slave", 0, 2)])
def test_ellipses_have_the_axes_of_the_covariance(moving, title, i, j):
    """Half axes of a 2 x 2 covariance in closed form, times the 95 % radius sqrt(-2 ln 0.05); the
    reference, 3.7 mm away, stands at its place; what is far off at the border."""
    covariance = COVARIANCE.copy()
    covariance[:3, :3] = [[1.0, 0.6, -0.3], [0.6, 4.0, 0.2], [-0.3, 0.2, 0.25]]
    files = judged(moving, covariance=covariance.tolist())
    far = dict(files.pose["poses"][0]) | {"estimator": "paper"}
    far["translation_mm"] = (1e3 * T_M + [90, 9, 9]).tolist()
    files.pose["poses"].append(far)
    axes = panel(calibration_figure(files), title)
    a, b, c = covariance[i, i], covariance[j, j], covariance[i, j]
    root = np.sqrt((a - b) ** 2 / 4 + c**2)
    by_label = {line.get_label(): line for line in axes.lines}
    for label, radius in (("95 % region of the position", np.sqrt(-2 * np.log(0.05))),
                          ("1 σ of the position", 1.0)):  # fmt: skip
        x, y = by_label[label].get_data()
        distance = np.hypot(x, y)
        half_axes = radius * np.sqrt((a + b) / 2 + np.array([root, -root]))
        assert [distance.max(), distance.min()] == pytest.approx(half_axes, rel=2e-3)
        turn = 2 * np.arctan2(y[distance.argmax()], x[distance.argmax()])
        assert np.tan(turn) == pytest.approx(2 * c / (a - b), rel=0.3)
    reference = np.ravel(by_label["reference: 3.7 mm away"].get_data())
    assert reference == pytest.approx(np.array([1.0, 2.0, 3.0])[[i, j]])
    x, y = np.ravel(by_label["paper, final: 91 mm away"].get_data())
    assert x == pytest.approx(axes.get_xlim()[1]) and y == pytest.approx(x / 10)


BY_BATCH = {
    "against": [
        {"against": against, "station": station, "axis": axis, "at": [1.0, 2.0, 3.0],
         "mean_urad": [high, 0.0, -high], "sd_urad": [5.0, 4.0, 5.0]}
        for against, high in (("angle_deg", 90.0), ("time_s", 30.0))
        for station in ROLES for axis in ("azimuth", "elevation")
    ],
    "by_diode": [
        {"station": station, "diode": list(range(32)), "n": [9] * 32,
         "rms_urad": [900.0 if k == 5 else 50.0 for k in range(32)], "excluded": out}
        for station, out in zip(ROLES, ([5], []), strict=True)
    ],
}  # fmt: skip


def test_residuals_by_angle_time_and_diode(moving, tmp_path):
    details = {"residuals": BY_BATCH, "noise_hit_urad": 47.0}
    drawn = calibration_figure(judged(moving, estimator="batch", details=details))
    limits = {panel(drawn, title).get_ylim() for title in ("(f) Az", "(g) El", "(h) Mean")}
    assert len(limits) == 1 and max(max(limits)) > 95
    means = [line.get_ydata() for line in panel(drawn, "(f) Azimuth").lines]
    assert sum(list(y) == [90.0, 0.0, -90.0] for y in means) == 2
    diodes = panel(drawn, "(i) Residuals")
    (cross,) = (one for one in diodes.lines if one.get_marker() == "x")
    assert cross.get_xdata() == pytest.approx([5], abs=0.3) and len(cross.get_xdata()) == 1
    assert cross.get_ydata()[0] < diodes.get_ylim()[1] == pytest.approx(200.0)
    assert "Excluded from the estimate, master: 5 (900 µrad)." in drawn.caption
    assert "noise of a hit: 47 µrad" in every_text(drawn)
    check_saved(drawn, tmp_path / "out")
