"""Claims that many realisations decide: closed form for white noise, plain sums for random walk."""

import math

import numpy as np
import pytest

from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.twin import Slow, Twin
from mocap_metrology.papers import gaussian_table
from mocap_metrology.papers.claims import decide
from mocap_metrology.papers.claims.decide import DOES_NOT, HOLDS, UNKNOWN
from mocap_metrology.papers.claims.study import TYPES, Moments
from mocap_metrology.papers.claims.table import claims, decisions, of_realisations, realisations
from mocap_metrology.present.claims import claim_rows

NS = TYPES["T40"]
LAW = claims()["S-4.2-sigma-T40"]
ONE = decide.finding("x", UNKNOWN)
SIGMAS = ("sigma_1_mm", "sigma_2_mm")


def of_twins(coefficient: str, exponent: float, repeats: int, **how: object) -> Moments:
    """T40 subsets with h = 1e-5 n^exponent in all coordinates, each of its own seed."""
    names = [f"{axis}{k}" for axis in "xyz" for k in (1, 2)]
    moments = {}
    for n in NS:
        model = NoiseModel.from_coefficients({coefficient: 1e-5 * n**exponent})
        rest = {"seed": n, "models": dict.fromkeys(names, model), "duration_s": 2000.0} | how
        twin = Twin(f"T40-{n}", **rest)
        moments["T40", n] = gaussian_table.realisations(twin, repeats, None, 1 << 12)
    return moments


def decided(moments: Moments) -> tuple[str, str]:
    one, counted = of_realisations(LAW, ONE, realisations(moments))
    return one.word, counted


@pytest.mark.parametrize(("exponent", "word"), [(-1.0, HOLDS), (-2.0, DOES_NOT)])
def test_white_noise_leaves_nothing_to_chance(exponent: float, word: str) -> None:
    moments = of_twins("h_0", exponent, 20)
    sigma = moments["T40", 10]["sigma_1_mm"][0]
    assert sigma == pytest.approx(math.sqrt(60e-5 * 10**exponent), rel=0.01)  # sqrt(h_0 f_h)
    assert decided(moments) == (word, f"holds in {20 if word == HOLDS else 0} of 20")


def test_random_walk_is_left_to_chance() -> None:
    """Exponents as those of sums of normal steps: two samples of 600, quantiles of a spread of
    0.25 within 0.06 (5 standard errors)."""
    moments = of_twins("h_-2", -1.0, 300)
    sigma = np.array([[moments["T40", n][name] for n in NS] for name in SIGMAS])
    drawn = -np.polyfit(np.log(NS), np.log(sigma).transpose(1, 0, 2).reshape(len(NS), -1), 1)[0]
    walks = np.random.default_rng(7).standard_normal((600, len(NS), 1000)).cumsum(axis=2)
    plain = -np.polyfit(np.log(NS), np.log(walks.std(axis=2) / np.sqrt(NS)).T, 1)[0]
    quantiles = [np.quantile(v, [0.16, 0.5, 0.84]) for v in (drawn, plain)]
    np.testing.assert_allclose(*quantiles, atol=0.06)
    word, counted = decided(moments)
    assert word == UNKNOWN and counted.endswith("that decide, 300 drawn")
    assert 0.05 < int(counted.split()[4]) / 300 < 0.15  # x1 and x2 denied in 5 % each, though true


def test_random_walk_of_one_history_is_not() -> None:
    """Subsets of one recording: the walk scales with its coefficient and nothing else."""
    moments = of_twins("h_-2", -1.0, 20, seed=1, slow=Slow("T40", 0.1))
    scaled = np.array([moments["T40", n]["sigma_1_mm"] * math.sqrt(n) for n in NS])
    np.testing.assert_allclose(scaled, scaled[:1].repeat(len(NS), axis=0), rtol=1e-6)
    assert decided(moments) == (HOLDS, "holds in 20 of 20")


def scattered(exponent: float, scatter: np.ndarray, seed: int) -> Moments:
    """sigma = n^-exponent times normal scatter of ln sigma, of each draw."""
    rng = np.random.default_rng(seed)
    return {
        ("T40", n): {k: np.exp(scatter * rng.normal(size=scatter.size)) * n**-exponent
                     for k in SIGMAS}
        for n in NS
    }  # fmt: skip


@pytest.mark.parametrize("scatter", [0.5, 0.8])
@pytest.mark.parametrize("exponent", [0.0, 0.5, 1.0])
def test_scatter_is_no_law(exponent: float, scatter: float) -> None:
    """500 draws: the law holds in 1 % at most of whatever exponent (47 to 82 % if a wide error
    were enough); of a true one it is denied in 5 % each of x1 and x2 (within 3 errors)."""
    moments = scattered(exponent, np.full(500, scatter), 8)
    words = [LAW.find(one).word for one in realisations(moments)]
    assert words.count(HOLDS) <= 5
    if exponent == 0.5:
        assert 0.055 < words.count(DOES_NOT) / 500 < 0.14
        assert decided(moments)[0] == UNKNOWN


@pytest.mark.parametrize(("exponent", "word"), [(0.0, DOES_NOT), (0.5, HOLDS), (1.0, DOES_NOT)])
def test_draws_that_cannot_decide_do_not_count(exponent: float, word: str) -> None:
    """Precise draws, and one in five that mostly decides nothing."""
    moments = scattered(exponent, np.repeat([0.03, 1.0], [80, 20]), 9)
    words = [LAW.find(one).word for one in realisations(moments)]
    decide_ = 100 - words.count(UNKNOWN)
    counted = f"holds in {words.count(HOLDS)} of {decide_} that decide, 100 drawn"
    assert decided(moments) == (word, counted) and 80 <= decide_ <= 90


def test_claims_that_chance_does_not_decide() -> None:
    draws = realisations(of_twins("h_0", -1.0, 2))
    for name in ("S-4.2-law-T40", "S-4.2-covariance"):  # not by chance; no Bonita
        assert of_realisations(claims()[name], ONE, draws) == (ONE, "")
    assert of_realisations(LAW, ONE, []) == (ONE, "")
    flat = {"sigma_1_mm": np.ones(4), "sigma_2_mm": np.ones(4), "sigma_12_mm2": np.zeros(4)}
    moments = {(kind, n): flat for kind, ns in TYPES.items() for n in ns}
    rows = {row["id"]: row for row in claim_rows(decisions(None, None, ("twin", ""), moments))}
    assert rows["S-4.2-sigma-T40"]["realisations"] == "holds in 0 of 4"
    assert rows["S-4.2-covariance"]["regenerated_word"] == HOLDS
