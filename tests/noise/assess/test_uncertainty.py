"""Numbers of one series: from its model, and from itself where the model is not to be trusted."""

from __future__ import annotations

import math
from dataclasses import asdict

import numpy as np
import pytest

from mocap_metrology.noise.assess.uncertainty import Span, Unmodelled, Why, assess_series

RATE = 50.0
N = 15_000  # 5 min
SIGMA = 0.02
SPAN = Span(RATE)


def white(seed: int = 1, n: int = N) -> np.ndarray:
    return 100 + SIGMA * np.random.default_rng(seed).standard_normal(n)


def rows(status: str = "ok", sigma: float = SIGMA) -> list[dict]:
    return [{"parameter": "h_0", "value": 2 * sigma**2 / RATE, "status": status}]


def curve() -> dict[str, np.ndarray]:
    tau = np.array([0.02, 1.0, 20.0])
    adev = SIGMA / np.sqrt(tau * RATE)
    bounds = {"adev_lower_mm": 0.9 * adev, "adev_upper_mm": 1.1 * adev}
    bounds["edf"] = np.array([15000.0, 300.0, 15.0])
    return {"tau_s": tau, "adev_mm": adev, **bounds}


def test_white_noise_by_its_model() -> None:
    found = assess_series(white(), rows(), curve(), SPAN)
    assert (found.status, found.basis, found.unmodelled) == ("ok", "model", None)
    assert found.sigma_frame_mm == pytest.approx(SIGMA, rel=1e-9)
    assert found.frame_mm == pytest.approx(SIGMA, rel=1e-4)
    # ln u of white noise: half the relative error of its level, sqrt(2/n); the measured interval,
    # as wide, is about the series' own value
    own, error = np.std(white()) / SIGMA, math.sqrt(0.5 / N)
    assert found.frame_upper_mm / SIGMA == pytest.approx(max(own, 1) + error, rel=5e-4)
    assert found.frame_lower_mm / SIGMA == pytest.approx(min(own, 1) - error, rel=5e-4)
    for mean in found.means:
        n = mean.duration_s * RATE
        assert mean.uncertainty_mm == pytest.approx(SIGMA * math.sqrt(1 / n - 1 / N), rel=1e-9)
    assert found.means[0].measured_mm == pytest.approx(SIGMA / math.sqrt(RATE), rel=0.15)
    assert found.means[1].adev_mm == pytest.approx(SIGMA / math.sqrt(10 * RATE), rel=1e-9)
    assert math.isnan(found.means[2].adev_mm)  # beyond the curve
    assert found.shares == {"white": pytest.approx(1.0)}
    assert (found.tau_min_s, found.adev_min_mm) == (20.0, curve()["adev_mm"][2])
    assert found.adev_still_falls


def test_a_misfit_is_measured() -> None:
    found = assess_series(white(), rows("misfit"), curve(), SPAN)
    assert (found.status, found.basis) == ("misfit", "measured")
    assert found.frame_mm == pytest.approx(np.std(white()), rel=1e-9)
    assert found.shares == {}
    assert found.frame_lower_mm < SIGMA < found.frame_upper_mm


def assert_same(found: Unmodelled, expected: Unmodelled) -> None:
    """Field by field, NaN equal to NaN."""
    np.testing.assert_equal(asdict(found), asdict(expected))


def test_no_coefficients_and_refused_are_measured() -> None:
    refused = [{"parameter": "", "value": math.nan, "status": "refused"}]
    for given, status in (([], "no coefficients"), (refused, "refused")):
        found = assess_series(white(), given, curve(), SPAN)
        assert (found.status, found.basis) == (status, "measured")
        assert_same(found.unmodelled, Unmodelled(Why.NO_MODEL))


def test_refused_says_why() -> None:
    note = "61.4 % of the samples are missing, expected at most half"
    refused = [{"parameter": "", "value": math.nan, "status": "refused", "note": note}]
    gaps = white(n=5000)
    gaps[:4500] = math.nan
    found = {
        Unmodelled(Why.TOO_SHORT, 700, 1000): white(n=700),
        Unmodelled(Why.TOO_MANY_GAPS, 500, 1000): gaps,
        Unmodelled(Why.REFUSED, note=note): white(),
    }
    for why, series in found.items():
        assert_same(assess_series(series, refused, curve(), SPAN).unmodelled, why)


def test_wander_the_model_lacks_is_measured() -> None:
    drifting = white() + np.linspace(0, 0.2, N)
    found = assess_series(drifting, rows(), curve(), SPAN)
    assert (found.status, found.basis) == ("ok", "measured")
    assert found.frame_mm == pytest.approx(math.hypot(SIGMA, 0.2 / math.sqrt(12)), rel=0.02)
    why = found.unmodelled
    assert (why.why, why.over_s) == (Why.MEANS_DISAGREE, 1.0)
    assert why.value > 1.25 * why.expected > 0
    assert found.drift_mm_per_h == pytest.approx(0.2 * 12, rel=0.02)


def test_a_wrong_level_is_measured() -> None:
    found = assess_series(white(), rows(sigma=2 * SIGMA), curve(), SPAN)
    assert found.basis == "measured"
    why = found.unmodelled
    assert (why.why, why.expected) == (Why.FRAMES_DISAGREE, pytest.approx(2 * SIGMA))
    assert why.value == pytest.approx(SIGMA, rel=0.02)


@pytest.mark.parametrize(("ratio", "basis"), [(1.2, "model"), (1.3, "measured")])
def test_a_level_may_be_wrong_by_a_quarter(ratio: float, basis: str) -> None:
    """Either way: of 15,000 frames the series' own is known to 0.6 %."""
    for sigma in (SIGMA * ratio, SIGMA / ratio):
        assert assess_series(white(), rows(sigma=sigma), curve(), SPAN).basis == basis


def test_chance_is_no_disagreement() -> None:
    """Of 300 white series the right model is believed in all but what 1 in 1000 explains."""
    trusted = [assess_series(white(s), rows(), curve(), SPAN).basis for s in range(300)]
    assert trusted.count("measured") <= 3


def test_horizon_is_the_shorter_of_both() -> None:
    minute = assess_series(white(), rows(), curve(), Span(RATE, horizon_s=60.0))
    assert math.isnan(minute.means[2].uncertainty_mm)  # nothing to compare a minute with
    expected = SIGMA * math.sqrt(1 / (10 * RATE) - 1 / (60 * RATE))
    assert minute.means[1].uncertainty_mm == pytest.approx(expected, rel=1e-9)


def test_a_coarse_step_limits_means() -> None:
    step = 0.1  # frames scatter by a fifth of it
    found = assess_series(white(), rows(), curve(), Span(RATE, step_mm=step))
    assert found.floor_mm == pytest.approx(step / math.sqrt(12))
    assert found.means[2].uncertainty_mm == pytest.approx(step / math.sqrt(12), rel=1e-3)
    fine = assess_series(white(), rows(), curve(), Span(RATE, step_mm=0.03))
    assert fine.floor_mm == 0.0  # two thirds of it dither the step away


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("rate", [0.2, 1.0, 50.0, 1000.0])
def test_short_series_with_and_without_a_model(rate: float) -> None:
    for n in (2, 3, 10, 49, 51, 101):
        for given in (rows(), rows("misfit"), []):
            series = white(n=n)
            series[2::3] = math.nan
            found = assess_series(series, given, curve(), Span(rate, step_mm=1e-4))
            assert found.frame_mm >= 0
            assert found.basis in ("model", "measured")


def test_constant_and_empty_series() -> None:
    still = assess_series(np.full(500, 3.0), [], curve(), Span(RATE, step_mm=0.01))
    assert (still.sigma_frame_mm, still.frame_mm) == (0.0, pytest.approx(0.01 / 12**0.5))
    assert still.status == "constant"
    none = assess_series(np.full(500, math.nan), [], curve(), SPAN)
    assert none.status == "no valid samples"
    assert math.isnan(none.frame_mm)
    assert_same(none.unmodelled, Unmodelled(Why.NO_SAMPLES))
    assert len(none.means) == len(still.means)
    assert assess_series(white(n=20), [], curve(), SPAN).basis == "measured"
