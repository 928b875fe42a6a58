"""What an export did: gaps filled, low-pass filters, rounding; noise of no kind is any of
them. What filters would do."""

import math

import numpy as np
import pytest
from mocap_workflow.recording_twins import twin_from_mapping
from scipy import signal
from scipy.interpolate import CubicSpline, make_interp_spline
from scipy.signal import butter, iirnotch, sosfiltfilt, sosfreqz, tf2sos

from mocap_metrology.noise.diagnosis.export import bands, low_pass, resolution
from mocap_metrology.noise.diagnosis.fills import filled
from mocap_metrology.noise.diagnosis.filtering import (
    averaging,
    filtered_variances,
    filters,
    predicted,
    tried,
)
from mocap_metrology.noise.model.components import GaussMarkov, NoiseModel, PowerLaw, Sinusoid
from mocap_metrology.noise.twins.published import published_row
from mocap_metrology.noise.twins.simulate import simulate

N, SIGMA = 30_000, 0.05
STARTS = np.arange(1000, 29_000, 2000)


def noise(seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return SIGMA * rng.standard_normal(N) + np.cumsum(0.01 * rng.standard_normal(N)) + 160


def with_gaps_filled(x: np.ndarray, size: int, how: str) -> tuple[np.ndarray, np.ndarray]:
    gone = np.zeros(N, bool)
    for first in STARTS:
        gone[first : first + size] = True
    at, gap = np.flatnonzero(~gone), np.flatnonzero(gone)
    out = x.copy()
    if how == "linear":
        out[gap] = np.interp(gap, at, x[at])
    elif how == "held":
        out[gap] = np.repeat(x[STARTS - 1], size)
    else:
        spline = CubicSpline(at, x[at]) if how == "cubic" else make_interp_spline(at, x[at], 5)
        out[gap] = spline(gap)
    return out, gone


@pytest.mark.parametrize("how", ["linear", "held", "cubic", "quintic"])
@pytest.mark.parametrize("size", [15, 100])
def test_fills_are_found_and_nothing_else(how: str, size: int) -> None:
    x, gone = with_gaps_filled(noise(), size, how)
    found = filled(np.float32(x), 1.5e-5)
    assert (found & gone).sum() >= 0.9 * gone.sum()
    assert (found & ~gone).sum() <= 0.01 * gone.sum() + 2 * STARTS.size
    assert how != "held" or found[gone].all()  # the last frame, too, which is far off


def test_noise_of_no_kind_is_a_fill() -> None:
    """Steps of the file, which are constant for long, and straight; hidden steps; repeated frames;
    heavy tails; smooth data; constant, missing and short series. In coarse files a long straight
    fill still is."""
    rng, x, again = np.random.default_rng(5), noise(4), noise(4)
    line, places = 160 + np.linspace(0, 0.5, N), rng.choice(N - 1, 600, replace=False) + 1
    again[places] = again[places - 1]
    steps = (1e-4, 0.01, 0.05, 0.1, 0.3)
    cases = [(step * np.round(v / step), step) for step in steps for v in (x, line)]
    cases += [(0.1 * np.round(x / 0.1), 1e-3), (np.repeat(x[::2], 2), 1.5e-5), (again, 1.5e-5)]
    tails = rng.standard_t(3, N), rng.laplace(size=N), np.cumsum(rng.standard_normal(N))
    cases += [(0.02 * v, 1.5e-5) for v in tails]
    cases += [(np.float32(np.convolve(noise(6), np.hanning(21) / 10, "valid")), 1.5e-5)]
    cases += [(v, 0.0) for v in (0 * x, np.nan * x, np.arange(5.0), np.empty(0))]
    for values, step in cases:
        assert not filled(values, step).any()
    coarse, gone = with_gaps_filled(noise(2), 100, "linear")
    assert (filled(np.round(coarse, 2), 0.01) & gone).sum() >= 0.9 * gone.sum()


RATE = 100.0


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


@pytest.mark.parametrize(
    "kind",
    [*("white", "walk", "walk alone", "correlated over a frame", "correlated over 0.1 s"),
     *("violet", "line", "movement over white noise")],
)  # fmt: skip
@pytest.mark.parametrize("step", [1.5e-5, 0.05])
def test_unfiltered_noise_is_not_called_filtered(kind: str, step: float) -> None:
    for seed in range(3):
        x = step * np.round((made(kind, seed) + 160.1) / step)
        assert low_pass("x1", bands(x, RATE), RATE, step) is None


@pytest.mark.parametrize("kind", ["white", "walk", "correlated over 0.1 s"])
@pytest.mark.parametrize("cutoff_hz", [6.0, 10.0, 20.0])
@pytest.mark.parametrize("order", [2, 4])
def test_a_filter_is_named_with_its_cutoff(kind: str, cutoff_hz: float, order: int) -> None:
    """Half the amplitude at the cutoff: a Butterworth run both ways."""
    sos = signal.butter(order, cutoff_hz, fs=RATE, output="sos")
    x = np.float32(signal.sosfiltfilt(sos, made(kind)) + 160).astype(float)
    x[1000:1200] = np.nan
    found = low_pass("x1", bands(x, RATE), RATE, 1.5e-5)
    assert found is not None
    assert found.cutoff_hz == pytest.approx(cutoff_hz, rel=0.2)
    assert found.ratio < 0.02


def test_the_cutoff_of_a_sharp_edge() -> None:
    """Of a transform that is cut at 17 Hz."""
    f = np.fft.rfftfreq(N, 1 / RATE)
    for seed in range(6):
        x = np.fft.irfft(np.fft.rfft(made("white", seed)) * (f < 17), N)
        found = low_pass("x1", bands(np.float32(x + 160).astype(float), RATE), RATE, 1.5e-5)
        assert found is not None and found.cutoff_hz == pytest.approx(17, rel=0.15)


def test_resolution_against_rounded_noise():
    """Rounding adds q^2/12, whatever the noise, while that is above a third of a step."""
    q, rng = 0.01, np.random.default_rng(6)
    fine = rng.normal(0, 0.008, 400_000)
    rounded = np.round(fine / q) * q
    added = np.var(rounded) - np.var(fine)
    found = resolution("x1", q, "rounded", float(np.var(rounded)), 120.0)
    assert found.share == pytest.approx(added / np.var(rounded), rel=0.05)
    assert found.rounding_h0 == pytest.approx(q**2 / (6 * 120.0))
    assert found.word == "noticeable"
    assert resolution("x1", q, "rounded", 1e-2, 120.0).word == "fine"
    assert resolution("x1", q, "rounded", (0.1 * q) ** 2, 120.0).word == "dominates"
    assert resolution("L", q, "rounded", 1e-4, 120.0, distance=True).share == pytest.approx(
        2 * resolution("x1", q, "rounded", 1e-4, 120.0).share
    )
    for share, word in ((0.0099, "fine"), (0.0101, "noticeable"), (0.2, "noticeable"),
                        (0.201, "dominates")):  # fmt: skip
        assert resolution("x1", q, "rounded", q**2 / 12 / share, 120.0).word == word
    constant, unknown = (resolution("x1", q, "rounded", v, 120.0) for v in (0.0, math.nan))
    assert (constant.share, unknown.word) == (1.0, "unknown")
    assert found.share_of(2 * q) == pytest.approx(4 * found.share)


def test_bands_are_medians_of_the_one_sided_density() -> None:
    """White noise of variance s^2 has 2 s^2 / rate, and ordinates of median ln 2 times that."""
    found = bands(np.random.default_rng(5).normal(0, 0.3, 120_000), 120.0)
    assert found is not None
    for level in (found.middle, found.top, np.median(found.psd)):
        assert level == pytest.approx(2 * 0.09 / 120 * math.log(2), rel=0.05)
    for lowest in (8.1, 8.7):  # ordinates at least: of one segment a band has e (1 - 2^-0.25)
        n = round(2 * lowest * 2 ** (10 / 4) / (1 - 2**-0.25) / 0.95)
        found = bands(np.random.default_rng(1).normal(size=n), 1000.0)
        assert found is not None and found.psd.size == 11


HZ = 120.0
AMONG = filters(HZ, (6.0, 10.0), (14.4,), 1.0)


def white(f):
    return np.full_like(np.asarray(f, float), 2 / HZ)


@pytest.mark.parametrize("one", AMONG, ids=lambda one: one.name)
def test_the_gain_is_scipys(one):
    if one.sos is None:
        pytest.skip("no filter")
    f, h = sosfreqz(one.sos, 500, fs=HZ)
    assert one.gain(f, HZ) == pytest.approx(np.abs(h) ** 2, rel=1e-9, abs=1e-15)
    cutoff = float(one.name.split()[1])
    assert one.gain(np.array([cutoff]), HZ)[0] == pytest.approx(
        0.0 if "notch" in one.name else 0.5, abs=1e-9
    )


@pytest.mark.parametrize("cutoff", [1.0, 2.0])
def test_white_noise_through_a_butterworth_of_fourth_order(cutoff):
    """Int_0^inf dx / (1 + x^4)^2 = 3 pi / (8 sqrt 2): share 2 f_c / rate times that, far below
    Nyquist, where the bilinear transform does not bend frequencies."""
    one = filters(HZ, (cutoff,), (), 1.0)[1]
    share = predicted(white, [], one, averaging(100_000, HZ), HZ).sigma ** 2
    # Ten-second means hold what is slower than 0.05 Hz: 1 / (10 s x rate) of the white variance
    expected = 2 * cutoff / HZ * 3 * math.pi / (8 * math.sqrt(2)) - 1 / (10 * HZ)
    assert share == pytest.approx(expected, rel=0.005)


def test_filtering_is_scipys():
    series = np.random.default_rng(3).normal(size=3000) + 1000.0
    designs = [*(butter(2, f, fs=HZ) for f in (6.0, 10.0)), iirnotch(14.4, 14.4, fs=HZ)]
    for one, design in zip(AMONG[1:], designs, strict=True):
        assert one.sos == pytest.approx(tf2sos(*design), rel=1e-12)
        expected = sosfiltfilt(tf2sos(*design), series - series.mean()) + series.mean()
        assert one.applied(series, HZ) == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize(
    "part",
    [PowerLaw(-2, 1e-8), PowerLaw(-1, 1e-6), PowerLaw(0, 1e-6), PowerLaw(2, 1e-9),
     GaussMarkov(0.01, 0.3)],
    ids=str,
)  # fmt: skip
def test_without_a_filter_the_allan_variance_is_the_models(part):
    m = averaging(1 << 20, HZ)
    model = NoiseModel((part,))
    found, _ = filtered_variances(lambda f: model.psd(f, HZ), AMONG[0], m, HZ)
    assert found == pytest.approx(model.avar(m, HZ), rel=1e-3)


def test_published_noise_and_its_line_behind_filters():
    """z1 of T40-10: every predicted number is the measured one, and the notch takes the line."""
    twin = twin_from_mapping(
        {"published": {"camera_type": "T40", "n_cameras": 10}, "seed": 5}, "T40-10"
    )
    model = published_row("T40", 10)["z1"]
    series = simulate(twin, 1200.0).position_mm[0, 2]
    left = tried("z1", series, HZ, AMONG, lambda f: model.psd(f, HZ), model.lines)
    for one in left:
        assert one.measured.sigma == pytest.approx(one.predicted.sigma, rel=0.03)
        assert one.measured.adev[:3] == pytest.approx(one.predicted.adev[:3], rel=0.05)
    none, notch = left[0].predicted, left[3].predicted
    line = Sinusoid(model.lines[0].A_s, 14.4)
    taken = none.sigma**2 - notch.sigma**2
    assert taken == pytest.approx(line.A_s**2 / 2, rel=0.5)
    assert taken > line.A_s**2 / 2  # and some noise


def test_fills_of_eight_frames_are_found_beside_longer_ones() -> None:
    """Cubic ones between noise, whose overshoot would be an event; and no frame of the noise."""
    rng = np.random.default_rng(12)
    x = rng.normal(0, 0.05, 30_000)
    true = np.zeros(x.size, bool)
    for k, start in enumerate(range(500, 29_000, 1500)):
        stop = start + (30 if k % 2 else 8)
        known = np.r_[start - 6 : start, stop : stop + 6]
        x[start:stop] = CubicSpline(known, x[known])(np.arange(start, stop))
        true[start:stop] = True
    found = filled(np.float32(x), 1.5e-8)
    assert found[true].all() and np.count_nonzero(found & ~true) <= 2  # beside an end, by chance
