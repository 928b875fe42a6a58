"""ACO_R on functions whose optimum is known."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.allan.annealing import Colony, colony, jittered


def sphere(x):
    return np.sum(x**2, axis=1)


def ellipsoid(x):
    return np.sum(100.0 ** (np.arange(x.shape[1]) / (x.shape[1] - 1)) * x**2, axis=1)


def branin(x):
    a, b = x.T
    bowl = (b - 5.1 / (4 * np.pi**2) * a**2 + 5 / np.pi * a - 6) ** 2
    return bowl + 10 * (1 - 1 / (8 * np.pi)) * np.cos(a) + 10


def goldstein_price(x):
    a, b = x.T
    p = 1 + (a + b + 1) ** 2 * (19 - 14 * a + 3 * a**2 - 14 * b + 6 * a * b + 3 * b**2)
    q = 30 + (2 * a - 3 * b) ** 2 * (18 - 32 * a + 12 * a**2 + 48 * b - 36 * a * b + 27 * b**2)
    return p * q


def rosenbrock(x):
    a, b = x.T
    return 100 * (a**2 - b) ** 2 + (a - 1) ** 2


# cost, dimensions, lower, upper, optimum, tolerance
FUNCTIONS = {
    "sphere": (sphere, 10, -3.0, 7.0, 0.0, 1e-8),
    "ellipsoid": (ellipsoid, 10, -3.0, 7.0, 0.0, 1e-8),
    "Branin": (branin, 2, -5.0, 15.0, 0.39788735772973816, 1e-8),
    "Goldstein-Price": (goldstein_price, 2, -2.0, 2.0, 3.0, 1e-8),
    "Rosenbrock": (rosenbrock, 2, -5.0, 10.0, 0.0, 1e-8),
    "on the bound": (lambda x: np.sum(x, axis=1), 5, 1.0, 4.0, 5.0, 1e-6),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_finds_the_known_optimum(name):
    costs, d, low, high, optimum, tolerance = FUNCTIONS[name]
    lower, upper = np.full(d, low), np.full(d, high)
    settings = Colony(archive=50, ants=10, q=0.1, iterations=1500)
    rng = np.random.default_rng(2008)
    archive = rng.uniform(lower, upper, size=(settings.archive, d))
    found = colony(costs, archive, lower, upper, settings, rng)
    assert found.cost == pytest.approx(optimum, abs=tolerance)
    assert costs(found.x[None])[0] == found.cost
    assert np.all(np.diff(found.history) <= 0) and found.history.size == 1501


def test_same_seed_same_ants():
    lower, upper = np.full(3, -1.0), np.full(3, 2.0)
    runs = []
    for _ in range(2):
        rng = np.random.default_rng(5)
        archive = jittered(np.ones(3), 20, 0.3, lower, upper, rng)
        runs.append(colony(sphere, archive, lower, upper, Colony(archive=20, iterations=30), rng))
    assert np.array_equal(runs[0].x, runs[1].x) and np.array_equal(*[r.history for r in runs])


def test_vanishing_q_follows_the_best_alone():
    """q = 1e-4 with 50 solutions, the original's choice: weights of all but the first are 0."""
    lower, upper = np.full(4, -5.0), np.full(4, 5.0)
    rng = np.random.default_rng(6)
    archive = rng.uniform(lower, upper, size=(50, 4))
    settings = Colony(ants=2, q=1e-4, iterations=1500)
    assert colony(sphere, archive, lower, upper, settings, rng).cost < 1e-6


def test_no_iterations_give_the_best_of_the_archive():
    archive = np.array([[3.0], [-1.0], [2.0]])
    settings = Colony(archive=3, iterations=0)
    found = colony(sphere, archive, np.array([-5.0]), np.array([5.0]), settings, None)
    assert found.x == pytest.approx([-1.0]) and found.cost == 1.0


def test_jitter_keeps_its_centre_and_the_bounds():
    centre, lower, upper = np.array([0.0, 1.0]), np.array([-0.1, -9.0]), np.array([9.0, 9.0])
    points = jittered(centre, 4000, np.array([1.0, 0.5]), lower, upper, np.random.default_rng(7))
    assert np.array_equal(points[0], centre)
    assert points[:, 0].min() == -0.1
    assert points[:, 1].std() == pytest.approx(0.5, rel=0.05)


@pytest.mark.parametrize("bad", [{"archive": 1}, {"ants": 0}, {"q": 0.0}, {"xi": -1.0}])
def test_impossible_settings_are_refused(bad):
    with pytest.raises(Refusal, match="expected archive >= 2"):
        Colony(**bad)
