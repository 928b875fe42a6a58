"""What software did to frames: on the filters themselves, on noise of other kinds without, and
shares of a spectrum in closed form."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy import ndimage, signal

from mocap_metrology.noise.diagnosis.export import Bands
from mocap_metrology.noise.diagnosis.findings import findings_of
from mocap_metrology.noise.diagnosis.recording import diagnose
from mocap_metrology.noise.diagnosis.records import Recording
from mocap_metrology.noise.diagnosis.software import (
    variance_cycle,
    white_share,
)
from mocap_metrology.noise.motion.exchange import put_right

RATE, N = 120.0, 18_000
NAMES = ["x1", "y1", "z1"]


def kalman(x: np.ndarray) -> np.ndarray:
    """Of constant velocity, at its steady gains."""
    place, speed, out = np.zeros(3), np.zeros(3), np.empty_like(x)
    for k in range(x.shape[1]):
        place = place + speed
        off = x[:, k] - place
        place, speed = place + 0.2 * off, speed + 0.02 * off
        out[:, k] = place
    return out[:, 500:]


def one_euro(x: np.ndarray) -> np.ndarray:
    """At rest, where its cutoff is the least, 1.2 Hz."""
    share = 1 / (1 + RATE / (2 * np.pi * 1.2))
    return signal.lfilter([share], [1, share - 1], x)[:, 500:]


def resampled(x: np.ndarray) -> np.ndarray:
    """From 100 to 120 Hz, linearly."""
    at = np.arange(0, N - 2, 100 / RATE)
    return np.array([np.interp(at, np.arange(N), row) for row in x])


def held(x: np.ndarray) -> np.ndarray:
    """One frame in a hundred repeats the one before."""
    some = np.random.default_rng(1).random(x.shape[1]) < 0.01
    return x[:, np.maximum.accumulate(np.where(some, 0, np.arange(x.shape[1])))]


def mains(x: np.ndarray) -> np.ndarray:
    return x + 0.1 * np.sin(2 * np.pi * 33 * np.arange(N) / RATE)


def flashes(x: np.ndarray) -> np.ndarray:
    return x * (1 + 0.3 * (np.arange(N) % 2))


def correlated(x: np.ndarray) -> np.ndarray:
    return x + signal.lfilter([0.05], [1, -0.9], x[::-1])


def held_alone(x: np.ndarray) -> np.ndarray:
    """Every coordinate repeats a fifth of its values, at times of its own."""
    some = np.random.default_rng(2).random(x.shape) < 0.2
    kept = np.maximum.accumulate(np.where(some, 0, np.arange(x.shape[1])), axis=1)
    return np.take_along_axis(x, kept, axis=1)


def wavelet(x: np.ndarray) -> np.ndarray:
    """Haar's, four levels, coefficients drawn in by 0.03 mm."""
    if x.shape[1] <= N // 16:
        return x
    a, b = x[:, ::2], x[:, 1::2]
    detail = (a - b) / np.sqrt(2)
    detail = np.sign(detail) * np.maximum(np.abs(detail) - 0.03, 0)
    mean = wavelet((a + b) / np.sqrt(2))
    return np.stack([mean + detail, mean - detail], axis=2).reshape(len(x), -1) / np.sqrt(2)


KINDS: dict[str, tuple[Callable[[np.ndarray], np.ndarray], str]] = {
    "Kalman": (kalman, "smoothed"),
    "one-euro": (one_euro, "smoothed"),
    "resampled": (resampled, "resampled"),
    "median of five": (lambda x: ndimage.median_filter(x, (1, 5)), "running_median"),
    "median of nine, 3 m away": (
        lambda x: ndimage.median_filter(x, (1, 9)) + 3000.0,
        "running_median",
    ),
    "Savitzky-Golay": (lambda x: signal.savgol_filter(x, 21, 3), "low_pass"),
    "repeated": (held, "repeated"),
    "repeated, each coordinate for itself": (held_alone, "repeated"),
    "wavelet": (wavelet, "repeated"),
    "white": (lambda x: x, ""),
    "mains": (mains, ""),
    "every second frame louder": (flashes, ""),
    "white and correlated": (correlated, ""),
}


def found_in(kind: str, seed: int = 1) -> dict[str, dict[str, float]]:
    """Codes of whole recordings in float32, with their values by series."""
    values = KINDS[kind][0](0.02 * np.random.default_rng(seed).standard_normal((3, N)))
    stored = dict(zip(NAMES, values.astype(np.float32).astype(float), strict=True))
    recording = Recording(stored, ["A"], [], RATE, 4e-6, "float32")
    codes: dict[str, dict[str, float]] = {}
    for one in findings_of(recording, diagnose(recording, []), []):
        codes.setdefault(one.code, {})[one.series] = one.value
    return codes


@pytest.mark.parametrize("kind", KINDS)
def test_what_software_did_is_named(kind: str) -> None:
    """In each coordinate, and nothing else of this sort."""
    codes = found_in(kind)
    of_software = {"smoothed", "resampled", "running_median", "repeated", "low_pass"} & set(codes)
    assert of_software == ({KINDS[kind][1]} - {""})
    if of_software:
        assert list(codes[KINDS[kind][1]]) == NAMES
    if kind == "resampled":  # 100 Hz in a file of 120 Hz: the variance varies with 20 Hz
        assert codes["resampled"]["x1"] == pytest.approx(20, abs=0.01)


def test_exchanged_labels_are_put_right() -> None:
    """In 6000 frames, of which some are missing; a third marker is left alone, and nothing is
    changed where nothing is exchanged. Of three markers in both directions, too."""
    rng = np.random.default_rng(4)
    place = np.array([[0, 0, 0], [60, 5, 0], [0, 300, 0]], float)[:, :, None]
    true = place + 0.02 * rng.standard_normal((3, 3, 20_000))
    true[0, :, 500:600] = np.nan
    given = true.copy()
    assert put_right(["A", "B", "C"], given) == []
    there = slice(9_000, 15_000)
    given[0, :, there], given[1, :, there] = true[1, :, there], true[0, :, there]
    (found,) = put_right(["A", "B", "C"], given)
    assert found.labels == ("A", "B") and found.share == pytest.approx(0.3)
    np.testing.assert_array_equal(given, true)
    there = np.arange(9_000, 9_900)
    for at, order in ((there, [1, 2, 0]), (there + 5_000, [2, 0, 1]), (there + 9_000, [1, 0, 2])):
        given[:, :, at] = true[order][:, :, at]
    every = put_right(["A", "B", "C"], given)
    assert [one.labels for one in every] == [("A", "B"), ("A", "B", "C"), ("A", "C", "B")]
    assert all(one.share == pytest.approx(0.045) for one in every)
    np.testing.assert_array_equal(given, true)


def test_markers_that_pass_each_other_are_not_exchanged() -> None:
    t = np.arange(20_000) / RATE
    swing = np.array([60 * np.sin(t), -60 * np.sin(t)])
    given = np.zeros((2, 3, t.size))
    given[:, 0] = swing + 0.02 * np.random.default_rng(5).standard_normal(swing.shape)
    given[:, 1] = [[0.0], [30.0]]
    before = given.copy()
    assert put_right(["A", "B"], given) == []
    np.testing.assert_array_equal(given, before)


AT_HZ = 100.0
F = np.geomspace(9.0, 48.0, 12)


def bands(walk: float, white: float, n: int = 12) -> Bands:
    """Of a random walk's increments h / W and white noise; W = 4 sin^2(pi f / rate)."""
    psd = walk / (4 * np.sin(np.pi * F / AT_HZ) ** 2) + white
    return Bands(F[-n:], psd[-n:], 0.0, 0.0, 0.0)


@pytest.mark.parametrize(("walk", "white"), [(0.0, 1.0), (1.0, 0.0), (1.0, 0.05), (3.0, 2.0)])
def test_white_share_is_that_of_the_last_band(walk: float, white: float) -> None:
    at_end = walk / (4 * math.sin(math.pi * 0.48) ** 2) + white
    assert white_share(bands(walk, white), AT_HZ, 0.0) == pytest.approx(white / at_end, abs=1e-9)
    assert math.isnan(white_share(bands(walk, white, 7), AT_HZ, 0.0))  # less than 1/8 octave


def cyclic(depth: float, f: float, n: int = 60_000, seed: int = 1) -> np.ndarray:
    """Values whose second differences have a variance of 1 + depth cos(2 pi f t)."""
    t = np.arange(n) / AT_HZ
    noise = np.random.default_rng(seed).standard_normal(n)
    second = np.sqrt(1 + depth * np.cos(2 * np.pi * f * t)) * noise
    return np.cumsum(np.cumsum(second))


def test_a_cycle_of_the_variance_and_none_of_a_line_at_twice_its_frequency() -> None:
    assert variance_cycle(cyclic(0.3, 13.7), AT_HZ, 1e-4) == pytest.approx(13.7, abs=0.01)
    half = 1e-3 * cyclic(1.0, 20.0, 6000)
    half[:2900] = np.nan
    assert variance_cycle(half, AT_HZ, 1e-4) == pytest.approx(20.0, abs=0.1)
    for deep, f, n, is_found in (
        *((0.0, 13.7, 60_000, False), (0.1, 13.7, 60_000, False), (1.0, 20.0, 1900, False)),
        *((0.8, 1.9, 60_000, False), (0.8, 2.1, 60_000, True), (0.8, 49.9, 60_000, True)),
    ):  # a seventh of the variance, 2000 frames, cycles of fifty frames at most
        assert (variance_cycle(cyclic(deep, f, n), AT_HZ, 1e-4) > 0) is is_found
    x = np.random.default_rng(2).standard_normal(20_000)
    t = np.arange(x.size) / AT_HZ
    for f in (7.0, 43.0):  # twice 43 Hz is seen at 14 Hz
        assert variance_cycle(x + 3 * np.sin(2 * np.pi * f * t), AT_HZ, 1e-4) == 0.0
    x += 1.5 * (np.arange(x.size) % 4 == 0)  # two lines, at a quarter and half of the frame rate
    assert variance_cycle(x, AT_HZ, 1e-4) == 0.0
    t = np.arange(60_000) / AT_HZ
    for f in (2.4, 9.7, 41.0):  # louder in a tenth of each period: not interpolated
        loud = np.random.default_rng(3).standard_normal(t.size) * (1 + 1.2 * (t * f % 1 < 0.1))
        assert variance_cycle(loud, AT_HZ, 1e-4) == 0.0
