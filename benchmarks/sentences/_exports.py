"""What cameras, software and files do to still markers: makers of kinds of `labs`, see `_labs`."""

from __future__ import annotations

import numpy as np
from scipy import ndimage, signal
from scipy.interpolate import CubicSpline

from benchmarks.sentences.unforeseen import WHITE, Make, Noise

PLACES = np.array([812.0, -430.0, 1105.0, 1312.0, -415.0, 1098.0])  # mm, of two markers


def placed(x: np.ndarray) -> np.ndarray:
    """With the markers where they are."""
    return x + np.resize(PLACES, len(x))[:, None] + 40.0 * (np.arange(len(x)) // 6)[:, None]


def lost_regularly(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x[:3, (t + rng.uniform(0, 7)) % 7 < 1.5] = np.nan
    return x


def stalls(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    for at in np.cumsum(rng.uniform(20, 90, 20)):
        x[:, (t > at) & (t < at + 3)] = np.nan
    return x


def rounded(step: float, slope: float = 0.0) -> Make:
    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        x[0] += slope * t / t[-1]
        return step * np.round((placed(x) + rng.uniform(0, step, (len(x), 1))) / step)

    return made


def half_floats(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    places = np.array([[61.0], [-43.0], [88.0], [112.0], [-40.0], [90.0]])
    return (x + places).astype(np.float16).astype(float)


def other_unit(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """m from some frame on."""
    x = placed(x)
    x[:, t > rng.uniform(80, 220)] /= 1000
    return x


def filled_linearly(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Gaps of 10 to 40 frames of one marker, with straight lines."""
    for start in rng.integers(50, t.size - 100, 40):
        stop = start + rng.integers(10, 40)
        for axis in x[:3]:
            axis[start:stop] = np.linspace(axis[start - 1], axis[stop], stop - start + 2)[1:-1]
    return x


def filtered(order: int, corner: float, both: bool = True, kind: str = "low") -> Make:
    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        sos = signal.butter(order, corner, kind, fs=1 / (t[1] - t[0]), output="sos")
        return signal.sosfiltfilt(sos, x) if both else signal.sosfilt(sos, x)

    return made


def notch(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    return signal.filtfilt(*signal.iirnotch(12.5, 5, fs=50), x)


def exponential(share: float) -> Make:
    return lambda rng, t, x: signal.lfilter([share], [1, share - 1], x)


def dead_band(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """A coordinate is told anew where it is 0.03 mm from the one told last."""
    for axis in x:
        told = axis[0]
        for k, value in enumerate(axis):
            told = axis[k] = value if abs(value - told) > 0.03 else told
    return x


def nearest(old_hz: float) -> Make:
    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        return x[:, np.floor(t * old_hz + 0.3).astype(int) % t.size]

    return made


def doubled(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Every second frame is the mean of its neighbours."""
    x[:, 1:-1:2] = (x[:, :-2:2] + x[:, 2::2])[:, : x[:, 1:-1:2].shape[1]] / 2
    return x


def recalibrated(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x = placed(x)
    later = t > rng.uniform(80, 220)
    return np.where(later, x * (1 + 2e-4) + 0.05, x)


def dropped(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Frames of a vibrating marker that were lost without a gap."""
    kept = np.cumsum(1 + (rng.random(t.size) < 0.004) * rng.integers(1, 12, t.size))
    x[0] += 0.03 * np.sin(2 * np.pi * 7.3 * kept * (t[1] - t[0]))
    return x


def copied(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    n = round(30 / (t[1] - t[0]))
    x[:, 6 * n : 7 * n] = x[:, 2 * n : 3 * n]
    return x


def alternate(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Two groups of cameras in turn."""
    return x + 0.006 * (-1.0) ** np.arange(t.size)


def both_lost(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x[:, (t + rng.uniform(0, 3)) % 3 < 0.5] = np.nan
    return x


def filtered_with_line(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x[0] += 0.03 * np.sin(2 * np.pi * 3.1 * t)
    return filtered(2, 6.0)(rng, t, x)


def paused(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Warm-up, and a minute without frames."""
    x[0] += 0.25 * np.exp(-t / 80)
    x[:, (t > 120) & (t < 180)] = np.nan
    return x


def packets(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Each tenth frame repeats the one before."""
    k = np.arange(t.size)
    return x[:, k - (k % 10 == 9)]


def cubic(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    old = np.arange(0, t[-1] + 1, 1 / 43.0)
    return np.array([CubicSpline(old, WHITE * rng.standard_normal(old.size))(t) for _ in x])


def kalman(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Forwards and backwards, of constant position."""
    return signal.filtfilt([0.2], [1, -0.8], x)


def two_filters(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    return ndimage.uniform_filter1d(ndimage.median_filter(x, (1, 3)), 3, axis=1)


def one_coordinate(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x[1] = filtered(2, 4.0)(rng, t, x[1:2])[0]
    return x


def for_good(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x = placed(x)
    later = t > rng.uniform(80, 220)
    return np.where(later, np.vstack([x[3:], x[:3]]), x)


def late(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x[:3, t < 150] = np.nan
    return x


def breaks(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """A recording of three takes, each with a place of its own."""
    part = np.minimum((t / 100).astype(int), 2)
    return x + rng.normal(0, 0.05, (6, 3))[:, part]


def five_digits(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x = placed(x)
    e = 10.0 ** (np.floor(np.log10(np.abs(x))) - 4)
    return np.round(x / e) * e


def centimetres(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    return np.round(placed(x) / 10, 2) * 10


def ticks(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """One frame is off every 10 s."""
    x[0, 250::500] += 0.5
    return x


def edges_of_gaps(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    for s in rng.integers(50, t.size - 100, 25):
        n = rng.integers(5, 60)
        x[:3, s - 3 : s] += 0.3
        x[:3, s + n : s + n + 3] -= 0.25
        x[:3, s : s + n] = np.nan
    return x


def cut(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    return np.clip(x, -0.03, 0.03)


def blue(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    return np.diff(np.hstack([x, x[:, :1]]), axis=1) * 0.7 + 0.3 * x


def axes(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    return x * np.array([[1], [5], [0.2], [1], [5], [0.2]])


def drifted_gap(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x += np.linspace(0, 0.2, t.size)
    x[:3, (t > 100) & (t < 140)] = np.nan
    return x


def hampel_export(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x = WHITE * rng.standard_t(3, x.shape) / 1.7
    m = ndimage.median_filter(x, (1, 7))
    return np.where(abs(x - m) > 0.05, m, x)


def of_51(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    return signal.savgol_filter(x, 51, 3)


def held_alone(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Every coordinate repeats a fifth of its values, at times of its own."""
    kept = np.where(rng.random(x.shape) < 0.2, 0, np.arange(t.size))
    return np.take_along_axis(x, np.maximum.accumulate(kept, axis=1), axis=1)


def wavelet(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Haar's, four levels, coefficients drawn in by 1.5 sd."""
    if x.shape[1] <= t.size // 16 + 1:
        return x
    a, b = x[:, : x.shape[1] // 2 * 2 : 2], x[:, 1::2]
    detail = (a - b) / np.sqrt(2)
    detail = np.sign(detail) * np.maximum(np.abs(detail) - 1.5 * WHITE, 0)
    mean = wavelet(rng, t, (a + b) / np.sqrt(2))
    detail = detail[:, : mean.shape[1]]
    return np.stack([mean + detail, mean - detail], axis=2).reshape(len(x), -1) / np.sqrt(2)
