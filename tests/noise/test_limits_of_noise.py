"""Limits that rules of the noise apply at, on the shortest series that reach them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.diagnosis import dynamic, events
from mocap_metrology.noise.fit.allan import annealing
from mocap_metrology.noise.fit.estimates import Components
from mocap_metrology.noise.fit.spectral import gaps, likelihood, whittle
from mocap_metrology.noise.fit.spectral.line import Line, folded
from mocap_metrology.noise.fit.spectral.lines import find_slow_lines
from mocap_metrology.noise.gaussian.two_markers import correlation_time, kernel_density
from mocap_metrology.noise.model.deterministic import Deterministic
from mocap_metrology.noise.twins.take import Take, TakeTwin, simulate_take
from mocap_metrology.settings import Annealing


def test_one_valid_sample_has_the_least_correlation_time() -> None:
    """1/2, that of white noise: the sum over lags has no term."""
    assert correlation_time(np.array([math.nan, 3.0, math.nan])) == 0.5
    assert correlation_time(np.array([])) == 0.5


def test_a_constant_series_has_no_density() -> None:
    for series in ([2.0, 2.0, 2.0], [2.0], []):
        found = kernel_density(np.array(series))
        assert found.x.size == found.density.size == 0 and found.bandwidth == 0


def test_the_ratio_of_a_burst_is_that_of_its_variances() -> None:
    """Ten seconds of three times the noise: nine times the Allan variance."""
    rate, rng = 100.0, np.random.default_rng(6)
    series = rng.normal(0, 0.02, 60_000)
    series[30_000:31_000] *= 3
    first = dynamic.dynamic_allan(series, rate)[0]
    assert first.tau_s == 1 / rate
    begin = np.arange(first.ratio.size) * first.hop_s
    inside = (begin > 300) & (begin + first.window_s < 310)
    assert np.mean(first.ratio[inside]) == pytest.approx(9, rel=0.15)
    assert np.nanmedian(first.ratio) == pytest.approx(1, rel=0.05)


def test_averaging_factors_are_no_more_than_asked_where_all_are_distinct() -> None:
    found = averaging_factors(3_000_000, 5, min_m=1000)
    assert found.tolist() == [1000, 5623, 31623, 177828, 1000000]


def test_a_lone_gap_beside_another_is_drawn_given_the_valid_samples_about_it() -> None:
    """Conditional Gaussian: mean K_uk K_kk^-1 x_k, the root of the rest times a draw."""
    rng = np.random.default_rng(8)
    series, lone = rng.normal(size=400), [100, 200, 206]  # the first has no other gap near it
    series[lone] = np.nan
    found = gaps.filled(series, lambda f: 1 / (0.5 + f), 100.0, np.random.default_rng(9))
    covariance = gaps._covariance(lambda f: 1 / (0.5 + f), 100.0, 400)
    level, draws = np.nanmean(series), np.random.default_rng(9).standard_normal(3)
    done = series - level
    for place, draw in zip(lone, draws, strict=True):
        after = [k for k in range(place + 1, place + 40) if np.isfinite(done[k])][:16]
        known = np.r_[place - 16 : place, after]
        K = covariance[np.abs(np.subtract.outer(np.r_[known, place], np.r_[known, place]))]
        L = np.linalg.cholesky(K)
        done[place] = L[-1, :-1] @ np.linalg.solve(L[:-1, :-1], done[known]) + L[-1, -1] * draw
        assert found[place] - level == pytest.approx(done[place], abs=1e-6)


def test_only_what_lies_at_its_end_is_held() -> None:
    """Newton's step of one coefficient: gradient over information; at 0 none goes below it."""
    one, step = np.ones((1, 1)), np.array([-0.1])
    assert whittle._trial(np.array([0.5]), 1, step, one, 0.0, (0.0, 1.0))[0] == pytest.approx(0.4)
    assert whittle._trial(np.array([0.0]), 1, step, one, 0.0, (0.0, 1.0))[0] == 0
    assert whittle._trial(np.array([0.0]), 1, -step, one, 0.0, (0.0, 1.0))[0] == pytest.approx(0.1)


def test_a_wave_in_a_later_stretch_runs_on_from_the_first() -> None:
    search = likelihood._Search([0, 100], 50.0, None, None, None)
    wave = search.wave(Deterministic(drift=3600.0), 1, 4)
    assert wave == pytest.approx([2.0, 2.02, 2.04, 2.06])


def test_errors_of_a_line_near_nyquist_are_those_of_the_inverse_information() -> None:
    rng, n, spacing_s = np.random.default_rng(1), 1000, 0.01
    matrix, line = 30 * rng.normal(size=(12, 3)), Line(2.0, 49.99, 0.3, 1e-4, 100.0)
    x = 2.0 * np.array([math.sin(0.3), math.cos(0.3)])
    covariance = np.linalg.inv(matrix.T @ matrix) * 1e-4 * n / (4 * spacing_s)
    found = folded(line, x, matrix, n, spacing_s)
    along = np.r_[x / 2, 0]
    assert found.f_error == pytest.approx(math.sqrt(covariance[2, 2]) / 10)
    assert found.A_error == pytest.approx(math.sqrt(along @ covariance @ along))


def test_half_of_the_false_alarms_are_for_changes_of_level(monkeypatch) -> None:
    chances = []
    monkeypatch.setattr(events, "alarms", lambda _, p: chances.append(p) or ([], 1))
    monkeypatch.setattr(events, "changes", lambda *given: chances.append(given[-1]) or [])
    assert events.find_events([], {}, {}, 100.0, 0.02, 10.0) == []
    assert chances == [0.01, 0.01]


def test_a_take_has_no_random_walk_unless_it_is_stated() -> None:
    """Of white noise the variance of halves' means is 2 / n of one frame's."""
    take = Take("T40", 6, 1, 0.05)
    series = simulate_take(TakeTwin("t", take, (1, 2, 3, 4), 5, 200.0, 100.0)).position_mm[0, 0]
    halves = series.reshape(40, -1).mean(axis=1)
    assert halves.var(ddof=1) / series.var() == pytest.approx(40 / series.size, rel=0.7)


def test_guides_of_the_colony_are_drawn_by_their_rank() -> None:
    """Socha & Dorigo 2008, Eq. 12; with a small xi an ant is its guide."""
    k, q, seen = 6, 0.4, []

    def costs(points: np.ndarray) -> np.ndarray:
        seen.append(points[:, 0])
        return points[:, 0].copy()

    settings = Annealing(ants=60_000, q=q, xi=1e-9, colony_iterations=1)
    archive = np.arange(k, dtype=float)[::-1, None]
    bounds = np.array([-1.0]), np.array([9.0])
    annealing.colony(costs, archive, bounds, settings, np.random.default_rng(2))
    share = np.bincount(np.rint(seen[1]).astype(int), minlength=k) / 60_000
    weight = np.exp(-(np.arange(k) ** 2) / (2 * (q * k) ** 2))
    assert share == pytest.approx(weight / weight.sum(), abs=0.01)


def test_starts_of_plain_annealing_are_where_it_stopped() -> None:
    """Without a descent from there, as S did it; what can move by more than 5 % at a cost 0.1 % of
    itself higher is named."""
    m = np.array([1, 2, 4, 8, 16, 32, 64, 128])
    avar = 1e-3 / m + 1e-6 * m
    settings = Annealing(starts=2, plain_iterations=20, plain_colony_iterations=1)
    settings = annealing.without_descents(settings)
    of = m, avar, 100.0, Components((-2, 0), 0, False)
    run = annealing.annealing_run(*of, settings, seed=4)
    problem = annealing.misfit(*of, "continuous", "relative", settings, None)
    for cost, seed in zip(run.starts_cost, np.random.SeedSequence(4).spawn(3)[1:], strict=True):
        x = annealing._anneal(problem, settings, np.random.default_rng(seed))
        assert cost == pytest.approx(problem.costs(x[None])[0])
    x, _ = problem.polished(x)
    assert problem.freedom(x, 0.05)["h_0"] == pytest.approx(
        np.sqrt(0.05 * np.linalg.inv(problem.residual(x)[1] @ problem.residual(x)[1].T)[1, 1])
    )


def test_the_tail_is_the_median_of_the_greatest_of_24_parts() -> None:
    x, greatest = np.zeros(24 * 50), np.arange(1.0, 25)
    x[49::50] = greatest
    assert dynamic.tail(x) == pytest.approx(
        12.5 / (math.log(50) + math.log(1 / math.log(2))), rel=0.01
    )


def test_a_slow_wide_line_keeps_the_density_that_was_stated() -> None:
    rng, rate, n = np.random.default_rng(12), 10.0, 20_000
    phase = np.cumsum(rng.normal(0, 0.004, n))
    series = rng.normal(0, 1.0, n) + np.sin(2 * np.pi * 0.03 * np.arange(n) / rate + phase)
    found = [line for line in find_slow_lines(series, rate, lambda f: 0 * f + 0.2) if line.wide]
    assert found and all(line.psd == pytest.approx(0.2) for line in found)
