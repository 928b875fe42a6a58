"""Measured variances of a few frames, computed by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mocap_metrology.common.parallel import in_turn
from mocap_metrology.noise.assess.measured import Measured, measured_spread, measured_within
from mocap_metrology.noise.assess.recording import Inputs, assess_recording
from mocap_metrology.noise.assess.spread import spread
from mocap_metrology.noise.assess.uncertainty import Span
from mocap_metrology.noise.diagnosis.findings import Finding
from mocap_metrology.noise.model.components import GaussMarkov, PowerLaw, Sinusoid
from mocap_metrology.settings import Verdict as Limits

X = np.array([0.0, 4, 0, 4, 0, 4, 1, 3, 1, 3, 1, 3, 90, 0, 0, 0, 0, 90])


def test_within_stretches_of_six_frames() -> None:
    """Variances 4.8, 1.2 and 2160; what is left over at the end does not count."""
    found = measured_within(np.append(X, [500.0, -500.0]), 6)
    parts = np.array([4.8, 1.2, 2160.0])
    assert found.variance == pytest.approx(parts.mean())
    each = 2 * parts.mean() ** 2 / parts.var(ddof=1)
    assert found.edf == pytest.approx(max(3 * min(each, 5.0), 1.0))
    assert measured_within(X[:12], 99).variance == pytest.approx(X[:12].var(ddof=1))


@pytest.mark.parametrize(("n_missing", "counts"), [(3, True), (4, False)])
def test_a_stretch_counts_with_half_of_its_frames(n_missing: int, counts: bool) -> None:
    series = X.copy()
    series[12 : 12 + n_missing] = np.nan
    left = series[12 + n_missing :]
    parts = [4.8, 1.2] + ([float(left.var(ddof=1))] if counts else [])
    assert measured_within(series, 6).variance == pytest.approx(np.mean(parts))


def test_two_frames_make_a_variance_and_one_none() -> None:
    assert measured_within(np.array([1.0, 3.0]), 2).variance == 2.0
    assert measured_within(np.array([1.0, 3.0, 1.0, 5.0]), 1).variance == 5.0  # of two at least
    one = np.array([1.0, np.nan, np.nan, 3.0])
    for series in (one[:1], one):
        assert math.isnan(measured_within(series, 2).variance)


def test_spread_of_means_about_their_mean() -> None:
    """Means of 2 of 8 frames: 2, 2, 4, 0: variance 2 with the number of them; half of the frames,
    and half of the means, must be there."""
    x = np.array([0.0, 4, 1, 3, 3, 5, 0, 0])
    assert measured_spread(x, 2, 8).variance == pytest.approx(np.var([2, 2, 4, 0]))
    assert measured_spread(np.tile(x, 3), 2, 8).variance == pytest.approx(2.0)
    x[1] = np.nan
    assert measured_spread(x, 2, 8).variance == pytest.approx(np.var([0, 2, 4, 0]))
    x[0] = np.nan
    assert measured_spread(x, 2, 8).variance == pytest.approx(np.var([2, 4, 0]))
    x[2:4] = np.nan
    assert measured_spread(x, 2, 8).variance == pytest.approx(np.var([4, 0]))
    x[4:6] = np.nan
    assert math.isnan(measured_spread(x, 2, 8).variance)
    assert math.isnan(measured_spread(X, 10, 19).variance)
    assert measured_spread(np.ones(8), 2, 8) == Measured(0.0, 1.0)


@pytest.mark.parametrize("n", [1, 5, 40])
def test_spread_of_white_noise_a_walk_and_a_sinusoid(n: int) -> None:
    """h / (2 tau0) (1/n - 1/N); s^2/6 (N - 1/N - n + 1/n) of steps s; A^2/2 times the squared
    means of n and of N points of exp(2 pi i f t)."""
    rate, N, h = 50.0, 200, 3e-6
    assert spread(PowerLaw(0, h), n, N, rate) == pytest.approx(h * rate / 2 * (1 / n - 1 / N))
    square = 2 * math.pi**2 * h / rate
    walk = square / 6 * (N - 1 / N - n + 1 / n)
    assert spread(PowerLaw(-2, h), n, N, rate) == pytest.approx(walk)
    of_averages = spread(PowerLaw(-2, h), n, N, rate, "continuous")
    assert of_averages == pytest.approx(square / 6 * (N - n))

    def gain(count: int, f: float) -> float:
        return abs(np.exp(2j * math.pi * f * np.arange(count) / rate).mean()) ** 2

    for f, size in ((3.3, 2), (25.0, 1), (50.0, 2)):
        line = 0.04 / size * (gain(n, f) - gain(N, f))
        assert spread(Sinusoid(0.2, f), n, N, rate) == pytest.approx(line, abs=1e-12)
    phi = math.exp(-1 / (0.3 * rate))
    term = GaussMarkov(0.1, 0.3)
    lags = np.arange(N)
    rho = phi**lags

    def of_mean(count: int) -> float:
        weight = np.where(lags[:count] > 0, 2.0, 1.0) * (count - lags[:count])
        return float(weight @ rho[:count]) / count**2

    expected = term.variance * (of_mean(n) - of_mean(N))
    assert spread(term, n, N, rate) == pytest.approx(expected)


def test_a_walk_is_not_named_where_the_wander_is_of_another_kind() -> None:
    """Of two series alike the one with a cycle among its findings has slow wander, the other a
    random walk; its mean over all time is no number."""
    rng, rate = np.random.default_rng(3), 20.0
    rows, series = [], {}
    for name in ("x1", "y1", "z1"):
        values = 0.02 * rng.standard_normal(4000) + 4e-3 * np.cumsum(rng.standard_normal(4000))
        series[name] = values
        walk = 16e-6 * rate / (2 * math.pi**2)
        for parameter, value in (("h_0", 8e-4 / rate), ("h_-2", walk)):
            rows.append({"series": name, "estimator": "likelihood", "parameter": parameter,
                         "value": value, "status": "ok"})  # fmt: skip
    keys = ("tau_s", "adev_mm", "adev_lower_mm", "adev_upper_mm", "edf")
    allan = {k: np.array([1.0]) for k in keys}
    allan |= {"series": np.array(["x1"]), "estimator": np.array(["oadev"])}
    inputs = Inputs(series.items(), ["A"], rows, allan, [], [Finding("cycle", "x1", 30.0)])
    found = assess_recording(inputs, Span(rate, horizon_s=200.0), Limits(), in_turn).series
    kinds = {name: {one.kind for one in of.kinds} for name, of in found.items()}
    assert "slow wander" in kinds["x1"] and "random walk" not in kinds["x1"]
    for name in ("y1", "z1"):
        assert "random walk" in kinds[name] and "slow wander" not in kinds[name]
