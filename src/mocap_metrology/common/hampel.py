"""Hampel filter: outliers against the true sliding median absolute deviation (S 3.4).

A sample is an outlier when `|x_i - med_i| > n_sigma * 1.4826 * MAD_i`, where `med_i` is the median
of the window of `half_window` samples before and after it, and `MAD_i` the median of
`|x_j - med_i|` over the same window [Hampel 1974; Pearson 2002]. Both are exact here, ends and gaps
included: the window remains sorted while it slides, and since the deviations to either side of the
median are then sorted too, their median is found by moving one split point, not by sorting again.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.compiled import njit
from mocap_metrology.common.errors import Refusal

SAMPLED = 1 << 17  # changes of frames that show steps
CHANGING, HIDDEN, LEAST_CHANGE = 0.1, 0.1, 0.3  # of steps: share of frames that change, at least;
# quantile of their changes, and its share of their median
GAUSSIAN = 0.16  # of the changes of Gaussian noise are below that share
MAD_TO_SIGMA = 1.4826  # 1 / Phi^-1(3/4): the MAD of a Gaussian times this is its sigma
WINDOWS, FINE_STEPS = 64, 8  # windows looked at; steps in a MAD that they do not change
SHORT_WINDOW = 15  # frames to each side; below, the MAD scatters too much to be a scale


@dataclass(frozen=True)
class Cleaned:
    """A series after the filter.

    values: (n,) float64, outliers replaced by the local median, or NaN if masked;
    outlier: (n,) bool; n_valid: samples that could be tested.
    """

    values: np.ndarray
    outlier: np.ndarray
    n_valid: int

    @property
    def share(self) -> float:
        """Share of the valid samples that were outliers."""
        return float(np.count_nonzero(self.outlier)) / self.n_valid if self.n_valid else np.nan


def hampel(
    series: np.ndarray,
    half_window: int,
    n_sigma: float = 3.0,
    action: str = "replace",
    resolution: float = 0.0,
    among: np.ndarray | None = None,
) -> Cleaned:
    """Clean one series.

    series: (n,), any unit; NaN and infinite samples are gaps: they are skipped in every window and
        stay as they are. half_window: samples to each side; at the ends and around gaps the window
        holds what there is. n_sigma: threshold. action: `replace` by the local median (S 3.4),
        `mask` with NaN, or `off`.
    resolution: step of the stored values, same unit as the series (0: continuous). In coarsely
        stored data the MAD may be stored as 0 although all that is known is that it is below half a
        step; so half a step is the least MAD assumed.

    among: (n,) the outliers by the same window and a lower threshold, where they are known: all
        others are none by this one, and are not looked at.

    On clean Gaussian noise a 3-sigma filter with 241 samples replaces 0.34 % of the samples and
    leaves 0.966 of the white level (see `white_level_kept`).
    """
    if half_window < 1 or not n_sigma > 0:
        raise Refusal(
            f"hampel: half window {half_window}, n_sigma {n_sigma}; expected >= 1 and > 0"
        )
    series = np.ascontiguousarray(series, dtype=np.float64)
    valid = np.isfinite(series)
    n_valid = int(np.count_nonzero(valid))
    outlier = np.zeros(series.size, dtype=np.bool_)
    if action == "off":
        return Cleaned(series.copy(), outlier, n_valid)
    values = series.copy()
    known = np.where(valid, series, np.inf)
    limits = n_sigma * MAD_TO_SIGMA, 0.5 * resolution
    if among is None:
        _filter(known, half_window, *limits, values, outlier)
    else:
        _filter_at(known, np.flatnonzero(among & valid), half_window, *limits, values, outlier)
    if action == "mask":
        values[outlier] = np.nan
    return Cleaned(values, outlier, n_valid)


def own_step(series: np.ndarray) -> float:
    """Step of (n,) values, in their unit, where it is large beside their noise, as of one axis that
    a file has coarser than the others: no change from frame to frame is far below their median. 0
    where there is none, or where values hardly ever change."""
    first = max((series.size - SAMPLED) // 2, 0)
    changes = np.abs(np.diff(series[first : first + SAMPLED].astype(np.float64)))
    some = changes[changes > 0]
    if not some.size > CHANGING * np.count_nonzero(np.isfinite(changes)):
        return 0.0
    # Of a few changes hardly any may be as small by chance
    hidden = min(HIDDEN, GAUSSIAN - 4 * np.sqrt(GAUSSIAN * (1 - GAUSSIAN) / some.size))
    if hidden < 0:
        return 0.0
    least = float(np.quantile(some, hidden))
    return least if least > LEAST_CHANGE * float(np.median(some)) else 0.0


def mask_half_window(half_window_s: float, frame_rate_hz: float) -> int:
    """Frames to each side of the filter that masks gross outliers."""
    return max(round(half_window_s * frame_rate_hz), SHORT_WINDOW)


def white_level_kept(
    n_sigma: float, half_window: int, action: str = "replace"
) -> tuple[float, float]:
    """What the filter does to clean Gaussian noise: (share replaced, variance retained).

    Against a threshold of k sigma exactly: share 2 Q(k), variance retained 1 - 2 (k phi(k) +
    Q(k)). The MAD of a window of w samples scatters, k = n_sigma (1 + 1.1664 z / sqrt(w)), z ~
    N(0, 1) [its asymptotic variance, Falk 1997]; both are averaged over that. 3 sigma, 241
    samples: 0.0034 and 0.966; a long window: 0.0027 and 0.971. Masked samples leave the variance
    of the others. NaN for windows below SHORT_WINDOW, where the MAD is not nearly normal.
    """
    if action == "off":
        return 0.0, 1.0
    if half_window < SHORT_WINDOW:
        return np.nan, np.nan
    from scipy.special import ndtr

    z, weight = np.polynomial.hermite_e.hermegauss(40)
    k = np.abs(n_sigma * (1 + 1.1664 * z / np.sqrt(2 * half_window + 1)))
    tail, density = ndtr(-k), np.exp(-0.5 * k**2) / np.sqrt(2 * np.pi)
    weight = weight / weight.sum()
    share, left = float(weight @ (2 * tail)), float(1 - weight @ (2 * (k * density + tail)))
    return share, left / (1 - share) if action == "mask" else left


def share_of_rounded(
    series: np.ndarray, half_window: int, n_sigma: float, resolution: float
) -> float:
    """Share of clean Gaussian noise in steps q = resolution that the filter replaces; 0 where the
    steps are fine.

    Of windows over (n,) values, from their own medians: where a share p lies within MAD + q/2, half
    a step more than the MAD that is stored, sigma is (MAD + q/2) / Phi^-1((1 + p) / 2), which may
    be well above 1.4826 MAD.
    """
    from scipy.special import ndtr, ndtri

    size = 2 * half_window + 1
    starts = np.linspace(0, max(series.size - size, 0), WINDOWS).astype(int)
    rows = np.array([series[start : start + size] for start in starts], np.float64)
    rows = rows[np.isfinite(rows).all(axis=1)]
    if not (resolution > 0 and rows.size):
        return 0.0
    off = np.abs(rows - np.median(rows, axis=1, keepdims=True))
    mad = np.maximum(np.median(off, axis=1, keepdims=True), resolution / 2)
    if float(np.median(mad)) > FINE_STEPS * resolution:
        return 0.0
    edge = (np.floor(mad / resolution + 0.01) + 0.5) * resolution
    within = np.mean(off < edge)
    sigma = float(np.mean(edge)) / float(ndtri((1 + within) / 2)) if 0 < within < 1 else 0.0
    beyond = (np.floor(n_sigma * MAD_TO_SIGMA * mad / resolution) + 0.5) * resolution
    return float(np.mean(2 * ndtr(-beyond / sigma))) if sigma > 0 else 0.0


def tail(
    cleaned: Cleaned, series: np.ndarray, among: np.ndarray, n_sigma: float, half_window: int
) -> np.ndarray:
    """(n,) which gross outliers, replaced in `cleaned`, are the tail of the noise and no errors.

    Octave by octave from the least of their distances a tail holds ever fewer samples, and some
    below: more of `among`, the outliers by the lower threshold n_sigma, than Gaussian noise has.
    """
    of_noise = white_level_kept(n_sigma, half_window)[0] * cleaned.n_valid
    before = np.count_nonzero(among & np.isfinite(series)) - np.count_nonzero(cleaned.outlier)
    before -= of_noise + 3 * np.sqrt(of_noise)
    distance = np.abs(np.where(cleaned.outlier, series - cleaned.values, 0.0))
    least = distance[cleaned.outlier].min(initial=np.inf)
    while 0 < (count := np.count_nonzero((distance >= least) & (distance < 2 * least))) < before:
        before, least = count, 2 * least
    return cleaned.outlier & (distance < least)


def taken_at_most(n_sigma: float, half_window: int, action: str = "replace") -> float:
    """Largest share by which the filter reduces the Allan deviation of clean noise.

    Twice what it takes of white noise, as slow noise makes the medians lag that it puts in: at 3
    sigma and 241 samples 3.4 %, where 132 published series lost 0.9 to 3.0 % at 1 to 30 frames.
    """
    left = white_level_kept(n_sigma, max(half_window, SHORT_WINDOW), action)[1]
    return 1 - left


@njit
def _exchange(window: np.ndarray, result: np.ndarray, old: float, new: float) -> None:
    """Write to `result` the sorted `window` without one `old` and with one `new`.

    Both hold -inf, the sorted samples, and +inf to the end; so `old = inf` takes nothing out and
    `new = inf` puts nothing in. Every slot depends on three neighbours alone and on no branch:
    without `old`, slot j is w_j where w_j < old, else w_(j+1); putting in `new` makes that
    max(slot_(j-1), min(slot_j, new)).
    """
    for j in range(1, window.size - 1):
        below = window[j - 1] if window[j - 1] < old else window[j]
        here = window[j] if window[j] < old else window[j + 1]
        here = here if here < new else new
        result[j] = below if below > here else here


@njit
def _median(window: np.ndarray, count: int) -> float:
    half = count // 2
    return float(window[half + 1] if count % 2 else (window[half] + window[half + 1]) / 2)


@njit
def _least_mad(window: np.ndarray, count: int, median: float) -> float:
    """A lower bound of the MAD, from the quartiles alone: of the deviations, at most quarter - 1
    to the left of the median and half - quarter - 1 to its right are smaller."""
    half = count // 2
    quarter = half // 2
    if quarter == 0:
        return 0.0
    below = median - window[half - quarter + 1]
    above = window[count % 2 + 2 * half - quarter] - median
    return float(min(below, above))


@njit
def _mad(window: np.ndarray, count: int, median: float) -> float:
    """MAD of a sorted window: its deviations are two sorted runs, left and right of the median, of
    which the smaller half takes `split` and `half - split`."""
    half = count // 2
    odd = count % 2
    left = half  # left deviation k: median - window[left - k]; slot 0 is the -inf
    right = half + odd + 1  # right deviation k: window[right + k] - median
    split = half // 2
    while split > 0 and median - window[left - split + 1] > window[right + half - split] - median:
        split -= 1
    while (
        split < half and window[right + half - split - 1] - median > median - window[left - split]
    ):
        split += 1
    low = 0.0
    if split > 0:
        low = median - window[left - split + 1]
    if split < half:
        low = max(low, window[right + half - split - 1] - median)
    if odd or half == 0:
        return low
    high = np.inf
    if split < half:
        high = median - window[left - split]
    if split > 0:
        high = min(high, window[right + half - split] - median)
    return (low + high) / 2


@njit
def _filter(
    series: np.ndarray,
    half_window: int,
    threshold: float,
    least_mad: float,
    values: np.ndarray,
    outlier: np.ndarray,
) -> None:
    """`series` holds +inf in its gaps: entering or leaving the window, those change nothing."""
    n = series.size
    window = np.full(2 * half_window + 3, np.inf)
    window[0] = -np.inf
    spare = window.copy()
    count = 0
    for i in range(-half_window, n):
        entering = series[i + half_window] if i + half_window < n else np.inf
        leaving = series[i - half_window - 1] if i > half_window else np.inf
        _exchange(window, spare, leaving, entering)
        window, spare = spare, window
        count += int(entering < np.inf) - int(leaving < np.inf)
        if i < 0 or series[i] == np.inf:
            continue
        median = _median(window, count)
        deviation = abs(series[i] - median)
        # The bound clears nearly every sample without its MAD
        if deviation > threshold * max(
            _least_mad(window, count, median), least_mad
        ) and deviation > threshold * max(_mad(window, count, median), least_mad):
            values[i] = median
            outlier[i] = True


@njit
def _filter_at(
    series: np.ndarray,
    places: np.ndarray,
    half_window: int,
    threshold: float,
    least_mad: float,
    values: np.ndarray,
    outlier: np.ndarray,
) -> None:
    """`_filter` of the samples at these places alone: each sorts its own window, unless half of it
    is so far off its median that the sample is none."""
    window = np.full(2 * half_window + 3, np.inf)
    window[0] = -np.inf
    for i in places:
        near = series[max(i - half_window, 0) : i + half_window + 1]
        near = near[near < np.inf]
        count, median = near.size, np.median(near)
        deviation = abs(series[i] - median)
        if np.count_nonzero(np.abs(near - median) < deviation / threshold) < count // 2:
            continue
        window[1 : count + 1] = np.sort(near)
        window[count + 1 :] = np.inf
        if deviation > threshold * max(_mad(window, count, median), least_mad):
            values[i] = median
            outlier[i] = True


def warm_up() -> None:
    """Compile for float64."""
    filtered = hampel(np.arange(8.0), half_window=2)
    hampel(np.arange(8.0), half_window=2, among=filtered.outlier)
