"""Kinds of `labs` that take more than a line: waves and makers, see `_waves`."""

from __future__ import annotations

import numpy as np
from scipy import ndimage, signal
from scipy.interpolate import CubicSpline

from benchmarks.sentences import _waves as w
from benchmarks.sentences._waves import WHITE, Make, Noise, Wave


def building(rng: Noise, t: np.ndarray) -> np.ndarray:
    """A hammer drill, for a while now and then."""
    on = w.dwelling(3, 60, [0.0, 1.0])(rng, t)
    return 0.025 * on * signal.lfilter([1], [1, -0.6, 0.8], rng.standard_normal(t.size))


def gusts(rng: Noise, t: np.ndarray) -> np.ndarray:
    """A tent's wall: bursts of low-frequency shaking."""
    strength, a = np.maximum(w.ou(rng, t, 12.0), 0), [1, -1.9 * np.cos(0.2), 0.9025]
    return 0.05 * strength * signal.lfilter([0.1], a, rng.standard_normal(t.size))


def lamps(rng: Noise, t: np.ndarray) -> np.ndarray:
    """100 Hz of a grid that wanders, folded."""
    f = 100 + 0.04 * w.ou(rng, t, 60.0)
    return 0.02 * np.sin(2 * np.pi * (np.cumsum(f) / 60 + rng.uniform()))


def shadows(rng: Noise, t: np.ndarray) -> np.ndarray:
    """Twice as loud for a second, now and then."""
    times = np.cumsum(rng.exponential(15, 40))
    return 1.0 + np.any([(t > at) & (t < at + 1) for at in times], axis=0)


def loud_for_a_minute(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    since = t - rng.uniform(60, 180)
    x[1] *= np.where((since > 0) & (since < 60), 2, 1)
    return x


def leaning(rng: Noise, since: np.ndarray) -> np.ndarray:
    return 0.12 * np.clip(np.minimum(since, rng.uniform(30, 70) - since) / 3, 0, 1)


def faded(at: float) -> Wave:
    return w.after(at, at + 20, lambda r, s: 0.1 * np.exp(-s / 8))


def slips(rng: Noise, t: np.ndarray) -> np.ndarray:
    at = np.expm1(np.sort(rng.uniform(0, np.log(t[-1] + 2), 14)))
    return 0.02 * np.searchsorted(at, t)


def warm_for_a_while(rng: Noise, t: np.ndarray) -> np.ndarray:
    up, down = rng.uniform(30, 90), rng.uniform(180, 250)
    return 0.15 * np.clip(np.minimum((t - up) / 50, (down - t) / 50 + 1), 0, 1)


def day_with_doors(rng: Noise, t: np.ndarray) -> np.ndarray:
    doors = w.pulses(lambda r: r.uniform(0, 86400, 12), lambda s: np.exp(-s / 900))
    return 0.15 * np.sin(2 * np.pi * t / 86400) - 0.08 * doors(rng, t)


def merging(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Two images become one, now and then."""
    for at in np.cumsum(rng.uniform(20, 90, 20)):
        now = (t > at) & (t < at + rng.uniform(0.3, 2))
        x[0, now] += 3
        x[3, now] -= 3
    return x


def leanings(rng: Noise, t: np.ndarray) -> np.ndarray:
    """Somebody comes and goes, and leans as he likes."""
    ends = np.cumsum(rng.uniform(10, 60, 40))
    size = rng.uniform(0, 0.1, 41)[np.searchsorted(ends, t)]
    return ndimage.uniform_filter1d(size, 150)


def two_pumps(rng: Noise, t: np.ndarray) -> np.ndarray:
    f = rng.uniform(0.7, 2)
    return 0.02 * (np.sin(2 * np.pi * f * t) + np.sin(2 * np.pi * (f + 0.027) * t))


def passers_by(rng: Noise, t: np.ndarray) -> np.ndarray:
    times = np.cumsum(rng.uniform(25, 90, 20))
    return sum(
        0.08 * np.exp(-(((t - at) / 3) ** 2)) * np.sin(2 * np.pi * 1.9 * t + at) for at in times
    )


def camera_lost(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    later = t > rng.uniform(80, 220)
    return np.where(later, 1.3 * x, x) + np.outer([0.04, 0, -0.03, 0, 0, 0], later)


def thermostat(rng: Noise, t: np.ndarray) -> np.ndarray:
    """Short heating, long cooling, of unequal length."""
    value, heats, out = 0.5, True, np.empty(t.size)
    rise, fall, dt = rng.uniform(10, 16), rng.uniform(30, 50), t[1] - t[0]
    for k in range(t.size):
        value += dt * ((1.3 - value) / rise if heats else -(value + 0.3) / fall)
        heats = (value < 1) if heats else value < 0
        out[k] = value
    return 0.08 * out


def unsteady(rng: Noise, t: np.ndarray) -> np.ndarray:
    jump = np.repeat(rng.uniform(0, 6, 12), t.size // 12 + 1)[: t.size]
    return 0.05 * np.sin(2 * np.pi * t / 20 + jump)


def peeling(rng: Noise, t: np.ndarray) -> np.ndarray:
    at = rng.uniform(200, 260)
    return np.where(t < at, 0.4 * np.exp((t - at) / 20), 40.0)


def ghosts(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    for start in rng.integers(10, t.size - 20, 8):
        x[:3, start : start + rng.integers(2, 11)] += [[60.0], [20.0], [-9.0]]
    return x


def reflections(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    for start in rng.integers(10, t.size - 20, 30):
        there = slice(start, start + rng.integers(1, 6))
        x[:3, there] += rng.normal(0, 0.4, (3, 1))
    return x


def threes(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """One frame of a hundred, three at a time."""
    for start in rng.integers(5, t.size - 5, t.size // 300):
        x[:3, start : start + 3] += rng.normal(0, 0.4, (3, 1))
    return x


def person(rng: Noise, t: np.ndarray) -> np.ndarray:
    """Holds the markers, breathes and sways."""
    breath = w.swept(t, 0.25 + 0.02 * w.ou(rng, t, 10.0))
    return 0.8 * breath + 2.0 * np.array([w.ou(rng, t, 4.0) for _ in range(3)])


def bouncing(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """A walk between walls."""
    rate = 1 / (t[1] - t[0])
    for axis in x:
        path = np.cumsum(0.02 / np.sqrt(rate) * rng.standard_normal(t.size))
        axis += np.abs((path + 0.05) % 0.2 - 0.1)
    return x


def mixed(*terms: tuple[float, float]) -> Make:
    """Gauss-Markov noise of time constants and sizes."""

    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        return x + np.array([sum(s * w.ou(rng, t, c) for c, s in terms) for _ in x])

    return made


def rounded(step: float, slope: float = 0.0) -> Make:
    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        x[0] += slope * t / t[-1]
        return step * np.round((w.placed(x) + rng.uniform(0, step, (len(x), 1))) / step)

    return made


def half_floats(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    places = np.array([[61.0], [-43.0], [88.0], [112.0], [-40.0], [90.0]])
    return (x + places).astype(np.float16).astype(float)


def other_unit(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """m from some frame on."""
    return np.where(t > rng.uniform(80, 220), w.placed(x) / 1000, w.placed(x))


def recalibrated(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    return np.where(t > rng.uniform(80, 220), w.placed(x) * (1 + 2e-4) + 0.05, w.placed(x))


def for_good(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Labels are exchanged from some frame on."""
    return np.where(t > rng.uniform(80, 220), np.roll(w.placed(x), 3, axis=0), w.placed(x))


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


def one_coordinate(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x[1] = filtered(2, 4.0)(rng, t, x[1:2])[0]
    return x


def dead_band(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """A coordinate is told anew where it is 0.03 mm from the one told last."""
    for axis in x:
        told = axis[0]
        for k, value in enumerate(axis):
            told = axis[k] = value if abs(value - told) > 0.03 else told
    return x


def doubled(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Every second frame is the mean of its neighbours."""
    x[:, 1:-1:2] = (x[:, :-2:2] + x[:, 2::2])[:, : x[:, 1:-1:2].shape[1]] / 2
    return x


def dropped(rng: Noise, t: np.ndarray) -> np.ndarray:
    """Frames of a vibrating marker that were lost without a gap."""
    kept = np.cumsum(1 + (rng.random(t.size) < 0.004) * rng.integers(1, 12, t.size))
    return 0.03 * np.sin(2 * np.pi * 7.3 * kept * (t[1] - t[0]))


def copied(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    n = round(30 / (t[1] - t[0]))
    x[:, 6 * n : 7 * n] = x[:, 2 * n : 3 * n]
    return x


def cubic(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    old = np.arange(0, t[-1] + 1, 1 / 43.0)
    return np.array([CubicSpline(old, WHITE * rng.standard_normal(old.size))(t) for _ in x])


def five_digits(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x = w.placed(x)
    e = 10.0 ** (np.floor(np.log10(np.abs(x))) - 4)
    return np.round(x / e) * e


def edges_of_gaps(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    for s in rng.integers(50, t.size - 100, 25):
        n = rng.integers(5, 60)
        x[:3, s - 3 : s] += 0.3
        x[:3, s + n : s + n + 3] -= 0.25
        x[:3, s : s + n] = np.nan
    return x


def outliers_replaced(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x = WHITE * rng.standard_t(3, x.shape) / 1.7
    m = ndimage.median_filter(x, (1, 7))
    return np.where(abs(x - m) > 0.05, m, x)


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
