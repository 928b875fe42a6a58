"""Recordings of kinds that no detector was made for: what the findings say that is not so.

Two markers, 10 min at 100 Hz or as the kind has it, white noise of 0.02 mm a frame. `named`: one of
the findings that say what it is (those that no finding can name need none); `false`: any finding
that is not so.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from scipy import ndimage, signal

from benchmarks.sentences import Row
from benchmarks.sentences import _waves as w
from benchmarks.sentences._kinds import coloured, gauss_markov
from benchmarks.sentences._waves import in_x1, kind
from benchmarks.sentences.recordings import said_of


def passed(b: list[float], a: list[float] | None = None) -> w.Make:
    """White noise through a filter, each coordinate by itself; put to the same size."""

    def made(rng: w.Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        y = signal.lfilter(b, a or [1.0], x)
        return w.WHITE * y / y.std(axis=1, keepdims=True)

    return made


def held(rng: w.Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Gaps of 20 to 100 frames of one marker."""
    for start in rng.integers(100, t.size - 200, 30):
        x[:3, start : start + rng.integers(20, 100)] = x[:3, start - 1 : start]
    return x


def swapped(rng: w.Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Labels, for a frame each."""
    x[3] += 60
    at = rng.choice(t.size, 20, replace=False)
    x[:3, at], x[3:, at] = x[3:, at].copy(), x[:3, at].copy()
    x[4, at] -= 500
    x[1, at] += 500
    return x


def resampled(rng: w.Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    old = np.arange(int(t[-1] * 240) + 2) / 240
    return np.array([np.interp(t, old, w.WHITE * rng.standard_normal(old.size)) for _ in x])


def occluded(rng: w.Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """For 30 s, and back 0.05 mm beside."""
    at = rng.uniform(150, 400)
    x[:3, (t > at) & (t < at + 30)] = np.nan
    x[0, t > at] += 0.05
    return x


def handled(rng: w.Noise, since: np.ndarray) -> np.ndarray:
    """Taken up for 3 s and put back 0.3 mm beside."""
    return 5 * np.sin(np.pi * np.clip(since / 3, 0, 1)) + 0.3 * (since > 1.5)


def stick_slip(rng: w.Noise, t: np.ndarray) -> np.ndarray:
    ends = np.concatenate([[0], np.cumsum(rng.uniform(60, 160, 20))])
    which = np.searchsorted(ends, t, "right") - 1
    return 0.06 * (t - ends[which]) / np.diff(ends)[which]


def constant(rng: w.Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x[2] = 0.25
    return x


def by_time(gain: Callable[[np.ndarray], np.ndarray]) -> w.Make:
    """Louder by the share of the recording that has passed."""
    return w.louder(lambda r, t: gain(t / t[-1]))


def scattered(values: Callable[[w.Noise, tuple[int, ...]], np.ndarray]) -> w.Make:
    return lambda rng, t, x: w.WHITE * values(rng, x.shape)


def zero_phase(cutoff_hz: float) -> w.Make:
    sos = signal.butter(4, cutoff_hz, fs=100, output="sos")
    return lambda rng, t, x: signal.sosfiltfilt(sos, x)


def triangle(rng: w.Noise, t: np.ndarray) -> np.ndarray:
    at = rng.uniform(0.3, 0.7) * t[-1]
    return 0.12 * np.minimum(t / at, (t[-1] - t) / (t[-1] - at))


SLOW = "wander slowing accelerating"
LEVELS = "levels two_levels"
KINDS: dict[str, w.Kind] = {
    "turning marker": in_x1(lambda r, t: 0.2 * np.tanh(t / r.uniform(150, 400)), SLOW),
    "ramp, then plateau": in_x1(lambda r, t: 0.15 * np.minimum(t / r.uniform(150, 350), 1), SLOW),
    "drift that turns back": in_x1(triangle, "wander"),
    "part of a day": in_x1(lambda r, t: 0.3 * np.sin(t / 1500 + r.uniform(0, 6)), f"{SLOW} drift"),
    "logistic": in_x1(lambda r, t: 0.15 / (1 + np.exp((r.uniform(200, 400) - t) / 40)), "wander"),
    "two sines of no ratio": in_x1(
        w.lines((0.05, 1 / 210), (0.05, 1 / 134)), "wander cycle", "line"
    ),
    "growing cycle": in_x1(
        lambda r, t: 0.08 * t / 600 * np.sin(t / 15 + r.uniform(0, 6)), "wander cycle", "line"
    ),
    "stick and slip": in_x1(stick_slip, "wander step", "event drift moves"),
    # Two cameras come and go, each with an offset of its own.
    "two cameras in turns": kind(
        w.added(0, *(w.dwelling(10, 60, [0.0, size]) for size in (0.03, 0.05))), LEVELS
    ),
    "three levels": in_x1(w.dwelling(8, 50, [0.0, 0.03, 0.07]), LEVELS, "event"),
    "fast switching": in_x1(w.dwelling(0.5, 3, [0.0, 0.04, 0.07]), "", f"{LEVELS} wander"),
    "regular square wave": in_x1(lambda r, t: 0.04 * ((t % 40) < 20), f"{LEVELS} cycle", "line"),
    "occluded and back": kind(occluded, "step", "event moves"),
    "taken up and put back": in_x1(w.after(120, 450, handled), "event moves step", "heavy_tails"),
    "hits": in_x1(
        w.pulses(lambda r: np.cumsum(r.exponential(40, 60)), lambda s: w.ringing(s, 0.15, 0.3, 8)),
        "event",
        "heavy_tails",
    ),
    "sweep": in_x1(lambda r, t: 0.03 * np.sin(2 * np.pi * (2 * t + 9 * t**2 / t[-1]))),
    "beat": in_x1(w.lines((0.03, 7.0), (0.03, 7.1)), "line"),
    "slow line": in_x1(w.lines((0.05, 0.23)), "line"),
    "line that grows": in_x1(
        lambda r, t: 0.06 * t / 600 * np.sin(2 * np.pi * 21.7 * t), "line", "level_changes"
    ),
    "louder and louder": kind(by_time(lambda u: 1 + u), "level_changes"),
    "loud for a part": kind(
        by_time(lambda u: 1 + 0.5 * ((u > 0.4) & (u < 0.7))), "level_changes", "event heavy_tails"
    ),
    "loud every other minute": kind(
        by_time(lambda u: 1 + 0.4 * (u * 5 % 1 > 0.5)),
        "",
        "level_changes event heavy_tails recurring",
    ),
    "tails": kind(scattered(lambda r, of: r.standard_t(4, of) / np.sqrt(2)), "heavy_tails"),
    "two positions at random": kind(
        scattered(lambda r, of: r.normal(0, 0.3, of) + r.choice([-1, 1], of))
    ),
    "dithered steps": kind(
        lambda r, t, x: 0.05 * np.round(x / 0.05 + r.uniform(-0.5, 0.5, x.shape)),
        "",
        "resolution_limited",
        step_mm=0.05,
    ),
    "resampled from 240 Hz": kind(resampled, "", "resampled"),
    "mean of two": kind(passed([0.5, 0.5]), "low_pass smoothed", "resonance"),
    "Butterworth 6 Hz": kind(zero_phase(6), "low_pass"),
    "Butterworth 20 Hz": kind(zero_phase(20), "low_pass"),
    "median of three": kind(
        lambda r, t, x: ndimage.median_filter(x, (1, 3)), "running_median", "heavy_tails low_pass"
    ),
    "Savitzky-Golay": kind(lambda r, t, x: signal.savgol_filter(x, 21, 3), "low_pass"),
    "held": kind(held, "gap_filled repeated"),
    "labels of single frames": kind(swapped, "exchanged"),
    "half is missing": kind(w.lost(lambda r, t: r.random(t.size) < 0.5)),
    "ARMA of both signs": kind(passed([1.0, -0.6], [1.0, 0.5])),
    "AR, oscillating": kind(passed([1.0], [1.0, -1.2, 0.7]), "", "resonance"),
    "moving average": kind(passed([1.0, 0.6]), "", "smoothed low_pass"),
    "1/f^0.5": kind(w.of_noise(coloured(-0.5, w.WHITE)), "", "wander"),
    "1/f^1.5": kind(
        w.of_noise(coloured(-1.5, w.WHITE / 20), 1.0), "", "wander random_walk smoothed"
    ),
    "correlated over 60 s": kind(w.of_noise(gauss_markov(60.0, 0.02), 1.0), "", "wander"),
    "of one body": kind(  # the noise of both markers is half common
        w.then(
            lambda r, t, x: x / np.sqrt(2),
            w.common(lambda r, t: w.WHITE * r.standard_normal((3, t.size)) / np.sqrt(2)),
        )
    ),
    "a constant coordinate": kind(constant, "", "resolution_limited"),
    "1 um": kind(lambda r, t, x: x / 20),
    "20 s at 300 Hz": kind(lambda r, t, x: x, rate=300.0, seconds=20.0),
    "2 h at 30 Hz": kind(lambda r, t, x: x, rate=30.0, seconds=7200.0),
}


def rows(runs: int) -> Iterator[Row]:
    """(case, statistic, runs, reach, measured)."""
    return w.rows_of(KINDS, lambda name, run: said_of(KINDS, name, run, 26), runs)
