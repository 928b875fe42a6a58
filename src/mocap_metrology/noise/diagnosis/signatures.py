"""What kind of slow wander is it? A kind is named only where the data exclude every other.

Block means z of a series (1000 at most) are explained by a shape (`shapes`) and a noise: white, or
with a walk, flicker, or a Gauss-Markov term of at most a tenth of the recording, or a walk and such
a term; with one of a quarter of a block, which is no slow wander; steeper ones, f^-2.5 and f^-3,
alone. Any other curve, of many cosines, bends or steps, is a shape, too, so that it is not taken
for noise. A shape must also be better than noise alone where the size of both noises may differ
between parts of the recording (`by_parts`).

Differences d of neighbouring block means have, for all these noises, a covariance that the discrete
sine transform makes diagonal, but for the ends of the recording: at f_k = k / 2 (n + 1) cycles a
block, the spectrum of a noise S(f) is lambda_k sum_j S(f_k + j) sinc^2(f_k + j), lambda_k =
4 sin^2(pi f_k), as averages over blocks fold it. So each hypothesis is a weighted least-squares fit
of few columns, and has

    BIC = sum ln S_k + n ln(rest / n) + p ln n,

with p parameters: columns, slow noises and time constants that were searched, and two for a place
in time. A kind is named where every hypothesis without it has a BIC that is greater by 2 ln(33) at
least, odds of 33 to 1 [Kass & Raftery 1995, J. Am. Stat. Assoc. 90, 773], and white noise alone one
by 2 ln(1000), as most series have no wander.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.types import Floats
from mocap_metrology.noise.diagnosis.block_means import (
    block_length,
    by_parts,
    likeliest_sums,
    mean_variance,
    means_of_blocks,
    spectra,
)
from mocap_metrology.noise.diagnosis.shape import AT_ONCE, LEVELS, Shape, on_line
from mocap_metrology.noise.diagnosis.shapes import LAWLESS, PERIODS, shapes
from mocap_metrology.noise.fit.estimates import Z_95

LEVEL, UNEVEN, NOTHING = 0.03, 0.01, 1e-3  # of what is excluded; among loud blocks; of white noise
USUAL = 7  # series of a recording
WALK = 1 / 3  # of every other noise, beside a random walk
LEAST_BLOCKS, OFTEN = 60, 0.05  # at least; share of loud ones from which others may be so, too
NEAR, LOUDER = 20, 1.5  # blocks from a change; times the variance elsewhere that counts there
MOST_FREE, SIZED = 30, 3.3  # blocks that are missing where it shifts; standard errors of size
SETTLES = 4  # blocks at the start, within which a step may be an approach of some seconds
SLOWEST = 30  # coefficients that show whether noise is bounded
WHITE, GAUSSIAN = 1.95, 8.0  # Kolmogorov's statistic; standard errors of the kurtosis
EXACT = 1e-9  # of the variance: a shape that leaves less leaves nothing
KINDS = (
    *("drift", "accelerating", "warm_up", "creep", "slowing"),
    *("cycle", "step", "shift", "two_levels", "levels"),
)
PARTS = {  # what a kind has in it, that is no kind of its own beside it
    "warm_up": {"slowing"},
    "creep": {"slowing", "drift"},
    "slowing": {"drift"},
    "accelerating": {"drift"},
    "two_levels": {"levels"},
}
NONE = math.nan, math.nan
FAST = ("white", "fast")  # noises that are none of slow wander
ADDED = {"white": 0, "sum": 2}  # parameters of a noise beside that of white noise; of others one
OTHER = {"smooth", "steps", "recoveries"}  # shapes of no kind; a line beside them is part of them
LASTING_S = 10.0  # of a shift; a shorter one is movement
NEAR_S = 5.0  # from an event to the step or shift that it is an end of


@dataclass(frozen=True)
class Wander:
    """Slow wander of a series.

    kinds: shapes that every possible explanation has; noise: the likeliest slow noise where every
    one has some, else empty; possible: shapes that are not excluded, none where
    white noise alone explains it; net_mm: level at the end less that at the start (means of a tenth
    of the recording), with its standard error; range_mm: of medians of a fiftieth; size_mm: of the
    shape that explains most, signed; at_s: its places, or its period or mean dwell; jumps: time in
    s and signed size in mm of every change at once; curve: (2, n) times in s and the positions
    of a shape that has some; moved_mm: of that shape, from start to end, without these changes;
    error_mm: standard error of the size of one step or shift; slope: of a straight line, mm/s, with
    its standard error; slowest: of slow noise (see `_slowest`); lost_s: that is missing where the
    first change at once is, from its time on.
    """

    kinds: tuple[str, ...]
    noise: str
    possible: tuple[str, ...]
    net_mm: float
    net_error_mm: float
    range_mm: float
    size_mm: float = math.nan
    at_s: tuple[float, ...] = ()
    jumps: tuple[tuple[float, float], ...] = ()
    curve: Floats | None = field(default=None, repr=False, compare=False)
    moved_mm: float = math.nan
    error_mm: float = math.nan
    slope: tuple[float, float] = NONE
    slowest: Floats | None = field(default=None, repr=False, compare=False)
    lost_s: float = 0.0

    @property
    def of(self) -> frozenset[str]:
        """Kinds, and what they have in them."""
        return frozenset(self.kinds).union(*(PARTS.get(kind, set()) for kind in self.kinds))

    @property
    def undecided(self) -> bool:
        """Whether there is wander whose kind is open."""
        return bool(self.possible) and not self.kinds and not self.noise

    def allows(self, kind: str) -> bool:
        """Whether a coefficient of the noise model of this kind may be named."""
        return kind == self.noise or kind in self.kinds

    def own(self, kind: str) -> bool:
        """Whether the size of a drift or a warm-up is of this curve, as the noise model does not
        have what is beside it."""
        return len(self.jumps) == 1 or self.kinds == (kind, "cycle")

    def beyond(self, step_mm: float) -> Wander:
        """Without what steps of a file may make of a straight line, or lines of nothing: shapes and
        ranges of less than a step."""
        larger = abs(self.size_mm) > step_mm
        kinds = tuple(kind for kind in self.kinds if larger or kind == "drift")
        least = step_mm if kinds or not self.kinds else 2 * step_mm
        possible = self.possible if self.range_mm > least else ()
        return replace(self, kinds=kinds, possible=possible, jumps=self.jumps if kinds else ())

    def size_of(self, kind: str) -> float:
        """Size of one kind of movement: for a line, or a curve beside a sudden change or a cycle,
        what is left of all movement, for others size_mm."""
        beside = kind == "drift" or self.jumps or "cycle" in self.kinds
        return self.moved_mm if beside and kind not in AT_ONCE | {"cycle"} else self.size_mm

    def without_jumps(self, series: np.ndarray, frame_rate_hz: float) -> np.ndarray:
        """Values (n,) without the shape that changes at once; NaN in the blocks of its changes."""
        if self.curve is None or not self.jumps:
            return series
        time = np.arange(series.size) / frame_rate_hz
        rest = series - np.interp(time, *self.curve)
        block_s = float(np.diff(self.curve[0]).min())
        for at, _ in self.jumps:
            after = self.curve[0][np.searchsorted(self.curve[0], at)] + block_s / 2
            rest[(at - block_s <= time) & (time <= after)] = np.nan
        return rest

    def jump_near(self, begin_s: float, end_s: float) -> tuple[float, float] | None:
        """The largest of `jumps` in begin_s to end_s or within `NEAR_S` of it."""
        near = [one for one in self.jumps if begin_s - NEAR_S <= one[0] <= end_s + NEAR_S]
        return max(near, key=lambda one: abs(one[1]), default=None)

    @property
    def ends_mm(self) -> tuple[float, float]:
        """95 % interval of |size_mm|; NaN where there is none."""
        return abs(self.size_mm) - Z_95 * self.error_mm, abs(self.size_mm) + Z_95 * self.error_mm

    @property
    def returns(self) -> bool:
        """Whether the second of two changes at once undoes the first, but for a fifth."""
        sizes = [size for _, size in self.jumps]
        return len(sizes) != 2 or abs(sum(sizes)) <= abs(sizes[0]) / 5

    @property
    def lasting_s(self) -> float:
        """Duration of a shift, from its begin to its end, s."""
        return self.at_s[1] - self.at_s[0] if "shift" in self.kinds else math.inf


def signature(series: np.ndarray, frame_rate_hz: float, n_series: int = 1) -> Wander | None:
    """Kind of the slow wander of (n,) values in mm, NaN in gaps; None where there is too little to
    tell. n_series: of the recording; many have the chances of two markers together."""
    from scipy.special import ndtri

    rarer = 2 * math.log(max(n_series / USUAL, 1.0))
    length = block_length(series.size, frame_rate_hz)
    z, k, loud = means_of_blocks(series, length)
    if z.size < LEAST_BLOCKS or not np.ptp(z) > 0:
        return None
    z = z - np.median(z)
    best, shape, fitted = _fits(z, k)
    white, gaussian, solved = fitted.white, fitted.gaussian, fitted.solved
    excluded = min(best.values()) - 2 * math.log(UNEVEN if loud > OFTEN else LEVEL) + rarer
    none = _may_be_noise(best, rarer)
    if not none and loud > OFTEN:  # normal scores, among which a few extreme values are not far off
        none = _may_be_noise(_fits(ndtri((z.argsort().argsort() + 1) / (z.size + 1)), k)[0], rarer)
    near = [key for key, value in best.items() if value < excluded]
    near += [(frozenset(), "white")] if none else []
    sure = frozenset.intersection(*(kinds for kinds, _ in near))
    alone = {key: v for key, v in best.items() if key[1] != "louder"}
    noises = {kind: v for (kinds, kind), v in alone.items() if kinds == sure & {"drift"}}
    noise = min(noises, key=lambda kind: noises[kind])
    slow = all(noise not in FAST for _, noise in near)
    slow = slow and any(kinds <= {"drift"} for kinds, _ in near)  # else it may be of a shape
    straight = any("drift" in kinds and not kinds & OTHER for kinds, _ in near)
    sure = sure - (set() if straight else {"drift"}) if white else frozenset()
    rival = min(value for other, value in noises.items() if other not in (noise, "sum"))
    sure_walk = noise != "random_walk" or rival > noises[noise] - 2 * math.log(WALK)
    noise = noise if slow and gaussian and sure_walk and not fitted.exact else ""
    block_s = length / frame_rate_hz
    begun = np.append(k[0], k[:-1] + 1)  # after missing blocks: where these begin
    lost = int(k[int(shape.at[0])] - begun[int(shape.at[0])]) if shape.placed and shape.at else 0
    at = tuple(block_s * (begun[int(a)] if shape.placed else a) for a in shape.at)
    short = "shift" in shape.kinds and at[1] - at[0] < LASTING_S
    sure -= {"shift"} if short else set()
    sure -= set() if gaussian else {"shift", "cycle"}  # as heavy tails, switches may be
    sure -= {"warm_up"} if shape.kinds >= LAWLESS else set()  # a constant is of one approach
    unsure = shape.separate and abs(shape.size(solved)) < SIZED * fitted.errors[shape.main]
    unsure |= shape.separate and any(k[a] - k[a - 1] > MOST_FREE + 1 for a in _places(shape))
    unsure |= shape.separate and bool((_places(shape) < SETTLES).any())  # fast approaches, too
    apart = np.diff(at) if "step" in shape.kinds else np.zeros(0)
    unsure |= bool(((apart > 1.5 * block_s) & (apart < LASTING_S)).any())  # or one is slow
    if unsure or (not gaussian and all(noise not in FAST for _, noise in near)):
        # What it consists of may be, if it adds up, and so may what is beside it.
        sure -= sure if all(kinds & AT_ONCE for kinds, _ in near) else AT_ONCE
    slope = shape.line and "drift" in shape.kinds
    span_s = (k[-1] - k[0]) * block_s
    if "cycle" in sure and span_s < PERIODS * at[-1]:
        sure, noise = sure - {"cycle", "drift"}, ""  # what is beside it may be of its form
    for named, part in PARTS.items():
        sure -= part if named in sure else set()
    jumps = shape.jumps(solved) if sure & AT_ONCE else []
    single = len(jumps) == len(at) == (2 if "shift" in sure else 1)
    possible = tuple(dict.fromkeys(k for kinds, _ in near for k in sorted(kinds)))
    possible = () if none else possible or (() if noise or not slow else ("noise",))
    tenth, few = max(z.size // 10, 1), max(z.size // 50, 1)
    first, last = z[:tenth], z[-tenth:]
    return Wander(
        tuple(kind for kind in KINDS if kind in sure),
        noise,
        possible,
        float(last.mean() - first.mean()),
        math.sqrt(mean_variance(first) + mean_variance(last)),
        float(np.ptp([np.median(z[at : at + few]) for at in range(0, z.size, few)])),
        shape.size(solved),
        at,
        tuple((float(begun[place]) * block_s, size) for place, size in jumps),
        np.array([(k + 0.5) * block_s, shape.curve(solved)]) if jumps else None,
        shape.moved(solved),
        float(fitted.errors[shape.main]) if single else math.nan,
        (float(solved[0]) / span_s, float(fitted.errors[0]) / span_s) if slope else NONE,
        _slowest(z) if slow and noise in ("", "random_walk") else None,
        lost * block_s,
    )


def _slowest(z: Floats) -> Floats:
    """(2, SLOWEST) slowest coefficients of differences of (n,) values, of variance 1 by the best
    walk in white noise, and the share of the walk in it."""
    from scipy.fft import dst

    y = dst(np.diff(z), type=1, norm="ortho")
    white, walks = spectra(y.size)["white"], spectra(y.size)["random_walk"]
    best = walks[np.argmin(_bic(y, y[:0, None], 1 / walks, np.log(walks).sum(axis=1)))]
    whitened = y / np.sqrt(best * np.mean(y**2 / best))
    return np.array([whitened, 1 - white[0] / best])[:, :SLOWEST]


def _fits(
    z: Floats, k: np.ndarray
) -> tuple[dict[tuple[frozenset[str], str], float], Shape, Fitted]:
    """Least BIC of every set of kinds and noise; the shape of the least of all, as it describes."""
    from scipy.fft import dst

    n = z.size - 1
    y = dst(np.diff(z), type=1, norm="ortho")
    likely = {}
    for noise, rows in spectra(n).items():  # a shape leaves less to the noise
        alone = _bic(y, np.zeros((0, n)), 1 / rows, np.log(rows).sum(axis=1))
        likely[noise] = rows[: int(np.argmin(alone)) + 2]
    likely |= {"sum": likeliest_sums(y), "steep": likely.pop("steep")}
    every = [one for shape in shapes(z, k) for one in (shape, on_line(shape, k)) if one]
    fits: dict[tuple[frozenset[str], str], float] = {}
    best, free = (math.inf, every[0], y[None], y), np.empty(0, int)
    sizes = [len(rows) for rows in likely.values()]
    stacked, ends = np.concatenate(list(likely.values())), np.cumsum(sizes)
    added = np.repeat([ADDED.get(noise, 1) for noise in likely], sizes)
    inverse, logs = 1 / stacked, np.log(stacked).sum(axis=1) + added * math.log(n)
    plain: list[tuple[frozenset[str], Floats, Floats]] = []  # of noise alone, or on a line
    for shape in every:
        columns = dst(np.diff(shape.columns), type=1, norm="ortho", axis=1)
        last = -1 if shape.kinds else None  # steep noise hides the misfit of any curve
        values = _bic(y, columns, inverse[: ends[-2]] if last else inverse, logs)
        values += (len(columns) + shape.searched) * math.log(n)
        for noise, end in list(zip(likely, ends, strict=True))[:last]:
            at = end - len(likely[noise]) + int(np.argmin(values[end - len(likely[noise]) : end]))
            value, key = float(values[at]), (shape.kinds, noise)
            best = min(best, (value, shape, columns, stacked[at]), key=lambda one: one[0])
            fits[key] = min(value, fits.get(key, math.inf))
            if len(columns) == len(shape.kinds) <= ("drift" in shape.kinds):
                plain.append((shape.kinds, columns, stacked[at]))
    least, shape, columns, spectrum = best
    if not shape.kinds <= {"drift"}:
        price = (len(columns) + shape.searched) * math.log(n)
        named = by_parts(y, columns, spectrum) + price
        for kinds, line, alone in plain:
            value = least - named + by_parts(y, line, alone) + (len(line) + 1) * math.log(n)
            fits[kinds, "louder"] = min(value, fits.get((kinds, "louder"), math.inf))
    if shape.whole.separate:
        shape = shape.whole
        blocks, rows, free = _at_changes(z, k, shape)
        y, columns = (dst(np.diff(values), type=1, norm="ortho") for values in (blocks, rows))
        noises = np.concatenate([*spectra(y.size).values()][:-1])
        logs = np.log(noises).sum(axis=1) + math.log(n) * (np.arange(len(noises)) > 0)
        spectrum = noises[np.argmin(_bic(y, columns, 1 / noises, logs))]
    fitted = _fitted(y, columns, spectrum, len(shape.columns), free)
    return fits, shape, fitted._replace(solved=shape.solved(z)) if shape.kinds & LEVELS else fitted


def _places(shape: Shape) -> np.ndarray:
    """Blocks in which it changes at once."""
    return np.array(shape.at[:1] if "fades" in shape.kinds else shape.at, int)


def _at_changes(z: Floats, k: np.ndarray, shape: Shape) -> tuple[Floats, Floats, np.ndarray]:
    """Blocks (n,), with those that are missing where a shape changes, its columns, with one for
    each block that says nothing of sizes (it is missing, or the change may come within it), and
    these blocks."""
    places = _places(shape)
    lost = np.minimum(k[places] - k[places - 1] - 1, MOST_FREE)
    at, beside = np.repeat(places, lost), places[lost == 0]
    free = np.insert(np.isin(np.arange(z.size), [beside - 1, beside]), at, True)
    columns = np.insert(shape.columns, at, shape.columns[:, at], axis=1)
    every = np.vstack([columns, np.eye(free.size)[free]])
    return np.insert(z, at, z[at]), every, np.flatnonzero(free)


class Fitted(NamedTuple):
    """A shape in a noise: coefficients of its own columns with their standard errors; whether what
    is left is white [cumulative periodogram, Bartlett 1955; 0.001], and also Gaussian."""

    solved: Floats
    errors: Floats
    white: bool
    gaussian: bool

    @property
    def exact(self) -> bool:
        """Whether nothing is left."""
        return self.errors.size > 0 and not self.errors.any()


def _fitted(y: Floats, X: Floats, spectrum: Floats, n_own: int, at: np.ndarray) -> Fitted:
    """at: blocks near which the noise counts, where it is louder than elsewhere."""
    from scipy.fft import dst

    root, n = np.sqrt(spectrum), y.size
    whole = y / root
    inverse = np.linalg.pinv((X / root).T)
    solved = inverse @ whole
    rest = whole - solved @ (X / root)
    if rest @ rest <= EXACT * (whole @ whole):
        return Fitted(solved[:n_own].astype(float), np.zeros(n_own), True, True)
    variances = (inverse**2).sum(axis=1) * float(rest @ rest) / (n - len(X))
    grown = np.cumsum(rest**2) / np.sum(rest**2)
    white = np.abs(grown - np.arange(1, n + 1) / n).max() * math.sqrt(n / 2) < WHITE
    values = dst(rest, type=1, norm="ortho")
    excess = (np.mean(values**4) / np.mean(values**2) ** 2 - 3) * math.sqrt(n / 24)
    known = np.delete(np.arange(n), at[at < n])
    near = np.abs(known[:, None] - at).min(axis=1, initial=n) < NEAR
    louder = np.mean(values[known[near]] ** 2) / np.mean(values**2) if near.any() else 1.0
    errors = np.sqrt(variances * (louder if louder > LOUDER else 1.0))[:n_own]
    values = solved[:n_own].astype(float)
    return Fitted(values, errors, bool(white), bool(white and excess < GAUSSIAN))


def _may_be_noise(best: Mapping[tuple[frozenset[str], str], float], rarer: float) -> bool:
    """Whether noise that is none of slow wander may be all."""
    fast = min(best[frozenset(), noise] for noise in FAST)
    return fast < min(best.values()) - 2 * math.log(NOTHING) + rarer


def _bic(y: Floats, X: Floats, inverse: Floats, logs: Floats) -> Floats:
    """(m,) of spectra, of which the inverse (m, n) and the sum of logarithms (m,) are given, less
    the price of the parameters."""
    rest = inverse @ (y * y)
    least = EXACT * rest
    if len(X):
        row, column = np.triu_indices(len(X))
        A = np.empty((len(inverse), len(X), len(X)))
        A[:, row, column] = A[:, column, row] = inverse @ (X[row] * X[column]).T
        b = inverse @ (X * y).T
        diagonal = A[:, np.arange(len(X)), np.arange(len(X))]  # of columns alike, or none
        A[:, np.arange(len(X)), np.arange(len(X))] = diagonal * (1 + 1e-10) + 1e-300
        rest = rest - (b * np.linalg.solve(A, b[..., None])[..., 0]).sum(axis=1)
    return logs[: len(inverse)] + y.size * np.log(np.maximum(rest, least + 1e-300) / y.size)
