"""Shapes that slow wander may have: a small library, each fitted to block means."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import islice

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.noise.diagnosis.recoveries import (
    recoveries,
    recurring_levels,
    several_recoveries,
)
from mocap_metrology.noise.diagnosis.shape import PLACE, Shape, pace, refined_place, time_of

CONSTANTS = np.geomspace(0.005, 0.7, 20)  # of a warm-up, over the recording
POWERS = np.array([0.3, 0.4, 0.5, 0.6])  # of time; less is a logarithm, more a straight line
FINER = 8  # places a cycle of the search for one
SMOOTH, BESIDE = (4, 8, 16, 32, 48), 4  # cosines of any other slow curve; of one beside a cycle
MOST_STEPS, MOST_BENDS, MOST_BESIDE = 8, 10, 4
SIDE = 10  # blocks before and after a step, at least, that may have curves of their own
PHASES = np.arange(24) / 24  # of equal steps at equal times
SLOW = (0.3, 0.7, 1.5)  # constants of the slower of two approaches, over the recording
FINER_PAIRS = [width ** np.linspace(-1, 1, 11)[:, None] for width in (1.1, 1.02)]
TURNS = 1.05  # times the way of a curve that goes one way, its range is at most
HARMONICS, PERIODS = 3, 3.0  # of a cycle of another form; of one that is named
DAYS = np.geomspace(0.15, 0.75, 8)  # periods of a cycle that is longer than the recording
RAMPS, RAMP_WIDTHS = (4, 0.25), 8  # blocks, and share of the recording; widths between them

CURVES: dict[str, Callable[[Floats, float], Floats]] = {  # of time and constant over the recording
    "warm_up": lambda t, c: np.exp(-t / c),
    "accelerating": lambda t, c: np.exp((t - 1) / c),
    "creep": lambda t, c: np.log1p(15 * t / c),
    "power": lambda t, c: t**c,
    "stretched": lambda t, c: np.exp(-np.sqrt(t / c)),
    "hyperbolic": lambda t, c: 1 / (1 + t / c),
}
LAWLESS = frozenset({"warm_up", "smooth"})  # by no single constant
NAMELESS = "power", "stretched", "hyperbolic"  # laws that are `slowing` alone


def shapes(z: Floats, k: np.ndarray) -> Iterator[Shape]:
    """The library, of blocks with the numbers k (n,), some of which may be missing; places are
    among those that are there. Of searched shapes those that fit best by least squares."""
    n, t = z.size, time_of(k)
    since = t + 0.5 + 0.5 / n  # of the middle of a block; a root is steep in the first
    yield Shape(frozenset(), np.zeros((0, n)))
    yield Shape(frozenset({"drift"}), t[None])
    for powers in (np.array([t, t**2]), np.array([t, t**2, t**3])):
        yield _smooth(powers, z)
    yield _smooth(_wave(t, refined_place(z, t, partial(_wave, t), DAYS, False)), z, 1)
    for kind, curve in CURVES.items():
        kinds = {"slowing"} if kind in NAMELESS else {kind, "slowing"}
        kinds -= {"slowing"} if kind == "accelerating" else set()
        for line in (False,) if kind in NAMELESS else (False, True):  # that it is searched on
            among = POWERS if kind == "power" else CONSTANTS
            constant = refined_place(z, t, partial(curve, since), among, line)
            yield Shape(frozenset(kinds), curve(since, constant)[None], 1)
    yield from _two_approaches(z, t)
    yield from _curves_and_steps(z, t)
    yield from _cycles(z, k)
    yield from _steps(z, t)
    yield from _ramps(z, t)
    yield from recoveries(z, k)
    yield from several_recoveries(z, k)
    yield from recurring_levels(z, k)
    for count in SMOOTH:
        yield _smooth(np.vstack([t, t**2, t**3, _waves(count, t)]), z)  # free ends
    yield from _bends(z, t)
    yield from _several_steps(z, np.ones((1, n)), frozenset())
    yield from _several_steps(z, np.array([np.ones(n), t]), frozenset({"drift"}))


def _wave(t: Floats, place: float) -> Floats:
    """(2, n) of so many periods."""
    return np.array([np.sin(2 * np.pi * place * t), np.cos(2 * np.pi * place * t)])


def _waves(count: int, t: Floats) -> Floats:
    """(count, n) half cosines."""
    return np.asarray(np.cos(np.pi * np.arange(1, count + 1)[:, None] * (t + 0.5)))


def _smooth(columns: Floats, z: Floats, searched: int = 0) -> Shape:
    """Any smooth curve, with its pace."""
    shape = Shape(frozenset({"smooth"}), columns, searched)
    return replace(shape, kinds=shape.kinds | pace(shape.curve(shape.solved(z))))


def _two_approaches(z: Floats, t: Floats) -> Iterator[Shape]:
    """Beside a warm-up a slow one, which may look like a straight line, and the pair of any two
    that leaves least, alone and on a line."""
    fall = partial(CURVES["warm_up"], t + 0.5)

    def best(fast: Floats, slow: Floats, degree: int = 0) -> tuple[float, float]:
        """Constants of the pair of columns x, y of greatest gain beside powers of time: b' G^-1 b,
        G their products, b those with z."""
        basis, _ = np.linalg.qr(np.vander(t, degree + 1))
        x, y = (np.exp(-(t + 0.5) / one) for one in (fast, slow))
        x, y = (rows - rows @ basis @ basis.T for rows in (x, y))
        a, d, c = (x * x).sum(axis=1)[:, None], (y * y).sum(axis=1), x @ y.T
        b, e = (x @ z)[:, None], y @ z
        apart = a * d - c * c
        gain = (b * b * d - 2 * b * e * c + e * e * a) / np.maximum(apart, 1e-9 * a * d)
        i, j = np.unravel_index(np.argmax(np.where(2 * fast <= slow.T, gain, -1.0)), gain.shape)
        return float(fast[i, 0]), float(slow[j, 0])

    every = np.geomspace(CONSTANTS[0], SLOW[-1], 3 * CONSTANTS.size)[:, None]
    for among, line in (*((np.array([[one]]), 0) for one in SLOW), (every, 0), (every, 1)):
        pair = best(every, among, line)
        for width in FINER_PAIRS:
            pair = best(pair[0] * width, pair[1] * width if among is every else among, line)
        shape = Shape(LAWLESS, np.array([*[t] * line, *(fall(constant) for constant in pair)]), 2)
        solved = shape.solved(z)
        curve = shape.curve(solved)
        one_way = solved[-2:].prod() > 0 and np.ptp(curve) < TURNS * abs(curve[-1] - curve[0])
        yield replace(shape, kinds=LAWLESS | ({"slowing"} if one_way else set()))


def _curves_and_steps(z: Floats, t: Floats) -> Iterator[Shape]:
    """A curve and a step, in turn, each beside the other; and the curve beside several."""
    for kind in ("warm_up", "creep"):
        curve, step = partial(CURVES[kind], t + 0.5), None
        for _ in range(4):
            constant = refined_place(z, t, curve, CONSTANTS, False, step)
            beside = np.array([np.ones(z.size), curve(constant)])
            steps = _several_steps(z, beside, frozenset({kind}))
            stepped = next(steps)
            step = stepped.columns[-1:]
        yield replace(stepped, searched=1 + PLACE, line=0)
        for one in islice(steps, MOST_BESIDE - 1):
            constant = refined_place(z, t, curve, CONSTANTS, False, one.columns[1:])
            columns = np.vstack([curve(constant), one.columns[1:]])
            yield replace(one, columns=columns, searched=one.searched + 1)


def _cycles(z: Floats, k: np.ndarray) -> Iterator[Shape]:
    """The best cycle of 3/4 to n/8 periods, alone and beside a smooth curve or a warm-up."""
    from scipy.fft import rfft

    n, t = int(k[-1] - k[0]), time_of(k)
    places = np.arange(n) / FINER  # of the zero-padded transform
    among = (places >= 0.75) & (places < max(n / 8, 4))

    wave = partial(_wave, t)

    def near(values: Floats) -> Floats:
        every = np.interp(np.arange(n), k - k[0], values)
        power = np.abs(rfft(every, FINER * n)[:n]) ** 2
        best = int(np.argmax(np.where(among, power, 0.0)))
        return places[max(best - 1, 0) : best + 2]

    powers = np.vstack([t ** np.arange(1, 4)[:, None], _waves(BESIDE, t)])
    for beside in (powers[:0], powers[:1], powers[:2], powers[:3], powers):
        X = np.vstack([np.ones(z.size), beside]).T
        left = z - X @ np.linalg.lstsq(X, z, rcond=None)[0]
        place = refined_place(z, t, wave, near(left), beside=beside[1:])
        curve = beside if len(beside) > 1 else powers[:0]  # a line is put beside others, too
        kinds = {"cycle", "smooth"} if len(curve) else {"cycle"}
        for count in (1, HARMONICS) if place >= PERIODS else (1,):
            waves = np.vstack([curve, *(wave(place * j) for j in range(count, 0, -1))])
            shape = Shape(frozenset(kinds), waves, PLACE, (n / place,))
            straight = pace(shape.solved(z)[: len(curve)] @ curve) & {"drift"}
            yield replace(shape, kinds=shape.kinds | straight)
        if len(beside) == 1 and place >= PERIODS:  # the line and the cycle of even steps
            yield _stairs(z, t, place * np.linspace(0.97, 1.03, 13))
    fall = partial(CURVES["warm_up"], t + 0.5)
    constant = refined_place(z, t, fall, CONSTANTS)
    for _ in range(4):  # in turn, each beside the other
        X = np.array([np.ones(z.size), t, fall(constant)]).T
        rest = z - X @ np.linalg.lstsq(X, z, rcond=None)[0]
        place = refined_place(z, t, wave, near(rest), beside=fall(constant)[None])
        constant = refined_place(z, t, fall, CONSTANTS, beside=wave(place))
    both = np.vstack([fall(constant), wave(place)])
    yield Shape(frozenset({"warm_up", "cycle"}), both, 2, (n / place,))


def _stairs(z: Floats, t: Floats, among: Floats) -> Shape:
    """The best of equal steps at equal times, of these numbers in the recording. The mean over a
    block of the greatest integer below x is the difference of its integral, k x - k (k + 1) / 2
    with k = floor(x), over the ends of the block."""
    ends = np.array([t + 0.5, t + 0.5 + 1 / t.size])
    x = ends * among[:, None, None, None] + PHASES[:, None, None]  # (places, phases, 2, n)
    whole = np.floor(x)
    integral = whole * x - whole * (whole + 1) / 2
    stairs = np.diff(integral, axis=2)[:, :, 0].reshape(-1, t.size)
    stairs -= stairs.mean(axis=1, keepdims=True)
    gain = (stairs @ z) ** 2 / (stairs**2).sum(axis=1)
    kinds = frozenset({"drift", "steps"})  # of many small ones nothing tells it from a line
    return Shape(kinds, stairs[[int(np.argmax(gain))]], 1 + PLACE)


def _steps(z: Floats, time: Floats) -> Iterator[Shape]:
    """The best step and temporary shifts (begin and end searched) by least squares, also of z less
    its trend, and those of the largest differences, where noise wanders."""
    n = z.size
    t = np.arange(n)
    apart = np.maximum(t - t[:, None], 1)
    either = 1 / apart + 1 / (n - apart)  # of blocks inside and outside
    for left in (z - z.mean(), z - np.polyval(np.polyfit(time, z, 1), time)):
        total = np.concatenate([[0.0], np.cumsum(left)])
        at = np.arange(2, n - 1)
        gain = total[at] ** 2 * (1 / at + 1 / (n - at))
        for begun in (at[np.argmax(gain)], 2 + np.argmax(np.abs(np.diff(left)[1:-1]))):
            for parts in ([t >= begun], [t == begun - 1, t >= begun], [t == begun, t > begun]):
                columns = np.array(parts, float)  # two: of a block that it comes within
                shape = Shape(frozenset({"step"}), columns, PLACE, (float(begun),))
                first, *rest = shape.solved(z)
                if all(0 <= first * size <= size**2 for size in rest):  # else a spike
                    yield shape
            bends = ((1,), (1, 2)) if SIDE <= begun <= n - SIDE else ()
            for orders in bends:  # another line before than after, or another parabola
                powers = (time - time[begun]) ** np.array(orders)[:, None]
                bent = np.vstack([powers, powers * (t >= begun), t >= begun])
                shape = Shape(frozenset({"step", "smooth"}), bent, PLACE, (float(begun),))
                straight = pace(shape.solved(z)[:-1] @ bent[:-1]) & {"drift"}
                yield replace(shape, kinds=shape.kinds | straight)
        gain = np.triu((total[:n] - total[:n, None]) ** 2 * either, 1)
        best = np.unravel_index(int(np.argmax(gain[1:])), gain[1:].shape) + np.array([1, 0])
        over = left[2:] - left[:-2]
        for first, last in (best, 1 + np.sort([np.argmin(over), np.argmax(over)])):
            inside = ((t >= first) & (t < last)).astype(float)
            ends = [t == place for place in (first - 1, first, last - 1, last)]
            for columns in (inside[None], np.vstack([inside, *ends])):  # blocks that it ends within
                places = float(first), float(last)
                yield Shape(frozenset({"shift"}), columns, 2 * PLACE, places, -len(columns))


def _ramps(z: Floats, t: Floats) -> Iterator[Shape]:
    """Between two levels, alone and on a straight line: a step that takes its time. A ramp is the
    mean of the steps within it."""
    n, at = z.size, np.arange(z.size)
    for line in (np.zeros((0, n)), t[None]):
        rest = z - np.polyval(np.polyfit(t, z, len(line)), t)
        later = np.cumsum(rest[::-1])[::-1]  # what a step at a place has of it
        best: tuple[float, Floats] = -1.0, z
        for width in np.geomspace(RAMPS[0], n * RAMPS[1], RAMP_WIDTHS).astype(int).tolist():
            first = at[1 : n - width]
            middle = first + (width - 1) / 2
            size = np.convolve(later, np.full(width, 1 / width), "valid")[1:-1]
            gain = size**2 / (middle * (n - middle) / n - (width - 1 / width) / 6)
            ramp = np.clip((at - first[np.argmax(gain)] + 1) / width, 0, 1)
            best = max(best, (float(gain.max()), ramp), key=lambda one: one[0])
        yield _smooth(np.vstack([line, best[1]]), z, 2 * PLACE)


def _bends(z: Floats, t: Floats) -> Iterator[Shape]:
    """Straight lines that meet at some places, each searched beside those before it."""
    places, finer = np.linspace(-0.48, 0.48, 97), np.linspace(-0.01, 0.01, 21)
    columns = np.array([np.ones(t.size), t])
    for count in range(1, MOST_BENDS + 1):
        columns = np.vstack([columns, t])  # a place for the next
        again = range(2, count + 2) if count == MOST_BENDS else ()  # each beside all others
        for place in (count + 1, *again):
            basis, _ = np.linalg.qr(np.delete(columns, place, axis=0).T)
            best = 0.0
            for among in (places, finer):
                hinges = np.maximum(t - (best + among)[:, None], 0.0)
                bent = hinges - (hinges @ basis) @ basis.T
                gain = (bent @ z) ** 2 / np.maximum((bent**2).sum(axis=1), 1e-9)
                best, columns[place] = best + among[np.argmax(gain)], hinges[np.argmax(gain)]
        yield _smooth(columns[1:], z, count)


def _several_steps(z: Floats, beside: Floats, kinds: frozenset[str]) -> Iterator[Shape]:
    """Each where it leaves least beside those before it, and columns (p, n) of these kinds."""
    n, fixed = z.size, len(beside)
    columns, at = beside, np.arange(2, n - 1)
    for count in range(1, MOST_STEPS + 1):
        rest = z - columns.T @ np.linalg.lstsq(columns.T, z, rcond=None)[0]
        stairs = columns[fixed:].sum(axis=0) if count > 1 else np.zeros(n)
        ends = np.append(np.flatnonzero(np.diff(stairs)) + 1, n)
        total = np.cumsum(rest)[at - 1]  # within a part its residuals add up to zero
        part = np.searchsorted(ends, at, "right")
        first, last = np.append(0, ends)[part], ends[part]
        inside = (at > first) & (at < last)
        gain = np.where(inside, total**2, 0.0) * (
            1 / np.maximum(at - first, 1) + 1 / np.maximum(last - at, 1)
        )
        columns = np.vstack([columns, np.arange(n) >= at[int(np.argmax(gain))]])
        sizes = np.linalg.lstsq(columns.T, z, rcond=None)[0][fixed:]
        lasting = abs(sizes.sum()) > np.abs(sizes).sum() / 2
        places = tuple(sorted(float(np.argmax(row)) for row in columns[fixed:]))
        both = np.count_nonzero(np.diff(places) > 1) == 1  # others are within a block of one
        kind = "step" if lasting else "shift" if both else "steps"
        places = (places[0], places[-1]) if kind == "shift" else places
        begun = int(np.argmax(columns[fixed:].sum(axis=1)))
        main = (begun if kind == "shift" else int(np.argmax(np.abs(sizes)))) - count
        yield Shape(kinds | {kind}, columns[1:], PLACE * count, places, main, fixed - 1)
