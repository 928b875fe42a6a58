"""Shapes of slow wander that return: shifts and steps that fade, levels that recur."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.types import Floats
from mocap_metrology.noise.diagnosis.shape import PLACE, Shape, refined_place, time_of

FADINGS, MOST_FADING = 5, 16  # time constants of shifts that fade alike; such shifts, at most
SWITCHES, MOST_LEVELS = 4, 4  # of levels that recur, at least; levels, at most
DWELL = 3.0  # blocks, of each level
BROKEN = 0.5  # of the stays at a level, at most, that have a gap within: else it is of flanks
LASTING, AT_ONCE = 0.2, 0.8  # of what fades, that is left for good; of that, which comes at once
LEAST_SEEN = 0.5  # of the blocks in which it fades, but the first: else its size is not known
SPIKE = 1.5  # times what fades, in the block where it begins: more is of that block alone


def recoveries(z: Floats, k: np.ndarray) -> Iterator[Shape]:
    """Shifts at once that fade, wholly or in part."""
    n, t = z.size, np.arange(z.size)
    centred = z - np.median(z)
    gains = [_fading_at(centred, constant) for constant in np.geomspace(3, n / 5, 10)]
    start, jump = max(gains)[1], int(np.argmax(np.abs(np.diff(z))))
    among = {start - 1, start, start + 1, jump, jump + 1} & set(range(1, n - 1))
    for best in sorted(among):

        def fading(constant: float, begin: int = best) -> Floats:
            return np.where(t >= begin, np.exp(-np.maximum(k - k[begin], 0) / constant), 0.0)[None]

        first = (t == best).astype(float)[None]  # a block that the shift begins within
        grid = np.geomspace(1, n / 5, 16)
        for kind, beside in (("shift", first), ("step", np.vstack([t >= best, first]))):
            constant = refined_place(z, time_of(k), fading, grid, line=False, beside=beside)
            places = (float(best), min(best + 3 * constant, n - 1.0))[: 3 - len(beside)]
            columns, main = np.vstack([beside, fading(constant)]), -1 if kind == "shift" else -3
            shape = Shape(frozenset({kind, "fades"}), columns, PLACE + 1, places, main)
            lasting, *_, faded = shape.solved(z)
            seen = np.count_nonzero((k > k[best]) & (k < k[best] + 3 * constant))
            if seen < LEAST_SEEN * 3 * constant or (
                kind == "step" and (lasting + faded) / lasting < AT_ONCE
            ):
                shape = replace(shape, kinds=frozenset({"recoveries"}), at=())
            spike = kind == "shift" and abs(lasting + faded) > SPIKE * abs(faded)
            if not spike and (kind == "shift" or abs(lasting) > LASTING * abs(faded)):
                yield shape


def _fading_at(z: Floats, constant: float) -> tuple[float, int]:
    """What an exponential that begins at once takes of the squares of (n,) values, at most, and at
    which block: a matched filter."""
    from scipy.signal import lfilter

    decay = math.exp(-1 / constant)
    energy = (1 - decay ** (2 * np.arange(z.size, 0, -1))) / (1 - decay**2)
    gain = lfilter([1], [1, -decay], z[::-1])[::-1] ** 2 / energy
    return float(np.max(gain[1:])), int(np.argmax(gain[1:])) + 1


def several_recoveries(z: Floats, k: np.ndarray) -> Iterator[Shape]:
    """Some shifts that fade alike, wholly or in part, each where it leaves least beside those that
    came before."""
    n = z.size
    for constant, parts in product(np.geomspace(1, n / 10, FADINGS), (1, 2)):
        columns, fits = np.ones((1, n)), []
        for count in range(MOST_FADING // parts + 1):
            rest = z - columns.T @ np.linalg.lstsq(columns.T, z, rcond=None)[0]
            fits.append(n * math.log(float(rest @ rest)) + (parts + PLACE) * count * math.log(n))
            since = k - k[_fading_at(rest, constant)[1]]
            fading = np.exp(-np.maximum(since, 0) / constant) * (since >= 0)
            columns = np.vstack([columns, *(fading, since >= 0)[:parts]])
        if (best := int(np.argmin(fits))) > 1:  # one is a shift
            shape = columns[1 : parts * best + 1]
            yield Shape(frozenset({"recoveries"}), shape, 1 + PLACE * best)


def recurring_levels(z: Floats, numbers: np.ndarray) -> Iterator[Shape]:
    """Two levels, and more where two are switched between, each by the most probable sequence
    (Viterbi). A switch counts as two parameters, as its place is searched among many, and as the
    choice among the other levels. A rival slides between its switches."""
    n = z.size
    for count in range(2, MOST_LEVELS + 1):
        levels = np.quantile(z, np.linspace(0.1, 0.9, count))
        state = np.argmin(np.abs(z - levels[:, None]), axis=0)
        for _ in range(20):
            if np.unique(state).size < count:
                return
            levels = np.array([z[state == k].mean() for k in range(count)])
            sigma = MAD_TO_SIGMA * float(np.median(np.abs(z - levels[state]))) or 1e-12
            new = _viterbi(((z - levels[:, None]) / sigma) ** 2, 2 * math.log(n))
            if (new == state).all():
                break
            state = new
        changes = np.flatnonzero(np.diff(state, prepend=-1))
        switches = changes.size - 1
        each = np.bincount(state) / np.maximum(np.bincount(state[changes], minlength=count), 1)
        if switches < SWITCHES or np.unique(state).size < count:
            return
        if each.min() < DWELL:  # blocks on the way from one level to another, or loud ones
            return
        dwell = (numbers[-1] - numbers[0] + 1) / (switches + 1)
        kinds = {"levels"} | ({"two_levels"} if count == 2 else set())
        inside = np.diff(numbers, prepend=numbers[0]) > 1  # blocks are missing before it
        inside[changes] = False
        broken = np.add.reduceat(inside, changes) > 0
        if any(np.mean(broken[state[changes] == level]) > BROKEN for level in range(count)):
            kinds = {"steps"}
        columns = (state == np.arange(1, count)[:, None]).astype(float)
        searched = switches * (PLACE + 2 * math.log(count - 1) / math.log(n))
        yield Shape(frozenset(kinds), columns, searched, (dwell,))
        since = np.arange(n) - np.repeat(changes, np.diff(changes, append=n))
        yield Shape(frozenset({"steps"}), np.vstack([columns, since / n]), searched + PLACE)


@njit
def _viterbi(costs: Floats, price: float) -> np.ndarray:
    """States (n,) of least cost, of costs (k, n), with a price for each change."""
    total = costs[:, 0].copy()
    before = np.empty(costs.shape, np.int64)
    for place in range(1, costs.shape[1]):
        best = np.argmin(total)
        moved = total[best] + price
        for k in range(total.size):
            before[k, place] = best if moved < total[k] else k
            total[k] = min(total[k], moved) + costs[k, place]
    state = np.empty(costs.shape[1], np.int64)
    state[-1] = np.argmin(total)
    for place in range(state.size - 1, 0, -1):
        state[place - 1] = before[state[place], place]
    return state


def warm_up() -> None:
    """Compile for float64."""
    _viterbi(np.zeros((2, 3)), 1.0)
