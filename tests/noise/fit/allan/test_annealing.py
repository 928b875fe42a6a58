"""The paper's fit: truths recovered, other optimisers not better, what is on a bound said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.allan.annealing import (
    AnnealingSettings,
    annealing_run,
)
from mocap_metrology.noise.fit.allan.relative import SearchRange, misfit
from mocap_metrology.noise.fit.estimates import Components
from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.published import published_row

RATE = 120.0
TAU0 = 1 / RATE
M = np.unique(np.round(np.logspace(0, np.log10(1_296_000), 116))).astype(int)
SETTINGS = AnnealingSettings(longest_tau_share=1.0)
QUICK = AnnealingSettings(starts=2, iterations=1, colony_iterations=10, longest_tau_share=1.0)
TRUTH = NoiseModel.from_coefficients(
    {"h_-2": 4e-10, "h_0": 1e-6, "q_c1": 0.012, "T_c1": 0.3, "q_c2": 0.002, "T_c2": 6.0}
)


def scattered(model, seed, form="sampled", edf=3e6):
    """Variances with about the scatter of nine hours: edf falls as 1/m (independent taus)."""
    rng = np.random.default_rng(seed)
    degrees = np.maximum(edf / M, 2.0)
    return model.avar(M, RATE, form) * rng.chisquare(degrees) / degrees


@pytest.mark.parametrize("seed", range(5))
def test_recovers_the_truth_from_every_seed(seed):
    avar = TRUTH.avar(M, RATE)
    found = annealing_run(M, avar, RATE, Components.of(TRUTH), SETTINGS, seed, "sampled").estimate
    assert found.values == pytest.approx(TRUTH.coefficients(), rel=1e-3)
    assert {c.status for c in found.coefficients} == {"ok"}
    assert found.estimator == "annealing-ant-colony" and found.form == "sampled"
    assert all(np.isnan([c.std_error, c.crlb, c.upper_95]).all() for c in found.coefficients)


@pytest.mark.parametrize("key, series", [(("T40", 10), "z1"), (("T40", 6), "x1")])
def test_recovers_a_published_row_of_four_terms(key, series):
    truth = published_row(*key)[series]
    avar = truth.avar(M, RATE, "continuous")
    run = annealing_run(M, avar, RATE, Components.of(truth), SETTINGS, 1)
    assert run.estimate.cost < 1e-6
    expected = truth.ordered().coefficients()
    visible = [name for name in expected if name not in ("h_-1", "h_1", "h_2")]
    for name in visible:
        assert run.estimate.values[name] == pytest.approx(expected[name], rel=0.02), name


def test_nobody_finds_a_better_fit_to_scattered_variances():
    """scipy's trust region, started at the truth, with `model`'s curves and its own derivatives."""
    from scipy.optimize import least_squares

    names = list(TRUTH.coefficients())
    for seed in range(3):
        avar = scattered(TRUTH, seed)

        def residual(x, avar=avar):
            model = NoiseModel.from_coefficients(dict(zip(names, np.exp(x), strict=True)))
            return 1 - model.avar(M, RATE) / avar

        other = least_squares(residual, np.log(list(TRUTH.coefficients().values())))
        found = annealing_run(
            M, avar, RATE, Components.of(TRUTH), SETTINGS, seed, "sampled"
        ).estimate
        assert found.cost <= 2 * other.cost * (1 + 1e-6)
        assert found.cost == pytest.approx(
            np.sum(residual(np.log(list(found.values.values()))) ** 2)
        )


def test_power_laws_alone_are_non_negative_least_squares():
    from scipy.optimize import nnls

    alphas = (-2, -1, 0, 1, 2)
    truth = NoiseModel.from_coefficients({"h_-2": 4e-10, "h_-1": 1e-6, "h_0": 1e-6, "h_1": 1e-9})
    avar = scattered(truth, 7, "continuous")
    curves = [
        NoiseModel.from_coefficients({f"h_{a}": 1.0}).avar(M, RATE, "continuous") for a in alphas
    ]
    h, residual = nnls(np.array(curves).T / avar[:, None], np.ones(M.size))
    found = annealing_run(M, avar, RATE, Components(alphas, 0), SETTINGS, 3).estimate
    assert found.cost == pytest.approx(residual**2, rel=1e-3)
    for alpha, expected in zip(alphas, h, strict=True):
        if expected > 0:
            assert found.values[f"h_{alpha}"] == pytest.approx(expected, rel=0.01)
        else:
            status = {c.parameter: c.status for c in found.coefficients}
            assert status[f"h_{alpha}"] == "at_bound"


def test_same_seed_same_numbers_and_any_seed_the_same_optimum():
    avar = scattered(TRUTH, 11)
    first, again, other = (
        annealing_run(M, avar, RATE, Components.of(TRUTH), SETTINGS, seed) for seed in (1, 1, 2)
    )
    assert first.estimate == again.estimate or repr(first) == repr(again)
    assert first.starts_cost != other.starts_cost
    assert other.estimate.values == pytest.approx(first.estimate.values, rel=1e-3)


def test_unit_of_length_does_not_matter():
    avar = scattered(TRUTH, 12)
    mm = annealing_run(M, avar, RATE, Components.of(TRUTH), QUICK, 4).estimate
    um = annealing_run(M, 1e6 * avar, RATE, Components.of(TRUTH), QUICK, 4).estimate
    assert um.model.scaled(1e-3).coefficients() == pytest.approx(mm.values, rel=1e-6)


def test_starts_are_reported_with_their_cost():
    avar = scattered(TRUTH, 13)
    run = annealing_run(M, avar, RATE, Components.of(TRUTH), SETTINGS, 5)
    assert len(run.starts) == len(run.starts_cost) == SETTINGS.starts
    for model, cost in zip(run.starts, run.starts_cost, strict=True):
        times = [v for k, v in model.coefficients().items() if k.startswith("T_c")]
        assert times == sorted(times)
        residual = 1 - model.avar(M, RATE, "continuous") / avar
        assert cost == pytest.approx(np.sum(residual**2), rel=1e-8)
    assert run.estimate.cost <= min(run.starts_cost) * (1 + 1e-12)


def test_what_is_not_there_ends_at_a_bound():
    white = NoiseModel.from_coefficients({"h_0": 1e-6})
    found = annealing_run(
        M, white.avar(M, RATE), RATE, Components((-2, 0, 2), 0), SETTINGS, 6
    ).estimate
    assert {c.parameter: c.status for c in found.coefficients} == {
        "h_-2": "at_bound",
        "h_0": "ok",
        "h_2": "at_bound",
    }
    assert found.values["h_0"] == pytest.approx(1e-6, rel=1e-4)


def test_time_constants_beyond_the_range_end_at_its_ends():
    long = NoiseModel.from_coefficients({"h_0": 1e-6, "q_c1": 1e-3, "T_c1": 3000.0})
    found = annealing_run(
        M, long.avar(M, RATE), RATE, Components((0,), 1), SETTINGS, 7, "sampled", duration=20_000.0
    ).estimate
    status = {c.parameter: c.status for c in found.coefficients}
    assert status["T_c1"] == "at_bound" and found.values["T_c1"] == pytest.approx(2000.0)
    # The sampled curve of a term of two frames is beyond what the continuous form can follow
    short = NoiseModel.from_coefficients({"h_0": 1e-6, "q_c1": 0.05, "T_c1": 2 * TAU0})
    found = annealing_run(M, short.avar(M, RATE), RATE, Components((0,), 1), SETTINGS, 8).estimate
    assert found.values["T_c1"] == pytest.approx(2 * TAU0)
    assert {c.parameter: c.status for c in found.coefficients}["T_c1"] == "at_bound"


def test_a_search_that_was_too_short_says_so():
    truth = published_row("T40", 10)["L"]
    hasty = AnnealingSettings(starts=3, iterations=1, descent=0, colony_iterations=0)
    found = annealing_run(M, scattered(truth, 14), RATE, Components.of(truth), hasty, 1).estimate
    assert "not_converged" in {c.status for c in found.coefficients}
    assert "0 of 3 starts reached the cost of the result" in found.note


def test_plain_colony_without_any_descent():
    """Annealing and colony that only compare costs, as in S: the colony has work to do, and with it
    the fit comes within 20 % of the cost of the best valley, never below."""
    truth = NoiseModel.from_coefficients({"h_-2": 4e-10, "h_0": 1e-6, "q_c1": 0.012, "T_c1": 0.3})
    avar = scattered(truth, 21)
    given = replace(SETTINGS, starts=3, plain_iterations=60, plain_colony_iterations=300)
    best = annealing_run(M, avar, RATE, Components.of(truth), given, 1)
    plain = annealing_run(M, avar, RATE, Components.of(truth), given.plain, 1)
    assert best.estimate.estimator == "annealing-ant-colony"
    assert plain.estimate.estimator == "annealing-ant-colony-plain"
    assert best.colony_gain < 1 + 1e-6
    assert plain.colony_gain > 1.001
    assert plain.estimate.cost == pytest.approx(min(plain.starts_cost) / plain.colony_gain)
    assert best.estimate.cost <= plain.estimate.cost < 1.2 * best.estimate.cost
    assert plain.estimate.values["h_0"] == pytest.approx(best.estimate.values["h_0"], rel=0.1)


def test_a_slow_sinusoid_is_not_taken_out_of_chance():
    """A line of 14.4 Hz, half as high as the white noise of a frame: with f_0 from 1 / T and every
    tau, relative residuals give it away for the chance of the longest ones."""
    truth = NoiseModel.from_coefficients({"h_-2": 4e-10, "h_0": 1e-6, "A_s": 0.0035, "f_0": 14.4})
    asked = Components((-2, -1, 0, 1, 2), 1, True)
    bounded, free = (
        AnnealingSettings(starts=4),
        AnnealingSettings(starts=4, lowest_hz=1e-5, longest_tau_share=1.0),
    )
    hits = {True: 0, False: 0}
    for seed in range(4):
        avar = scattered(truth, seed, "continuous")
        for within in (bounded, free):
            found = annealing_run(M, avar, RATE, asked, within, 1, duration=32400.0).estimate
            f_0 = found.values["f_0"]
            assert within is free or 0.01 <= f_0 <= 60
            hits[within is bounded] += abs(f_0 / 14.4 - 1) < 0.1
    assert hits[True] >= 3 > hits[False]


def test_longest_tau_that_is_fitted():
    """3 % of the recording, so what stands beyond does not matter; of a short one three variances
    a coefficient."""
    avar, given = TRUTH.avar(M, RATE), AnnealingSettings(starts=1)
    changed = np.where(M * TAU0 <= 0.03 * 32400, avar, 100 * avar)
    asked = M, avar, RATE, Components((0, 1, -2), 0), given, 1, "sampled", 32400.0
    again = M, changed, *asked[2:]
    assert annealing_run(*again).estimate.cost == annealing_run(*asked).estimate.cost
    within, terms = SearchRange(longest_tau_share=1e-3), Components((0,), 2)
    few = misfit(M[:20], avar[:20], RATE, terms, within=within, duration=100.0)
    assert few.m.size == 15


def test_bad_input_is_refused():
    avar = TRUTH.avar(M, RATE)
    for bad, expected in (
        (np.where(M == 1, np.nan, avar), "nan, expected a number > 0"),
        (np.where(M == 1, 0.0, avar), "0.0, expected a number > 0"),
        (-avar, "expected a number > 0"),
    ):
        with pytest.raises(Refusal, match=expected):
            annealing_run(M, bad, RATE, Components.of(TRUTH), QUICK, 1)
    with pytest.raises(Refusal, match="5 Allan variances for 6 coefficients"):
        annealing_run(M[:5], avar[:5], RATE, Components.of(TRUTH), QUICK, 1)


@pytest.mark.parametrize(
    "bad",
    [
        {"starts": 0},
        {"iterations": 0},
        {"jitter": 0.0},
        {"q": 0.0},
        {"negligible": 0.0},
        {"largest": 0.5},
        {"lowest_hz": 0.0},
        {"longest_tau_share": 0.0},
        {"plain_iterations": 0},
    ],
)
def test_impossible_settings_are_refused(bad):
    with pytest.raises(Refusal, match="expected"):
        AnnealingSettings(**bad)
