"""Recordings that were filtered are told from all that were not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from mocap_metrology.noise.diagnosis.export import low_pass, low_passes, wander

RATE, N = 100.0, 30_000


def made(kind: str, seed: int = 0, n: int = N) -> np.ndarray:
    rng = np.random.default_rng([seed, len(kind)])
    white = 0.05 * rng.standard_normal(n)
    walk = np.cumsum(rng.standard_normal(n))
    t = np.arange(n) / RATE
    return {
        "white": white,
        "walk": 0.05 * walk + white,
        "walk alone": 0.02 * walk,
        "correlated over a frame": signal.lfilter([1], [1, -0.4], white),
        "correlated over 0.1 s": signal.lfilter([1], [1, -0.905], white),
        "violet": np.diff(white, prepend=0.0),
        "line": white + 0.2 * np.sin(2 * np.pi * 3.1 * t),
        "movement over white noise": white + 5 * np.sin(t) + 2 * np.sin(7 * t) ** 3,
    }[kind]


KINDS = (
    *("white", "walk", "walk alone", "correlated over a frame", "correlated over 0.1 s"),
    *("violet", "line", "movement over white noise"),
)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("step", [1.5e-5, 0.05])
def test_unfiltered_noise_is_not_called_filtered(kind: str, step: float) -> None:
    for seed in range(3):
        x = step * np.round((made(kind, seed) + 160.1) / step)
        assert low_pass("x1", x, RATE, step) is None


@pytest.mark.parametrize("kind", ["white", "walk", "correlated over 0.1 s"])
@pytest.mark.parametrize("cutoff_hz", [6.0, 10.0, 20.0])
@pytest.mark.parametrize("order", [2, 4])
def test_a_filter_is_named_with_its_cutoff(kind: str, cutoff_hz: float, order: int) -> None:
    """Half the amplitude at the cutoff: a Butterworth run both ways."""
    sos = signal.butter(order, cutoff_hz, fs=RATE, output="sos")
    x = np.float32(signal.sosfiltfilt(sos, made(kind)) + 160).astype(float)
    x[1000:1200] = np.nan
    found = low_pass("x1", x, RATE, 1.5e-5)
    assert found is not None
    assert found.cutoff_hz == pytest.approx(cutoff_hz, rel=0.2)
    assert found.ratio < 0.02


@pytest.mark.parametrize("size", [5, 9])
def test_a_moving_mean_is_named(size: int) -> None:
    """1.207/size of the rate: where sin(size x) = size sin(x) / 2, nearly."""
    x = np.convolve(made("white"), np.full(size, 1 / size), "same")
    found = low_pass("x1", x, RATE)
    assert found is not None
    assert found.cutoff_hz == pytest.approx(0.6 * RATE / size, rel=0.25)


def test_coarse_steps_after_a_filter_leave_it_to_be_seen() -> None:
    sos = signal.butter(2, 6.0, fs=RATE, output="sos")
    x = 0.01 * np.round((signal.sosfiltfilt(sos, made("white")) + 160) / 0.01)
    found = low_pass("x1", x, RATE, 0.01)
    assert found is not None and found.cutoff_hz == pytest.approx(6.0, rel=0.3)


def test_most_coordinates_must_agree() -> None:
    sos = signal.butter(2, 6.0, fs=RATE, output="sos")
    series = {f"{axis}1": made("white", k) for k, axis in enumerate("xyz")}
    series["x1"] = signal.sosfiltfilt(sos, series["x1"])
    assert not low_passes(series, RATE, 0.0)
    series["y1"] = signal.sosfiltfilt(sos, series["y1"])
    assert [one.series for one in low_passes(series, RATE, 0.0)] == ["x1", "y1"]


def test_a_walk_wanders_less_than_what_moves() -> None:
    rng = np.random.default_rng(0)
    assert wander(np.cumsum(rng.normal(0, 0.1, 36_000))) < 1
    assert wander(5 * np.sin(np.arange(100))) > 5


def test_short_and_missing_series_are_not_judged() -> None:
    assert low_pass("x1", np.full(5000, np.nan), RATE) is None
    assert low_pass("x1", np.full(5000, 3.0), RATE) is None
    assert low_pass("x1", made("white")[:200], RATE) is None
