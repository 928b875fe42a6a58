"""The lowest Allan deviation, against the true one of white and flicker noise."""

from __future__ import annotations

import math

import numpy as np

from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.assess.uncertainty import lowest
from mocap_metrology.noise.model.components import NoiseModel, PowerLaw
from mocap_metrology.noise.model.synthesis import circle_length, draw, increment_spectrum

RATE, N = 100.0, 12_000


def test_the_lowest_is_not_low_by_chance() -> None:
    """60 recordings of two minutes. The true curve only falls, to the flicker's floor within 1 % at
    the last tau; in the median the lowest found is 0.8 to 1.05 of that floor (standard error 0.02),
    and that of all points below 0.75, which is what the limit on degrees of freedom is for."""
    noise = NoiseModel((PowerLaw(0, 1e-5), PowerLaw(-1, 1e-5)))
    floor = math.sqrt(2 * math.log(2) * 1e-5)  # of flicker noise [Allan 1966]
    length, m = circle_length(N), averaging_factors(N)
    spectrum = increment_spectrum(noise, length, RATE)
    found, of_all = [], []
    for seed in range(60):
        series = draw(spectrum, N, length, RATE, np.random.default_rng([seed, 8]))
        curve = allan_curve(series, RATE, m)
        found.append(curve.deviation[lowest(curve.deviation, curve.edf)[0]] / floor)
        of_all.append(curve.deviation.min() / floor)
    assert 0.8 <= np.median(found) <= 1.05
    assert np.median(of_all) < 0.75


def test_it_says_whether_the_curve_still_falls() -> None:
    adev, edf = np.array([3.0, 2.0, 2.5, 1.0]), np.array([100.0, 50.0, 10.0, 9.9])
    assert lowest(adev, edf) == (1, False)
    assert lowest(adev[:2], edf[:2]) == (1, True)
    assert lowest(np.array([3.0, 2.0, 1.0]), np.array([50.0, 20.0, 10.0])) == (2, True)


def test_too_few_degrees_of_freedom_leave_the_best_known() -> None:
    assert lowest(np.array([3.0, 1.0]), np.array([4.0, 1.0])) == (0, True)
    assert lowest(np.array([math.nan, 1.0]), np.array([4.0, 1.0])) == (1, True)
    assert lowest(np.array([]), np.array([])) == (None, False)
