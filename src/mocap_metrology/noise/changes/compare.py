"""Has a tracking system changed? Ratios of Allan deviations, their trend, and what they go with.

Two recordings made at different times are independent, so the ratio of their Allan variances over
the ratio of the true ones follows Fisher's F with the equivalent degrees of freedom of both. Rows
that are subsets of one take are not independent, and not for here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.errors import Refusal
from mocap_metrology.noise.allan.confidence import PARTS

LEAST_EDF = 2.0  # an Allan variance of fewer gives no ratio
# Windows of a coherence, at least: at alpha 0.01 a common cause shows above 0.6 (60 samples) to
# 0.72 (360), down to a fifth of the recording
WINDOWS = 8
SLOWEST = 1.3  # by Monte Carlo: 1.2 to 1.4 from 60 to 360 samples
SAME_PHASE = 0.01  # probability by chance
DAYS_A_MONTH = 30.4375


@dataclass(frozen=True)
class Curve:
    """Allan deviation of a series: `tau_s` rising, `adev` in any unit, `edf`; each (n,).
    `stretches`: (3, n) `levels_of_stretches`; none of noise that is known to be stationary."""

    tau_s: np.ndarray
    adev: np.ndarray
    edf: np.ndarray
    stretches: np.ndarray | None = None

    def usable(self) -> Curve:
        """The part of the curve that has positive deviations with enough degrees of freedom."""
        with np.errstate(invalid="ignore"):
            keep = (self.adev > 0) & (self.edf >= LEAST_EDF)
        stretches = None if self.stretches is None else self.stretches[:, keep]
        return Curve(self.tau_s[keep], self.adev[keep], self.edf[keep], stretches)

    def at(self, tau_s: np.ndarray) -> Curve:
        """Interpolated in logarithms of tau, of deviations, and of degrees of freedom; NaN outside
        of what was computed (1 % tolerance)."""
        at_s = np.asarray(tau_s, dtype=float)
        rows = [
            np.log(self.adev),
            np.log(self.edf),
            *(() if self.stretches is None else self.stretches),
        ]
        if self.tau_s.size:
            x, inside = np.log(self.tau_s), np.log(at_s)
            inside = np.where((inside > x[0] - 0.01) & (inside < x[-1] + 0.01), inside, np.nan)
            # Of a single tau np.interp makes a number of NaN, too
            rows = [np.where(np.isnan(inside), np.nan, np.interp(inside, x, row)) for row in rows]
        else:
            rows = [np.full(at_s.size, np.nan) for _ in rows]
        stretches = None if self.stretches is None else np.array(rows[2:])
        return Curve(at_s, np.exp(rows[0]), np.exp(rows[1]), stretches)


@dataclass(frozen=True)
class Ratio:
    """ADEV of one recording over that of another at each tau, all (n,): `value`, its confidence
    interval `lower` to `upper`, and `p`, the probability of a ratio at least so far from 1 either
    way where nothing has changed."""

    tau_s: np.ndarray
    value: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    p: np.ndarray


def adev_ratio(new: Curve, old: Curve, tau_s: np.ndarray, confidence: float = 0.95) -> Ratio:
    """sigma_new(tau) / sigma_old(tau) with the interval of Fisher's F, and of their stretches.

    s_new^2/s_old^2 over the true ratio ~ F(edf_new, edf_old), so that the true ratio of variances
    lies between R / F_(1 - a/2) and R / F_(a/2), a = 1 - confidence. tau_s: (n,) where to compare;
    NaN where one of both does not reach.

    F does not hold of what comes a few times, more often in one recording than in the other by
    chance: bursts, knocks, shifts. Of curves with `stretches` the interval therefore reaches as far
    as that of the difference of their mean logarithms, too (Welch's t), and p is the larger of
    both; where stretches are too short for the averaging time, that of the difference of the
    variances, each with its own scatter (Wald's).
    """
    return _ratio(new.usable().at(tau_s), old.usable().at(tau_s), confidence)


def _ratio(a: Curve, b: Curve, confidence: float) -> Ratio:
    """a over b, two independent curves at the same tau; see `adev_ratio`."""
    ratio = _fishers(a, b, confidence)
    if a.stretches is None or b.stretches is None:
        return ratio
    return _widened(ratio, a, b, np.stack([a.stretches, b.stretches], axis=1), confidence)


def _widened(ratio: Ratio, a: Curve, b: Curve, stretches: np.ndarray, confidence: float) -> Ratio:
    """A ratio of Fisher's F that allows for what comes a few times; see `adev_ratio`."""
    from scipy.special import stdtr, stdtrit

    means, u, n = stretches
    power = np.array([a.adev, b.adev]) ** 2
    of_power = power * np.sqrt(2 / np.array([a.edf, b.edf]))
    known = np.isfinite(means).all(axis=0)
    apart = np.where(known, means[0] - means[1], power[0] - power[1])
    u = np.where(known, u, of_power)
    squares = np.maximum(u, 1e-300) ** 2
    dof = squares.sum(axis=0) ** 2 / (squares**2 / (np.where(known, n, PARTS) - 1)).sum(axis=0)
    error = np.sqrt(squares.sum(axis=0))
    p = 2 * stdtr(dof, -np.abs(apart) / error)
    reach = np.where(known, stdtrit(dof, (1 + confidence) / 2) * error, np.nan)
    return Ratio(
        ratio.tau_s,
        ratio.value,
        np.fmin(ratio.lower, np.exp((apart - reach) / 2)),
        np.fmax(ratio.upper, np.exp((apart + reach) / 2)),
        np.maximum(ratio.p, p),
    )


def _fishers(a: Curve, b: Curve, confidence: float) -> Ratio:
    """a over b, two independent curves at the same tau."""
    from scipy.special import fdtr, fdtri

    ratio = (a.adev / b.adev) ** 2
    tail = (1 - confidence) / 2
    known = np.isfinite(ratio)
    out = np.full((3, ratio.size), np.nan)
    dof = a.edf[known], b.edf[known]
    out[0, known] = ratio[known] / fdtri(*dof, 1 - tail)
    out[1, known] = ratio[known] / fdtri(*dof, tail)
    below = fdtr(*dof, ratio[known])
    out[2, known] = 2 * np.minimum(below, fdtr(*dof[::-1], 1 / ratio[known]))
    return Ratio(a.tau_s, np.sqrt(ratio), np.sqrt(out[0]), np.sqrt(out[1]), np.minimum(out[2], 1))


def ratios_to_mean(curves: Sequence[Curve], tau_s: np.ndarray) -> list[Ratio]:
    """Each of K independent curves over the geometric mean of all, with 95 % intervals: no curve is
    chosen by what it shows, as the quietest would be, so they hold what they say.

    s_i / mean = (s_i / m_i)^(1 - 1/K), where m_i, the geometric mean of the other curves, is
    independent of s_i. Var(ln m_i) = sum_j trigamma(edf_j/2) / (4 (K - 1)^2); the degrees of
    freedom of m_i are those of one curve of this variance, and its mean that curve's, so that
    Fisher's F holds of (s_i / m_i)^2 (exactly for K = 2); `stretches` widen it as in `adev_ratio`.
    All places weigh the same, however long each was recorded: weights would make the mean one of
    the longest recordings. tau_s: (n,); K counts what reaches a tau; NaN where fewer than two do.
    """
    at = [curve.usable().at(tau_s) for curve in curves]
    adev, edf = (np.array([getattr(a, k) for a in at]) for k in ("adev", "edf"))
    known = np.isfinite(adev) & np.isfinite(edf)
    count = np.maximum(known.sum(axis=0), 1)
    mean = np.exp(np.log(np.where(known, adev, 1.0)).sum(axis=0) / count)
    ratios = []
    for i, one in enumerate(at):
        this = np.arange(len(at)) == i
        others = [_mean_curve(adev[k & ~this, j], edf[k & ~this, j]) for j, k in enumerate(known.T)]
        adev_i, edf_i = np.array(others).T
        stretches = _mean_stretches(at, known & ~this[:, None])
        mean_of_others = Curve(one.tau_s, adev_i, edf_i, stretches)
        ratio = _ratio(one, mean_of_others, 0.95)
        power = 1 - 1 / np.maximum(count, 2)  # of one alone the ratio is NaN
        bounds = (ratio.lower**power, ratio.upper**power)
        value = np.where(np.isfinite(bounds[0]), one.adev / mean, np.nan)
        ratios.append(Ratio(one.tau_s, value, *bounds, ratio.p))
    return ratios


def _mean_stretches(curves: Sequence[Curve], chosen: np.ndarray) -> np.ndarray | None:
    """(3, n) stretches of the geometric mean of the curves that are chosen (K, n) at each tau."""
    each = [curve.stretches for curve in curves if curve.stretches is not None]
    if len(each) < len(curves):
        return None
    means, u, n = np.where(chosen, np.swapaxes(each, 0, 1), 0.0)
    count, squares = np.maximum(chosen.sum(axis=0), 1), u**2
    with np.errstate(invalid="ignore", divide="ignore"):
        dof = squares.sum(axis=0) ** 2 / np.where(chosen, squares**2 / (n - 1), 0.0).sum(axis=0)
    return np.array([means.sum(axis=0) / count, np.sqrt(squares.sum(axis=0)) / count, dof + 1])


def _mean_curve(adev: np.ndarray, edf: np.ndarray) -> tuple[float, float]:
    """(ADEV, edf) of a curve whose logarithm has the mean and variance of that of the geometric
    mean of independent ones (k,); NaN of none."""
    from scipy.optimize import brentq
    from scipy.special import digamma, polygamma

    if not adev.size:
        return math.nan, math.nan
    variance = float(np.sum(polygamma(1, edf / 2))) / adev.size**2
    half = brentq(lambda x: float(polygamma(1, x)) - variance, 1e-3, 2 / variance + 2)
    low = np.mean(np.log(edf / 2) - digamma(edf / 2)) - (math.log(half) - digamma(half))
    return float(np.exp(np.mean(np.log(adev)) + low / 2)), 2 * half


def words_of(ratio: Ratio, margin: float, alpha: float) -> list[str]:
    """`better`, `same` or `worse` at each tau, or an empty word where nothing is known.

    Changed means both: more than a share `margin` (a precise ratio finds changes that matter to
    nobody), and p below alpha over the number of tau (Bonferroni), so that of unchanged series a
    share alpha at most has any such word.
    """
    level = alpha / max(int(np.isfinite(ratio.value).sum()), 1)
    sure = ratio.p < level
    worse, better = ratio.value > 1 + margin, ratio.value < 1 / (1 + margin)
    kinds = [~np.isfinite(ratio.value), sure & worse, sure & better]
    return np.select(kinds, ["", "worse", "better"], "same").tolist()


@dataclass(frozen=True)
class Trend:
    """Change of ADEV over dates: `per_month` as a ratio (1.02: 2 % more a month) with its interval,
    `p` of no trend, `n` recordings, and `scatter`: how much more they scatter about the line than
    their own noise explains (1: not at all)."""

    per_month: float
    lower: float
    upper: float
    p: float
    n: int
    scatter: float


def adev_trend(
    days: Sequence[float], adev: Sequence[float], edf: Sequence[float], confidence: float
) -> Trend:
    """Straight line through ln ADEV over time, weighted by the information of each recording.

    Var(ln s) = trigamma(edf/2)/4, as s^2 is chi-squared with edf degrees of freedom; its mean, low
    by (ln(edf/2) - digamma(edf/2))/2, is put right, or longer recordings would seem worse. The
    standard
    error is multiplied by the scatter about the line where that exceeds 1 (a system differs from
    day to day), and the interval is Student's with n - 2 degrees of freedom. Refuses fewer than
    three recordings and recordings of one day.
    """
    from scipy.special import digamma, polygamma, stdtr, stdtrit

    half = np.asarray(edf, dtype=float) / 2
    t = np.asarray(days, dtype=float) / DAYS_A_MONTH
    y = np.log(np.asarray(adev, dtype=float)) + (np.log(half) - digamma(half)) / 2
    if t.size < 3 or np.ptp(t) == 0:
        raise Refusal(f"trend: {t.size} recordings; expected three or more, of different days")
    weight = 4 / polygamma(1, half)
    middle = np.average(t, weights=weight)
    spread = np.sum(weight * (t - middle) ** 2)
    level = np.average(y, weights=weight)
    slope = np.sum(weight * (t - middle) * (y - level)) / spread
    left = y - level - slope * (t - middle)
    scatter = math.sqrt(np.sum(weight * left**2) / (t.size - 2))
    error = max(scatter, 1.0) / math.sqrt(spread)
    reach = stdtrit(t.size - 2, (1 + confidence) / 2) * error
    p = 2 * stdtr(t.size - 2, -abs(slope) / error)
    a_unit, low, high = np.exp([slope, slope - reach, slope + reach]).tolist()
    return Trend(a_unit, low, high, float(p), t.size, scatter)


@dataclass(frozen=True)
class Coherence:
    """What a series and a covariate have in common, over frequency `f_hz` (n,): squared coherence
    (0 to 1), `gain` (series' unit per covariate's), `phase_rad` (series behind covariate), the
    `threshold` (n,) that an unrelated pair exceeds anywhere with probability alpha, and whether the
    windows agree on the phase (`same_phase`, n)."""

    f_hz: np.ndarray
    squared: np.ndarray
    gain: np.ndarray
    phase_rad: np.ndarray
    threshold: np.ndarray
    same_phase: np.ndarray


def coherence(
    series: np.ndarray, covariate: np.ndarray, step_s: float, alpha: float = 0.01
) -> Coherence:
    """Magnitude-squared coherence of two series (n,) sampled every `step_s`, by Welch's method.

    |S_xy|^2 / (S_xx S_yy) of W Hann windows of an even length, so that they overlap by just half,
    each less its straight line; W is eight, of fewer than 100 samples sometimes nine or ten.
    Of K independent segments an unrelated pair has P(> c) = (1 - c)^(K - 1) (Carter 1987).
    Neighbours that overlap by half are correlated by 1/6 in amplitude, which makes
    K = W / (1 + 2 (1/6)^2 (W - 1)/W) (Welch 1967); at the lowest frequency, from which the straight
    line takes part, K is less by SLOWEST. The Nyquist frequency, which has no phase, is omitted.
    Over the frequencies Bonferroni's bound.

    One event in each at about the same time makes a window or two of large coherent power, and
    chance may have it so. What belongs together has the same phase in all windows: Rayleigh's test,
    exp(-K R^2) < SAME_PHASE, R the length of the mean of the unit phasors of the windows.

    alpha holds of random series. Two causes that have nothing to do with each other but are both
    periodic (sinusoids of random periods: in some 8 % at alpha 0.01), or both settle, exceed the
    threshold more often: they are alike.
    """
    from scipy.signal import csd, spectrogram, welch

    x, y = np.asarray(covariate, dtype=float), np.asarray(series, dtype=float)
    length = 2 * x.size // (WINDOWS + 1)
    length -= length % 2  # of an odd one the overlap is rounded, and only seven fit
    if length < 8 or not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise Refusal(f"coherence: {x.size} common samples; expected 36 or more without gaps")
    how = {"fs": 1 / step_s, "window": "hann", "nperseg": length, "detrend": "linear"}
    f, cross = csd(x, y, **how)
    power_x, power_y = welch(x, **how)[1], welch(y, **how)[1]
    with np.errstate(divide="ignore", invalid="ignore"):
        squared = np.abs(cross) ** 2 / (power_x * power_y)
        gain = np.abs(cross) / power_x
    keep = slice(1, length // 2)
    n_tests = f[keep].size
    windows = 2 * x.size // length - 1
    count = np.full(n_tests, windows / (1 + 2 / 36 * (windows - 1) / windows))
    count[0] -= SLOWEST
    threshold = 1 - (alpha / n_tests) ** (1 / (count - 1))
    phase = -np.angle(cross)
    each = [spectrogram(one, **how, noverlap=length // 2, mode="complex")[2] for one in (x, y)]
    phasors = np.exp(1j * np.angle(each[1] * np.conj(each[0])))
    together = np.exp(-count * np.abs(phasors.mean(axis=1)[keep]) ** 2) < SAME_PHASE
    squared, gain = (np.nan_to_num(value[keep]) for value in (squared, gain))
    return Coherence(f[keep], squared, gain, phase[keep], threshold, together)
