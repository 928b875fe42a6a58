"""Claims that many realisations decide: closed form for white noise, plain sums for random walk."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.twin import Slow, Twin
from mocap_metrology.present.claims.claim import DOES_NOT, HOLDS, UNKNOWN, unknown
from mocap_metrology.present.claims.realisations import draw, of_realisations
from mocap_metrology.present.claims.study import TYPES, Drawn, Key
from mocap_metrology.present.claims.table import claim_rows, claims, claims_markdown

BY_ID = claims()
NS = TYPES["T40"]
LAW = BY_ID["S-4.2-sigma-T40"]
REPEATS = 300


def twins(coefficient: str, exponent: float) -> dict[Key, Twin]:
    """T40 subsets with h = 1e-5 n^exponent in all coordinates, each of its own seed."""
    names = [f"{axis}{k}" for axis in "xyz" for k in (1, 2)]
    found = {}
    for n in NS:
        model = NoiseModel.from_coefficients({coefficient: 1e-5 * n**exponent})
        models = dict.fromkeys(names, model)
        found["T40", n] = Twin(f"T40-{n}", n, models, duration_s=2000.0)
    return found


@pytest.mark.parametrize(("exponent", "word"), [(-1.0, HOLDS), (-2.0, DOES_NOT)])
def test_white_noise_leaves_nothing_to_chance(exponent: float, word: str) -> None:
    draws = draw(twins("h_0", exponent), repeats=20)
    sigma = draws[0].gaussian(("T40", 10))["sigma_1_mm"]
    assert sigma == pytest.approx(math.sqrt(60e-5 * 10**exponent), rel=0.01)  # sqrt(h_0 f_h)
    found, counted = of_realisations(LAW, unknown("x"), draws)
    assert (found.word, counted) == (word, f"holds in {20 if word == HOLDS else 0} of 20")


def exponents_of_random_walks(repeats: int) -> np.ndarray:
    """(repeats, 2) of sigma = a n^-b for sums of normal steps, sigma_step ~ n^-1/2."""
    rng = np.random.default_rng(7)
    log_n = np.log(NS)
    found = []
    for _ in range(repeats):
        walk = rng.standard_normal((2, len(NS), 1000)).cumsum(axis=2)
        sigma = walk.std(axis=2) / np.sqrt(NS)
        found.append(-np.polyfit(log_n, np.log(sigma).T, 1)[0])
    return np.array(found)


def test_random_walk_is_left_to_chance() -> None:
    draws = draw(twins("h_-2", -1.0), repeats=REPEATS)
    sigma = np.array(
        [[[one.gaussian(("T40", n))[f"sigma_{k}_mm"] for n in NS] for k in (1, 2)] for one in draws]
    )
    drawn = -np.polyfit(np.log(NS), np.log(sigma).reshape(-1, len(NS)).T, 1)[0]
    plain = exponents_of_random_walks(REPEATS).ravel()
    # two samples of 600: quantiles of a spread of 0.25 within 0.06 (5 standard errors)
    np.testing.assert_allclose(
        np.quantile(drawn, [0.16, 0.5, 0.84]), np.quantile(plain, [0.16, 0.5, 0.84]), atol=0.06
    )
    found, counted = of_realisations(LAW, unknown("x"), draws)
    decide = int(counted.split()[4])
    assert found.word == UNKNOWN and counted.endswith(f"that decide, {REPEATS} drawn")
    assert 0.05 < decide / REPEATS < 0.15  # x1 and x2 denied in 5 % each, though true


def test_random_walk_of_one_history_is_not() -> None:
    """Subsets of one recording: the walk scales with its coefficient and nothing else."""
    take = Slow("T40", 0.1)
    alike = {key: replace(t, seed=1, slow=take) for key, t in twins("h_-2", -1.0).items()}
    draws = draw(alike, repeats=20)
    for one in draws:
        sigma = [one.gaussian(("T40", n))["sigma_1_mm"] for n in NS]
        assert sigma * np.sqrt(NS) == pytest.approx(sigma[0] * math.sqrt(NS[0]), rel=1e-6)
    found, counted = of_realisations(LAW, unknown("x"), draws)
    assert (found.word, counted) == (HOLDS, "holds in 20 of 20")


def scattered(exponent: float, scatter: float, rng: np.random.Generator, repeats: int):
    """Draws of T40 with sigma = n^-exponent times normal scatter of ln sigma."""
    return [
        Drawn(
            {
                ("T40", n): {
                    f"sigma_{k}_mm": float(np.exp(scatter * rng.normal()) * n**-exponent)
                    for k in (1, 2)
                }
                for n in NS
            }
        )
        for _ in range(repeats)
    ]


@pytest.mark.parametrize("scatter", [0.5, 0.8])
@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0])
def test_scatter_is_no_law(exponent: float, scatter: float) -> None:
    """500 draws: the law holds in 1 % at most of whatever exponent (47 to 82 % if a wide error
    were enough); of a true one it is denied in 5 % each of x1 and x2 (within 3 errors)."""
    draws = scattered(exponent, scatter, np.random.default_rng(8), 500)
    words = [LAW.find(one).word for one in draws]
    assert words.count(HOLDS) <= 5
    if exponent == 0.5:
        assert 0.055 < words.count(DOES_NOT) / 500 < 0.14
        assert of_realisations(LAW, unknown("x"), draws)[0].word == UNKNOWN


@pytest.mark.parametrize(("exponent", "word"), [(0.0, DOES_NOT), (0.5, HOLDS), (1.0, DOES_NOT)])
def test_draws_that_cannot_tell_do_not_count(exponent: float, word: str) -> None:
    """Precise draws, and one in five that mostly says nothing."""
    rng = np.random.default_rng(9)
    draws = scattered(exponent, 0.03, rng, 80) + scattered(exponent, 1.0, rng, 20)
    words = [LAW.find(one).word for one in draws]
    decide = 100 - words.count(UNKNOWN)
    found, counted = of_realisations(LAW, unknown("x"), draws)
    assert found.word == word
    assert counted == f"holds in {words.count(HOLDS)} of {decide} that decide, 100 drawn"
    assert 80 <= decide <= 90


def test_what_is_not_by_chance_or_not_there_stays_as_it_was() -> None:
    found = unknown("x")
    draws = draw(twins("h_0", -1.0), repeats=2)
    assert of_realisations(BY_ID["S-4.2-law-T40"], found, draws) == (found, "")
    assert of_realisations(BY_ID["S-4.2-covariance"], found, draws) == (found, "")  # no Bonita
    assert of_realisations(LAW, found, []) == (found, "")


def test_table_says_in_how_many() -> None:
    moments = {"sigma_1_mm": 1.0, "sigma_2_mm": 1.0, "sigma_12_mm2": 0.0, "rho_12": 0.0}
    flat = [Drawn({(kind, n): moments for kind, ns in TYPES.items() for n in ns})] * 4
    rows = {row["id"]: row for row in claim_rows(None, None, ("twin", ""), flat)}
    assert rows["S-4.2-sigma-T40"]["realisations"] == "holds in 0 of 4"
    assert rows["S-4.2-covariance"]["regenerated_word"] == HOLDS
    assert "holds in 4 of 4" in claims_markdown(list(rows.values()))
