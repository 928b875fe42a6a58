"""Slopes of curves whose coefficients are known in closed form."""

import numpy as np
import pytest

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.allan.baselines import slopes
from mocap_metrology.noise.model.components import NoiseModel

RATE = 120.0
TAU0 = 1 / RATE
M = np.unique(np.round(np.logspace(0, np.log10(1_296_000), 116))).astype(int)


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


def test_mixtures():
    """Each rules at its end of the curve; the valley between them is level at a point only."""
    found = read({"h_0": 1e-6, "h_-2": 4e-10})
    # At the longest tau read (3240 s) white noise adds 3 (h_0/h_-2) / (2 pi tau)^2 = 2e-5
    assert found.values == pytest.approx({"h_0": 1e-6, "h_-2": 4e-10}, rel=1e-3)
    # What else there is adds to flicker: white and walk of equal size at the valley's floor
    assert 1e-6 < read({"h_0": 1e-6, "h_-1": 1e-6, "h_-2": 4e-12}).values["h_-1"] < 1.02e-6


@pytest.mark.parametrize(
    ("count", "value", "expected"),
    [(116, np.nan, "expected a number > 0"), (116, 0.0, "a number > 0"), (3, 1.0, "expected more")],
)
def test_bad_input_is_refused(count, value, expected):
    m = M[:count]
    with pytest.raises(Refusal, match=expected):
        slopes(m, np.full(m.size, value), RATE)
