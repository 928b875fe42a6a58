"""ACO_R on functions whose optimum is known."""

import numpy as np
import pytest

from mocap_metrology.noise.fit.allan.annealing import colony
from mocap_metrology.settings import Annealing


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
    bounds, settings = (np.full(d, low), np.full(d, high)), Annealing(colony_iterations=1500)
    runs = []
    for _ in range(2):
        rng = np.random.default_rng(2008)
        archive = rng.uniform(*bounds, size=(50, d))
        runs.append(colony(costs, archive, bounds, settings, rng))
    (x, cost), (again, _) = runs
    assert cost == pytest.approx(optimum, abs=tolerance)
    assert costs(x[None])[0] == cost and np.array_equal(x, again)
    assert np.all((x >= bounds[0]) & (x <= bounds[1]))
