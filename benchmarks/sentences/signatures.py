"""Kinds of slow wander: how often the right kind is named, and how often a wrong one.

One coordinate, 15 min at 100 Hz, white noise of 0.02 mm a frame. `named`: the right kind and no
other; `false`: at least one wrong kind. In the remaining runs the kind is left open.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from benchmarks.sentences import Row
from benchmarks.sentences import _waves as w
from benchmarks.sentences._kinds import gauss_markov
from mocap_metrology.noise.diagnosis.signatures import signature

RATE, N = 100.0, 90_000
T = np.arange(N) / RATE


def flicker(rng: w.Noise, t: np.ndarray) -> np.ndarray:
    """Of 0.02 mm."""
    f = np.fft.rfftfreq(t.size, 1 / RATE)
    f[0] = f[1]
    drawn = rng.normal(size=f.size) + 1j * rng.normal(size=f.size)
    x = np.fft.irfft(drawn / np.sqrt(f), t.size)
    return 0.02 * x / x.std()


def walk(step_mm: float) -> w.Wave:
    """A random walk of so much a frame."""
    return lambda rng, t: np.cumsum(rng.normal(0, step_mm, t.size))


def sine(amplitude_mm: float, period_s: float) -> w.Wave:
    """Of any phase."""
    return lambda rng, t: amplitude_mm * np.sin(2 * np.pi * (t / period_s + rng.uniform()))


def bump(rng: w.Noise, t: np.ndarray) -> np.ndarray:
    return 0.1 * np.exp(-(((t - rng.uniform(200, 700)) / rng.uniform(30, 80)) ** 2))


def chirp(rng: w.Noise, t: np.ndarray) -> np.ndarray:
    """Cycles that become shorter."""
    return 0.05 * np.sin(2 * np.pi * (t / 200 + t**2 / 270_000 + rng.uniform()))


def kind(draw: w.Wave, names: str = "", also: str = "") -> tuple[w.Wave, str, str]:
    """What it is, and what may be said, too."""
    return draw, names, also


KINDS: dict[str, tuple[w.Wave, str, str]] = {
    "nothing": kind(lambda rng, t: 0 * t),
    "flicker": kind(flicker, "noise"),
    "random walk of 0.0005 mm a frame": kind(walk(5e-4), "noise"),
    "random walk of 0.003 mm a frame": kind(walk(3e-3), "noise"),
    "drift of 0.05 mm": kind(lambda rng, t: 0.05 * t / t[-1], "drift"),
    "warm-up": kind(lambda rng, t: 0.2 * np.exp(-t / rng.uniform(100, 300)), "warm_up"),
    "accelerating": kind(
        lambda rng, t: 0.594 * np.expm1(t / 150) / np.expm1(6), "accelerating", "drift"
    ),
    "creep": kind(w.creep, "creep"),
    "two levels": kind(w.two_levels(400), "two_levels"),
    "step of 0.03 to 0.08 mm": kind(
        w.after(100, 800, lambda r, s: r.uniform(0.03, 0.08) + 0 * s), "step"
    ),
    "lift for 20 s": kind(
        w.after(100, 800, lambda r, s: r.uniform(0.06, 0.06) * (s < 20)), "shift"
    ),
    "shift with recovery": kind(w.recovering(100, 700), "shift"),
    "cycle of 200 s": kind(sine(0.05, 200), "cycle"),
    "cycle of 420 s": kind(sine(0.1, 420)),  # two of them: undecided
    "warm-up and cycle of 250 s": kind(
        lambda rng, t: 0.2 * np.exp(-t / 200) + sine(0.05, 250)(rng, t), "warm_up cycle", "drift"
    ),
    "drift in flicker": kind(lambda rng, t: flicker(rng, t) / 4 + 0.05 * t / t[-1], "drift noise"),
    "correlated over 10 s": kind(lambda rng, t: gauss_markov(10.0, 0.02)(rng, N, RATE), "noise"),
    "several levels": kind(w.dwelling(10, 60, [0.0, 0.03, 0.06], 200), "levels"),
    "fourth power of time": kind(lambda rng, t: 0.6 * (t / 900) ** 4, "accelerating"),
    "square root of time": kind(lambda rng, t: 0.2 * np.sqrt(t / 900), "slowing", "noise"),
    "three steps": kind(
        lambda rng, t: 0.04 * sum(rng.uniform(at, at + 150) < t for at in (100, 350, 600)),
        "step",
        "drift",
    ),
    "two steps": kind(
        lambda rng, t: 0.05 * (rng.uniform(100, 800, (2, 1)) < t).sum(axis=0), "step"
    ),
    "step, of which half fades": kind(
        w.after(200, 700, lambda r, s: 0.05 + 0.05 * np.exp(-s / 20)), "step"
    ),
    "creep and step": kind(
        lambda rng, t: 0.05 * np.log1p(t / 8) + 0.08 * (rng.uniform(200, 700) < t), "creep step"
    ),
    # Of no kind in the library
    "bend": kind(w.after(200, 500, lambda r, s: 0.1 * np.minimum(s / 200, 1))),
    "bump": kind(bump, "", "shift"),
    "cycles that become shorter": kind(chirp),
    "slides, and rests between": kind(w.sliding(70, 120, [0.003, 0.0])),
}


def rows(runs: int) -> Iterator[Row]:
    """For docs/accuracy."""
    for k, (case, (draw, names, also)) in enumerate(KINDS.items()):
        true = set(names.split())
        count: Counter[str] = Counter()
        for run in range(runs):
            rng = np.random.default_rng([k, run])
            found = signature(draw(rng, T) + rng.normal(0, 0.02, N), RATE)
            assert found is not None
            said = {*found.kinds, *(("noise",) if found.noise else ())} - {*also.split()}
            count["false"] += not said <= true
            count["named"] += said == true
        reach = ">= 0.7" if true else ">= 0.97"
        yield case, "named", runs, reach, f"{count['named'] / runs:.2f}"
        yield case, "false", runs, "<= 0.03", f"{count['false'] / runs:.2f}"
