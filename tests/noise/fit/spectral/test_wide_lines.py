"""Lines whose frequency wanders are one line, whole; filters and ends of the spectrum make none.

Truth: phase by summed frequency (a normal walk, an Ornstein-Uhlenbeck process, a sinusoid), so the
amplitude is constant and its power A_s^2 / 2 wherever it lies.
"""

import numpy as np
import pytest
from scipy.signal import butter, lfilter, savgol_filter, sosfiltfilt

from mocap_metrology.noise.diagnosis.periodic import described, series_lines
from mocap_metrology.noise.fit.spectral.likelihood import likelihood
from mocap_metrology.noise.fit.spectral.lines import find_lines

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
    lines, duration = series_lines(series, RATE, 10, lambda f: np.full_like(f, 4.17e-5))
    (one,) = described("x1", lines, duration, RATE, series)
    assert one.lower < A_S < one.upper
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
    [
        five_point,
        butterworth(6),
        butterworth(20),
        brick_wall,
        lambda x: savgol_filter(x, 11, 3),
        lambda x: np.convolve(x, np.ones(12) / 12, "valid"),
    ],
)
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


def test_two_stable_lines_side_by_side_stay_two():
    rng = np.random.default_rng(9)
    t = np.arange(N) / RATE
    for apart in (0.012, 0.05, 0.1):
        waves = 0.01 * np.sin(2 * np.pi * 20 * t) + 0.006 * np.sin(2 * np.pi * (20 + apart) * t + 1)
        found = sorted(x.f_0 for x in find_lines(waves + white(rng), RATE))
        assert np.allclose(found, [20, 20 + apart], atol=5e-4)
