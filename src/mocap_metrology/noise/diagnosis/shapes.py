"""Shapes that slow wander may have: a small library, each fitted to block means."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.types import Floats

CONSTANTS = np.geomspace(0.02, 0.7, 16)  # of a warm-up, over the recording
FINER = 8  # places a cycle of the search for one
PLACE = 2  # parameters of a place in time, as it is searched among many
SMOOTH, MOST_STEPS = (4, 8, 16, 32, 48), 8  # cosines of any other slow curve; steps
SWITCHES = 4  # of two levels, at least

Columns = Callable[[float], Floats]
CURVES: dict[str, Callable[[Floats, float], Floats]] = {  # of time and constant over the recording
    "warm_up": lambda t, c: np.exp(-t / c),
    "accelerating": lambda t, c: np.exp((t - 1) / c),
    "creep": lambda t, c: np.log1p(15 * t / c),
}


@dataclass(frozen=True)
class Shape:
    """A column (n,) of level over blocks, its kinds, and how many parameters it cost."""

    kinds: frozenset[str]
    columns: Floats  # (p, n)
    searched: int = 0
    at: tuple[float, ...] = ()


def on_line(shape: Shape, n: int) -> Shape | None:
    if not shape.kinds or shape.kinds & {"drift", "smooth"}:
        return None
    line = np.linspace(-0.5, 0.5, n)[None]
    both = np.vstack([line, shape.columns])
    return Shape(shape.kinds | {"drift"}, both, shape.searched, shape.at)


def shapes(z: Floats) -> Iterator[Shape]:
    """The library; places in blocks. Of searched shapes those that fit best by least squares."""
    n = z.size
    t = np.linspace(-0.5, 0.5, n)
    yield Shape(frozenset(), np.zeros((0, n)))
    yield Shape(frozenset({"drift"}), t[None])
    yield Shape(frozenset({"drift", "accelerating"}), np.array([t, t**2]))
    yield Shape(frozenset({"drift", "accelerating"}), np.array([t, t**2, t**3]))
    for kind, curve in CURVES.items():
        for line in (False, True):
            constant = _refined(z, partial(curve, t + 0.5), CONSTANTS, line)
            yield Shape(frozenset({kind}), curve(t + 0.5, constant)[None], 1)
    yield from _cycles(z)
    yield from _steps(z)
    yield from _recoveries(z)
    levels = _two_levels(z)
    if levels is not None:
        yield levels
    for count in SMOOTH:
        waves = np.cos(np.pi * np.arange(1, count + 1)[:, None] * (t + 0.5))
        yield Shape(frozenset({"smooth"}), np.vstack([t, t**2, t**3, waves]))  # free ends
    yield from _bends(z)
    yield from _several_steps(z, np.ones((1, n)), frozenset())
    yield from _several_steps(z, np.array([np.ones(n), t]), frozenset({"drift"}))


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


def _cycles(z: Floats) -> Iterator[Shape]:
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
        yield Shape(frozenset({"cycle"}), wave(place), 1, (n / place,))
    fall = partial(CURVES["warm_up"], time)
    constant = _refined(z, fall, CONSTANTS)
    for _ in range(4):  # in turn, each beside the other
        X = np.array([np.ones(n), time, fall(constant)]).T
        rest = z - X @ np.linalg.lstsq(X, z, rcond=None)[0]
        place = _refined(z, wave, near(rest), beside=fall(constant)[None])
        constant = _refined(z, fall, CONSTANTS, beside=wave(place))
    both = np.vstack([fall(constant), wave(place)])
    yield Shape(frozenset({"warm_up", "cycle"}), both, 2, (n / place,))


def _steps(z: Floats) -> Iterator[Shape]:
    """Steps and temporary shifts (begin and end searched) by least squares, also of z less its
    trend; the best few of each."""
    n = z.size
    t = np.arange(n)
    for own in (z - z.mean(), z - np.polyval(np.polyfit(t, z, 1), t)):
        total = np.concatenate([[0.0], np.cumsum(own)])
        at = np.arange(2, n - 1)
        gain = total[at] ** 2 * (1 / at + 1 / (n - at))
        for best in at[np.argsort(gain)[-2:]]:
            yield Shape(frozenset({"step"}), (t >= best).astype(float)[None], PLACE, (float(best),))
            for begun in (best - 1, best):  # a block that it comes within
                parts = np.array([t == begun, t > begun], float)
                yield Shape(frozenset({"step"}), parts, PLACE, (float(begun),))
        edges = np.unique(np.linspace(1, n - 1, min(n - 1, 120)).astype(int))
        i, j = np.triu_indices(edges.size, 1)
        a, b = edges[i], edges[j]
        m = b - a
        gain = (total[b] - total[a]) ** 2 * (1 / m + 1 / np.maximum(n - m, 1))
        for best in np.argsort(gain)[-2:]:
            first, last = _edges(total, int(a[best]), int(b[best]), n, n // 120 + 1)
            inside = ((t >= first) & (t < last)).astype(float)
            ends = [t == place for place in (first - 1, first, last - 1, last)]
            for columns in (inside[None], np.vstack([inside, *ends])):  # blocks that it ends within
                at_s = float(first), float(last)
                yield Shape(frozenset({"shift"}), columns, 2 * PLACE, at_s)


def _bends(z: Floats) -> Iterator[Shape]:
    """Straight lines that meet at one to three places, each searched beside those before it."""
    n = z.size
    t = np.linspace(-0.5, 0.5, n)
    columns, places = np.array([np.ones(n), t]), np.linspace(-0.48, 0.48, 97)
    hinges = np.maximum(t - places[:, None], 0.0)
    for _ in range(3):
        basis, _ = np.linalg.qr(columns.T)
        own = hinges - (hinges @ basis) @ basis.T
        gain = (own @ z) ** 2 / np.maximum((own**2).sum(axis=1), 1e-9)
        columns = np.vstack([columns, hinges[int(np.argmax(gain))]])
        yield Shape(frozenset({"smooth"}), columns[1:], len(columns) - 2)


def _several_steps(z: Floats, beside: Floats, kinds: frozenset[str]) -> Iterator[Shape]:
    """Each where it leaves least beside those before it, and columns (p, n) of these kinds."""
    n, fixed = z.size, len(beside)
    at = np.arange(2, n - 1)
    columns = beside
    for count in range(1, MOST_STEPS + 1):
        own = z - columns.T @ np.linalg.lstsq(columns.T, z, rcond=None)[0]
        stairs = columns[fixed:].sum(axis=0) if count > 1 else np.zeros(n)
        ends = np.append(np.flatnonzero(np.diff(stairs)) + 1, n)
        total = np.cumsum(own)[at - 1]  # within a part its residuals add up to zero
        part = np.searchsorted(ends, at, "right")
        first, last = np.append(0, ends)[part], ends[part]
        inside = (at > first) & (at < last)
        gain = np.where(inside, total**2, 0.0) * (
            1 / np.maximum(at - first, 1) + 1 / np.maximum(last - at, 1)
        )
        columns = np.vstack([columns, np.arange(n) >= at[int(np.argmax(gain))]])
        sizes = np.linalg.lstsq(columns.T, z, rcond=None)[0][fixed:]
        lasting = abs(sizes.sum()) > np.abs(sizes).sum() / 2
        kind = "step" if lasting else "shift" if count == 2 else "steps"
        if count > 1:
            yield Shape(kinds | {kind}, columns[1:], PLACE * count)


def _edges(total: Floats, a: int, b: int, n: int, reach: int) -> tuple[int, int]:
    i = np.arange(max(a - reach, 1), a + reach + 1)[:, None]
    j = np.arange(b - reach, min(b + reach, n - 1) + 1)[None]
    m = np.maximum(j - i, 1)
    gain = np.where(j > i, (total[j] - total[i]) ** 2 * (1 / m + 1 / np.maximum(n - m, 1)), 0.0)
    at = np.unravel_index(int(np.argmax(gain)), gain.shape)
    return int(i[at[0], 0]), int(j[0, at[1]])


def _recoveries(z: Floats) -> Iterator[Shape]:
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
        yield Shape(
            frozenset({"shift"}),
            np.vstack([first, fading(constant)]),
            PLACE + 1,
            (best, best + 3 * constant),
        )


def _two_levels(z: Floats) -> Shape | None:
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
    return Shape(frozenset({"two_levels"}), state.astype(float)[None], 2 * switches, (dwell,))


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
