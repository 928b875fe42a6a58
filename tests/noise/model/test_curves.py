"""Curves beside data against closed forms and scipy."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mocap_metrology.noise.model.components import Sinusoid
from mocap_metrology.noise.model.curves import (
    sinusoid_avar,
)

RATE = 100.0


@pytest.mark.parametrize("form", ["sampled", "continuous"])
def test_beyond_six_periods_a_sinusoid_is_its_envelope(form: str) -> None:
    """Of the Allan variance A^2 sin^4(pi f tau) / (m sin(pi f tau0))^2, or with pi f tau0."""
    line = Sinusoid(0.3, 1.0)
    m = np.array([50, 599, 600, 601, 650, 1234])
    x = math.pi / RATE
    gain = math.sin(x) if form == "sampled" else x
    envelope = 0.09 / (m * gain) ** 2
    found = sinusoid_avar(line, m, RATE, form)
    assert found[3:] == pytest.approx(envelope[3:])
    whole = envelope * np.sin(x * m) ** 4
    assert found[:3] == pytest.approx(whole[:3], rel=1e-6, abs=1e-20)
    folded = Sinusoid(0.3, RATE)  # falls on zero
    assert np.isfinite(sinusoid_avar(folded, m, RATE, "sampled")).all()
