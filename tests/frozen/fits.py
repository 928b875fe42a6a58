"""Noise models of brief series: each kind of noise, line, slow part and gap in a few doses."""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import lfilter

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.fit.spectral.likelihood import LikelihoodSettings, likelihood

from .digest import Flat, flat

N, RATE = 2000, 100.0
Floats = np.ndarray
Series = Iterator[tuple[Floats, dict[str, Any]]]


def walks(x: Floats, t: Floats, rng: np.random.Generator) -> Series:
    walk = np.cumsum(rng.standard_normal(N))
    yield from ((x + dose * walk, {}) for dose in (0.01, 0.03, 0.1))


def correlated(x: Floats, t: Floats, rng: np.random.Generator) -> Series:
    for share in (0.05, 0.25, 0.7):
        yield x + share * lfilter([1.0], [1.0, share - 1], rng.standard_normal(N)), {}


def several(x: Floats, t: Floats, rng: np.random.Generator) -> Series:
    """Two correlation times; flicker; blue noise."""
    a, b, c, d = rng.standard_normal((4, N))
    yield lfilter([1.0], [1, -0.9], a) + lfilter([0.1], [1, -0.995], b) + x, {}
    shape = np.sqrt(1 / np.maximum(np.arange(N // 2 + 1), 1))
    yield 0.3 * x + 6 * np.fft.irfft(np.fft.rfft(c) * shape, N), {}
    yield 0.2 * x + np.fft.irfft(np.fft.rfft(d) / shape, N) / 25, {}


def lines(x: Floats, t: Floats, rng: np.random.Generator) -> Series:
    for f_0, amplitude in ((12.34, 0.25), (49.98, 0.4), (0.9, 0.6)):
        yield x + amplitude * np.sin(2 * np.pi * f_0 * t + 1), {}
    wander = np.cumsum(np.sin(t)) / RATE
    yield x + np.sin(2 * np.pi * (9 * t + 0.1 * wander)), {}
    yield x + np.sin(2 * np.pi * 9 * t) + np.sin(2 * np.pi * 9.2 * t), {}


def slow(x: Floats, t: Floats, rng: np.random.Generator) -> Series:
    yield x + 0.8 * t / t[-1], {}
    yield x + 0.5 * np.exp(-t / 4), {}
    yield x + 3.0 * np.exp(-t / 2), {}


def gaps(x: Floats, t: Floats, rng: np.random.Generator) -> Series:
    y = x + lfilter([0.1], [1, -0.97], rng.standard_normal(N)) + 0.4 * np.sin(60 * t)
    for share in (0.02, 0.2):
        yield np.where(rng.random(N) < share, np.nan, y), {}
    yield np.where(abs(t - 8) < 1.5, np.nan, y), {}


def settings(x: Floats, t: Floats, rng: np.random.Generator) -> Series:
    y = x + lfilter([0.1], [1, -0.97], rng.standard_normal(N)) + 0.4 * np.sin(60 * t)
    yield y, {"either": True}
    yield y, {"form": "continuous", "criterion": "aicc"}
    yield y, {"sinusoid": False, "max_gauss_markov": 1, "deterministic": False}


KINDS: dict[str, Callable[..., Series]] = {
    one.__name__: one for one in (walks, correlated, several, lines, slow, gaps, settings)
}


def fits(kind: str, folder: Path | None = None) -> Flat:
    rng = np.random.default_rng([13, *kind.encode()])
    x, found = rng.standard_normal(N), {}
    for k, (series, own) in enumerate(KINDS[kind](x, np.arange(N) / RATE, rng)):
        try:
            found[str(k)] = likelihood(0.02 * series, RATE, None, LikelihoodSettings(**own))
        except Refusal as refusal:
            found[str(k)] = str(refusal)
    return dict(flat(found))


CASES: dict[str, Callable[..., Flat]] = {f"fits of {kind}": partial(fits, kind) for kind in KINDS}
