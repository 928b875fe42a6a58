"""Lines: found where they are, as exactly as theory allows, and not where they are not. Those whose
frequency wanders are one line, whole; filters and ends of the spectrum make none.

Truth of these: phase by summed frequency (an Ornstein-Uhlenbeck process, a sinusoid), so the
amplitude is constant and its power A_s^2 / 2 wherever it lies.
"""

import numpy as np
import pytest
from scipy.signal import butter, lfilter, savgol_filter, sosfiltfilt

from mocap_metrology.noise.diagnosis.periodic import described, series_lines
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.fit.spectral.line import (
    Transform,
    beside,
    density_around,
    grown,
    line_errors,
)
from mocap_metrology.noise.fit.spectral.lines import find_lines, find_slow_lines

RATE, SECONDS, SIGMA, A_S = 120, 600, 0.05, 0.015
N = RATE * SECONDS


def wandering(rng, kind, rate=RATE, seconds=SECONDS, f_0=50.0, by=0.02):
    """(n,) A_S sin of a phase whose frequency departs from f_0 by some `by` Hz."""
    n = rate * seconds
    if kind == "sinusoid":
        offset = by * np.sin(2 * np.pi * np.arange(n) / rate / 100 + rng.uniform(0, 6))
    else:
        a = np.exp(-1 / (rate * 60))
        start = rng.normal()
        drawn = rng.normal(size=n) * np.sqrt(1 - a**2)
        offset = by * lfilter([1], [1, -a], drawn, zi=[a * start])[0]
    return A_S * np.sin(2 * np.pi * (f_0 * np.arange(n) + np.cumsum(offset)) / rate)


def white(rng, n=N):
    return rng.normal(0, SIGMA, n)


@pytest.mark.parametrize(("kind", "rate"), [("ou", 120), ("sinusoid", 120), ("ou", 100)])
def test_mains_that_wander_are_one_line_with_all_of_their_power(kind, rate):
    """At 100 Hz they fold at Nyquist. 95 % of A_s: at most 3 of 20 outside with probability 0.98;
    one chance line in 20 recordings with probability 0.98."""
    held, extra = 0, 0
    for seed in range(20):
        rng = np.random.default_rng(seed)
        n = rate * SECONDS
        found = find_lines(wandering(rng, kind, rate) + white(rng, n), rate)
        line, extra = found[0], extra + len(found) - 1
        assert line.wide
        assert abs(line.f_0 - 50) < 3 * line.errors(SECONDS)[1] + 0.02
        assert 0.004 < line.width_f < 0.04
        held += abs(line.A_s - A_S) < 1.96 * line.errors(SECONDS)[0]
    assert held >= 17
    assert extra <= 1


def test_the_width_is_the_standard_deviation_of_the_frequency():
    """Up and down by 20 mHz in 100 s: 20 / sqrt 2 mHz."""
    widths = []
    for seed in range(8):
        rng = np.random.default_rng(seed)
        widths.append(find_lines(wandering(rng, "sinusoid") + white(rng), RATE)[0].width_f)
    assert np.mean(widths) == pytest.approx(0.02 / np.sqrt(2), rel=0.1)


def test_a_wide_line_is_out_of_the_noise_and_one_row():
    """h_0 as without it, with gaps too; noise.csv and periodic.csv agree."""
    rng = np.random.default_rng(2)
    series = wandering(rng, "ou") + white(rng)
    series[20_000:20_400] = np.nan
    series[rng.random(N) < 0.02] = np.nan
    series[[0, -1]] = 0.0
    run = likelihood(series, RATE)
    found = {c.parameter: c for c in run.estimate.coefficients}
    assert len(run.lines) == 1
    assert abs(found["h_0"].value - 2 * SIGMA**2 / RATE) < 4 * found["h_0"].std_error
    assert found["A_s"].lower_95 < A_S < found["A_s"].upper_95
    assert found["width_f"].lower_95 < 0.02 < 2 * found["width_f"].upper_95
    assert all(c.status in ("ok", "not_detected") for c in run.estimate.coefficients)
    lines, part = series_lines(series, RATE, 10, lambda f: np.full_like(f, 4.17e-5))
    (one,) = described("x1", lines, part, RATE)
    assert one.lower < A_S < one.upper
    assert one.upper - one.lower == pytest.approx(2 * 1.96 * one.line.errors(N / RATE)[0])
    assert (one.lower + one.upper) / 2 == pytest.approx(one.line.A_s)
    assert one.line.f_0 == pytest.approx(found["f_0"].value, abs=0.01)
    assert one.line.wide
    assert 0 < one.line.width_f < 0.095


def five_point(x):
    return np.convolve(x, np.ones(5) / 5, "valid")


def butterworth(cutoff):
    return lambda x: sosfiltfilt(butter(2, cutoff, fs=RATE, output="sos"), x)


def brick_wall(x):
    f = np.fft.rfftfreq(x.size, 1 / RATE)
    return np.fft.irfft(np.fft.rfft(x) * np.where(f < 30.3, 1, 1e-3), x.size)


@pytest.mark.parametrize(
    "filtered",
    [five_point, butterworth(6), butterworth(20), brick_wall, lambda x: savgol_filter(x, 11, 3),
     lambda x: np.convolve(x, np.ones(12) / 12, "valid")],
)  # fmt: skip
def test_filters_make_no_lines_and_hide_none(filtered):
    """At most one by chance in 8 recordings (probability 0.9997 with 3 in 1000); a line of 3 Hz,
    which all of them pass, is found in all."""
    wave = 0.01 * np.sin(2 * np.pi * 3.0 * np.arange(N) / RATE)
    invented = 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        noise = white(rng)
        invented += len(find_lines(filtered(noise), RATE))
        assert round(find_lines(filtered(noise + wave), RATE)[0].f_0, 2) == 3.0
    assert invented <= 1


@pytest.mark.parametrize("from_nyquist", [4.8, 0.9, 0.6])
def test_a_stable_line_within_coefficients_of_nyquist_is_found_as_it_is(from_nyquist):
    """Of 20, at most 3 outside 95 % with probability 0.98."""
    held = 0
    for seed in range(20):
        rng = np.random.default_rng(seed)
        f_0 = 50 - from_nyquist / SECONDS
        wave = 0.005 * np.sin(2 * np.pi * f_0 * np.arange(60_000) / 100 + rng.uniform(0, 6))
        (line,) = find_lines(wave + white(rng, 60_000), 100)[:1]
        assert not line.wide
        assert abs(line.f_0 - f_0) < 1 / SECONDS
        held += abs(line.A_s - 0.005) < 1.96 * line.errors(SECONDS)[0]
    assert held >= 17


TAU0, SHORT = 1 / RATE, 1 << 15


def sine(A_s: float, f_0: float, phase: float, n: int = SHORT) -> np.ndarray:
    return A_s * np.sin(2 * np.pi * f_0 * TAU0 * np.arange(n) + phase)


@pytest.mark.parametrize(
    ("low", "high", "expected"),
    [(20, 29, 2.0), (6, 29, 2.0), (5, 29, 1.0), (20, 34, 2.0), (20, 35, 4.0), (5, 35, 2.5)],
)
def test_noise_beside_a_line_is_the_geometric_mean_of_both_sides(low, high, expected) -> None:
    """4 below and 1 above: of sides that have half of 10 coefficients, or else the median of what
    there is; medians are ln 2 of means."""
    power = np.log(2) * np.repeat([9.0, 4.0, 100.0, 1.0], [1, 19, 10, 10])
    power[low : high + 1] = 100.0
    assert density_around(power, low, high, 10) == pytest.approx(expected)


@pytest.mark.parametrize("offset", [0.0, 0.25, 0.5])
def test_amplitude_frequency_and_phase_reach_the_cramer_rao_bound(offset):
    rng = np.random.default_rng(2)
    duration = SHORT * TAU0
    f_0 = (4000 + offset) / duration
    psd = 2 * TAU0  # of unit noise noise
    found = []
    for _ in range(60):
        phase = rng.uniform(-np.pi, np.pi)
        lines = find_lines(rng.normal(size=SHORT) + sine(0.1, f_0, phase), RATE)
        assert len(lines) == 1
        turn = np.angle(np.exp(1j * (lines[0].phase - phase)))
        found.append((lines[0].A_s - 0.1, lines[0].f_0 - f_0, turn))
    rms = np.sqrt(np.mean(np.square(found), axis=0))
    bounds = line_errors(0.1, psd, duration)
    assert 0.75 < rms[0] / bounds[0] < 1.3
    assert 0.75 < rms[1] / bounds[1] < 1.3
    assert rms[2] < 2.5 * 2 * bounds[0] / 0.1  # 2 sigma/(A sqrt n): phase at the start, f unknown


def test_the_last_band_beside_a_line_is_a_whole_one() -> None:
    """Of 42 coefficients here, of which ten alone would be a flank of 100 times the noise."""
    power = np.log(2) * np.r_[np.ones(161), np.full(10, 100.0)]
    assert beside(power, np.arange(1, 171)).max() < 1


def test_power_of_no_line_is_as_uncertain_as_its_error_states() -> None:
    """Power of a band less that of noise beside it, known from a few coefficients: of half of the
    recordings it is above zero, and its rms there is that of all; A^2 has twice the error of A."""
    rng = np.random.default_rng(6)
    lines = [Transform.of(rng.normal(size=4096), TAU0).measured(600, 1099) for _ in range(1500)]
    power = [line.A_s**2 for line in lines if line.A_s > 0]
    error = {round(line.A_error**2 / line.psd, 9) for line in lines if line.A_s == 0}
    assert len(error) == 1
    assert 2 * error.pop() * 2 * TAU0 == pytest.approx(np.sqrt(np.mean(np.square(power))), rel=0.1)


def test_bands_and_ends_of_the_spectrum() -> None:
    """A band grows to where its power ends, and by half; without power it has no line. Blue noise
    is no line at Nyquist, where it is most. A line seen in means has the phase that it has."""
    flat = np.full(2000, 0.1)
    assert grown(flat, 10, 1240, 1260) == (1230, 1270)
    flat[1000:1300] = 10.0
    low, high = grown(flat, 10, 1240, 1260)
    assert low <= 1010 and high >= 1309
    rng = np.random.default_rng(5)
    blue = np.diff(rng.normal(size=SHORT + 1))
    assert not find_lines(blue, RATE)
    none = Transform.of(blue, TAU0).measured(5000, 5020, psd=1.0)
    assert (none.A_s, none.width_f) == (0, 0)
    n = 8 * SHORT
    x = sine(1.0, 120 / (n * TAU0), 0.7, n) + 0.02 * rng.normal(size=n)
    (slow,) = find_slow_lines(x, RATE, lambda f: np.full(f.size, 8e-4 * TAU0), 3)
    assert slow.phase == pytest.approx(0.7, abs=1e-3)
