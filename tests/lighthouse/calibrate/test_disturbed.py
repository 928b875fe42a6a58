"""Calibrations of recordings with what real ones have: wrong sweeps, stray light, a misfit, boards
that are not as their files."""

from dataclasses import replace
from types import SimpleNamespace as Some

import numpy as np
import pytest

from benchmarks.lighthouse_recordings import hand, wrong_sweeps
from benchmarks.sentences.flights import Outcome, outcome
from mocap_metrology.lighthouse.assess.summary import summary
from mocap_metrology.lighthouse.calibrate import stages
from mocap_metrology.lighthouse.calibrate.fits import _bad_stretches
from mocap_metrology.lighthouse.calibrate.jansen import CalibrationSettings, calibrate, chosen
from mocap_metrology.lighthouse.calibrate.static import StaticPose, is_constant, is_still
from mocap_metrology.lighthouse.decode.clean import clean_hits
from mocap_metrology.lighthouse.records import Halves, Hits, Path, PoseEstimate
from mocap_metrology.lighthouse.simulate.recording import SimulatedSweeps

BATCH = CalibrationSettings(estimators=("batch",), optics=("factory",), variant="libsurvive")


@pytest.fixture(scope="module")
def made() -> SimulatedSweeps:
    return hand(1)


def judged(made: SimulatedSweeps, hits: Hits, board: np.ndarray | None = None) -> Outcome:
    board = made.truth.board if board is None else board
    return outcome(made, clean_hits(hits, board)[0], board)


@pytest.fixture(scope="module")
def plain(made: SimulatedSweeps) -> Outcome:
    return judged(made, made.hits)


def test_whole_sweeps_that_are_wrong_lose_their_weight(
    made: SimulatedSweeps, plain: Outcome
) -> None:
    """4 % of the sweeps: the pose is as good as without, not the share of their errors of mrad."""
    angle = wrong_sweeps(made.hits, np.random.default_rng(3), 0.04)
    wrong = judged(made, replace(made.hits, angle_rad=angle))
    assert plain.mm < 0.5 and wrong.mm < 0.5 and wrong.z < 1
    assert np.trace(wrong.covariance) < 1.5 * np.trace(plain.covariance)  # rotor models open


def test_a_board_within_what_is_stated_of_it_is_good_and_a_stretched_one_is_not() -> None:
    made, rng = hand(2), np.random.default_rng(5)
    board = made.truth.board
    assert judged(made, made.hits, board + 2e-4 * rng.normal(size=board.shape)).word == "good"
    assert judged(made, made.hits, board * [1, 1.01, 1]).word == "doubtful"
    uneven = hand(2, out_of_plane_m=2e-4)  # of a flat file: errors of places are no third extent
    assert judged(uneven, uneven.hits, uneven.truth.board * [0, 1, 1]).word == "good"


POSE = PoseEstimate("batch", "final", "factory", np.eye(3), np.ones(3))


@pytest.mark.parametrize(
    ("batch", "other", "index"),
    [
        (Halves(1.0, 0.01, 5.0), Halves(4.0, 0.1, 5.0), 0),
        (Halves(60.0, 0.5, 90.0), Halves(20.0, 0.1, 20.0), 1),
        (Halves(60.0, 0.5, 90.0), Halves(20.0, 0.4, 20.0), 0),  # no better in angle
        (Halves(60.0, 0.5, 20.0), Halves(20.0, 0.1, 20.0), 0),  # within chance
        (Halves(60.0, 0.5, 90.0), None, 0),
        (None, Halves(20.0, 0.1, 20.0), 0),
    ],
)
def test_the_pose_is_chosen_by_how_parts_predict_each_other(batch, other, index: int) -> None:
    poses = replace(POSE, halves=batch), replace(POSE, estimator="paper-lm", halves=other)
    assert chosen(poses) == index


def test_a_board_that_moves_for_a_third_of_the_time_is_not_still() -> None:
    n, rng = 300, np.random.default_rng(7)
    t = np.array([2.0, 0, 0]) + 1e-3 * rng.normal(size=(n, 3))
    R, zero = np.tile(np.eye(3), (n, 1, 1)), np.zeros(n)
    path = Path(np.arange(n) / 30, R, t, zero, zero, zero)
    assert is_still(path)
    alone = t.copy()
    alone[[20, 90, 91, 200]] += 1.0  # single wrong poses are no motion
    assert is_still(replace(path, t_m=alone))
    moving = t.copy()
    moving[200:] += np.linspace(0, 0.3, 100)[:, None]
    assert not is_still(replace(path, t_m=moving))


def test_hits_that_determine_nothing_are_a_reason_and_no_crash(
    made: SimulatedSweeps, monkeypatch
) -> None:
    """Whatever fails in linear algebra."""

    def singular(*_: object, **__: object) -> None:
        raise np.linalg.LinAlgError("Singular matrix")

    monkeypatch.setattr(stages, "agreed_paths", singular)
    factories = [station.factory for station in made.truth.stations]
    found = calibrate(made.hits, made.truth.board, factories, BATCH)
    assert found.why == ["factory optics: the hits do not determine a pose (Singular matrix)"]
    assert summary(found, made.truth.stations).verdict.word == "failed"


@pytest.mark.parametrize(
    ("sway", "begin", "still"),
    [(0, 0, True), (1, 0, True), (5, 0, False), (100, 320, False), (100, 392, False)],
)
def test_a_board_whose_angles_are_white_noise_is_at_rest(
    sway: float, begin: int, still: bool
) -> None:
    """400 turns of eight diodes, sway in standard deviations of the noise of a hit, from a turn."""
    turn, diode = (grid.ravel() for grid in np.mgrid[:400, :8])
    noise = np.random.default_rng(1).standard_normal(turn.size)
    angle = 0.1 * diode + 25e-6 * (noise + sway * (turn >= begin) * np.sin(turn / 50))
    none = np.zeros(turn.size, np.int8)
    hits = Hits(none, none, turn, diode, 0.02 * turn, angle, 4e-6 + none)
    assert is_constant(hits, 8) == still


@pytest.mark.parametrize(("ratio", "guess"), [(98.0, True), (100.0, False), (np.inf, False)])
def test_a_mirrored_pose_is_excluded_beyond_chance(ratio: float, guess: bool) -> None:
    """Four diodes leave two degrees of freedom: F exceeds x with the probability 1 / (1 + x)."""
    R, t = np.eye(3), np.zeros(3)
    assert StaticPose(R, t, np.eye(6), 0.0, 16, ratio, ((), ()), R, t).open_mirror == guess


def test_stretches_of_fine_knots_are_judged_together() -> None:
    who = np.arange(160)[:, None].repeat(4, 1) // 20
    off = np.where(who[:, 3] == 4, 1e-3, 1e-4)
    for knot_s, bad in ((0.025, [4]), (0.0125, [4, 5])):
        one = Some(trajectory=Some(knot_s=knot_s), seen=Some(who=who), alone=off)
        assert np.flatnonzero(_bad_stretches(one, False, 3.0)).tolist() == bad
