"""Claims that many realisations decide: closed form for white noise, plain sums for random walk."""

import math

import numpy as np
import pytest

from mocap_metrology.noise.model.components import NoiseModel
from mocap_metrology.noise.twins.twin import Twin
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
