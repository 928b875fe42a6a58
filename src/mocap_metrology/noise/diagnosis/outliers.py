"""Frames that are off: isolated ones, the business of the Hampel filter and not events, and tails
heavier than those of Gaussian noise.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.hampel import MAD_TO_SIGMA, own_step
from mocap_metrology.common.large import LazyArrays, kept_if_small
from mocap_metrology.common.parallel import MapFunction, in_turn

BLOCK = 1000  # differences whose kurtosis is computed at once, so no change of level makes any
FEWEST_BLOCKS = 8  # blocks
CHANCE = 0.005  # that heavy tails are reported for any series of a Gaussian recording
LEAST_EXCESS = 0.2  # excess that is reported
LONGEST_FRAMES = 2  # frames; what is off for longer is an event
NEAR_FRAMES = 2  # frames between markers that were struck by the same thing
DRAWN_IN_SCALES = 3.0  # scales that a frame may be off the median of the five round it
MANY_BEYOND = 0.1  # share of the frames; of Gaussian noise 0.03
TOGETHER_FRAMES = (1, 3, 9)  # frames
ALONE_EXPECTED = 1e-3  # number of times that so many are off among them by chance in a recording
LOUDER = 1.15  # than the usual scale; that of a block varies by 4 %
SAMPLED = 1 << 18  # values of a scale
FEWEST = 30  # values of a scale that is known
MANY_OUTLIERS = 1e-3  # share of the frames from which a reader is warned


@dataclass(frozen=True)
class Tails:
    """Excess kurtosis of the differences of frames of a series, with its 95 % interval."""

    series: str
    excess: float
    lower: float
    upper: float


def heavy_tails(
    series: Mapping[str, np.ndarray], step_mm: float, over: MapFunction = in_turn
) -> list[Tails]:
    """The series (n,) in mm, NaN in gaps, whose tails are surely heavier than those of a Gaussian.
    over: how the series are shared among threads."""
    chance = CHANCE / max(len(series), 1)
    tails = over(lambda one: _tails(*one, step_mm, chance), series.items())
    return [one for one in tails if one]


def _tails(name: str, series: np.ndarray, step: float, chance: float) -> Tails | None:
    """m_4 / m_2^2 - 3 + 6/n of blocks [unbiased for Gaussian noise to 1/n], and Student's t of
    their mean. Frames that repeat the one before have no information, steps as large as the noise
    little."""
    from scipy.special import stdtrit

    d = np.diff(series.astype(np.float64))
    d = d[np.isfinite(d)]
    size = float(d.std()) if d.size else 0.0
    if size > 10 * step:
        d = d[d != 0]
    if d.size < FEWEST_BLOCKS * BLOCK or size < step or not size > 0:
        return None
    rows = d[: d.size // BLOCK * BLOCK].reshape(-1, BLOCK)
    squares = (rows - rows.mean(axis=1, keepdims=True)) ** 2
    power = squares.mean(axis=1)
    squares = squares[power > 0]
    if len(squares) < FEWEST_BLOCKS:
        return None
    excess = (squares**2).mean(axis=1) / squares.mean(axis=1) ** 2 - 3 + 6 / BLOCK
    mean, error = float(excess.mean()), float(excess.std(ddof=1) / math.sqrt(excess.size))
    if mean < LEAST_EXCESS or mean < -float(stdtrit(excess.size - 1, chance)) * error:
        return None
    reach = float(stdtrit(excess.size - 1, 0.975)) * error
    return Tails(name, mean, mean - reach, mean + reach)


def mad_spread(values: np.ndarray) -> float:
    """1.4826 MAD of (n,) values, of every k-th of long ones; NaN left out."""
    known = values[:: max(values.size // SAMPLED, 1)]
    known = known[np.isfinite(known)]
    return MAD_TO_SIGMA * float(np.median(np.abs(known - np.median(known)))) if known.size else 0.0


def off_frames(series: np.ndarray, n_sigma: float, resolution: float = 0.0) -> np.ndarray:
    """Frames of (n,) that are farther than n_sigma scales from the median of the five round them;
    the scale is that of all these distances, or of steps from frame to frame over sqrt(2) if that
    is more (smoothed tracks lie on their medians; of a fine file without steps of 0, which repeated
    frames have), half a step of the values at least; as many times that as the distances of `BLOCK`
    frames are louder, there or beside."""
    from scipy.ndimage import median_filter

    distance, changes = series - median_filter(series, 5), np.diff(series)
    if np.isfinite(distance).sum() < FEWEST:
        return np.empty(0, int)
    usual, step = mad_spread(distance), max(resolution, own_step(series))
    if usual > 10 * step:
        changes = changes[changes != 0]
    scale = max(usual, mad_spread(changes) / np.sqrt(2), step / 2)
    with np.errstate(invalid="ignore"):
        off = np.flatnonzero(np.abs(distance) > n_sigma * scale) if scale > 0 else np.empty(0, int)
    blocks = np.add.outer(off // BLOCK, (-1, 0, 1)).clip(0, max(series.size // BLOCK - 1, 0))
    level = {k: mad_spread(distance[k * BLOCK : (k + 1) * BLOCK]) for k in np.unique(blocks)}
    louder = np.array([max(level[k] for k in near) for near in blocks]) / (usual or math.inf)
    return off[np.abs(distance[off]) > n_sigma * scale * np.where(louder > LOUDER, louder, 1.0)]


def isolated_frames(
    off: Mapping[str, np.ndarray], markers: Mapping[str, int]
) -> dict[str, np.ndarray]:
    """Those of the `off_frames` of every coordinate that are spikes: one or two frames long while
    no other marker was off within two frames.

    off: coordinate -> frames, ascending; markers: coordinate -> number of its marker.
    """
    by_series = {}
    for name, frames in off.items():
        others = [off[k] for k in off if markers[k] != markers[name]]
        elsewhere = np.unique(np.concatenate(others)) if others else np.empty(0, int)
        groups = np.split(frames, np.flatnonzero(np.diff(frames) > 1) + 1)
        alone = [g for g in groups if 0 < g.size <= LONGEST_FRAMES and not _near(g, elsewhere)]
        by_series[name] = np.concatenate(alone) if alone else np.empty(0, int)
    return by_series


def _near(group: np.ndarray, frames: np.ndarray) -> bool:
    first, last = np.searchsorted(frames, (group[0] - NEAR_FRAMES, group[-1] + NEAR_FRAMES + 1))
    return bool(last > first)


def without(series: np.ndarray, frames: np.ndarray) -> np.ndarray:
    """The series with straight lines over these frames; gaps stay."""
    if not frames.size:
        return series
    out = series.copy()
    out[frames] = np.nan
    near = np.unique(np.add.outer(frames, np.arange(-4, 5)).clip(0, series.size - 1))
    known = near[np.isfinite(out[near])]
    if known.size:
        out[frames] = np.interp(frames, known, out[known])
    return out


def drawn_in(
    series: Mapping[str, np.ndarray], resolution: float = 0.0, over: MapFunction = in_turn
) -> Mapping[str, np.ndarray]:
    """(n,) coordinates with no frame farther than three scales from the median of the five round
    it: heavy tails made light.

    The scale is that of these distances, half a step of the values at least. Where more are off, of
    all coordinates among one, three or nine frames, than so many would be by chance, something
    happened, and all stays. over: how coordinates are worked on.
    """
    pieces = over(lambda values: _far_frames(values, resolution), series.values())
    beyond = dict(zip(series, pieces, strict=True))
    off = np.zeros(len(next(iter(series.values()))), np.int16)
    for frames, _ in beyond.values():
        off[frames] += 1
    alone = ~_dense_frames(off, len(series))

    def drawn(name: str) -> np.ndarray:
        frames, excess = beyond[name]
        mask, values = alone[frames], series[name].copy()
        values[frames[mask]] -= excess[mask]
        return values

    return kept_if_small(LazyArrays(series, drawn), off.size)


def _far_frames(series: np.ndarray, resolution: float) -> tuple[np.ndarray, np.ndarray]:
    """Frames that are farther from the median of five than three scales of these distances, and by
    how much; of fifteen where many are, as three of five may be then."""
    from scipy.ndimage import median_filter

    with np.errstate(invalid="ignore"):
        distance = series - median_filter(series, 5)
    step = max(resolution, own_step(series))
    for again in (True, False):
        reach = DRAWN_IN_SCALES * max(mad_spread(distance), step / 2)
        if not reach > 0:
            return np.empty(0, int), np.empty(0)
        distance[~np.isfinite(distance)] = 0.0
        frames = np.flatnonzero(np.abs(distance) > reach)
        if not again or frames.size < MANY_BEYOND * series.size:
            break
        known = np.isfinite(series)  # a gap would spoil medians far from it, too
        distance = np.full(series.size, np.nan)
        distance[known] = series[known] - median_filter(series[known], 15)
    off = distance[frames]
    return frames, off - np.clip(off, -reach, reach)


def _dense_frames(off: np.ndarray, n_series: int) -> np.ndarray:
    """Frames around which more values are off than chance explains, (n,). off: (n,) number of
    series that are off."""
    from scipy.ndimage import binary_dilation
    from scipy.special import bdtrc

    share = float(off.mean()) / n_series
    mask = np.zeros(off.size, bool)
    for frames in TOGETHER_FRAMES:
        many = np.arange(1, frames * n_series + 1)
        chance = bdtrc(many - 1, frames * n_series, share) * off.size
        enough = many[chance < ALONE_EXPECTED]
        if enough.size:
            near = np.convolve(off, np.ones(frames, off.dtype))[frames // 2 :][: off.size]
            dense = near >= enough[0]
            mask |= binary_dilation(dense, iterations=frames // 2) if frames > 1 else dense
    return mask
