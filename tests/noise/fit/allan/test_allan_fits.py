"""Fits of Allan variances: curves, derivatives, truths recovered, other optimisers not better;
slopes of curves in closed form."""

from functools import partial

import numpy as np
import pytest
from scipy.optimize import least_squares, nnls

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.allan.annealing import _estimate, annealing_run
from mocap_metrology.noise.fit.allan.baselines import levenberg_marquardt, slopes
from mocap_metrology.noise.fit.allan.relative import misfit
from mocap_metrology.noise.fit.estimates import Components
from mocap_metrology.noise.model.components import FORMS, NoiseModel
from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.settings import Annealing

RATE = 120.0
TAU0 = 1 / RATE
M = np.unique(np.round(np.logspace(0, np.log10(1_296_000), 116))).astype(int)
SETTINGS = Annealing(longest_tau_share=1.0)
TRUTH = NoiseModel.from_coefficients(
    {"h_-2": 4e-10, "h_0": 1e-6, "q_c1": 0.012, "T_c1": 0.3, "q_c2": 0.002, "T_c2": 6.0}
)
ALL = Components((-2, -1, 0, 1, 2), 4, True)


def of(**coefficients):
    return NoiseModel.from_coefficients({k.replace("__", "_-"): v for k, v in coefficients.items()})


WALK = of(h_0=1e-6, h__2=4e-10)
LM = partial(levenberg_marquardt, seed=1)


def scattered(model, seed, form="sampled"):
    """Variances with about the scatter of nine hours: edf falls as 1/m (independent taus)."""
    degrees = np.maximum(3e6 / M, 2.0)
    scatter = np.random.default_rng(seed).chisquare(degrees) / degrees
    return model.avar(M, RATE, form) * scatter


def annealed(avar, components, settings=SETTINGS, seed=1, form="continuous", duration=None):
    if isinstance(components, NoiseModel):
        components = Components.of(components)
    return annealing_run(M, avar, RATE, components, settings, seed, form, duration)


def statuses(estimate):
    return {c.parameter: c.status for c in estimate.coefficients}


@pytest.mark.parametrize("weighting", ["relative", "equal"])
@pytest.mark.parametrize("form", FORMS)
def test_curves_costs_and_derivatives_are_those_of_the_model(form, weighting):
    m = M[::2]
    avar = WALK.avar(m, RATE)
    problem = misfit(m, avar, RATE, ALL, form, weighting, SETTINGS)
    step, rng = 1e-5, np.random.default_rng(1)
    for x in rng.uniform(problem.lower, problem.upper, size=(10, problem.lower.size)):
        r, jacobian = problem.residual(x)
        curve = problem.model(x).avar(m, RATE, form)
        off = avar - curve
        weight = 1 / avar if weighting == "relative" else 1 / np.sqrt(np.mean(avar**2))
        assert r == pytest.approx(-off * weight, rel=1e-8, abs=1e-10)
        assert problem.costs(x[None])[0] == pytest.approx(np.sum((off * weight) ** 2), rel=1e-9)
        for i, row in enumerate(jacobian):
            e = step * (np.arange(x.size) == i)
            slope = (problem.residual(x + e)[0] - problem.residual(x - e)[0]) / (2 * step)
            # Absolute error of a central difference of numbers the size of the whole misfit
            least = 1e-11 * (1 + np.abs(r).max()) / step
            assert row == pytest.approx(slope, abs=1e-4 * np.abs(row).max() + least)


def test_polished_stops_at_bounds_and_says_so():
    white = of(h_0=1e-6).avar(M, RATE)
    problem = misfit(M, white, RATE, Components((-2, 0), 1))
    x, cost = problem.polished((problem.lower + problem.upper) / 2)
    flags = problem.at_bound(x)
    assert np.all(x >= problem.lower) and np.all(x <= problem.upper) and cost < 1e-5
    assert flags["h_-2"] and not flags["h_0"]
    # Amplitude on its bound: the component is absent, and so is its time constant
    x[problem.components.names.index("q_c1")] = problem.lower[2]
    assert problem.at_bound(x)["q_c1"] and problem.at_bound(x)["T_c1"]
    # Terms are named by rising T_c, whatever their order among the coordinates
    problem = misfit(M, white, RATE, Components((), 2))
    names = ["q_c1", "T_c1", "q_c2", "T_c2"]
    for last, at in ((problem.lower[3], [0, 1, 0, 1]), (0.0, [0, 0, 0, 1])):
        x = np.array([-2.0, problem.upper[1], -3.0, last])
        assert problem.at_bound(x) == dict(zip(names, map(bool, at), strict=True))


@pytest.mark.parametrize("seed", range(3))
def test_recovers_the_truth_from_every_seed_and_better_than_scipy(seed):
    """scipy's trust region, started at the truth, with `model`'s curves and its own derivatives."""
    exact = annealed(TRUTH.avar(M, RATE), TRUTH, seed=seed, form="sampled").estimate
    assert exact.values == pytest.approx(TRUTH.coefficients(), rel=1e-3)
    assert {*statuses(exact).values()} == {"ok"}
    assert exact.estimator == "annealing-ant-colony" and exact.form == "sampled"
    assert all(np.isnan([c.std_error, c.crlb, c.upper_95]).all() for c in exact.coefficients)
    names, avar = list(TRUTH.coefficients()), scattered(TRUTH, seed)

    def residual(x):
        model = NoiseModel.from_coefficients(dict(zip(names, np.exp(x), strict=True)))
        return 1 - model.avar(M, RATE) / avar

    other = least_squares(residual, np.log(list(TRUTH.coefficients().values())))
    found = annealed(avar, TRUTH, seed=seed, form="sampled").estimate
    assert found.cost <= 2 * other.cost * (1 + 1e-6)
    assert found.cost == pytest.approx(np.sum(residual(np.log(list(found.values.values()))) ** 2))


@pytest.mark.parametrize("key, series", [(("T40", 10), "z1"), (("T40", 6), "x1")])
def test_recovers_a_published_row_of_four_terms(key, series):
    truth = published_row(*key)[series]
    run = annealed(truth.avar(M, RATE, "continuous"), truth)
    assert run.estimate.cost < 1e-6
    expected = truth.ordered().coefficients()
    for name in set(expected) - {"h_-1", "h_1", "h_2"}:  # the others are hidden
        assert run.estimate.values[name] == pytest.approx(expected[name], rel=0.02), name


@pytest.mark.parametrize(
    ("starts", "equal", "status"), [(3, 2, "ok"), (3, 1, "not_converged"), (1, 1, "ok")]
)
def test_a_result_has_converged_where_two_starts_or_the_only_one_reach_it(starts, equal, status):
    settings = SETTINGS.model_copy(update={"starts": starts})
    avar = WALK.avar(M, RATE, "continuous")
    problem = misfit(M, avar, RATE, Components.of(WALK), "continuous", "relative", settings)
    x, cost = problem.polished((problem.lower + problem.upper) / 2, 200)
    found = _estimate(problem, x, cost, [problem.model(x)] * equal, settings)
    assert {*statuses(found).values()} == {status}


def test_what_the_colony_gains_is_the_ratio_of_the_relative_squares():
    """Sums of ((avar - model) / avar)^2 (S Eq. 13) of the best start and of what the colony found,
    without Levenberg-Marquardt."""
    avar = TRUTH.avar(M, RATE, "continuous")
    plain = {"descent": 0, "starts": 2, "iterations": 20, "colony_iterations": 120}
    run = annealed(avar, TRUTH, SETTINGS.model_copy(update=plain))
    found = NoiseModel.from_coefficients(run.estimate.values)
    start, end = (
        min(float(np.sum((1 - one.avar(M, RATE, "continuous") / avar) ** 2)) for one in models)
        for models in (run.starts, [found])
    )
    assert run.colony_gain == pytest.approx(start / end, rel=1e-6) and end < 1 < run.colony_gain


@pytest.mark.parametrize("kind", ["relative", "equal"])
def test_power_laws_alone_are_non_negative_least_squares(kind):
    truth = {"h_-2": 4e-10, "h_-1": 1e-6, "h_0": 1e-6}
    alphas = (-2, -1, 0, 1) if kind == "relative" else (-2, -1, 0)
    avar = scattered(NoiseModel.from_coefficients(truth), 7, "continuous")
    curves = [
        NoiseModel.from_coefficients({f"h_{a}": 1.0}).avar(M, RATE, "continuous") for a in alphas
    ]
    weight = 1 / avar if kind == "relative" else np.full(M.size, 1 / np.sqrt(np.mean(avar**2)))
    matrix = np.array(curves).T * weight[:, None]
    size = np.linalg.norm(matrix, axis=0)  # nnls on columns of one size: they differ by 1e9
    h, residual = nnls(matrix / size, avar * weight)
    if kind == "relative":
        found = annealed(avar, Components(alphas, 0), seed=3).estimate
    else:
        found = LM(M, avar, RATE, Components(alphas, 0))
    assert found.cost == pytest.approx(residual**2, rel=1e-3)
    for alpha, expected in zip(alphas, h / size, strict=True):
        if expected > 1e-3 * truth.get(f"h_{alpha}", 0.0):
            assert found.values[f"h_{alpha}"] == pytest.approx(expected, rel=0.01)
        elif kind == "relative":
            assert statuses(found)[f"h_{alpha}"] == "at_bound"


BAD = {
    "NaN": ({"avar": np.where(M == 1, np.nan, 1.0)}, "m = 1: nan, expected a number > 0"),
    "zero": ({"avar": np.where(M > 1, 1.0, 0.0)}, "m = 1: 0.0, expected a number > 0"),
    "negative": ({"avar": np.full(M.size, -1.0)}, "(116 of 116 are none)"),
    "lengths": ({"m": M[:20]}, "expected equal"),
    "m twice": ({"m": np.ones(M.size)}, "different whole numbers"),
    "m broken": ({"m": M + 0.5}, "different whole numbers"),
    "form": ({"form": "textbook"}, "form 'textbook'"),
    "nothing to fit": ({"components": Components((), 0)}, "at least one component"),
    "short recording": (
        {"m": np.arange(1, 17), "avar": np.ones(16), "duration": 0.15},
        "expected a longer",
    ),
    "no duration": ({"duration": np.nan}, "recording of nan s"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_refused_in_one_line(case):
    change, expected = BAD[case]
    good = {"m": M, "avar": WALK.avar(M, RATE), "frame_rate_hz": RATE, "components": ALL}
    with pytest.raises(Refusal) as refusal:
        misfit(**(good | change))
    assert expected.replace("116", str(M.size)) in str(refusal.value)
    assert "\n" not in str(refusal.value)


def read(coefficients, form="continuous"):
    return slopes(M, NoiseModel.from_coefficients(coefficients).avar(M, RATE, form), RATE)


@pytest.mark.parametrize("form", ["continuous", "sampled"])
@pytest.mark.parametrize("name, value", [("h_0", 1e-6), ("h_-1", 3e-7), ("h_-2", 4e-10)])
def test_one_noise_is_read_exactly_and_nothing_else_is_seen(name, value, form):
    found = read({name: value}, form)
    assert found.values == pytest.approx({name: value}, rel=1e-6)
    missing = [c for c in found.coefficients if c.parameter != name]
    assert [c.status for c in missing] == ["not_detected"] * 2
    assert all(np.isnan(c.value) and not c.detected for c in missing)


def test_textbook_coefficients():
    """AVAR = N^2/tau, (2 ln 2 / pi) B^2, K^2 tau / 3 [IEEE Std 952], N = 2, B = 3, K = 5."""
    tau = M * TAU0
    for avar, name, h in (
        (2**2 / tau, "h_0", 2 * 2**2),
        (2 * np.log(2) / np.pi * 3**2 + 0 * tau, "h_-1", 3**2 / np.pi),
        (5**2 * tau / 3, "h_-2", 5**2 / (2 * np.pi**2)),
    ):
        assert slopes(M, avar, RATE).values == pytest.approx({name: h}, rel=1e-9)


@pytest.mark.parametrize(
    ("count", "value", "expected"),
    [(116, np.nan, "expected a number > 0"), (116, 0.0, "a number > 0"), (3, 1.0, "expected more")],
)
def test_bad_input_is_refused(count, value, expected):
    m = M[:count]
    with pytest.raises(Refusal, match=expected):
        slopes(m, np.full(m.size, value), RATE)
