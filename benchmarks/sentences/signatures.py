"""Kinds of slow wander: how often the right kind is named, and how often a wrong one.

One coordinate, 15 min at 100 Hz, white noise of 0.02 mm a frame. `named`: the right kind and no
other; `false`: at least one wrong kind. In the remaining runs the kind is left open.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator

import numpy as np

from benchmarks.sentences._kinds import gauss_markov
from mocap_metrology.noise.diagnosis.signatures import signature

RATE, N = 100.0, 90_000
T = np.arange(N) / RATE
Draw = Callable[[np.random.Generator], np.ndarray]


def flicker(rng: np.random.Generator) -> np.ndarray:
    """Of 0.02 mm."""
    f = np.fft.rfftfreq(N, 1 / RATE)
    f[0] = f[1]
    x = np.fft.irfft((rng.normal(size=f.size) + 1j * rng.normal(size=f.size)) / np.sqrt(f), N)
    return 0.02 * x / x.std()


def telegraph(rng: np.random.Generator) -> np.ndarray:
    """Two levels 1 to 3 standard deviations apart, for 5 to 120 s each."""
    ends = np.cumsum(rng.uniform(5, 120, 400) * RATE).astype(int)
    return 0.02 * rng.uniform(1, 3) * (np.searchsorted(ends, np.arange(N), "right") % 2)


def recovering(rng: np.random.Generator) -> np.ndarray:
    """A shift of 0.1 mm that recovers in 15 to 40 s."""
    since = T - rng.uniform(100, 700)
    return np.where(since > 0, 0.1 * np.exp(-np.maximum(since, 0) / rng.uniform(15, 40)), 0.0)


def walk(step_mm: float) -> Draw:
    """A random walk of so much a frame."""
    return lambda rng: np.cumsum(rng.normal(0, step_mm, N))


def sine(amplitude_mm: float, period_s: float) -> Draw:
    """Of any phase."""
    return lambda rng: amplitude_mm * np.sin(2 * np.pi * (T / period_s + rng.uniform()))


def at_once(low: float, high: float, lasts_s: float = np.inf) -> Draw:
    """A shift of so much at some time, for so long."""

    def drawn(rng: np.random.Generator) -> np.ndarray:
        since = T - rng.uniform(100, 800)
        return rng.uniform(low, high) * ((since >= 0) & (since < lasts_s))

    return drawn


def bend(rng: np.random.Generator) -> np.ndarray:
    """0.1 mm in 200 s."""
    return 0.1 * np.clip((T - rng.uniform(200, 500)) / 200, 0, 1)


def bump(rng: np.random.Generator) -> np.ndarray:
    return 0.1 * np.exp(-(((T - rng.uniform(200, 700)) / rng.uniform(30, 80)) ** 2))


def chirp(rng: np.random.Generator) -> np.ndarray:
    """Cycles that become shorter."""
    return 0.05 * np.sin(2 * np.pi * (T / 200 + T**2 / 270_000 + rng.uniform()))


def staircase(rng: np.random.Generator) -> np.ndarray:
    first, second = np.sort(rng.uniform(100, 800, 2))
    return 0.05 * (first < T) + 0.05 * (second < T)


def several(rng: np.random.Generator) -> np.ndarray:
    """Three positions 0.03 mm apart, for 10 to 60 s each."""
    ends = np.cumsum(rng.uniform(10, 60, 200))
    positions = np.cumsum(rng.integers(1, 3, 200)) % 3
    return 0.03 * positions[np.searchsorted(ends, T, "right")]


def sliding(rng: np.random.Generator) -> np.ndarray:
    """At 3 um/s, and at rest, in turn, for 70 to 120 s each."""
    ends = np.cumsum(rng.uniform(70, 120, 20))
    return np.cumsum(np.where(np.searchsorted(ends, T, "right") % 2, 0.003, 0.0)) / RATE


def half_recovering(rng: np.random.Generator) -> np.ndarray:
    since = T - rng.uniform(200, 700)
    return np.where(since > 0, 0.05 + 0.05 * np.exp(-np.maximum(since, 0) / 20), 0.0)


def creep_and_step(rng: np.random.Generator) -> np.ndarray:
    return 0.05 * np.log1p(T / 8) + 0.08 * (rng.uniform(200, 700) < T)


def correlated(rng: np.random.Generator) -> np.ndarray:
    """Of 0.02 mm over 10 s."""
    return gauss_markov(10.0, 0.02)(rng, N, RATE)


KINDS: dict[str, tuple[Draw, tuple[str, ...], tuple[str, ...]]] = {  # true; what may be said, too
    "nothing": (lambda rng: np.zeros(N), (), ()),
    "flicker": (flicker, ("noise",), ()),
    "random walk of 0.0005 mm a frame": (walk(5e-4), ("noise",), ()),
    "random walk of 0.003 mm a frame": (walk(3e-3), ("noise",), ()),
    "drift of 0.05 mm": (lambda rng: 0.05 * T / T[-1], ("drift",), ()),
    "warm-up": (lambda rng: 0.2 * np.exp(-T / rng.uniform(100, 300)), ("warm_up",), ()),
    "accelerating": (
        lambda rng: 0.594 * np.expm1(T / 150) / np.expm1(6),
        ("accelerating",),
        ("drift",),
    ),
    "creep": (lambda rng: 0.05 * np.log1p(T / rng.uniform(5, 30)), ("creep",), ()),
    "two levels": (telegraph, ("two_levels",), ()),
    "step of 0.03 to 0.08 mm": (at_once(0.03, 0.08), ("step",), ()),
    "lift for 20 s": (at_once(0.06, 0.06, 20), ("shift",), ()),
    "shift with recovery": (recovering, ("shift",), ()),
    "cycle of 200 s": (sine(0.05, 200), ("cycle",), ()),
    "cycle of 420 s": (sine(0.1, 420), (), ()),  # two of them: undecided
    "warm-up and cycle of 250 s": (
        lambda rng: 0.2 * np.exp(-T / 200) + sine(0.05, 250)(rng),
        ("warm_up", "cycle"),
        ("drift",),
    ),
    "drift in flicker": (lambda rng: flicker(rng) / 4 + 0.05 * T / T[-1], ("drift", "noise"), ()),
    "correlated over 10 s": (correlated, ("noise",), ()),
    "several levels": (several, ("levels",), ()),
    "fourth power of time": (lambda rng: 0.6 * (T / 900) ** 4, ("accelerating",), ()),
    "square root of time": (lambda rng: 0.2 * np.sqrt(T / 900), ("slowing",), ("noise",)),
    "three steps": (
        lambda rng: 0.04 * sum(rng.uniform(t, t + 150) < T for t in (100, 350, 600)),
        ("step",),
        ("drift",),
    ),
    "two steps": (staircase, ("step",), ()),
    "step, of which half fades": (half_recovering, ("step",), ()),
    "creep and step": (creep_and_step, ("creep", "step"), ()),
    # Of no kind in the library
    "bend": (bend, (), ()),
    "bump": (bump, (), ("shift",)),
    "cycles that become shorter": (chirp, (), ()),
    "slides, and rests between": (sliding, (), ()),
}


def rows(runs: int) -> Iterator[tuple[str, str, int, str, str, str]]:
    """For docs/accuracy."""
    for k, (case, (draw, true, also)) in enumerate(KINDS.items()):
        count: Counter[str] = Counter()
        for run in range(runs):
            rng = np.random.default_rng([k, run])
            found = signature(draw(rng) + rng.normal(0, 0.02, N), RATE)
            assert found is not None
            said = {*found.kinds, *(("noise",) if found.noise else ())} - {*also}
            count["false"] += not said <= set(true)
            count["named"] += said == set(true)
        reach = ">= 0.7" if true else ">= 0.97"
        yield case, "named", runs, reach, "", f"{count['named'] / runs:.2f}"
        yield case, "false", runs, "<= 0.03", "", f"{count['false'] / runs:.2f}"
