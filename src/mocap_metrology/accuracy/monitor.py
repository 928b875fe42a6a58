"""Charts of one series of a facility over months: is a new take like those of the baseline?

Statistics give notes, a tolerance gives alarms: limits from the scatter of few takes are wrong by
chance, and takes of neighbouring days are alike, so a facility that did not change leaves textbook
limits (mean +- 3 sd) in most cases.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np
from scipy.special import comb, ndtr, ndtri, stdtr, stdtrit

from mocap_metrology.common.types import Floats

CLIP, REFERENCE = 2.5, 0.5  # of the CUSUM, in standard deviations
LEARNT, SETTLED = 5, 10  # takes of a baseline: below it is learning, provisional
PRIOR_DF = 4  # degrees of freedom of the scatter that is stated
LEAST = 3.5  # s_p: the smallest tolerance that a series which is not capable can be watched for
CAPABLE = 0.5  # s_p by which the tolerance of a series that is may be below that
OFTEN = 3, 6  # values beyond the tolerance, of so many running, that make a series not valid
FEW = 6  # series together of which this holds
PARTED = 1e-3  # chance that an unchanged series of FEW, of any scatter, changes while it is learnt
ONE_SIDED = 1.645  # 95 % of a normal distribution lies below
CELLS = 250  # of the Markov chain


@dataclass(frozen=True)
class Limits:
    """Limits of |Q| and of a CUSUM, both in standard deviations, of each of `n_series`."""

    q: float
    cusum: float
    n_series: int = FEW

    def least(self, m: np.ndarray) -> Floats:
        """Distance from the mean of m values, in s_p, that an unchanged series is hardly beyond:
        3.5; of more than FEW series so much that all together alarm as often as FEW would."""
        dof = np.maximum(m, 1) - 1.0 + PRIOR_DF
        share = min(FEW / self.n_series, 1)
        return np.asarray(-stdtrit(dof, share * stdtr(dof, -LEAST)))


@cache
def limits(n_series: int, false_alarms: float, dates: int) -> Limits:
    """Limits that unchanged series, together, leave with probability `false_alarms` in `dates`
    takes: one half each for Q and for CUSUM, shared equally by series, sides and (Q) takes.

    Q: two-sided quantile. CUSUM: its distribution after `dates` steps by the Markov chain of
    Brook and Evans (Biometrika 59, 1972), for normal values clipped at 2.5. Tests compare it with
    published run lengths and with simulation.
    """
    share = -np.expm1(np.log1p(-false_alarms / 2) / (2 * n_series))
    low, high = 0.5, 40.0
    while high - low > 1e-3:
        middle = (low + high) / 2
        low, high = (middle, high) if crossing(middle, dates) > share else (low, middle)
    return Limits(float(-ndtri(-np.expm1(np.log1p(-share) / dates))), high, n_series)


def crossing(limit: float, steps: int, clip: float = CLIP) -> float:
    """Probability that max(0, C + z - 0.5), from 0, z standard normal and clipped, exceeds `limit`
    within `steps`."""
    width = limit / (CELLS - 0.5)  # the first cell is half as wide: zero is its middle
    edges = (np.arange(CELLS) + 0.5) * width
    reached = edges[None, :] - np.arange(CELLS)[:, None] * width + REFERENCE
    below = np.where(reached < -clip, 0.0, np.where(reached >= clip, 1.0, ndtr(reached)))
    chain = np.diff(below, axis=1, prepend=0.0)
    at = np.zeros(CELLS)
    at[0] = 1
    for _ in range(steps):
        at = at @ chain
    return float(1 - at.sum())


@dataclass(frozen=True)
class WatchLimits:
    """What a series is watched for.

    tolerance: change that matters; scatter: standard deviation from day to day that is expected,
    which counts like 4 degrees of freedom; relative: both are shares of a standard deviation whose
    power 2/3 the series is.
    """

    tolerance: float
    scatter: float
    relative: bool = False

    def at(self, mean: Floats) -> tuple[Floats, Floats]:
        """Tolerance and scatter in the unit of the series, for a mean of the baseline."""
        if not self.relative:
            return np.full_like(mean, self.tolerance), np.full_like(mean, self.scatter)
        return mean * ((1 + self.tolerance) ** (2 / 3) - 1), mean * self.scatter * 2 / 3


@dataclass(frozen=True)
class Chart:
    """Statistics of a series at each take, (n,) each; those before a take is judged are NaN.

    n_baseline, mean, scatter: takes of the baseline before this one, their mean, s_p; baseline: of
    which takes it consists; tolerance; least: tolerance in s_p that can be watched; q: of the take
    against the baseline; cusum: the larger of both sides; since: first value of its run; shift:
    mean from there on minus that of the baseline; learning; beyond: the tolerance; unusual: by Q;
    drifting: by CUSUM, shift and the mean of the last five values of its run; parted, apart: change
    within the baseline, and takes at the rarer of its levels (`_parted`).
    """

    value: Floats
    n_baseline: np.ndarray
    baseline: np.ndarray
    mean: Floats
    scatter: Floats
    tolerance: Floats
    least: Floats
    q: Floats
    cusum: Floats
    since: np.ndarray
    shift: Floats
    learning: np.ndarray
    beyond: np.ndarray
    unusual: np.ndarray
    drifting: np.ndarray
    parted: Floats
    apart: np.ndarray

    @property
    def capable(self) -> np.ndarray:
        """(n,) whether the scatter is small enough, s_p <= T/3."""
        return self.scatter * (self.least - CAPABLE) <= self.tolerance

    @property
    def scattered(self) -> np.ndarray:
        """(n,) whether the takes of the baseline scatter by more than the tolerance, as where they
        have several levels: of none of these is anything known."""
        return self.scatter > self.tolerance

    @property
    def band(self) -> Floats:
        """(n,) distance from the mean beyond which a take alarms."""
        return _allowed_distance(self.n_baseline, self.tolerance, self.scatter, self.least)

    @property
    def watchable(self) -> Floats:
        """(n,) smallest tolerance that the series can be watched for, 3.5 s_p."""
        return self.least * self.scatter


ORDER = ("failure", "alert", "note", "learning", "provisional", "pass", "")  # the worst first


def words(charted: Chart) -> list[tuple[str, int | None]]:
    """Word of each value, and since which one the series is not valid (None: it is).

    One value beyond the tolerance is an alert, the second running or the third of six a failure;
    then two running inside make the series valid again, and the first of them is an alert still.
    """
    said: list[tuple[str, int | None]] = []
    since: int | None = None
    unlike = charted.unusual, charted.drifting, charted.parted, charted.scattered
    for k in range(charted.value.size):
        again = k > 0 and charted.beyond[k] == charted.beyond[k - 1]
        if charted.beyond[k] and since is None:
            first = max(k + 1 - OFTEN[1], 0)
            recent = first + np.flatnonzero(charted.beyond[first : k + 1])
            if again or recent.size >= OFTEN[0]:
                since = k - 1 if again else int(recent[0])
        elif since is not None and not charted.beyond[k] and again:
            since = None
        if charted.beyond[k] or since is not None:
            word = "failure" if charted.beyond[k] and since is not None else "alert"
        elif charted.learning[k]:
            word = "learning"
        elif any(one[k] for one in unlike):
            word = "note"
        else:
            word = "provisional" if charted.n_baseline[k] < SETTLED else "pass"
        said.append((word, since))
    return said


def chart(
    values: Floats, days: Sequence[object], marked: np.ndarray, watched: WatchLimits, limit: Limits
) -> Chart:
    """Chart of the values (n,) of one series, in order of time, without NaN.

    With m values of the baseline before a value x, their mean and standard deviation s,

        Q = Phi^-1 G_(m-1)[(x - mean) / (s sqrt(1 + 1/m))],

    G the distribution of Student's t (Quesenberry, J. Qual. Technol. 23, 1991): normal for an
    unchanged series, whatever m. The CUSUM (Hawkins, The Statistician 36, 1987) is of the same Q
    against all earlier values, clipped to 2.5: independent, so its limits are exact. A value is
    beyond the tolerance T if |x - mean| > T + 1.645 s_p / sqrt(m), where s_p^2 = (4 s_0^2 + (m-1)
    s^2) / (m+3) and s_0 is the scatter that is stated. Where s_p > T/3, the series is not capable:
    it would alarm by chance, and 3.5 s_p stands in place of T; both numbers are larger where there
    are more than six series (`Limits.least`).

    days: (n,) day of each; marked: (n,) whether the sheet names it as of the baseline. Where none
    is, the baseline is the first ten values that are not beyond; of its first five one that is
    beyond the tolerance of the four others is none of it. Values are judged from five values of
    five days on.
    """
    x = np.asarray(values, dtype=np.float64)
    baseline = marked if marked.any() else _learning_values(x, days, watched, limit)
    m, mean, spread = _earlier_moments(x, baseline)
    learning = (m < LEARNT) | (_days_before(days, baseline) < LEARNT)
    tolerance, scatter = _widths(m, mean, spread, watched)
    least = limit.least(m)
    count, all_mean, all_spread = _earlier_moments(x, np.ones(x.size, dtype=bool))
    running = np.clip(_self_starting_q(x, count, all_mean, all_spread), -CLIP, CLIP)
    (high, since_high), (low, since_low) = _cusum(running), _cusum(-running)
    cusum, since = np.maximum(high, low), np.where(high >= low, since_high, since_low)
    total = np.concatenate([[0.0], np.cumsum(x - x[:1].sum())])
    length = np.arange(x.size) + 1 - since
    recent = (total[1:] - total[since]) / length + x[:1].sum()
    gap = np.where(learning, np.nan, 0.0)
    shift = recent - mean + gap
    few = np.minimum(length, LEARNT)  # what came back has not moved
    latest = (total[1:] - total[np.arange(x.size) + 1 - few]) / few + x[:1].sum() - mean
    moved = (np.abs(shift) > tolerance / 2) & (np.copysign(1, shift) * latest > tolerance / 4)
    q = _self_starting_q(x, m, mean, spread) + gap
    beyond = ~learning & (np.abs(x - mean) > _allowed_distance(m, tolerance, scatter, least))
    parted, apart = _parted(x, baseline, m, watched, limit)
    return Chart(
        x,
        m,
        baseline,
        *(mean + gap, scatter + gap, tolerance + gap, least, q, cusum),
        since,
        shift,
        *(learning, beyond, np.abs(q) > limit.q, (cusum > limit.cusum) & moved),
        np.where(learning, 0.0, parted),
        np.where(learning, 0, apart),
    )


def _parted(
    x: Floats, chosen: np.ndarray, m: np.ndarray, watched: WatchLimits, limit: Limits
) -> tuple[Floats, np.ndarray]:
    """(n,) change within the chosen values before each, 0 where they have none; (n,) how many are
    at the rarer of two levels, 0 of a step or a drift. The likeliest leaves the least squares."""
    change, apart = np.zeros(x.size), np.zeros(x.size, dtype=np.int64)
    for k in np.flatnonzero(m >= LEARNT):
        change[k], apart[k] = change[k - 1], apart[k - 1]
        if m[k] != m[k - 1]:
            how = x[:k][chosen[:k]], watched, limit
            found = [_divided(*how, False), _divided(*how, True), _drifted(*how)]
            _, change[k], apart[k] = min(found, key=lambda one: one[0])
    return change, apart


def _divided(
    known: Floats, watched: WatchLimits, limit: Limits, levels: bool
) -> tuple[float, float, int]:
    """Sum of squares, change and smaller number of the n values, where the means of two parts
    differ by more than the tolerance and by more than chance; else infinite, 0 and 0.

    Parts are two values or more before and after a moment, or the larger and the smaller (levels).
    Each division has Student's t of n - 2 degrees of freedom: PARTED is shared by those in time, or
    by sizes of a part and divisions of a size (Bonferroni); the stated scatter is the least.
    """
    y, n = (np.sort(known) if levels else known) - known[0], known.size
    at = np.arange(1, n) if levels else np.arange(2, n - 1)
    first, total, fewer = np.cumsum(y)[at - 1], y.sum(), np.minimum(at, n - at)
    change = (total - first) / (n - at) - first / at
    squares = np.maximum(y @ y - first**2 / at - (total - first) ** 2 / (n - at), 0)
    tolerance, stated = watched.at(known.mean(keepdims=True))
    error = np.maximum(np.sqrt(squares / (n - 2)), stated) * np.sqrt(1 / at + 1 / (n - at))
    number = n // 2 * comb(n, fewer) if levels else at.size
    times = -stdtrit(n - 2, PARTED * min(FEW / limit.n_series, 1) / 2 / number)
    is_real = np.abs(change) > np.maximum(tolerance + ONE_SIDED * error, times * error)
    if not is_real.any():
        return np.inf, 0.0, 0
    best = np.argmin(np.where(is_real, squares, np.inf))
    return float(squares[best]) * (1 + 1e-6 * levels), float(change[best]), fewer[best] * levels


def _drifted(known: Floats, watched: WatchLimits, limit: Limits) -> tuple[float, float, int]:
    """As `_divided`, of a straight line through the n values: its change from the first to the
    last."""
    n, t = known.size, np.arange(known.size) - (known.size - 1) / 2
    y = known - known.mean()
    change = float(t @ y / (t @ t)) * (n - 1)
    squares = float(np.sum((y - change * t / (n - 1)) ** 2))
    tolerance, stated = (float(one[0]) for one in watched.at(known.mean(keepdims=True)))
    error = max(np.sqrt(squares / (n - 2)), stated) * (n - 1) / np.sqrt(t @ t)
    times = -stdtrit(n - 2, PARTED * min(FEW / limit.n_series, 1) / 2)
    is_real = abs(change) > max(tolerance + ONE_SIDED * error, times * error)
    return (squares, change, 0) if is_real else (np.inf, 0.0, 0)


def _earlier_moments(x: Floats, chosen: np.ndarray) -> tuple[np.ndarray, Floats, Floats]:
    """Number, mean and standard deviation of the chosen values before each; NaN where too few."""
    origin = x[chosen][:1].sum()  # sums of small numbers keep their digits
    y = np.where(chosen, x - origin, 0.0)
    m, first, second = (
        np.concatenate([[0], np.cumsum(one)])[: x.size] for one in (chosen, y, y * y)
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = first / m
        variance = np.where(m > 1, (second - m * mean**2) / (m - 1), np.nan)
    return m, mean + origin, np.sqrt(np.maximum(variance, 0))


def _self_starting_q(x: Floats, m: np.ndarray, mean: Floats, spread: Floats) -> Floats:
    """(n,) Q of each value; 0 where fewer than two values are before it."""
    with np.errstate(invalid="ignore", divide="ignore"):
        t = (x - mean) / (spread * np.sqrt(1 + 1 / m))
    t = np.where((m < 2) | np.isnan(t), 0.0, t)
    return np.copysign(
        -ndtri(stdtr(np.maximum(m - 1, 1), -np.abs(t))), t
    )  # of the lower tail: exact


def _cusum(q: Floats) -> tuple[Floats, np.ndarray]:
    """(n,) C = max(0, C + q - 0.5), and the first value of its present run."""
    total = np.concatenate([[0.0], np.cumsum(q - REFERENCE)])
    least = np.minimum.accumulate(total)
    at = np.where(total[:-1] <= least[:-1], np.arange(q.size), 0)
    return (total - least)[1:], np.maximum.accumulate(at)


def _widths(
    m: np.ndarray, mean: Floats, spread: Floats, watched: WatchLimits
) -> tuple[Floats, Floats]:
    """Tolerance, and s_p: the scatter measured and that stated."""
    tolerance, stated = watched.at(mean)
    measured = np.where(m > 1, (m - 1) * np.nan_to_num(spread) ** 2, 0.0)
    scatter = np.sqrt((PRIOR_DF * stated**2 + measured) / (np.maximum(m, 1) - 1 + PRIOR_DF))
    return tolerance, scatter


def _allowed_distance(m: np.ndarray, tolerance: Floats, scatter: Floats, least: Floats) -> Floats:
    """Distance from the mean of a baseline of m values that is allowed."""
    watched = np.where(scatter * (least - CAPABLE) <= tolerance, tolerance, least * scatter)
    return watched + ONE_SIDED * scatter / np.sqrt(np.maximum(m, 1))


def _days_before(days: Sequence[object], chosen: np.ndarray) -> np.ndarray:
    """(n,) different days among the chosen takes before each."""
    seen: set[object] = set()
    numbers = []
    for day, is_chosen in zip(days, chosen, strict=True):
        numbers.append(len(seen))
        seen |= {day} if is_chosen else set()
    return np.array(numbers, dtype=np.int64)


def _learning_values(
    x: Floats, days: Sequence[object], watched: WatchLimits, limit: Limits
) -> np.ndarray:
    """(n,) the first ten values that are not beyond the tolerance of those before them; of the
    first five none that is beyond that of the four others."""

    def is_beyond(value: float, known: Floats) -> bool:
        m = np.array([known.size])
        mean, spread = known.mean(keepdims=True), known.std(ddof=1, keepdims=True)
        tolerance, scatter = _widths(m, mean, spread, watched)
        return bool(
            abs(value - mean[0]) > _allowed_distance(m, tolerance, scatter, limit.least(m))[0]
        )

    chosen: list[int] = []
    for k in range(x.size):
        if len(chosen) >= SETTLED:
            break
        is_learnt = len(chosen) >= LEARNT and len({days[c] for c in chosen}) >= LEARNT
        if is_learnt and is_beyond(x[k], x[chosen]):
            continue
        chosen.append(k)
        if len(chosen) == LEARNT and k < LEARNT:  # once, as a step would not end it
            alone = {c: x[[other for other in chosen if other != c]] for c in chosen}
            worst = max(chosen, key=lambda c: abs(x[c] - alone[c].mean()))
            if is_beyond(x[worst], alone[worst]):
                chosen.remove(worst)
    mask = np.zeros(x.size, dtype=bool)
    mask[chosen] = True
    return mask
