"""The picture of a calibration: its numbers, its lines, and what it says where there is nothing."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from calibration_inputs import COVARIANCE, DEAD, T_M, TURN, paths, write_calibration
from figure_data import check, check_saved, every_text
from matplotlib.colors import to_rgba
from matplotlib.text import Text
from scipy.spatial.transform import Rotation

from mocap_metrology.lighthouse.board import flat_board
from mocap_metrology.lighthouse.records import ROLES
from mocap_metrology.present.calibration import views
from mocap_metrology.present.calibration.calibration_figure import calibration_figure, faint_diodes
from mocap_metrology.present.calibration.calibration_files import (
    agreement,
    pose_of,
    read_calibration,
)
from mocap_metrology.present.calibration.pose_text import pose_rows
from mocap_metrology.present.jansen.paths import Superposed
from mocap_metrology.present.plot.figure import VERDICT_WORDS

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture(scope="module")
def moving(tmp_path_factory):
    files = write_calibration(tmp_path_factory.mktemp("moving"))
    return read_calibration(files, "lab-1", "twin-7")


@pytest.fixture(scope="module")
def figure(moving):
    return calibration_figure(moving)


def panel(picture, title: str):
    return next(a for a in picture.figure.axes if a.get_title(loc="left").startswith(title))


def cells(picture) -> list[str]:
    """Lines of all text, each by itself."""
    return [line for text in every_text(picture) for line in text.split("\n")]


def lines_of(axes, colour: str):
    return [line for line in axes.lines if line.get_color() == colour and len(line.get_xdata()) > 9]


def test_numbers_stand_in_the_text_to_the_digit(figure):
    texts = cells(figure)
    gamma, beta, alpha = TURN.as_euler("ZYX", degrees=True)
    # Two digits of 2.0 mm and 0.030 deg, the largest standard deviations
    for value, digits in (*((v, 1) for v in 1e3 * T_M), *((v, 3) for v in (alpha, beta, gamma))):
        shown = f"{value:+,.{digits}f}".replace("-", "−").replace(",", "\N{NARROW NO-BREAK SPACE}")
        assert shown in texts
    for value in np.sqrt(np.diag(COVARIANCE))[:3]:
        assert f"{value:.1f}" in texts
    said = " ".join(texts)
    assert "good" in texts and "All checks passed." in said
    assert f"baseline {np.linalg.norm(T_M):.3f} m" in said and "42 µrad" in said
    assert "master: id 1031, mode b, factory values from 9 frames" in said
    assert "slave: id unknown, mode c, no factory values: no whole frame" in said.replace("\n", " ")
    assert "simulated stand-in (twin) twin-7" in said and "lab-1: calibration" in said


def test_paths_are_drawn_where_another_program_puts_them(moving, figure):
    time, _, p = paths()
    slave = moving.paths("paper-lm", "factory")[1]
    moved = TURN.apply(slave.t_m) + T_M  # scipy, not the module's own product
    for title, (i, j) in (("(a) Stations", (0, 1)), ("(b) Stations", (0, 2))):
        axes = panel(figure, title)
        assert axes.get_aspect() == 1
        master_line = max(lines_of(axes, views.COLOURS[0]), key=lambda one: len(one.get_xdata()))
        slave_line = max(lines_of(axes, views.COLOURS[1]), key=lambda one: len(one.get_xdata()))
        x, y = master_line.get_data()
        known = np.isfinite(x)
        assert known.sum() > 400
        np.testing.assert_allclose(x[known], p[:, i][1:][: known.sum()], atol=0.006)
        x, y = slave_line.get_data()
        known = np.isfinite(x)
        other = np.column_stack([np.interp(time[1:], slave.time_s, moved[:, k]) for k in (i, j)])
        np.testing.assert_allclose(np.column_stack([x, y])[known], other[: known.sum()], atol=1e-9)
    middle = np.median(p, axis=0)
    far = [np.linalg.norm(middle), np.linalg.norm(middle - T_M)]
    assert f"board {far[0]:.2f} m from the master, {far[1]:.2f} m from the slave" in cells(figure)


@pytest.mark.parametrize("t_m", [T_M, [3.9, -0.1, 0.0], [0.3, -3.0, 0.2], [3.2, 0.1, 2.5]])
def test_names_of_stations_keep_off_lines(moving, t_m):
    drawn = calibration_figure(
        judged(moving, "good", "All.", [], translation_mm=(1e3 * np.asarray(t_m)).tolist())
    )
    check(drawn)
    for title in ("(a) Stations", "(b) Stations"):
        axes = panel(drawn, title)
        names = [t for t in axes.texts if t.get_text() in ROLES]
        assert len(names) == 2
        for name in names:
            box = name.get_window_extent().padded(-1)
            for line in [line for line in axes.lines if len(line.get_xdata()) == 2]:
                x, y = (np.linspace(*ends, 300) for ends in line.get_data())
                way = axes.transData.transform(np.column_stack([x, y]))
                assert not any(box.contains(*at) for at in way), (title, name.get_text())


def test_disagreement_and_the_mirrored_moment(moving, figure):
    both = agreement(moving.paths("paper-lm", "factory"), pose_of(moving.chosen))
    # Two independent errors of 1 mm a coordinate; the slave's halved or so by interpolation
    assert np.sqrt(np.mean(both.apart_mm**2)) == pytest.approx(np.sqrt(6), rel=0.08)
    assert 1 <= both.mirrored.sum() <= 2  # interpolation may carry it on to the next moment
    R = Rotation.from_matrix(moving.paths("paper-lm", "factory")[0].R[1:])
    assert both.turned_deg[5] < 1 and len(R) == len(both.time_s)
    axes = panel(figure, "(f) Distance")
    dots = max(axes.lines, key=lambda line: len(line.get_xdata()))
    np.testing.assert_allclose(dots.get_ydata(), both.apart_mm)
    marked = [line for line in axes.lines if line.get_marker() == views.MIRRORED["marker"]]
    assert len(marked) == 1 and len(marked[0].get_xdata()) == both.mirrored.sum()
    residuals = panel(figure, "(g) Residuals")
    levels = [np.median(line.get_ydata()) for line in residuals.lines if line.get_alpha() == 0.7]
    assert sorted(levels) == pytest.approx([30.0, 40.0])


@pytest.mark.parametrize(("title", "i", "j"), [("(d) Slave", 0, 1), ("(e) Slave", 0, 2)])
def test_ellipses_have_the_axes_of_the_covariance(moving, title, i, j):
    """Half axes of a 2 x 2 covariance in closed form, times the 95 % radius sqrt(-2 ln 0.05); the
    reference, 3.7 mm away, stands at its place."""
    covariance = COVARIANCE.copy()
    covariance[:3, :3] = [[1.0, 0.6, -0.3], [0.6, 4.0, 0.2], [-0.3, 0.2, 0.25]]
    drawn = calibration_figure(judged(moving, "good", "All.", [], covariance=covariance.tolist()))
    a, b, c = covariance[i, i], covariance[j, j], covariance[i, j]
    root = np.sqrt((a - b) ** 2 / 4 + c**2)
    axes = panel(drawn, title)
    for label, radius in (("95 % region of", np.sqrt(-2 * np.log(0.05))), ("1 σ", 1.0)):
        (line,) = (one for one in axes.lines if one.get_label().startswith(label))
        far = np.hypot(*line.get_data())
        own = (a + b) / 2 + np.array([root, -root])
        assert [far.max(), far.min()] == pytest.approx(radius * np.sqrt(own), rel=2e-3)
        x, y = (values[far.argmax()] for values in line.get_data())
        assert np.tan(2 * np.arctan2(y, x)) == pytest.approx(2 * c / (a - b), rel=0.3)
    (reference,) = (one for one in axes.lines if one.get_label().startswith("reference"))
    shown = np.array([reference.get_xdata()[0], reference.get_ydata()[0]])
    assert shown == pytest.approx(np.array([1.0, 2.0, 3.0])[[i, j]])
    assert reference.get_label() == "reference: 3.7 mm away"


def test_a_far_estimate_stands_on_the_border(moving):
    near, *more = moving.pose["poses"]
    far = dict(near) | {"estimator": "paper", "translation_mm": (1e3 * T_M + [90, 0, 9]).tolist()}
    pose = dict(moving.pose) | {"poses": [near, *more, far]}
    axes = panel(calibration_figure(dataclasses.replace(moving, pose=pose)), "(e) Slave")
    (point,) = (one for one in axes.lines if one.get_label() == "paper, final: 90 mm away")
    x, y = point.get_xdata()[0], point.get_ydata()[0]
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
    drawn = calibration_figure(
        judged(moving, "good", "All.", [], estimator="batch", details=details)
    )
    limits = {panel(drawn, title).get_ylim() for title in ("(f) Az", "(g) El", "(h) Res")}
    assert len(limits) == 1 and max(max(limits)) > 95
    means = [line.get_ydata() for line in panel(drawn, "(f) Azimuth").lines]
    assert sum(list(y) == [90.0, 0.0, -90.0] for y in means) == 2
    diodes = panel(drawn, "(i) Residuals")
    (cross,) = (one for one in diodes.lines if one.get_marker() == "x")
    assert cross.get_xdata() == pytest.approx([5], abs=0.3) and len(cross.get_xdata()) == 1
    assert cross.get_ydata()[0] < diodes.get_ylim()[1] == pytest.approx(200.0)
    assert "Excluded from the estimate, master: 5 (900 µrad)." in drawn.caption
    assert {"noise of a hit: 47 µrad", "excluded: 5"} <= set(every_text(drawn))
    check_saved(drawn, tmp_path / "out")


def test_dead_and_faint_diodes_are_named(figure):
    texts = every_text(figure)
    assert f"dead: {DEAD}" in texts and f"dead: {DEAD}, seldom: 20" in texts


def test_a_diode_is_dead_only_where_others_prove_it():
    shares = np.ones((2, 32))
    shares[:, 3] = 0.0  # neither station
    shares[0, 5], shares[0, 7] = 0.0, 0.3
    flat, solid = flat_board(), flat_board() + np.outer(np.arange(32) % 2, [0.1, 0, 0])
    found = {word: own.tolist() for word, own in faint_diodes(shares, flat, 0).items()}
    assert found == {"dead": [3], "not seen": [5], "seldom": [7]}  # the slave sees diode 5
    found = faint_diodes(shares, solid, 0)  # it may face away
    assert not found["dead"].size and found["not seen"].tolist() == [3, 5]
    assert not faint_diodes(np.zeros((2, 32)), flat, 0)["dead"].size  # nothing proves anything


def test_diodes_that_face_away_are_not_called_dead(moving):
    """A headset: each station sees one half of the diodes, and four are seen by neither."""
    n, front = len(moving.board), np.asarray(moving.sweeps["station"]) == 0
    diode = np.asarray(moving.sweeps["diode"])
    shown = np.where(front, diode < 14, diode >= 18)
    sweeps = {name: np.asarray(values)[shown] for name, values in moving.sweeps.items()}
    board = moving.board + np.outer(np.arange(n) >= 16, [0.1, 0.0, 0.0])
    drawn = calibration_figure(dataclasses.replace(moving, board=board, sweeps=sweeps))
    assert "not seen: 19" in every_text(drawn) and "dead diode" not in every_text(drawn)
    assert f"not seen: 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, {DEAD}, 14" in drawn.caption


def judged(moving, word: str, reason: str, checks, **entry):
    """The calibration with another verdict, and its chosen estimate changed."""
    poses = [dict(moving.pose["poses"][0]) | entry, *moving.pose["poses"][1:]]
    pose = dict(moving.pose) | {
        "verdict": {"word": word, "reason": reason}, "checks": checks, "poses": poses,
    }  # fmt: skip
    return dataclasses.replace(moving, pose=pose)


def row(name: str, value, limit, ok: bool, sentence: str):
    return {"name": name, "value": value, "limit": limit, "ok": ok, "sentence": sentence}


CHECKS = [
    row("residual", 1310.9, 2163.6, False, "Angles are 1311 µrad rms from the fit, as by X."),
    row("board poses", 47.0, 86.545, True, "."),
    row("reference", 31.4, 100.0, False, "The pose is 31.4 mm and 0.74° from the reference."),
]
REASON = "Angles are 1311 µrad rms from the fit. The pose is 31.4 mm and 0.74° from the reference."


def test_words_and_units_are_the_same_all_over_the_page(moving):
    drawn = calibration_figure(judged(moving, "usable", REASON, CHECKS, residual_rms_urad=1310.9))
    said = " ".join(every_text(drawn)).replace("\n", " ")
    assert "1311 µrad rms" in said and "residual 1311 µrad" in said and "1310" not in said
    assert "urad" not in said.replace("µrad", "") and " deg" not in said and "(deg)" not in said
    assert "The pose is 31.4 mm and 0.74° from the reference." in said
    assert "(usable below 2164)" in said
    assert "expected noise of an angle: 72 µrad" in said  # 86.545 is 1.2 times the noise
    good = [CHECKS[0] | {"value": 402, "limit": 576.97, "ok": True}, CHECKS[1]]
    passed = "All 2 checks passed. Angles are 402 µrad rms from the fit."
    drawn = calibration_figure(judged(moving, "good", passed, good))
    said = " ".join(every_text(drawn)).replace("\n", " ")
    assert "angles (good below 577)" in said
    assert passed in said


def test_the_badge_has_the_colours_of_the_pages(moving):
    drawn = calibration_figure(judged(moving, "usable", REASON, CHECKS))
    text, behind = VERDICT_WORDS["usable"]
    badge = next(t for t in drawn.figure.findobj(Text) if t.get_text() == "usable")
    assert badge.get_color() == text
    assert badge.get_bbox_patch().get_facecolor() == to_rgba(behind)


def test_an_error_beyond_sigma_is_remarked_and_takes_digits_away(moving):
    far = {"errors_mm": [26.0, -15.0, 10.0], "errors_deg": [-0.1, -0.2, 0.71]}
    rows = dict(pose_rows(moving.chosen | far))
    t = [
        f"{v:+,.0f}".replace("-", "−").replace(",", "\N{NARROW NO-BREAK SPACE}") for v in 1e3 * T_M
    ]
    assert rows["t, slave in master (mm)"] == t  # two digits of 26 mm
    assert rows["1 σ along x, y, z (mm)"] == ["1.0", "2.0", "0.5"]
    assert rows["t − reference (mm)"] == ["+26", "−15", "+10"]
    assert rows["rotation from it (°)"] == ["−0.10", "−0.20", "+0.71"]
    near = {"errors_mm": [1.0, -2.0, 0.3], "errors_deg": [0.01, 0.0, 0.0]}
    for errors, beyond in ((far, True), (near, False)):
        drawn = calibration_figure(judged(moving, "good", "All.", [], **errors))
        said = " ".join(every_text(drawn))
        assert ("Error beyond 3 σ" in said) == beyond


def test_frames_are_counted_and_rows_of_both_columns_are_level(moving):
    stations = [dict(moving.stations[0]) | {"frames_found": 1, "id": 10**30}, moving.stations[1]]
    drawn = calibration_figure(dataclasses.replace(moving, stations=stations))
    said = " ".join(every_text(drawn))
    assert "from 1 frame" in said and "1 frames" not in said
    columns = [t for t in drawn.figure.findobj(Text) if "\n" in t.get_text()]
    assert len(columns) == 5  # labels, three numbers, what they stand on
    assert len({(t.get_position()[1], t.get_size(), t._linespacing) for t in columns}) == 1
    assert len({len(t.get_text().split("\n")) for t in columns[:4]}) == 1


@pytest.mark.parametrize(
    ("kind", "said"),
    [
        ("static", "(c) At rest, from"),
        ("static-no-path", "The board was at rest: no path"),
        ("failed", "No pose of the slave: verdict failed"),
    ],
)
def test_pictures_without_a_path(tmp_path, kind, said):
    given = read_calibration(write_calibration(tmp_path / "in", kind), kind)
    drawn = calibration_figure(given)
    texts = " ".join(every_text(drawn))
    assert said in texts and "Source: measured." in texts
    if kind == "failed":
        assert "slave: 0 moments with both angles; expected 20" in texts
        assert "failed" in every_text(drawn) and "slave" not in [
            t.get_text() for t in panel(drawn, "(a) Stations").texts
        ]
    check_saved(drawn, tmp_path / "out")


def test_saved_whole_and_readable(figure, tmp_path):
    check_saved(figure, tmp_path / "out")


def test_odd_texts_stay_on_the_page(moving):
    verdict = {"word": "doubtful", "reason": "a$b_c^2 " * 60}
    odd = dataclasses.replace(
        moving, name="n" * 150, twin=None, pose=dict(moving.pose) | {"verdict": verdict}
    )
    check(calibration_figure(odd))


def test_the_path_is_drawn_beside_an_estimate_without_board_poses(moving):
    """`batch` has one trajectory, so the figure shows the board poses of paper-lm; those of J's
    Figures 5 to 8 are of paper-lm where paper was not requested."""
    kind = {"estimator": "batch", "stage": "final"}
    entries = [{**entry, **kind} for entry in moving.pose["poses"] if entry["stage"] == "final"]
    assert any(entry["estimator"] == "paper-lm" for entry in moving.pose["poses"])
    optics = next(e["optics"] for e in moving.pose["poses"] if e["estimator"] == "paper-lm")
    pose = {**moving.pose, "poses": [{**entries[0], "optics": optics}], "chosen": 0}
    own = dataclasses.replace(moving, pose=pose)
    scenery = views.Scenery.of(own)
    assert scenery.both is not None and scenery.paths is not None
    expected = moving.paths("paper-lm", optics)
    np.testing.assert_array_equal(scenery.paths[0].t_m, expected[0].t_m)
    assert Superposed.of(own).paths[0].t_m.shape == expected[0].t_m.shape
