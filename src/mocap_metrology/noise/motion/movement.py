"""Does a marker move? Only what a still marker of that noise cannot do is called movement.

Noise as this project knows it (white, flicker, random walk, Gauss-Markov, their sums) has Gaussian
increments that are all alike, and has no velocity: successive increments of a random walk are
independent, those of all the others rather return, so the mean square of an increment over 2 T is
at most twice that over T. A marker that is pushed, carried or put elsewhere does what such noise
cannot, however far the noise wanders:

* a jump: means before and after differ by far more than those of all other moments, and of those
  near, by the median of their deviations, which a few jumps do not touch;
* it continues: increments over 2 T are larger than those of a random walk of the same T;
* it comes far: the range within the horizon is many times that of a random walk of the steps seen.

The bounds are for a random walk, whose increments stay alike for longest: walks of 100 to 14,400
blocks, 300 to 20,000 of each length, stayed below two thirds of each. A straight line and an
exponential approach are subtracted before the search for jumps: a drift or warm-up is none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.hampel import MAD_TO_SIGMA
from mocap_metrology.common.parallel import MapFunction, in_turn
from mocap_metrology.noise.series import AXES

LEAST_BLOCKS = 100
BLOCK_S = 0.25
LASTS_S, MOST_TRIED = 15.0, 10
NEAR = 8  # times SIDE, to each side, within which noise may be louder than elsewhere
SIDE, BETWEEN = 16, 4  # blocks before and after a jump that are compared, and left out between
JUMP_SIGMAS = 4.0  # of a frame: a smaller jump is none that a frame could show
CELL, SMALL_CELL = 5, 3  # frames of a median, so that isolated outliers are removed
FEW = 2000  # frames below which SMALL_CELL is used, so that enough increments remain
LEAST_CELLS = 50  # increments over T that a recording holds
GOES_ON = 5.0  # standard deviations that successive increments are correlated by
COMES_FAR = 6.5  # standard deviations of the walk over the horizon that its range spans
MOST_OF_IT = 1.5  # times a jump; a range up to that is of the jump
PART = 4  # what goes on does so by this part of the range that matters


@dataclass(frozen=True)
class Movement:
    """Movement of one coordinate: size_mm, 0 for what is still, NaN where it is unknown; lower_95
    and upper_95 of a jump, NaN of other movement; time_s: of a jump, else NaN."""

    size_mm: float
    lower_95: float = math.nan
    upper_95: float = math.nan
    time_s: float = math.nan

    @property
    def moves(self) -> bool:
        """Whether the marker moves."""
        return self.size_mm > 0


STILL, UNKNOWN = Movement(0.0), Movement(math.nan)


def movements(
    positions: Mapping[str, np.ndarray],
    frame_rate_hz: float,
    range_mm: float,
    horizon_s: float,
    step_mm: float = 0.0,
    over: MapFunction = in_turn,
) -> dict[str, dict[str, Movement]]:
    """Label -> axis -> `movement` of markers, label -> (3, n). over: how coordinates are worked
    on."""
    limits = frame_rate_hz, range_mm, horizon_s, step_mm
    every = (values for marker in positions.values() for values in marker)
    in_order = iter(over(lambda values: movement(values, *limits), every))
    return {label: {axis: next(in_order) for axis in AXES} for label in positions}


def most_moving(by_marker: Mapping[str, Mapping[str, Movement]]) -> dict[str, tuple[str, Movement]]:
    """The markers that move more than their noise can, each with the axis along which it moves most
    and the movement there. by_marker: label -> axis -> movement. The Allan variance takes every
    change for noise, so it supposes markers that do not move."""
    moving = {}
    for label, axes in by_marker.items():
        axis, most = max(axes.items(), key=lambda item: np.nan_to_num(item[1].size_mm))
        if most.moves:
            moving[label] = axis, most
    return moving


def all_keep_moving(by_marker: Mapping[str, Mapping[str, Movement]]) -> bool:
    """Whether every marker, label -> axis -> movement, moves other than by one jump with rest
    before and after it."""
    return all(
        any(one.moves and math.isnan(one.time_s) for one in axes.values())
        for axes in by_marker.values()
    )


def movement(
    series: np.ndarray,
    frame_rate_hz: float,
    range_mm: float,
    horizon_s: float,
    step_mm: float = 0.0,
) -> Movement:
    """What a coordinate does beyond noise within `horizon_s`.

    series: (n,) mm, NaN in gaps, outliers allowed. A jump counts from `JUMP_SIGMAS` standard
    deviations of a frame (of steps `step_mm` of the file, if those are larger); other movement
    from `range_mm` on. Blocks are of a quarter of a second, or of a hundredth of a recording of
    less than 25 s. UNKNOWN below 100 frames.
    """
    values = np.asarray(series, dtype=float)
    length = max(min(round(BLOCK_S * frame_rate_hz), values.size // LEAST_BLOCKS), 1)
    blocks, sigma = _blocks(values, length)
    if np.count_nonzero(np.isfinite(blocks)) < LEAST_BLOCKS / 2:
        return UNKNOWN
    block_s = length / frame_rate_hz
    within = max(round(horizon_s / block_s), LEAST_BLOCKS)
    least = JUMP_SIGMAS * math.hypot(sigma, step_mm if math.isfinite(step_mm) else 0.0)
    least = max(least, range_mm / 1000)  # of what has no noise at all
    jump = _jump(_straightened(blocks), block_s, within, least)
    span, farthest = _range(blocks, within)
    if span > range_mm and span > MOST_OF_IT * jump.size_mm:
        far = _comes_far(blocks[farthest], span)
        if far or _goes_on(values, range_mm / PART):
            return Movement(span)
    return jump


def _blocks(values: np.ndarray, length: int) -> tuple[np.ndarray, float]:
    """Means of the middle half of every block of `length` samples, NaN where less than half as many
    are there as is usual, and the median of the standard deviations within them by quartiles."""
    count = values.size // length
    rising = np.sort(values[: count * length].reshape(count, length), axis=1)
    rising[np.isinf(rising)] = np.nan
    known = np.isfinite(rising).sum(axis=1)
    low, high = known // 4, known - known // 4
    sums = np.concatenate([np.zeros((count, 1)), np.cumsum(np.nan_to_num(rising), axis=1)], axis=1)
    row = np.arange(count)
    enough = known >= max(np.median(known[known > 0]) / 2 if known.any() else 1, 1)
    with np.errstate(invalid="ignore", divide="ignore"):
        means = np.where(enough, (sums[row, high] - sums[row, low]) / (high - low), np.nan)
    if length < 8:  # too few for quartiles
        steps = np.abs(np.diff(values))
        middle = np.median(steps[np.isfinite(steps)]) if np.isfinite(steps).any() else math.nan
        return means, float(MAD_TO_SIGMA / math.sqrt(2) * middle)
    last = np.minimum(high, length - 1)
    spread = (rising[row, last] - rising[row, low])[enough] * MAD_TO_SIGMA / 2
    return means, float(np.median(spread)) if spread.size else math.nan


def _straightened(blocks: np.ndarray) -> np.ndarray:
    """Less the straight line and exponential approach that fit best (least squares, the time
    constant from two blocks to the whole, by steps of 15 %)."""
    known = np.isfinite(blocks)
    t = np.arange(blocks.size) / blocks.size
    coarse = max(blocks.size // 1000, 1)  # of nine hours a thousand are enough
    use = np.flatnonzero(known)[::coarse]

    def fitted(constant: float) -> tuple[float, float, np.ndarray]:
        shape = _approach(t[use], constant)
        solved, *_ = np.linalg.lstsq(shape, blocks[use], rcond=None)
        return float(np.sum((blocks[use] - shape @ solved) ** 2)), constant, solved

    steps = round(math.log(blocks.size / 2) / 0.15) + 2
    fits = map(fitted, np.geomspace(2 / blocks.size, 1.0, steps))
    _, constant, solved = min(fits, key=lambda one: one[0])
    return blocks - _approach(t, constant) @ solved


def _approach(t: np.ndarray, constant: float) -> np.ndarray:
    """(n, 3) columns of a straight line and an exponential at the times t (n,)."""
    return np.stack([np.ones(t.size), t, np.exp(-t / constant)], axis=1)


def _jump(blocks: np.ndarray, block_s: float, within: int, least: float) -> Movement:
    """The largest jump of at least `least` beyond chance, over blocks of 1, 2, 4, ..."""
    largest = STILL
    for level, doubling in _levels(blocks, within):
        middles = _sliding_medians(level)
        steps = middles[SIDE + BETWEEN :] - middles[: -(SIDE + BETWEEN)]
        known = np.isfinite(steps)
        if np.count_nonzero(known) < LEAST_BLOCKS / 2:
            continue
        steps = np.where(known, steps - np.median(steps[known]), 0.0)
        scale = MAD_TO_SIGMA * float(np.median(np.abs(steps[known])))
        # Of a walk of n blocks, in median deviations: of 10,000 of 100 the largest step reached 17,
        # of 300 9, of 4800 5.1
        times = 8.0 + 60.0 * (2 * SIDE + BETWEEN) / level.size
        every = steps.copy()
        lasting = max(round(LASTS_S / (doubling * block_s)), SIDE)
        for _ in range(MOST_TRIED):
            at = int(np.argmax(np.abs(steps)))
            size = float(abs(steps[at]))
            if size <= max(times * scale, least, largest.size_mm):
                break
            far = np.abs(np.arange(steps.size) - at)
            beside = every[known & (far > SIDE + BETWEEN) & (far < NEAR * SIDE)]
            beside = np.abs(beside - np.median(beside)) if beside.size else np.zeros(1)
            louder = MAD_TO_SIGMA * float(np.median(beside))
            start, end = at + SIDE, at + SIDE + BETWEEN
            before, after = level[max(start - lasting, 0) : start], level[end : end + lasting]
            left = np.sign(steps[at]) * (np.nanmedian(after) - np.nanmedian(before))
            if left > size / 2 and size > times * louder:  # a shake returns
                time = (at + SIDE + BETWEEN / 2) * doubling * block_s
                reach = 1.96 * max(scale, louder)
                largest = Movement(size, size - reach, size + reach, time)
                break
            steps[max(at - lasting, 0) : at + lasting + 1] = 0.0
    return largest


def _levels(blocks: np.ndarray, within: int) -> Iterator[tuple[np.ndarray, int]]:
    """Blocks of 1, 2, 4, ... together while there are enough and both sides lie within."""
    level, doubling = blocks, 1
    while level.size >= LEAST_BLOCKS and (2 * SIDE + BETWEEN) * doubling <= within:
        yield level, doubling
        pairs = level[: level.size // 2 * 2].reshape(-1, 2)
        level, doubling = pairs.mean(axis=1), 2 * doubling


def _sliding_medians(values: np.ndarray) -> np.ndarray:
    """Medians of SIDE successive values; NaN where less than half of them are known."""
    rising = np.sort(np.lib.stride_tricks.sliding_window_view(values, SIDE), axis=1)
    known = np.isfinite(rising).sum(axis=1)
    row, last = np.arange(known.size), np.maximum(known - 1, 0)
    middle = (rising[row, last // 2] + rising[row, (last + 1) // 2]) / 2
    return np.where(2 * known >= SIDE, middle, np.nan)


def _range(blocks: np.ndarray, within: int) -> tuple[float, slice]:
    """The greatest within so many blocks (stretches overlap by half), and where."""
    starts = range(0, max(blocks.size - within, 0) + 1, max(within // 2, 1))
    stretches = [slice(s, s + within) for s in starts]
    stretches += [slice(max(blocks.size - within, 0), blocks.size)]
    spans = [float(np.ptp(block[np.isfinite(block)])) if np.isfinite(block).any() else 0.0
             for block in (blocks[s] for s in stretches)]  # fmt: skip
    most = int(np.argmax(spans))
    return spans[most], stretches[most]


def _comes_far(blocks: np.ndarray, span: float) -> bool:
    """Whether the range is beyond that of a random walk with the increments over T = 1, 2, 4, ...
    blocks up to a sixteenth (the least of the variances they make of it counts)."""
    lags = 2 ** np.arange(int(math.log2(blocks.size / 16)) + 1)
    variances = []
    for lag in lags:
        steps = np.abs(blocks[lag:] - blocks[:-lag])
        steps = steps[np.isfinite(steps)]
        if steps.size:
            of_points = lag - 1 / 3  # of a walk: means of blocks differ by less than points
            variances.append((MAD_TO_SIGMA * np.median(steps)) ** 2 * blocks.size / of_points)
    return bool(variances) and span > COMES_FAR * math.sqrt(min(variances))


def _goes_on(values: np.ndarray, least: float) -> bool:
    """Whether increments over some T, of `least` or more, are followed by like ones.

    Of a random walk D(2T) = 2 D(T) (of means over a cell (2 T - 1/3) / (T - 1/3) times), and
    their ratio scatters by about sqrt(T/n); of uniform movement it is 4.
    """
    cell = CELL if values.size >= FEW else SMALL_CELL if values.size >= LEAST_BLOCKS * 3 else 1
    cells = values[: values.size // cell * cell].reshape(-1, cell)
    cells = np.sort(cells, axis=1)[:, cell // 2]  # NaN come last: of few samples it is NaN
    lag, before = 1, _mean_square(cells, 1)
    while cells.size >= LEAST_CELLS * lag:
        after = _mean_square(cells, 2 * lag)
        walk = (2 * lag - 1 / 3) / (lag - 1 / 3) if cell > 1 else 2.0
        if before > least**2 and after / before / walk - 1 > GOES_ON * math.sqrt(lag / cells.size):
            return True
        lag, before = 2 * lag, after
    return False


def _mean_square(values: np.ndarray, lag: int) -> float:
    steps = values[lag:] - values[:-lag]
    return float(np.mean(steps[np.isfinite(steps)] ** 2)) if np.isfinite(steps).any() else 0.0
