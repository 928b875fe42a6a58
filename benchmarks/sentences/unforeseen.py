"""Recordings of kinds that no detector was made for: what the findings say that is not so.

Two markers, 10 min at 100 Hz or as the kind has it, white noise of 0.02 mm a frame. `named`: one of
the findings that say what it is (those that no finding can name need none); `false`: any finding
that is not so.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy import ndimage, signal

from benchmarks.sentences._kinds import coloured, gauss_markov
from benchmarks.sentences.recordings import told

Noise = np.random.Generator
Make = Callable[[Noise, np.ndarray, np.ndarray], np.ndarray]  # of times (n,), white noise (6, n)
WHITE = 0.02


@dataclass(frozen=True)
class Kind:
    """names: findings of which one is there; beside: others that are true; step: of the file."""

    make: Make
    names: frozenset[str] = frozenset()
    beside: frozenset[str] = frozenset()
    rate: float = 100.0
    seconds: float = 600.0
    step: float = 0.0

    def drawn(self, rng: Noise) -> np.ndarray:
        """(6, n) mm."""
        t = np.arange(round(self.seconds * self.rate)) / self.rate
        x = self.make(rng, t, WHITE * rng.standard_normal((6, t.size)))
        x[4] += 500
        return x


def kind(make: Make, names: str = "", beside: str = "", **how: float) -> Kind:
    return Kind(make, frozenset(names.split()), frozenset(beside.split()), **how)


def in_x1(wave: Callable[[Noise, np.ndarray], np.ndarray]) -> Make:
    """Added to one coordinate."""

    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        x[0] += wave(rng, t)
        return x

    return made


def of_noise(own: Callable[[Noise, int, float], np.ndarray], white: float = 0.0) -> Make:
    """All coordinates of this noise, and as much of the white one."""

    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        rate = 1 / (t[1] - t[0])
        return white * x + np.array([own(rng, t.size, rate) for _ in x])

    return made


def passed(b: list[float], a: list[float] | None = None) -> Make:
    """White noise through a filter, each coordinate by itself; put to the same size."""

    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        y = signal.lfilter(b, a or [1.0], x)
        return WHITE * y / y.std(axis=1, keepdims=True)

    return made


def dwelling(low_s: float, high_s: float, levels: list[float]) -> Callable[..., np.ndarray]:
    """Positions that are never the same twice in a row."""

    def wave(rng: Noise, t: np.ndarray) -> np.ndarray:
        ends = np.cumsum(rng.uniform(low_s, high_s, int(t[-1] / low_s) + 2))
        which = np.cumsum(rng.integers(1, len(levels), ends.size)) % len(levels)
        return np.array(levels)[which][np.searchsorted(ends, t, "right")]

    return wave


def hits(rng: Noise, t: np.ndarray) -> np.ndarray:
    """Every 40 s on average, ringing at 8 Hz."""
    total = np.zeros(t.size)
    for at in np.cumsum(rng.exponential(40, 60)):
        since = np.maximum(t - at, 0)
        total += 0.15 * (t >= at) * np.exp(-since / 0.3) * np.sin(2 * np.pi * 8 * since)
    return total


def lines(*pairs: tuple[float, float]) -> Callable[..., np.ndarray]:
    """Amplitudes and frequencies."""
    return lambda rng, t: sum(
        size * np.sin(2 * np.pi * (f * t + rng.uniform())) for size, f in pairs
    )


def sweep(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.03 * np.sin(2 * np.pi * (2 * t + 9 * t**2 / t[-1]))


def held(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Gaps of 20 to 100 frames of one marker."""
    for start in rng.integers(100, t.size - 200, 30):
        x[:3, start : start + rng.integers(20, 100)] = x[:3, start - 1 : start]
    return x


def swapped(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Labels, for a frame each."""
    x[3] += 60
    at = rng.choice(t.size, 20, replace=False)
    x[:3, at], x[3:, at] = x[3:, at].copy(), x[:3, at].copy()
    x[4, at] -= 500
    x[1, at] += 500
    return x


def resampled(old_hz: float) -> Make:
    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        then = np.arange(int(t[-1] * old_hz) + 2) / old_hz
        return np.array([np.interp(t, then, WHITE * rng.standard_normal(then.size)) for _ in x])

    return made


def occluded(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """For 30 s, and back 0.05 mm beside."""
    at = rng.uniform(150, 400)
    x[:3, (t > at) & (t < at + 30)] = np.nan
    x[0, t > at] += 0.05
    return x


def handled(rng: Noise, t: np.ndarray) -> np.ndarray:
    """Taken up for 3 s and put back 0.3 mm beside."""
    since = t - rng.uniform(120, 450)
    way = np.clip(since / 3, 0, 1)
    return 5 * np.sin(np.pi * way) + 0.3 * (since > 1.5)


def stick_slip(rng: Noise, t: np.ndarray) -> np.ndarray:
    ends = np.concatenate([[0], np.cumsum(rng.uniform(60, 160, 20))])
    which = np.searchsorted(ends, t, "right") - 1
    return 0.06 * (t - ends[which]) / np.diff(ends)[which]


def constant(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x[2] = 0.25
    return x


def of_a_body(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The noise of both markers is half common."""
    return np.tile(WHITE * rng.standard_normal((3, t.size)), (2, 1)) / np.sqrt(2) + x / np.sqrt(2)


def louder(of: Callable[[np.ndarray], np.ndarray]) -> Make:
    return lambda rng, t, x: x * of(t / t[-1])


def scattered(own: Callable[[Noise, tuple[int, ...]], np.ndarray]) -> Make:
    return lambda rng, t, x: WHITE * own(rng, x.shape)


def dithered(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    return 0.05 * np.round(x / 0.05 + rng.uniform(-0.5, 0.5, x.shape))


def missing(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    x[:3, rng.random(t.size) < 0.5] = np.nan
    return x


def zero_phase(cutoff_hz: float) -> Make:
    def made(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
        return signal.sosfiltfilt(signal.butter(4, cutoff_hz, fs=100, output="sos"), x)

    return made


def triangle(rng: Noise, t: np.ndarray) -> np.ndarray:
    at = rng.uniform(0.3, 0.7) * t[-1]
    return 0.12 * np.minimum(t / at, (t[-1] - t) / (t[-1] - at))


def plateau(rng: Noise, t: np.ndarray) -> np.ndarray:
    return 0.15 * np.minimum(t / rng.uniform(150, 350), 1)


def alternate(rng: Noise, t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Two cameras come and go, each with an offset of its own."""
    for size in (0.03, 0.05):
        x[0] += dwelling(10, 60, [0.0, size])(rng, t)
    return x


SLOW = "wander slowing accelerating"
KINDS: dict[str, Kind] = {
    "turning marker": kind(in_x1(lambda r, t: 0.2 * np.tanh(t / r.uniform(150, 400))), SLOW),
    "ramp, then plateau": kind(in_x1(plateau), SLOW),
    "drift that turns back": kind(in_x1(triangle), "wander"),
    "part of a day": kind(
        in_x1(lambda r, t: 0.3 * np.sin(t / 1500 + r.uniform(0, 6))), f"{SLOW} drift"
    ),
    "logistic": kind(
        in_x1(lambda r, t: 0.15 / (1 + np.exp((r.uniform(200, 400) - t) / 40))), "wander"
    ),
    "two sines of no ratio": kind(
        in_x1(lines((0.05, 1 / 210), (0.05, 1 / 134))), "wander cycle", "line"
    ),
    "growing cycle": kind(
        in_x1(lambda r, t: 0.08 * t / 600 * np.sin(t / 15 + r.uniform(0, 6))),
        "wander cycle",
        "line",
    ),
    "stick and slip": kind(in_x1(stick_slip), "wander step", "event drift moves"),
    "two cameras in turns": kind(alternate, "levels two_levels"),
    "three levels": kind(in_x1(dwelling(8, 50, [0.0, 0.03, 0.07])), "levels two_levels", "event"),
    "fast switching": kind(
        in_x1(dwelling(0.5, 3, [0.0, 0.04, 0.07])), "", "levels two_levels wander"
    ),
    "regular square wave": kind(
        in_x1(lambda r, t: 0.04 * ((t % 40) < 20)), "two_levels cycle levels", "line"
    ),
    "occluded and back": kind(occluded, "step", "event moves"),
    "taken up and put back": kind(in_x1(handled), "event moves step", "heavy_tails"),
    "hits": kind(in_x1(hits), "event", "heavy_tails"),
    "sweep": kind(in_x1(sweep)),
    "beat": kind(in_x1(lines((0.03, 7.0), (0.03, 7.1))), "line"),
    "slow line": kind(in_x1(lines((0.05, 0.23))), "line"),
    "line that grows": kind(
        in_x1(lambda r, t: 0.06 * t / 600 * np.sin(2 * np.pi * 21.7 * t)), "line", "level_changes"
    ),
    "louder and louder": kind(louder(lambda u: 1 + u), "level_changes"),
    "loud for a part": kind(
        louder(lambda u: 1 + 0.5 * ((u > 0.4) & (u < 0.7))), "level_changes", "event heavy_tails"
    ),
    "loud every other minute": kind(
        louder(lambda u: 1 + 0.4 * (u * 5 % 1 > 0.5)),
        "",
        "level_changes event heavy_tails recurring",
    ),
    "tails": kind(scattered(lambda r, of: r.standard_t(4, of) / np.sqrt(2)), "heavy_tails"),
    "two positions at random": kind(
        scattered(lambda r, of: r.normal(0, 0.3, of) + r.choice([-1, 1], of))
    ),
    "dithered steps": kind(dithered, "", "resolution_limited", step=0.05),
    "resampled from 240 Hz": kind(resampled(240.0), "", "resampled"),
    "mean of two": kind(passed([0.5, 0.5]), "low_pass smoothed", "resonance"),
    "Butterworth 6 Hz": kind(zero_phase(6), "low_pass"),
    "Butterworth 20 Hz": kind(zero_phase(20), "low_pass"),
    "median of three": kind(
        lambda r, t, x: ndimage.median_filter(x, (1, 3)), "running_median", "heavy_tails low_pass"
    ),
    "Savitzky-Golay": kind(lambda r, t, x: signal.savgol_filter(x, 21, 3), "low_pass"),
    "held": kind(held, "gap_filled repeated"),
    "labels of single frames": kind(swapped, "exchanged"),
    "half is missing": kind(missing),
    "ARMA of both signs": kind(passed([1.0, -0.6], [1.0, 0.5])),
    "AR, oscillating": kind(passed([1.0], [1.0, -1.2, 0.7]), "", "resonance"),
    "moving average": kind(passed([1.0, 0.6]), "", "smoothed low_pass"),
    "1/f^0.5": kind(of_noise(coloured(-0.5, WHITE)), "", "wander"),
    "1/f^1.5": kind(of_noise(coloured(-1.5, WHITE / 20), 1.0), "", "wander random_walk smoothed"),
    "correlated over 60 s": kind(of_noise(gauss_markov(60.0, 0.02), 1.0), "", "wander"),
    "of one body": kind(of_a_body),
    "a constant coordinate": kind(constant, "", "resolution_limited"),
    "1 um": kind(lambda r, t, x: x / 20),
    "20 s at 300 Hz": kind(lambda r, t, x: x, rate=300.0, seconds=20.0),
    "2 h at 30 Hz": kind(lambda r, t, x: x, rate=30.0, seconds=7200.0),
}


def codes(name: str, seed: int) -> Counter[str]:
    """Findings of one recording."""
    rng = np.random.default_rng([list(KINDS).index(name), seed, 26])
    one = KINDS[name]
    return Counter(found.code for found in told(one.drawn(rng), one.rate, one.step).findings)


def rows(runs: int) -> Iterator[tuple[str, str, int, str, str, str]]:
    """For docs/accuracy."""
    for name, one in KINDS.items():
        named = wrong = 0
        which: Counter[str] = Counter()
        for run in range(runs):
            said = set(codes(name, run))
            named += bool(said & one.names) or not one.names
            wrong += bool(said - one.names - one.beside)
            which.update(said - one.names - one.beside)
        yield name, "named", runs, ">= 0.7", "", f"{named / runs:.2f}"
        listed = ", ".join(f"{code} {count}" for code, count in which.items())
        yield name, "false", runs, "<= 0.03", "", f"{wrong / runs:.2f} {listed}".strip()
