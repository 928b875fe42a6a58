"""Lines of known frequency and size, and what is said of them."""

from types import SimpleNamespace

import numpy as np
import pytest
from mocap_workflow.recording_twins import twin_from_mapping

from mocap_metrology.noise.allan.variance import allan_variance
from mocap_metrology.noise.diagnosis.one_series import left_in_means
from mocap_metrology.noise.diagnosis.periodic import (
    comb,
    described,
    first_maximum,
    mains_of,
    series_lines,
)
from mocap_metrology.noise.fit.spectral.welch import welch
from mocap_metrology.noise.model.components import Sinusoid
from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.noise.twins.simulate import simulate

RATE = 120.0


def found_in(series, **more):
    lines, part = series_lines(series, RATE, 10)
    return described("x1", lines, part, RATE, **more)


def noise(n=72_000, sigma=0.01, seed=1):
    return np.random.default_rng(seed).normal(0, sigma, n)


def wave(amplitude, f_hz, n=72_000):
    return amplitude * np.sin(2 * np.pi * f_hz * np.arange(n) / RATE + 0.3)


@pytest.mark.parametrize("f_hz", [2.5, 7.3, 24.0, 49.0])
def test_what_a_line_leaves_in_means(f_hz: float) -> None:
    """Of 25 frames, from their least to their greatest; lines of fewer than half a cycle in a mean
    are no such."""
    means = np.convolve(wave(0.3, f_hz), np.full(25, 1 / 25), "valid")
    line = SimpleNamespace(line=SimpleNamespace(f_0=f_hz, width_f=0.0, A_s=0.3))
    assert left_in_means([line], 25, RATE) == pytest.approx(np.ptp(means), rel=1e-3, abs=1e-9)
    assert left_in_means([line], 23, RATE) == 0 or f_hz > 2.5


def test_the_line_of_s_is_named():
    """z1 of ten T40: published at 14.4 Hz."""
    published = published_row("T40", 10)["z1"].coefficients()
    twin = twin_from_mapping(
        {"published": {"camera_type": "T40", "n_cameras": 10}, "seed": 4}, "T40-10"
    )
    (line,) = found_in(simulate(twin, 600.0).position_mm[0, 2])
    assert line.line.f_0 == pytest.approx(14.4, abs=0.01)
    assert line.line.f_0 == pytest.approx(published["f_0"], abs=0.01)
    assert line.lower < published["A_s"] < line.upper
    assert line.in_adev


def test_several_lines_and_harmonics():
    series = noise() + wave(0.003, 7.0) + wave(0.0015, 21.0) + wave(0.002, 31.7)
    found = {round(x.line.f_0, 1): x for x in found_in(series)}
    assert set(found) == {7.0, 21.0, 31.7}
    assert found[21.0].harmonic == (3, pytest.approx(7.0, abs=0.001))
    assert found[7.0].harmonic is None
    assert found[31.7].harmonic is None


def test_share_of_the_allan_variance_is_the_closed_form():
    series = noise() + wave(0.004, 14.4)
    (one,) = found_in(series)
    for f_0 in (0.7, 3.3, 14.4, 31.0):  # sin^4(pi f tau) / tau^2 is greatest at 0.371 periods
        k = np.arange(1, 200)
        of_m = np.sin(np.pi * f_0 * k / RATE) ** 4 / k**2
        assert first_maximum(f_0, RATE) == k[np.argmax(of_m)]
    m = 3
    own = Sinusoid(0.004, 14.4).avar(m, RATE)
    assert one.share == pytest.approx(own / (own + 1e-4 / m), rel=0.05)
    assert one.tau_s == pytest.approx(3 / RATE)


def test_welch_sees_a_strong_line_and_not_a_weak_one():
    def psd(series, segment_s=600.0):
        made = welch(series, RATE, segment_s)
        n = np.full(made.f_hz.size, made.n_segments)
        return {"f_hz": made.f_hz, "psd_mm2_hz": made.psd, "n_segments": n}

    strong, weak = noise() + wave(0.003, 14.4), noise() + wave(0.0004, 14.4)
    (one,) = found_in(strong, psd=psd(strong))
    assert one.in_psd
    # A Hann window's line stands A^2/2 over its noise bandwidth of 1.5 bins
    segment = 600 / 4.5
    assert one.snr_psd == pytest.approx(0.003**2 / 2 * segment / 1.5 / (1e-4 * 2 / RATE), rel=0.5)
    assert all(not x.in_psd for x in found_in(weak, psd=psd(weak, 10.0)))


def test_long_gaps_do_not_make_a_line_twice() -> None:
    """Sidebands of 12 % of the frames look like a second line, broad and near the first."""
    begins = 1988, 13781, 17064, 19556, 20196, 23626, 25683, 26760
    sizes = 103, 751, 725, 532, 34, 454, 789, 207
    for seed in (1, 2, 4):
        time = np.arange(30_000) / 500
        series = 0.0616 * np.cos(2 * np.pi * 116.6111 * time - 0.342) + noise(30_000, 0.043, seed)
        for first, size in zip(begins, sizes, strict=True):
            series[first : first + size] = np.nan
        (line,), _ = series_lines(series, 500.0, 10, lambda f: np.full_like(f, 3.7e-3 / 500))
        assert line.A_s == pytest.approx(0.0616, rel=0.02)


@pytest.mark.parametrize("amplitude", [0.004, 0.04])
def test_gaps_neither_shrink_a_line_nor_make_one(amplitude: float):
    """Straight lines over the two of seconds would be bumps of some hundredths of a Hz; a strong
    line that is missing there would have sidebands."""
    series = noise() + wave(amplitude, 14.4)
    series[10_000:14_000:40] = np.nan
    series[30_000:31_000] = np.nan
    series[50_000:50_700] = np.nan
    lines, part = series_lines(series, RATE, 10, lambda f: np.full_like(f, 2e-4 / RATE))
    assert part.size == 72_000
    (one,) = described("x1", lines, part, RATE)
    assert one.line.f_0 == pytest.approx(14.4, abs=0.01) and not one.line.wide
    assert one.lower < amplitude < one.upper
    (one,) = found_in(series)
    assert one.lower < amplitude < one.upper
    assert series_lines(series, RATE, 10)[1].size == 30_000  # the longest, the first


def test_what_dies_away_contributes_the_variance_that_there_is() -> None:
    """A pendulum: what follows frames that are not known is no part of the stretch where it was
    found, nor of the share. By the Allan variance without it."""
    t = np.arange(72_000) / RATE
    series = noise() + 0.3 * np.exp(-t / 80) * np.sin(2 * np.pi * 0.7 * t)
    series[47_000:51_000] = np.nan
    (one,), (alone,) = found_in(series), found_in(series[:47_000])
    m = np.array([round(one.tau_s * RATE)])
    rest, total = (allan_variance(x[:47_000], m).variance[0] for x in (noise(), series))
    assert one.share == alone.share
    assert 1 - rest / total - 0.06 < one.share <= 1  # without the flanks of its band


def test_a_fan_that_is_switched_changes_its_amplitude() -> None:
    """On for 90 s, off for 60 s, with any phase; a frequency that wanders has one amplitude."""
    rng, t = np.random.default_rng(3), np.arange(90_000) / 120
    on = (t % 150) < 90
    phase = np.repeat(rng.uniform(0, 2 * np.pi, 8), 18_000)[: t.size]
    fan = 0.03 * on * np.sin(2 * np.pi * 12.34 * t + phase)
    gaps = np.where(rng.random(t.size) < 0.05, np.nan, 0.0)
    (found,) = found_in(fan + noise(t.size, 0.02) + gaps)
    assert found.amplitude == pytest.approx((0.0, 0.03), abs=0.004)
    slow = np.interp(t, np.arange(0, 760, 10), rng.standard_normal(76))
    wandering = 0.03 * np.sin(2 * np.pi * np.cumsum(12.34 + 0.03 * slow) / 120)
    (found,) = found_in(wandering + noise(t.size, 0.02))
    assert found.line.wide and found.amplitude is None


@pytest.mark.parametrize(
    ("f_0", "rate", "true", "mains"),
    [
        (50.0, 1000.0, 50.0, 50.0),
        (120.0, 1000.0, 120.0, 60.0),
        (200.0, 1000.0, 200.0, 50.0),
        (240.0, 1000.0, 240.0, 60.0),
        (20.0, 120.0, 100.0, 50.0),  # folded: 120 - 100
        (30.0, 70.0, 100.0, 50.0),
        (48.0, 98.0, 50.0, 50.0),
        (20.0, 100.0, 120.0, 60.0),
        (250.0, 1000.0, None, None),  # the fifth harmonic
        (45.0, 1000.0, None, None),
        (0.9, 49.1, None, None),  # so slow a line may be anything
    ],
)
def test_mains_and_lamps_that_would_show(f_0, rate, true, mains) -> None:
    found = mains_of(f_0, rate, 0.0)
    assert (found and (found.f_hz, found.mains_hz)) == (true and (true, mains))
    if found and true is not None:
        assert found.folded_at_hz == (rate if true > rate / 2 else None)


def test_white_noise_of_20_s_has_hardly_ever_a_line() -> None:
    """Fewer than one of a hundred recordings of seven series; the level beside a line is
    that of few coefficients."""
    found = 0
    for seed in range(220):
        rng = np.random.default_rng(seed)
        every = (
            series_lines(0.02 * rng.standard_normal(2000), 100.0, 10, None, 7) for _ in range(7)
        )
        found += any(lines for lines, _ in every)
    assert found <= 1


def test_multiples_of_one_frequency_are_a_comb_and_others_by_chance_none() -> None:
    def of(frequencies):
        lines = [SimpleNamespace(line=SimpleNamespace(f_0=f)) for f in frequencies]
        return [SimpleNamespace(first=one) for one in lines]

    rng = np.random.default_rng(5)
    for _ in range(20):
        f_1, off = rng.uniform(0.3, 3), rng.normal(0, 1e-4, 6)
        teeth = of(f_1 * rng.choice(np.arange(1, 20), 6, replace=False) + off)
        f_hz, found = comb([*of(rng.uniform(1, 50, 3)), *teeth], 300.0)
        assert all(one in found for one in teeth) and len(found) <= 7
        assert round(f_1 / f_hz, 2) in (1.0, 0.5, 0.33)  # or every second or third is there
    assert sum(bool(comb(of(rng.uniform(0.5, 50, 12)), 300.0)[1]) for _ in range(100)) <= 1
