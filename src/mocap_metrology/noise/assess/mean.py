"""The mean of all frames as a result, in the manner of the GUM (JCGM 100): how many independent
frames they are worth, its expanded uncertainty, and the length that a stated one needs.

Of stationary noise with the autocorrelation r, the mean of n frames has the variance
u^2 = sigma^2 / n_eff with n_eff = n / (1 + 2 sum (1 - k/n) r_k), and the correlation time is
T_c = T / n_eff, T = n tau0: frames that far apart count as independent. Here sigma^2 and u^2 are
those of the noise model (`spread` about a mean over FAR times the recording), and their interval
that of its coefficients; without a model, the variance of BATCHES batch means over their number
[Schmeiser 1982], chi-squared with one degree of freedom less than batches.

Flicker noise, random walk and deterministic parts have no such mean: it depends on when it is
taken, and no length makes it certain. Then only T is stated.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from mocap_metrology.common.gum import coverage_factor
from mocap_metrology.noise.assess.measured import Measured
from mocap_metrology.noise.assess.spread import expected_spread
from mocap_metrology.noise.model.components import NoiseModel, PowerLaw
from mocap_metrology.noise.model.deterministic import Deterministic
from mocap_metrology.noise.series import block_means

FAR = 10**6  # recordings, over which a mean is the true one
BATCHES = 20
LEAST_RATIO = 1.0  # of the squares of differences of batch means to those of their deviations
LEAST = 0.01  # share of the variance of the mean over ten recordings that noise without a mean has
NOT_COVERED = ("scale and distortion of the volume", "what changes between recordings")


@dataclass(frozen=True)
class MeanOfAll:
    """duration_s: T; n_eff with its 95 % interval; correlation_s: T_c; u_mm (type A), dof: its
    effective degrees of freedom; k: t(0.975, dof); expanded_mm: k u; length_s: so long a recording
    has a mean with k u of the wanted size. NaN where there is no such mean."""

    duration_s: float = math.nan
    n_eff: float = math.nan
    n_eff_lower_95: float = math.nan
    n_eff_upper_95: float = math.nan
    correlation_s: float = math.nan
    u_mm: float = math.nan
    dof: float = math.nan
    k: float = math.nan
    expanded_mm: float = math.nan
    length_s: float = math.nan


def mean_of_all(
    series: np.ndarray,
    frame_rate_hz: float,
    model: NoiseModel | None,
    part: Deterministic,
    wanted_mm: float,
) -> MeanOfAll:
    """The mean of a whole series (n,) in mm, NaN in gaps, with its uncertainty; model, part: what
    is fitted to them, or None where no model is believed."""
    n = int(np.isfinite(series).sum())
    duration = n / frame_rate_hz
    if model is None:
        by_batches = _by_batches(series)
        variance = float(np.nanvar(series, ddof=1)) if n > 1 else math.nan
        low, high = by_batches.interval(0.95)
    elif not part.empty or _has_no_mean(model, n, frame_rate_hz):
        return MeanOfAll(duration)
    else:
        recorded = (frame_rate_hz, n)
        one = expected_spread(model, 1, FAR * n, *recorded)
        mean = expected_spread(model, n, FAR * n, *recorded, confidence=0.95)
        variance, low, high = one.value**2, mean.lower, mean.upper
        error = math.log(high / mean.value) / 1.96 if mean.value > 0 else math.nan
        by_batches = Measured(mean.value**2, 1 / (2 * error**2) if error > 0 else math.inf)
    if not by_batches.variance > 0 or not low > 0:
        return MeanOfAll(duration)
    return _stated(duration, variance, by_batches, (low, high), wanted_mm)


def _stated(
    duration: float, variance: float, mean: Measured, ends: tuple[float, float], wanted_mm: float
) -> MeanOfAll:
    n_eff = variance / mean.variance
    k = coverage_factor(mean.edf)
    expanded = k * mean.value
    return MeanOfAll(
        duration, n_eff, variance / ends[1] ** 2, variance / ends[0] ** 2, duration / n_eff,
        mean.value, mean.edf, k, expanded, duration * (expanded / wanted_mm) ** 2,
    )  # fmt: skip


def _has_no_mean(model: NoiseModel, n: int, frame_rate_hz: float) -> bool:
    """Whether flicker noise or a random walk is more than LEAST of the variance of the mean about
    that over ten recordings."""
    slow = tuple(c for c in model.components if isinstance(c, PowerLaw) and c.alpha < 0)
    if not slow:
        return False
    every = expected_spread(model, n, 10 * n, frame_rate_hz, n).value
    of_slow = expected_spread(NoiseModel(slow, model.form), n, 10 * n, frame_rate_hz, n).value
    return of_slow**2 > LEAST * every**2


def _by_batches(series: np.ndarray) -> Measured:
    """Variance of the mean of all and its degrees of freedom; none of batches that wander: whose
    differences have less than half the mean square of white ones [von Neumann 1941; 1 %]."""
    length = series.size // BATCHES
    means = block_means(series, max(length, 1))[:BATCHES]
    means = means[np.isfinite(means)]
    if not length or means.size < BATCHES / 2:
        return Measured(math.nan, math.nan)
    if np.sum(np.diff(means) ** 2) < LEAST_RATIO * means.var() * means.size:
        return Measured(math.nan, math.nan)
    return Measured(float(means.var(ddof=1)) / means.size, means.size - 1.0)
