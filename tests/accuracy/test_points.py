"""Fits to reference points: real sets beside a laser tracker, scipy, and drawn frames that jump."""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from mocap_metrology.accuracy import points as of
from mocap_metrology.accuracy import points_report as report
from mocap_metrology.accuracy.points import Points, fit, frame_changes, left_out, residuals, rms
from mocap_metrology.accuracy.statement import known_of
from mocap_metrology.common.errors import Refusal

SETS = Path(__file__).parents[3] / "shared/data/metrology/vive_accuracy"


def real(name: str) -> Points:
    """A set as its README says: means of poses, and of the first and fourth row of the tracker."""
    folder = SETS / name
    laser = np.genfromtxt(
        folder / f"{name}_laserData.csv", delimiter=",", skip_header=6, usecols=(0, 1, 2)
    )
    laser = laser[: len(laser) // 4 * 4].reshape(-1, 4, 3)
    places, turns = [], []
    for k in range(1, len(laser) + 1):
        rows = np.loadtxt(folder / f"measurementPoint{k}.txt")
        if rows.shape[1] == 12:
            matrix = rows.reshape(-1, 3, 4)
            places.append(matrix[:, :, 3].mean(axis=0))
            turns.append(Rotation.from_matrix(matrix[:, :, :3]).mean().as_matrix())
        else:
            places.append(rows[:, :3].mean(axis=0))
            turns.append(Rotation.from_quat(rows[:, 3:], scalar_first=True).mean().as_matrix())
    return Points(1000 * np.array(places), np.array(turns), (laser[:, 0] + laser[:, 3]) / 2)


@pytest.mark.skipif(not SETS.exists(), reason="the sets of reference points are not here")
def test_real_sets() -> None:
    """2020-10-01: the frame jumped after points 10, 17 and 22, four segments leave 7.6 to 8.3 mm of
    56 to 62; 2020-09-18: it did not, the left-out points are 9.6 to 12.7 mm off, and no lever more
    than doubles it."""
    jumped = frame_changes(real("20201001_Exp1"))
    assert jumped.cuts == (10, 17, 22) and 7.6 < jumped.inside_mm < 8.3
    sound = real("20200918_Exp1")
    assert frame_changes(sound).cuts == ()
    off = left_out(sound, True, False)[0]
    assert rms(off) == pytest.approx(9.6, abs=0.2)
    assert rms(left_out(sound, False, False)[0]) > 2 * rms(off)


def drawn(rng: np.random.Generator, n: int, noise: float = 0.0, scale: float = 0.0) -> Points:
    """Bodies at random in 3 m, turned up to 40 degrees, lever of 210 mm."""
    places = rng.uniform(-1500, 1500, (n, 3))
    turns = Rotation.from_rotvec(rng.uniform(-0.7, 0.7, (n, 3))).as_matrix()
    bodies = places + turns @ [30.0, -60.0, 200.0]
    frame = Rotation.random(rng=rng).as_matrix()
    reference = (1 + scale) * bodies @ frame.T + rng.uniform(-1000, 1000, 3)
    return Points(places + noise * rng.standard_normal((n, 3)), turns, reference)


@pytest.mark.parametrize("scale", [False, True])
def test_a_fit_is_that_of_least_squares(scale: bool) -> None:
    """The same sum of squares as scipy's, over all ten unknowns at once; exact without noise."""
    points = drawn(np.random.default_rng(1), 12, 5.0, 0.003)
    found = fit(points, lever=True, scale=scale)

    def left(x: np.ndarray) -> np.ndarray:
        turn = Rotation.from_rotvec(x[:3]).as_matrix() @ found.rotation
        one = of.Fit(turn, x[3:6], x[9] if scale else 0.0, x[6:9])
        return residuals(points, one).ravel()

    best = least_squares(left, [0, 0, 0, *found.shift, *found.lever, found.scale], x_scale="jac")
    assert (left_sum := (residuals(points, found) ** 2).sum()) == pytest.approx(2 * best.cost)
    assert left_sum > 0
    exact = fit(drawn(np.random.default_rng(2), 8, 0.0, 0.003), True, True)
    assert exact.lever == pytest.approx([30, -60, 200], abs=1e-3)
    assert exact.scale == pytest.approx(0.003, abs=1e-7)


def test_jackknife_of_scale_and_lever() -> None:
    """12 sets of 12 points with independent errors: two standard errors hold in 88 % at least."""
    held = []
    for seed in range(12):
        points = drawn(np.random.default_rng(seed), 12, 3.0)
        found, (_, _, se) = fit(points, True, True), left_out(points, True, True)
        held.append(abs(found.scale) < 2.2 * se[0])
        held += list(np.abs(found.lever - [30, -60, 200]) < 2.2 * se[1:])
    assert np.mean(held) >= 0.88


def bent(rng: np.random.Generator, points: Points, size_mm: float) -> Points:
    """With a smooth distortion of the system's places."""
    waves = rng.normal(0, 1 / 2000, (4, 3))
    phases, arms = rng.uniform(0, 6, 4), rng.standard_normal((4, 3))
    off = np.sin(points.places @ waves.T + phases) @ arms
    return Points(points.places + size_mm * off / rms(off), points.turns, points.reference)


def test_jumps_of_frames_and_none() -> None:
    """20 sets of 20 points, smoothly distorted by 4 mm: no jump where there is none in 97 % at
    least; one of 50 mm and 1 degree after point 9 in 85 %, within one point."""
    false, found = 0, 0
    for seed in range(20):
        rng = np.random.default_rng(seed)
        points = bent(rng, drawn(rng, 20, 1.0), 4.0)
        false += bool(frame_changes(points).cuts)
        places = points.places.copy()
        away = rng.standard_normal(3)
        places[9:] += 50 * away / np.linalg.norm(away)
        cuts = frame_changes(Points(places, points.turns, points.reference)).cuts
        found += len(cuts) == 1 and abs(cuts[0] - 9) <= 1
    assert false <= 1 and found >= 17


def test_few_points_without_jump_or_scale() -> None:
    """Of 100 sets of 5 markers with noise alone at most 3 have a scale; of 100 of 8 bodies in a
    volume bent by 4 mm no frame jumps."""
    scales, jumps = 0, 0
    for seed in range(100):
        rng = np.random.default_rng([9, seed])
        places = rng.uniform(-1500, 1500, (5, 3))
        markers = Points(
            places, np.broadcast_to(np.eye(3), (5, 3, 3)), places + rng.normal(0, 1, (5, 3))
        )
        scales += "scale" in report.points_document(markers, 1.7, "abcde")[0]["findings"]
        jumps += bool(frame_changes(bent(rng, drawn(rng, 8, 1.0), 4.0)).cuts)
    assert scales <= 3 and jumps == 0


def test_too_few_points_and_a_line_are_refused() -> None:
    points = drawn(np.random.default_rng(3), 8)
    of.check(points, "set")
    with pytest.raises(Refusal, match="set: 5 reference points; expected at least 6"):
        of.check(points.only(slice(5)), "set")
    line = points.reference[0] + np.outer(np.arange(8), [1.0, 2, 3])
    with pytest.raises(Refusal, match="are on a line"):
        of.check(Points(points.places, points.turns, line), "set")


def test_an_exchange_and_repeated_places() -> None:
    """Two points whose names are exchanged are named, of places taken thrice each is one; what only
    rounding leaves has no cause."""
    points = drawn(np.random.default_rng(3), 12, noise=0.3)
    names = [f"P{k}" for k in range(12)]
    order = np.arange(12)
    order[[4, 5]] = order[[5, 4]]
    wrong = Points(points.places[order], points.turns[order], points.reference)
    document = report.points_document(wrong, 0.3, names)[0]
    assert document["findings"] == ["does_not_fit"] and document["exchanged"] == ["P4", "P5"]
    assert document["exchanged_mm"] < 0.6 and document["wrong_point"] is None
    with pytest.raises(Refusal, match="lab: 4 reference points"):
        of.check(points.only([0, 1, 2, 3] * 3), "lab")
    exact = drawn(np.random.default_rng(4), 12)
    assert report.points_document(exact, 0.0, names)[0]["findings"] == []


def markers(rng: np.random.Generator, n: int, noise: float = 0.3) -> Points:
    places = rng.uniform(-1500, 1500, (n, 3))
    turns = np.tile(np.eye(3), (n, 1, 1))
    return Points(places + noise * rng.standard_normal((n, 3)), turns, places)


def test_a_single_wrong_point_by_its_name() -> None:
    """By 8 mm among 12 or 20 of 0.3 mm, whether or not that is ten times the noise; of 100 sets
    without one, of which half are distorted by 4 mm, at most one has one."""
    false = 0
    for seed in range(100):
        rng = np.random.default_rng([4, seed])
        n = 12 + 8 * (seed % 2)
        points, names = markers(rng, n), [str(k) for k in range(n)]
        bent_or_not = bent(rng, points, 4.0) if seed % 4 < 2 else points
        false += report.points_document(bent_or_not, 0.05, names)[0]["wrong_point"] is not None
        if seed < 10:
            wrong = points.reference.copy()
            wrong[seed] += [4.8, 0.0, 6.4]
            moved = Points(points.places, points.turns, wrong)
            for noise in (0.05, 1.0):
                document, off = report.points_document(moved, noise, names)
                assert document["wrong_point"] == str(seed)
                assert document["others_mm"] < 0.7
                assert document["wrong_mm"] == pytest.approx(rms(off[[seed]]))
    assert false <= 1


def test_a_frame_that_drifts_does_not_jump() -> None:
    """20 sets of 20 points: a shift by 60 mm from the first to the last one is a drift of that
    size in 18; a jump of 50 mm halfway is none."""
    drifts = []
    names = [str(k) for k in range(20)]
    for seed in range(20):
        rng = np.random.default_rng([5, seed])
        points = bent(rng, markers(rng, 20), 2.0)
        off = np.linspace(0, 60, 20)[:, None] * [0.6, 0.0, 0.8]
        moved = Points(points.places + off, points.turns, points.reference)
        document = report.points_document(moved, 0.3, names)[0]
        if document["findings"][:1] == ["frame_drifts"]:
            drifts.append(document["drift_mm"])
        jumped = np.where(np.arange(20) < 10, 0, 50)[:, None] * [0.6, 0.0, 0.8]
        other = Points(points.places + jumped, points.turns, points.reference)
        assert report.points_document(other, 0.3, names)[0]["drift_mm"] is None
    assert len(drifts) >= 18 and np.mean(drifts) == pytest.approx(60, abs=3)


def test_scale_and_what_it_leaves() -> None:
    """Of 2 % of scale the rest is what a scaled fit leaves; five digits of a millimetre are no
    misfit."""
    points = markers(np.random.default_rng(7), 12)
    larger = Points(points.places, points.turns, 1.02 * points.reference)
    document = report.points_document(larger, 0.02, "abcdefghijkl")[0]
    assert document["findings"] == ["scale", "does_not_fit"]
    assert document["rest_mm"] == document["left_out_scaled_rms_mm"] < 1
    assert not document["mispaired"]
    rounded = Points(points.reference.round(4), points.turns, points.reference)
    assert report.points_document(rounded, 0.0, "abcdefghijkl")[0]["findings"] == []


def test_points_whose_names_are_exchanged_have_no_scale_in_a_statement() -> None:
    """Twelve places taken twice have 11 degrees of freedom; the jackknife of an exchange is
    percents of the length."""
    points, names = markers(np.random.default_rng(9), 12), [str(k) for k in range(24)]
    both = points.only(np.tile(np.arange(12), 2))
    (scale,) = known_of(["A", "B"], points=report.points_document(both, 0.3, names)[0])
    assert scale.dof == 11 and scale.u < 1e-3
    order = [1, 0, *range(2, 12)]
    wrong = Points(points.places[order], points.turns, points.reference)
    document = report.points_document(wrong, 0.3, names)[0]
    assert document["exchanged"] == ["0", "1"]
    assert known_of(["A", "B"], points=document) == []


@pytest.mark.parametrize(("drift_mm", "bent_mm", "jump_mm"), [(30, 1, 0), (0, 6, 0), (0, 4, 30)])
def test_points_in_order_of_their_places(drift_mm: float, bent_mm: float, jump_mm: float) -> None:
    """Twenty around a room: neither an even drift nor a bent volume is a jump, and a jump in a bent
    volume is told at its point."""
    rng = np.random.default_rng(3)
    angle = np.linspace(0, 2 * np.pi, 20, endpoint=False)
    for _ in range(10):
        at = np.stack([np.cos(angle), np.sin(angle), 0.5 * rng.standard_normal(20)], axis=1)
        bent = np.stack([at[:, 0] * at[:, 1], at[:, 0] ** 2, at[:, 2] * at[:, 0]], axis=1)
        after = int(rng.integers(5, 16))
        moved = drift_mm * np.linspace(0, 1, 20) + jump_mm * (np.arange(20) >= after)
        places = 2000 * at + 2 * bent_mm * bent + 0.1 * rng.standard_normal((20, 3))
        places += moved[:, None] * np.array([0.6, 0.0, 0.8])
        found = frame_changes(Points(places, np.tile(np.eye(3), (20, 1, 1)), 2000 * at))
        assert found.cuts == ((after,) if jump_mm else ())
