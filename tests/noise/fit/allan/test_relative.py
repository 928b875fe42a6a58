"""The compiled curves against `model`, their derivatives against differences, the refusals."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.allan.relative import SearchRange, misfit
from mocap_metrology.noise.fit.estimates import Components
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel

RATE = 120.0
TAU0 = 1 / RATE
M = np.unique(np.round(np.logspace(0, 6, 60))).astype(int)
ALL = Components((-2, -1, 0, 1, 2), 4, True)
FORMS = ("continuous", "sampled")


def white_and_walk(form="sampled"):
    return NoiseModel.from_coefficients({"h_0": 1e-6, "h_-2": 4e-10}).avar(M, RATE, form)


@pytest.mark.parametrize("form", FORMS)
def test_curves_and_cost_are_those_of_the_model(form):
    avar = white_and_walk()
    problem = misfit(M, avar, RATE, ALL, form)
    rng = np.random.default_rng(1)
    for x in rng.uniform(problem.lower, problem.upper, size=(20, problem.lower.size)):
        model = problem.model(x)
        curve = model.avar(M, RATE, form)
        assert avar * (1 + problem.residual(x)[0]) == pytest.approx(curve, rel=1e-10)
        cost = np.sum(((avar - curve) / avar) ** 2)
        assert problem.cost(x) == pytest.approx(cost, rel=1e-9)
        assert problem.costs(x[None])[0] == problem.cost(x)


@pytest.mark.parametrize("form", FORMS)
def test_gauss_markov_over_its_whole_range(form):
    within = SearchRange(shortest_frames=0.1, longest_share=1.0)
    problem = misfit(M, white_and_walk(), RATE, Components((), 1), form, within=within)
    for log_T in np.linspace(problem.lower[1], problem.upper[1], 200):
        x = np.array([0.0, log_T])
        curve = problem.model(x).avar(M, RATE, form)
        assert problem.avar * (1 + problem.residual(x)[0]) == pytest.approx(curve, rel=1e-10)


@pytest.mark.parametrize("weighting", ["relative", "equal"])
@pytest.mark.parametrize("form", FORMS)
def test_derivatives(form, weighting):
    problem = misfit(M, white_and_walk(), RATE, ALL, form, weighting)
    rng = np.random.default_rng(2)
    step = 1e-5
    for x in rng.uniform(problem.lower, problem.upper, size=(5, problem.lower.size)):
        jacobian = problem.residual(x)[1]
        for i, row in enumerate(jacobian):
            e = step * (np.arange(x.size) == i)
            slope = (problem.residual(x + e)[0] - problem.residual(x - e)[0]) / (2 * step)
            # Absolute error of a central difference of numbers the size of the whole misfit
            least = 1e-9 * (1 + np.abs(problem.residual(x)[0]).max()) / step * 1e-2
            assert row == pytest.approx(slope, abs=1e-4 * np.abs(row).max() + least)


def test_equal_weights_are_ordinary_least_squares():
    avar = white_and_walk()
    problem = misfit(M, avar, RATE, ALL, weighting="equal")
    x = (problem.lower + problem.upper) / 2
    curve = problem.model(x).avar(M, RATE, "continuous")
    ratio = np.sum((avar - curve) ** 2) / np.mean(avar**2)
    assert problem.cost(x) == pytest.approx(ratio, rel=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_point_is_the_inverse_of_model(form):
    problem = misfit(M, white_and_walk(), RATE, ALL, form)
    x = np.random.default_rng(3).uniform(problem.lower, problem.upper)
    model = problem.model(x)
    times = [c.T_c for c in model.components if isinstance(c, GaussMarkov)]
    assert times == sorted(times)
    again = problem.model(problem.point(model)).coefficients()
    assert again == pytest.approx(model.coefficients(), rel=1e-9)


def test_polished_reaches_the_minimum_that_generated_the_data():
    truth = NoiseModel.from_coefficients({"h_0": 1e-6, "q_c1": 0.01, "T_c1": 0.5})
    problem = misfit(M, truth.avar(M, RATE), RATE, Components.of(truth), "sampled")
    start = problem.point(truth) + np.array([-2.0, 1.0, 0.7])
    x, cost = problem.polished(start)
    assert cost < 1e-20
    assert problem.model(x).coefficients() == pytest.approx(truth.coefficients(), rel=1e-7)


def test_polished_stops_at_bounds_and_says_so():
    white = NoiseModel.from_coefficients({"h_0": 1e-6}).avar(M, RATE)
    problem = misfit(M, white, RATE, Components((-2, 0), 1))
    x, cost = problem.polished((problem.lower + problem.upper) / 2)
    flags = problem.at_bound(x)
    assert np.all(x >= problem.lower) and np.all(x <= problem.upper) and cost < 1e-5
    assert flags["h_-2"] and not flags["h_0"]
    # Amplitude on its bound: the component is absent, and so is its time constant
    x[problem.components.names.index("q_c1")] = problem.lower[2]
    assert problem.at_bound(x)["q_c1"] and problem.at_bound(x)["T_c1"]


def test_bounds_follow_the_component_when_terms_change_places():
    problem = misfit(M, white_and_walk(), RATE, Components((), 2))
    x = np.array([-2.0, problem.upper[1], -3.0, problem.lower[3]])
    assert problem.at_bound(x) == {"q_c1": False, "T_c1": True, "q_c2": False, "T_c2": True}
    x = np.array([-2.0, problem.upper[1], -3.0, 0.0])
    assert problem.at_bound(x) == {"q_c1": False, "T_c1": False, "q_c2": False, "T_c2": True}


def test_order_of_the_averaging_times_does_not_matter():
    avar = white_and_walk()
    order = np.random.default_rng(4).permutation(M.size)
    first, second = (misfit(M[o], avar[o], RATE, ALL) for o in (slice(None), order))
    x = (first.lower + first.upper) / 2
    assert first.cost(x) == second.cost(x)


GOOD = {"m": M, "avar": white_and_walk(), "frame_rate_hz": RATE, "components": ALL}
BAD = {
    "NaN": ({"avar": np.where(M == 1, np.nan, 1.0)}, "m = 1: nan, expected a number > 0"),
    "zero": ({"avar": np.where(M > 1, 1.0, 0.0)}, "m = 1: 0.0, expected a number > 0"),
    "negative": ({"avar": np.full(M.size, -1.0)}, "expected a number > 0"),
    "too few": ({"m": M[:14], "avar": np.ones(14)}, "14 Allan variances for 15 coefficients"),
    "lengths": ({"m": M[:20]}, "expected equal"),
    "m twice": ({"m": np.ones(M.size)}, "different whole numbers"),
    "m broken": ({"m": M + 0.5}, "different whole numbers"),
    "frame rate": ({"frame_rate_hz": 0.0}, "frame rate 0.0 Hz"),
    "form": ({"form": "textbook"}, "form 'textbook'"),
    "nothing to fit": ({"components": Components((), 0)}, "at least one component"),
    "short recording": (
        {"m": np.arange(1, 17), "avar": np.ones(16), "duration": 0.15},
        "expected a longer recording",
    ),
    "recording below tau": ({"duration": 5.0}, "recording of 5.0 s, expected more"),
    "no duration": ({"duration": np.nan}, "recording of nan s"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_refused_in_one_line(case):
    change, expected = BAD[case]
    with pytest.raises(Refusal) as refusal:
        misfit(**(GOOD | change))
    assert expected in str(refusal.value) and "\n" not in str(refusal.value)


@pytest.mark.parametrize(
    "change", [{"negligible": 0.0}, {"shortest_frames": 0.0}, {"longest_share": 2.0}]
)
def test_impossible_ranges_are_refused(change):
    with pytest.raises(Refusal, match="search range"):
        dataclasses.replace(SearchRange(), **change)
