"""Simulated recordings of studies have the circumstances that they are named by."""

import numpy as np
import pytest

from mocap_metrology.papers.studies.study import Case, draw, spread_out, twin_of


@pytest.mark.parametrize(("distance_m", "baseline_m"), [(2.0, 2.0), (3.0, 4.0), (1.0, 1.0)])
def test_places_of_board_and_stations(distance_m: float, baseline_m: float) -> None:
    case = Case(distance_m=distance_m, baseline_m=baseline_m)
    for seed in range(20):
        twin = twin_of(case, 1.0, np.random.default_rng(seed))
        assert twin.slave is not None
        centre = np.array(twin.motion.centre_m)
        assert np.linalg.norm(centre) == pytest.approx(distance_m)
        assert np.linalg.norm(centre - twin.slave.t) == pytest.approx(distance_m)
        assert np.linalg.norm(twin.slave.t) == pytest.approx(baseline_m)
        there = twin.slave.R.T @ (centre - twin.slave.t) / distance_m
        assert there[0] > np.cos(np.radians(15))  # both stations look at the board
        assert centre[0] > distance_m * np.cos(np.radians(19))


def test_lasers_are_at_their_distance_and_the_truth_is_between_the_optics() -> None:
    drawn = draw(Case(laser_offset_mm=25.0), 0.2, np.random.default_rng(1))
    np.testing.assert_allclose(np.linalg.norm(drawn.lasers_m, axis=2), 0.025)
    same = draw(Case(), 0.2, np.random.default_rng(1))  # without offsets
    master, slave = drawn.origins_m
    np.testing.assert_allclose(drawn.t_optical_m, same.t_optical_m + drawn.R @ slave - master)


def test_few_diodes_have_the_hits_of_the_whole_board() -> None:
    few = draw(Case(n_diodes=4), 0.2, np.random.default_rng(2))
    every = draw(Case(), 0.2, np.random.default_rng(2))
    chosen = spread_out(every.board, 4)
    np.testing.assert_array_equal(few.board, every.board[chosen])
    assert set(few.hits.diode) == {0, 1, 2, 3}
    for number, diode in enumerate(chosen):
        own, whole = few.hits.diode == number, every.hits.diode == diode
        np.testing.assert_array_equal(few.hits.angle_rad[own], every.hits.angle_rad[whole])
