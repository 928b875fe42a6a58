"""A drift that was found counts in the uncertainty of a frame, though it was subtracted."""

from __future__ import annotations

import numpy as np
import pytest

from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.assess.uncertainty import Span, assess_series
from mocap_metrology.noise.fit.estimates import rows
from mocap_metrology.noise.fit.spectral.likelihood import likelihood

RATE, N = 100.0, 60_000
T = np.arange(N) / RATE


@pytest.mark.parametrize(
    "wave, name", [(0.6 * T / 600, "drift"), (0.6 * np.exp(-T / 60), "warm-up")]
)
def test_what_lies_under_the_noise_counts(wave, name):
    series = np.random.default_rng(1).normal(0, 0.05, N) + wave
    table = rows("x1", likelihood(series, RATE).estimate)
    m = np.unique(np.geomspace(1, N // 3, 40).astype(int))
    curve = allan_curve(series, RATE, m)
    columns = dict(zip(
        ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm", "edf"),
        (curve.tau_s, curve.deviation, curve.lower, curve.upper, curve.edf),
        strict=True,
    ))  # fmt: skip
    found = assess_series(series, table, columns, Span(RATE))
    assert found.basis == "model"
    assert found.frame_mm == pytest.approx(np.hypot(0.05, wave.std()), rel=0.02)
    assert found.shares[name] == pytest.approx(wave.var() / (0.05**2 + wave.var()), rel=0.02)
    minutes = wave.reshape(10, -1).mean(axis=1).std()
    assert found.means[2].uncertainty_mm == pytest.approx(minutes, rel=0.05)
    assert sum(found.shares.values()) == pytest.approx(1)
