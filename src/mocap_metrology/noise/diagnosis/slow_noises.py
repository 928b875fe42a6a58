"""Noises that a slow wander may be: spectra of the differences of block means, see `signatures`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from mocap_metrology.common.types import Floats

FOLDED = 20  # to each side, of the spectra of block means
RATIOS = np.geomspace(1e-4, 1e3, 29)  # of slow noise to white noise in differences of blocks
STEEP = 2.5, 3.0  # exponents of steeper noise than a walk
LONGEST, SHARES = 0.1, 5  # of T_c of a Gauss-Markov term, from one block to this of all
EXACT = 1e-12  # of the variance, in a part where a fit is exact
LOUDNESS = 1, 2, 4, 8  # parts of a recording, in each of which noise has a size of its own


@lru_cache(maxsize=4)
def spectra(n: int) -> Mapping[str, Floats]:
    """(m, n) spectra of differences, by noise, white noise first, steep noise last."""
    weight = 4 * np.sin(np.pi * np.arange(1, n + 1) / (2 * (n + 1))) ** 2
    f = np.arange(1, n + 1)[:, None] / (2 * (n + 1)) + np.arange(-FOLDED, FOLDED + 1)
    share = np.sinc(f) ** 2

    def folded(psd: Floats) -> Floats:
        density = weight * (psd * share).sum(axis=1)
        return 4 * density / density.max()  # as white noise has it

    walk = weight + RATIOS[:, None] * (1 - weight / 6)
    flicker = weight + RATIOS[:, None] * folded(1 / np.abs(f))
    steep = [weight + r * folded(1 / np.abs(f) ** a) for a in STEEP for r in RATIOS[::2]]

    def correlated(T_c: float) -> list[Floats]:  # in blocks
        one = folded(1 / (1 + (2 * np.pi * f * T_c) ** 2))
        return [weight + ratio * one for ratio in RATIOS[::2]]

    slow = [one for T_c in np.geomspace(1, LONGEST * n, SHARES) for one in correlated(T_c)]
    return {
        "white": weight[None],
        "fast": np.array(correlated(0.25)),
        "random_walk": walk,
        "flicker": flicker,
        "correlated": np.array(slow),
        "steep": np.array(steep),
    }


@lru_cache(maxsize=4)
def _sums(n: int) -> tuple[Floats, Floats, Floats]:
    """(T_c, sizes, sizes, n) spectra of differences, of a walk and a Gauss-Markov term beside white
    noise; their inverse; the sums of their logarithms."""
    known = spectra(n)
    terms = np.vstack([known["fast"], known["correlated"]]) - known["white"]
    walks = known["random_walk"][::2]
    every = np.asarray(walks[:, None] + terms.reshape(-1, 1, len(RATIOS[::2]), n))
    return every, 1 / every, np.log(every).sum(axis=-1)


def likeliest_sums(y: Floats) -> Floats:
    """Spectra (m, n) of a walk and a Gauss-Markov term of one T_c, of the sizes that are likeliest
    for (n,) values, and smaller, as a shape leaves less to them."""
    every, inverse, logs = _sums(y.size)
    values = logs + y.size * np.log(inverse @ (y * y) / y.size)
    at, walk, term = np.unravel_index(np.argmin(values), values.shape)
    near = every[at, max(walk - 2, 0) : walk + 1, max(term - 2, 0) : term + 1]
    return near.reshape(-1, y.size)


def by_parts(y: Floats, X: Floats, spectrum: Floats) -> float:
    """BIC of a fit in noise whose size differs between equal parts of the recording, as many as it
    is best by; of what is left of the whitened differences, in order of time."""
    from scipy.fft import dst

    rows = dst(np.vstack([y, X]) / np.sqrt(spectrum), type=1, norm="ortho", axis=1)
    n, found = y.size, []
    for count in LOUDNESS:
        part, size = np.arange(n) * count // n, np.ones(n)
        for _ in range(2):
            weighted = rows / size
            rest = rows[0] - np.linalg.lstsq(weighted[1:].T, weighted[0], rcond=None)[0] @ rows[1:]
            variance = np.bincount(part, rest**2) / np.bincount(part)
            size = np.sqrt(np.maximum(variance, EXACT * variance.mean() + 1e-300))[part]
        found.append(2 * float(np.log(size).sum()) + (count - 1) * math.log(n))
    return float(np.log(spectrum).sum()) + min(found)
