"""Slopes of curves whose coefficients are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.allan.baselines import slopes
from mocap_metrology.noise.model.components import NoiseModel

RATE = 120.0
TAU0 = 1 / RATE
M = np.unique(np.round(np.logspace(0, np.log10(1_296_000), 116))).astype(int)


def read(coefficients, form="continuous", **choices):
    model = NoiseModel.from_coefficients(coefficients)
    return slopes(M, model.avar(M, RATE, form), RATE, **choices)


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


def test_mixture_of_white_noise_and_random_walk():
    """Each rules at its end of the curve; the valley between them is level at a point only."""
    found = read({"h_0": 1e-6, "h_-2": 4e-10})
    assert set(found.values) == {"h_0", "h_-2"}
    assert found.values["h_0"] == pytest.approx(1e-6, rel=1e-3)
    # At the longest tau read (3240 s) white noise adds 3 (h_0/h_-2) / (2 pi tau)^2 = 2e-5
    assert found.values["h_-2"] == pytest.approx(4e-10, rel=1e-3)


def test_flicker_between_the_two_is_read_too_high():
    """What else there is adds to it: white and walk of equal size at the valley's floor."""
    found = read({"h_0": 1e-6, "h_-1": 1e-6, "h_-2": 4e-12})
    assert 1e-6 < found.values["h_-1"] < 1.02e-6


def test_the_last_of_the_curve_is_not_read():
    model = NoiseModel.from_coefficients({"h_0": 1e-6})
    avar = model.avar(M, RATE)
    broken = np.where(0.3 * M[-1] < M, 50 * avar, avar)
    assert slopes(M, broken, RATE).values == pytest.approx({"h_0": 1e-6}, rel=1e-9)


def test_scattered_variances():
    rng = np.random.default_rng(1)
    model = NoiseModel.from_coefficients({"h_0": 1e-6, "h_-2": 4e-10})
    degrees = np.maximum(3e6 / M, 2.0)
    avar = model.avar(M, RATE) * rng.chisquare(degrees) / degrees
    found = slopes(M, avar, RATE).values
    assert found["h_0"] == pytest.approx(1e-6, rel=0.02)
    assert found["h_-2"] == pytest.approx(4e-10, rel=0.3)


@pytest.mark.parametrize(
    "change, expected",
    [
        ({"avar": np.full(M.size, np.nan)}, "expected a number > 0"),
        ({"avar": np.zeros(M.size)}, "expected a number > 0"),
        ({"m": M[:3], "avar": np.ones(3)}, "expected more"),
        ({"tolerance": 0.3}, "tolerance 0.3"),
        ({"longest_share": 0.0}, "longest_share 0.0"),
    ],
)
def test_bad_input_is_refused(change, expected):
    with pytest.raises(Refusal, match=expected):
        slopes(**({"m": M, "avar": 1 / M, "frame_rate_hz": RATE} | change))
