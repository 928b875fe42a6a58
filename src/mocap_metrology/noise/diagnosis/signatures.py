"""What kind of slow wander is it? A kind is named only where the data exclude every other.

Block means z of a series (1000 at most) are explained by a shape and a noise, in one small library:

* shapes: none, line, accelerating or slowing (parabola), warm-up (exponential approach), creep
  (logarithm of time), cycle, step, temporary shift, two levels; each also on a straight line;
* noises: white; with a random walk, flicker, or a Gauss-Markov term of at most a tenth of the
  recording.

Differences d of neighbouring block means have, for all these noises, a covariance that the discrete
sine transform makes diagonal: of white noise lambda_k = 4 sin^2(pi k / 2 (n + 1)) s^2, of a walk q,
of flicker c lambda_k^(1/2), of a Gauss-Markov term lambda_k / ((1 - a)^2 + a lambda_k). (Exact for
the first two; of the others up to the ends of the recording.) So each hypothesis is a weighted
least-squares fit of few columns, and has

    BIC = sum ln S_k + n ln(rest / n) + p ln n,

with p parameters: columns, and places, time constants and slow noises that were searched. A kind is
named where every hypothesis without it has a BIC that is greater by 2 ln(m / 0.01) at least, of a
recording of m series: odds of 100 to 1 for all [Kass & Raftery 1995, J. Am. Stat. Assoc. 90, 773].
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.types import Floats

LEVEL = 0.01  # of what is excluded in a recording
MOST_BLOCKS, LEAST_BLOCKS = 1000, 60
BLOCK_S = 1.0  # at least: what is faster is no slow wander
RATIOS = np.geomspace(1e-4, 1e3, 29)  # of slow noise to white noise in differences of blocks
SHARES = 5  # of T_c of a Gauss-Markov term, from one block to a tenth of the recording
CONSTANTS = np.geomspace(0.02, 0.7, 16)  # of a warm-up, over the recording
FINER = 8  # places a cycle of the search for one
PERIODS = 3.0  # of a cycle that is named
SWITCHES = 4  # of two levels, at least
KINDS = ("drift", "accelerating", "warm_up", "creep", "cycle", "step", "shift", "two_levels")
AT_ONCE = {"step", "shift", "two_levels"}
NOISES = ("random_walk", "flicker", "correlated")


Columns = Callable[[float], Floats]
CURVES: dict[str, Callable[[Floats, float], Floats]] = {  # of time and constant over the recording
    "warm_up": lambda t, c: np.exp(-t / c),
    "accelerating": lambda t, c: np.exp((t - 1) / c),
    "creep": lambda t, c: np.log1p(15 * t / c),
}


@dataclass(frozen=True)
class Wander:
    """Slow wander of a series.

    kinds: shapes that every possible explanation has; noise: whether every one has slow noise
    (which noise is for the model of it to say); possible: shapes that are not excluded, none where
    white noise alone explains it; net_mm: level at the end less that at the start (means of a tenth
    of the recording), with its standard error; range_mm: of medians of a fiftieth; size_mm: of the
    shape that explains most, signed; at_s: its begin and end, or its period or mean dwell.
    """

    kinds: tuple[str, ...]
    noise: bool
    possible: tuple[str, ...]
    net_mm: float
    net_error_mm: float
    range_mm: float
    size_mm: float = math.nan
    at_s: tuple[float, ...] = ()

    @property
    def undecided(self) -> bool:
        """Whether there is wander whose kind is open."""
        return bool(self.possible) and not self.kinds and not self.noise

    def allows(self, kind: str) -> bool:
        """Whether a coefficient of the noise model of this kind may be named."""
        return self.noise if kind == "random_walk" else kind in self.kinds


@dataclass(frozen=True)
class _Shape:
    """A column (n,) of level over blocks, its kinds, and how many parameters it cost."""

    kinds: frozenset[str]
    columns: Floats  # (p, n)
    searched: int = 0
    at: tuple[float, ...] = ()


def signature(series: np.ndarray, frame_rate_hz: float, among: int = 1) -> Wander | None:
    """Kind of the slow wander of (n,) values in mm, NaN in gaps; None where there is too little to
    tell. among: series of the recording, which share the level."""
    length = max(round(BLOCK_S * frame_rate_hz), -(-series.size // MOST_BLOCKS), 1)
    z = _means(series, length)
    if z.size < LEAST_BLOCKS or not np.ptp(z) > 0:
        return None
    z = z - np.median(z)
    best = _fits(z)
    least = min(value for value, _ in best.values())
    excluded = least + 2 * math.log(among / LEVEL)
    none = best[frozenset(), "white"][0] < excluded
    near = [key for key, (value, _) in best.items() if value < excluded]
    sure = frozenset.intersection(*(kinds for kinds, _ in near))
    _, shape = min(best.values(), key=lambda own: own[0])
    block_s = length / frame_rate_hz
    at = tuple(place * block_s for place in shape.at)
    if "cycle" in sure and z.size * block_s < PERIODS * at[-1]:
        sure -= {"cycle"}
    tenth, short = max(z.size // 10, 1), max(z.size // 50, 1)
    first, last = z[:tenth], z[-tenth:]
    medians = [np.median(z[k : k + short]) for k in range(0, z.size, short)]
    return Wander(
        tuple(kind for kind in KINDS if kind in sure),
        all(noise != "white" for _, noise in near),
        () if none else tuple(dict.fromkeys(k for kinds, _ in near for k in sorted(kinds))),
        float(last.mean() - first.mean()),
        math.sqrt(_mean_variance(first) + _mean_variance(last)),
        float(np.ptp(medians)),
        _size(z, shape),
        at,
    )


def _means(series: np.ndarray, length: int) -> Floats:
    """Means of blocks, those of gaps bridged by a line; nothing where half of them are gaps."""
    rows = series[: series.size // length * length].reshape(-1, length)
    known = np.isfinite(rows)
    count = known.sum(axis=1)
    with np.errstate(invalid="ignore"):
        means = np.where(known, rows, 0.0).sum(axis=1) / count
    there = np.flatnonzero(2 * count >= length)
    if 2 * there.size < count.size or there.size < 2:
        return np.empty(0)
    return np.interp(np.arange(count.size), there, means[there])


def _mean_variance(values: Floats) -> float:
    """Of the mean of values that are correlated, by means of eighths."""
    parts = np.array([part.mean() for part in np.array_split(values, min(8, values.size))])
    return float(parts.var(ddof=1) / parts.size) if parts.size > 1 else math.nan


def _size(z: Floats, shape: _Shape) -> float:
    """Of a fitted shape: greatest less least value, with the sign of its change."""
    if not len(shape.columns):
        return math.nan
    X = np.vstack([np.ones(z.size), shape.columns])
    solved, *_ = np.linalg.lstsq(X.T, z, rcond=None)
    if "cycle" in shape.kinds:
        return float(np.hypot(*solved[-2:]))
    of = len(shape.columns) if shape.kinds & {"accelerating"} else 1
    curve = solved[-of:] @ shape.columns[-of:]
    change = curve[-1] - curve[0]
    return float(np.ptp(curve) * np.sign(change if change else solved[-1]))


def _fits(z: Floats) -> dict[tuple[frozenset[str], str], tuple[float, _Shape]]:
    """Least BIC, and its shape, of every set of kinds and noise."""
    from scipy.fft import dst

    n = z.size - 1
    weight = 4 * np.sin(np.pi * np.arange(1, n + 1) / (2 * (n + 1))) ** 2
    y = dst(np.diff(z), type=1, norm="ortho")
    shapes = [one for shape in _shapes(z) for one in (shape, _on_line(shape, z.size)) if one]
    found: dict[tuple[frozenset[str], str], tuple[float, _Shape]] = {}
    transformed = [dst(np.diff(one.columns), type=1, norm="ortho", axis=1) for one in shapes]
    for noise, spectra in _noises(weight, n).items():
        start = _bic(y, np.zeros((0, n)), spectra, int(noise != "white"))
        for shape, columns in zip(shapes, transformed, strict=True):
            use = spectra if len(spectra) == 1 else spectra[_near(start[1], len(spectra))]
            p = len(columns) + shape.searched + (noise != "white")
            value = _bic(y, columns, use, p)[0] if len(columns) else start[0]
            key = shape.kinds, noise
            if key not in found or value < found[key][0]:
                found[key] = value, shape
    return found


def _near(at: int, size: int) -> slice:
    """Ratios below the best without a shape too: a shape leaves less to the noise."""
    return slice(0, min(at + 2, size))


def _noises(weight: Floats, n: int) -> Mapping[str, Floats]:
    """(m, n) spectra of differences, by noise."""
    walk = weight + RATIOS[:, None]
    flicker = weight + RATIOS[:, None] * np.sqrt(weight)
    slow = []
    for T_c in np.geomspace(1, n / 10, SHARES):  # in blocks
        a = math.exp(-1 / T_c)
        one = weight / ((1 - a) ** 2 + a * weight)
        slow += [weight + ratio * one for ratio in RATIOS[::2]]
    return {
        "white": weight[None],
        "random_walk": walk,
        "flicker": flicker,
        "correlated": np.array(slow),
    }


def _bic(y: Floats, X: Floats, spectra: Floats, p: int) -> tuple[float, int]:
    """The least over the spectra, and which."""
    n = y.size
    inverse = 1 / spectra
    rest = inverse @ (y * y)
    if len(X):
        A = (inverse @ (X[:, None] * X).reshape(-1, n).T).reshape(-1, len(X), len(X))
        b = inverse @ (X * y).T
        A[:, np.arange(len(X)), np.arange(len(X))] *= 1 + 1e-10
        rest = rest - (b * np.linalg.solve(A, b[..., None])[..., 0]).sum(axis=1)
    values = (
        np.log(spectra).sum(axis=1) + n * np.log(np.maximum(rest, 1e-300) / n) + p * math.log(n)
    )
    at = int(np.argmin(values))
    return float(values[at]), at


def _on_line(shape: _Shape, n: int) -> _Shape | None:
    if not shape.kinds or shape.kinds & {"drift"}:
        return None
    line = np.linspace(-0.5, 0.5, n)[None]
    both = np.vstack([line, shape.columns])
    return _Shape(shape.kinds | {"drift"}, both, shape.searched, shape.at)


def _shapes(z: Floats) -> Iterator[_Shape]:
    """The library; places in blocks. Of searched shapes those that fit best by least squares."""
    n = z.size
    t = np.linspace(-0.5, 0.5, n)
    yield _Shape(frozenset(), np.zeros((0, n)))
    yield _Shape(frozenset({"drift"}), t[None])
    yield _Shape(frozenset({"drift", "accelerating"}), np.array([t, t**2]))
    yield _Shape(frozenset({"drift", "accelerating"}), np.array([t, t**2, t**3]))
    for kind, curve in CURVES.items():
        for line in (False, True):
            constant = _refined(z, partial(curve, t + 0.5), CONSTANTS, line)
            yield _Shape(frozenset({kind}), curve(t + 0.5, constant)[None], 1)
    yield from _cycles(z)
    yield from _steps(z)
    yield from _recoveries(z)
    levels = _two_levels(z)
    if levels is not None:
        yield levels


def _refined(
    z: Floats, columns: Columns, grid: Floats, line: bool = True, beside: Floats | None = None
) -> float:
    """Place on a grid, and between its neighbours, where the columns leave least beside a constant,
    a straight line and further columns (p, n)."""
    from scipy.optimize import minimize_scalar

    fixed = np.vander(np.linspace(-0.5, 0.5, z.size), 2 if line else 1)
    basis, _ = np.linalg.qr(fixed if beside is None else np.hstack([fixed, beside.T]))
    own = z - basis @ (basis.T @ z)

    def rest(place: float) -> float:
        X = np.atleast_2d(columns(place))
        X = X - (X @ basis) @ basis.T
        b = X @ own
        return -float(b @ np.linalg.lstsq(X @ X.T, b, rcond=1e-9)[0])  # of the sum of squares

    best = int(np.argmin([rest(place) for place in grid]))
    bounds = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, grid.size - 1)])
    fine = {"xatol": 1e-4 * (bounds[1] - bounds[0])}
    return float(minimize_scalar(rest, bounds=bounds, method="bounded", options=fine).x)


def _cycles(z: Floats) -> Iterator[_Shape]:
    """Of 3/4 to n/8 cycles the best, alone and beside a warm-up."""
    from scipy.fft import rfft

    n = z.size
    time = np.arange(n) / n
    k = np.arange(n) / FINER  # places of the zero-padded transform
    among = (k >= 0.75) & (k < max(n / 8, 4))

    def wave(place: float) -> Floats:
        return np.array([np.sin(2 * np.pi * place * time), np.cos(2 * np.pi * place * time)])

    def near(own: Floats) -> Floats:
        power = np.abs(rfft(own, FINER * n)[:n]) ** 2
        best = int(np.argmax(np.where(among, power, 0.0)))
        return k[max(best - 1, 0) : best + 2]

    for own in (z - z.mean(), z - np.polyval(np.polyfit(time, z, 1), time)):
        place = _refined(z, wave, near(own))
        yield _Shape(frozenset({"cycle"}), wave(place), 1, (n / place,))
    fall = partial(CURVES["warm_up"], time)
    constant = _refined(z, fall, CONSTANTS)
    for _ in range(4):  # in turn, each beside the other
        X = np.array([np.ones(n), time, fall(constant)]).T
        rest = z - X @ np.linalg.lstsq(X, z, rcond=None)[0]
        place = _refined(z, wave, near(rest), beside=fall(constant)[None])
        constant = _refined(z, fall, CONSTANTS, beside=wave(place))
    both = np.vstack([fall(constant), wave(place)])
    yield _Shape(frozenset({"warm_up", "cycle"}), both, 2, (n / place,))


def _steps(z: Floats) -> Iterator[_Shape]:
    """Steps and temporary shifts (begin and end searched) by least squares, also of z less its
    trend; the best few of each."""
    n = z.size
    t = np.arange(n)
    for own in (z - z.mean(), z - np.polyval(np.polyfit(t, z, 1), t)):
        total = np.concatenate([[0.0], np.cumsum(own)])
        at = np.arange(2, n - 1)
        gain = total[at] ** 2 * (1 / at + 1 / (n - at))
        for best in at[np.argsort(gain)[-2:]]:
            yield _Shape(frozenset({"step"}), (t >= best).astype(float)[None], 1, (float(best),))
            for begun in (best - 1, best):  # a block that it comes within
                parts = np.array([t == begun, t > begun], float)
                yield _Shape(frozenset({"step"}), parts, 1, (float(begun),))
        edges = np.unique(np.linspace(1, n - 1, min(n - 1, 120)).astype(int))
        i, j = np.triu_indices(edges.size, 1)
        a, b = edges[i], edges[j]
        m = b - a
        gain = (total[b] - total[a]) ** 2 * (1 / m + 1 / np.maximum(n - m, 1))
        for best in np.argsort(gain)[-2:]:
            first, last = _edges(total, int(a[best]), int(b[best]), n, n // 120 + 1)
            inside = ((t >= first) & (t < last)).astype(float)
            yield _Shape(frozenset({"shift"}), inside[None], 2, (float(first), float(last)))


def _edges(total: Floats, a: int, b: int, n: int, reach: int) -> tuple[int, int]:
    i = np.arange(max(a - reach, 1), a + reach + 1)[:, None]
    j = np.arange(b - reach, min(b + reach, n - 1) + 1)[None]
    m = np.maximum(j - i, 1)
    gain = np.where(j > i, (total[j] - total[i]) ** 2 * (1 / m + 1 / np.maximum(n - m, 1)), 0.0)
    at = np.unravel_index(int(np.argmax(gain)), gain.shape)
    return int(i[at[0], 0]), int(j[0, at[1]])


def _recoveries(z: Floats) -> Iterator[_Shape]:
    """Shifts at once that fade, by matched filters of some time constants."""
    n = z.size
    t = np.arange(n)
    own = z - np.median(z)
    gains = []
    for constant in np.geomspace(3, n / 5, 10):
        decay = math.exp(-1 / constant)
        left = np.arange(n, 0, -1)
        energy = (1 - decay ** (2 * left)) / (1 - decay**2)
        passed, value = np.empty(n), 0.0
        for k in range(n - 1, -1, -1):
            value = own[k] + decay * value
            passed[k] = value
        best = int(np.argmax((passed**2 / energy)[1:])) + 1
        gains.append((float(np.max((passed**2 / energy)[1:])), best))
    start = max(gains)[1]
    for best in range(max(start - 1, 1), min(start + 2, n - 1)):

        def fading(constant: float, begin: int = best) -> Floats:
            return np.where(t >= begin, np.exp(-np.maximum(t - begin, 0) / constant), 0.0)[None]

        first = (t == best).astype(float)[None]  # a block that the shift begins within
        constant = _refined(z, fading, np.geomspace(1, n / 5, 16), line=False, beside=first)
        yield _Shape(
            frozenset({"shift"}),
            np.vstack([first, fading(constant)]),
            2,
            (best, best + 3 * constant),
        )


def _two_levels(z: Floats) -> _Shape | None:
    """By the most probable sequence of two levels (Viterbi). A switch counts as two parameters, as
    its place is searched among many."""
    n = z.size
    low, high = np.quantile(z, [0.1, 0.9])
    state = z > (low + high) / 2
    for _ in range(20):
        if not 0 < state.sum() < n:
            return None
        low, high = z[~state].mean(), z[state].mean()
        sigma = MAD_TO_SIGMA * float(np.median(np.abs(z - np.where(state, high, low)))) or 1e-12
        new = _viterbi(((z - low) / sigma) ** 2, ((z - high) / sigma) ** 2, 2 * math.log(n))
        if (new == state).all():
            break
        state = new
    switches = int(np.count_nonzero(np.diff(state)))
    if switches < SWITCHES:
        return None
    dwell = n / (switches + 1)
    return _Shape(frozenset({"two_levels"}), state.astype(float)[None], 2 * switches, (dwell,))


def _viterbi(cost_0: Floats, cost_1: Floats, price: float) -> np.ndarray:
    """States (n,) of least cost, with a price for each change."""
    n = cost_0.size
    back = np.zeros((n, 2), bool)
    a, b = cost_0[0], cost_1[0]
    for k in range(1, n):
        back[k] = b + price < a, a + price < b
        a, b = min(a, b + price) + cost_0[k], min(b, a + price) + cost_1[k]
    state = np.zeros(n, bool)
    state[-1] = b < a
    for k in range(n - 1, 0, -1):
        state[k - 1] = state[k] ^ back[k, int(state[k])]
    return state
