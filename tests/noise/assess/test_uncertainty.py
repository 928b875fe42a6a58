"""Numbers of one series: from its model, from itself, and the mean of all frames."""

import math
from dataclasses import asdict

import numpy as np
import pytest
from scipy import stats
from scipy.signal import lfilter

from mocap_metrology.noise.assess.mean import mean_of_all
from mocap_metrology.noise.assess.uncertainty import Reason, Span, Unmodelled, assess_series, lowest
from mocap_metrology.noise.fit.estimates import deterministic_of, model_of
from mocap_metrology.noise.fit.estimates import rows as noise_rows
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw
from mocap_metrology.noise.model.deterministic import Deterministic

RATE, N, SIGMA = 50.0, 15_000, 0.02  # 5 min
SPAN, NONE = Span(RATE), Deterministic()


def white(seed: int = 1, n: int = N) -> np.ndarray:
    return 100 + SIGMA * np.random.default_rng(seed).standard_normal(n)


def rows(status: str = "ok", sigma: float = SIGMA) -> list[dict]:
    return [{"parameter": "h_0", "value": 2 * sigma**2 / RATE, "status": status}]


def curve() -> dict[str, np.ndarray]:
    tau = np.array([0.02, 1.0, 20.0])
    adev = SIGMA / np.sqrt(tau * RATE)
    bounds = {"adev_lower_mm": 0.9 * adev, "adev_upper_mm": 1.1 * adev}
    return {"tau_s": tau, "adev_mm": adev, "edf": np.array([15e3, 300.0, 15.0])} | bounds


def test_white_noise_by_its_model() -> None:
    found = assess_series(white(), rows(), curve(), SPAN)
    assert (found.status, found.basis, found.unmodelled) == ("ok", "model", None)
    assert found.sigma_frame_mm == pytest.approx(SIGMA, rel=1e-9)
    assert found.frame_mm == pytest.approx(SIGMA * math.sqrt(1 - 1 / N), rel=1e-9)
    assert found.sigma_recording_mm == pytest.approx(np.std(white(), ddof=1))
    # ln u of white noise: half the relative error of its level, sqrt(2/n); the measured interval,
    # as wide, is about the series' own value
    own, error = np.std(white()) / SIGMA, math.sqrt(0.5 / N)
    assert found.frame_upper_mm / SIGMA == pytest.approx(max(own, 1) + error, rel=5e-4)
    assert found.frame_lower_mm / SIGMA == pytest.approx(min(own, 1) - error, rel=5e-4)
    for mean in found.means:
        n = mean.duration_s * RATE
        assert mean.uncertainty_mm == pytest.approx(SIGMA * math.sqrt(1 / n - 1 / N), rel=1e-9)
    measured = white().reshape(-1, 50).mean(axis=1).std()
    assert found.means[0].measured_mm == pytest.approx(measured)
    assert found.means[1].adev_mm == pytest.approx(SIGMA / math.sqrt(10 * RATE), rel=1e-9)
    assert math.isnan(found.means[2].adev_mm)  # beyond the curve
    assert found.shares == {"white": pytest.approx(1.0)}
    least = curve()["adev_mm"][2]
    assert (found.tau_min_s, found.adev_min_mm, found.adev_still_falls) == (20.0, least, True)
    assert (found.adev_min_lower_mm, found.adev_min_upper_mm) == (0.9 * least, 1.1 * least)
    span = Span(RATE, horizon_s=60.0)  # the shorter of horizon and recording
    minute = assess_series(white(), rows(), curve(), span)
    assert math.isnan(minute.means[2].uncertainty_mm)  # nothing to compare a minute with
    expected = SIGMA * math.sqrt(1 / (10 * RATE) - 1 / (60 * RATE))
    assert minute.means[1].uncertainty_mm == pytest.approx(expected, rel=1e-9)


REFUSED = [{"parameter": "", "value": math.nan, "status": "refused"}]
NOTE = [{"parameter": "", "value": math.nan, "status": "refused", "note": "why"}]
GAPS = np.where(np.arange(5000) < 4500, math.nan, white(n=5000))


@pytest.mark.parametrize(
    ("series", "table", "status", "why"),
    [
        (white(), rows("misfit"), "misfit", Unmodelled(Reason.MISFIT)),
        (white(), [], "no coefficients", Unmodelled(Reason.NO_MODEL)),
        (white(n=20), [], "no coefficients", Unmodelled(Reason.NO_MODEL)),
        (white(), REFUSED, "refused", Unmodelled(Reason.NO_MODEL)),
        (white(), NOTE, "refused", Unmodelled(Reason.REFUSED, note="why")),
        (white(n=999), NOTE, "refused", Unmodelled(Reason.TOO_SHORT, 999, 1000)),
        (white(n=1000), NOTE, "refused", Unmodelled(Reason.REFUSED, note="why")),
        (GAPS, NOTE, "refused", Unmodelled(Reason.TOO_MANY_GAPS, 500, 1000)),
    ],
    ids=range(8),
)
def test_without_a_model_numbers_are_measured(series, table, status: str, why) -> None:
    found = assess_series(series, table, curve(), SPAN)
    assert (found.status, found.basis, found.shares) == (status, "measured", {})
    np.testing.assert_equal(asdict(found.unmodelled), asdict(why))  # NaN equal to NaN
    if series is GAPS:  # nine frames of ten are missing
        assert math.isnan(found.frame_mm)
        return
    assert found.frame_mm == pytest.approx(np.nanstd(series), rel=1e-9)
    assert found.frame_lower_mm < found.frame_mm < found.frame_upper_mm


def test_constant_and_empty_series() -> None:
    still = assess_series(np.full(500, 3.0), [], curve(), Span(RATE, step_mm=0.01))
    assert (still.sigma_frame_mm, still.frame_mm) == (0.0, pytest.approx(0.01 / 12**0.5))
    assert still.status == "constant"
    for n_valid, status in (
        (0, "no valid samples"),
        (1, "no valid samples"),
        (2, "no coefficients"),
    ):
        none = np.full(500, math.nan)
        none[:n_valid] = np.arange(n_valid)
        assert assess_series(none, [], curve(), SPAN).status == status
    assert lowest(np.full(3, math.nan), np.ones(3)) == (None, False)


def test_wander_the_model_lacks_is_measured_and_chance_is_none() -> None:
    """Of 150 white series the right model is believed in all but what 1 in 1000 explains."""
    found = assess_series(white() + np.linspace(0, 0.2, N), rows(), curve(), SPAN)
    assert (found.status, found.basis) == ("ok", "measured")
    assert found.frame_mm == pytest.approx(math.hypot(SIGMA, 0.2 / math.sqrt(12)), rel=0.02)
    why = found.unmodelled
    assert (why.why, why.over_s) == (Reason.MEANS_DISAGREE, 1.0)
    assert why.expected == pytest.approx(SIGMA * math.sqrt(1 / RATE - 1 / N))
    assert why.value == pytest.approx(0.2 / math.sqrt(12), rel=0.02)
    assert found.drift_mm_per_h == pytest.approx(0.2 * 12, rel=0.02)
    bases = [assess_series(white(s), rows(), curve(), SPAN).basis for s in range(150)]
    assert bases.count("measured") <= 2


@pytest.mark.parametrize("name", ["drift", "warm-up"])
def test_what_lies_under_the_noise_counts(name: str) -> None:
    """A drift of 0.6 mm in 10 min, a warm-up of a minute: fitted, subtracted, and counted."""
    t = np.arange(60_000) / 100
    wave = 0.6 * t / 600 if name == "drift" else 0.6 * np.exp(-t / 60)
    series = np.random.default_rng(1).normal(0, 0.05, t.size) + wave
    table = noise_rows("x1", likelihood(series, 100.0).estimate)
    found = assess_series(series, table, curve(), Span(100.0))
    assert found.basis == "model"
    assert found.frame_mm == pytest.approx(np.hypot(0.05, wave.std()), rel=0.02)
    assert found.shares[name] == pytest.approx(wave.var() / (0.05**2 + wave.var()), rel=0.02)
    minutes = wave.reshape(10, -1).mean(axis=1).std()
    assert found.means[2].uncertainty_mm == pytest.approx(minutes, rel=0.05)
    assert sum(found.shares.values()) == pytest.approx(1)


def correlated(seed: list[int], n: int) -> np.ndarray:
    """White noise and a Gauss-Markov process of T_c 1 s at 100 Hz, of SIGMA each."""
    rng, phi = np.random.default_rng(seed), math.exp(-1 / 100)
    steps = SIGMA * math.sqrt(1 - phi**2) * rng.standard_normal(n)
    steps[0] = SIGMA * rng.standard_normal()
    return SIGMA * rng.standard_normal(n) + lfilter([1], [1, -phi], steps)


def n_effective(n: int) -> float:
    """Variance of a frame over that of the mean, by the sum over all lags."""
    k = np.arange(1, n)
    return 2 * n / (2 + 2 * float(np.sum((1 - k / n) * np.exp(-k / 100))))


def test_the_mean_of_all_by_its_model() -> None:
    """By the sum over lags; of 12 fitted recordings of 10 min 11 or more intervals of 95 % hold it,
    and 11 values are within 20 %, where two standard errors are 14 %."""
    model = NoiseModel((PowerLaw(0, 2 * SIGMA**2 / 100), GaussMarkov(SIGMA * math.sqrt(2), 1.0)))
    truth, held, near = n_effective(60_000), 0, 0
    for seed in range(12):
        series = correlated([seed, 3], 60_000)
        table = noise_rows("x1", likelihood(series, 100.0).estimate)
        found = mean_of_all(series, 100.0, model_of(table), deterministic_of(table), 0.01)
        held += found.n_eff_lower_95 <= truth <= found.n_eff_upper_95
        near += abs(found.n_eff / truth - 1) < 0.2
    assert held >= 11 and near >= 11
    found = mean_of_all(series, 100.0, model, NONE, 0.005)
    assert found.n_eff == pytest.approx(truth, rel=3e-3)
    assert found.u_mm == pytest.approx(SIGMA * math.sqrt(2 / truth), rel=2e-3)
    assert found.correlation_s * found.n_eff == pytest.approx(600)
    assert found.expanded_mm == pytest.approx(found.k * found.u_mm)
    assert found.k == pytest.approx(stats.t.ppf(0.975, found.dof))
    error = math.log(found.n_eff_upper_95 / found.n_eff) / 1.96  # of ln u^2: sqrt(2 / dof)
    assert found.dof == pytest.approx(2 / error**2, rel=1e-3)
    assert found.length_s == pytest.approx(600 * (found.expanded_mm / 0.005) ** 2)


def test_the_mean_of_all_by_batches() -> None:
    """Twenty batches, of which half must have half of their frames; the expanded uncertainty holds
    the true mean, 0, in 95 % of 200: 183 or more."""
    held = 0
    for seed in range(200):
        series = correlated([seed, 4], 20_000)
        found = mean_of_all(series, 100.0, None, NONE, 0.01)
        held += abs(series.mean()) <= found.expanded_mm
    assert held >= 183
    for lost in (0, 500, 501, 9500, 10_501):
        series[:lost] = math.nan
        means = [np.nanmean(b) for b in series.reshape(20, -1) if np.isfinite(b).sum() >= 500]
        found = mean_of_all(series, 100.0, None, NONE, 0.01)
        enough = len(means) >= 10
        u = np.std(means, ddof=1) / math.sqrt(len(means)) if enough else math.nan
        assert found.u_mm == pytest.approx(u, nan_ok=True)
        assert found.dof == pytest.approx(len(means) - 1 if enough else math.nan, nan_ok=True)
        if enough:
            assert found.n_eff == pytest.approx(np.nanvar(series, ddof=1) / u**2)
            assert found.k == pytest.approx(stats.t.ppf(0.975, found.dof))
