"""Medians, ratios and rank correlations of errors, with intervals of 95 %.

An error may be infinite: a calibration that found no pose is worse than any other.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from mocap_metrology.common.types import Floats

CONFIDENCE = 0.95
FEWEST_PAIRS = 4  # the variance of Fisher's z has n - 3 in its denominator


class Interval(NamedTuple):
    """An estimate and its limits; limits are NaN where the sample is too small to have any."""

    value: float
    lower: float
    upper: float


NONE = Interval(math.nan, math.nan, math.nan)


def median_interval(values: Floats) -> Interval:
    """Median of n values, and the order statistics x_(k), x_(n+1-k) that contain the median of the
    population with a probability of at least `CONFIDENCE`, whatever its distribution: k is the
    largest with P(B < k) <= (1 - CONFIDENCE) / 2, B binomial (n, 1/2) [David & Nagaraja 2003,
    section 7.1].

    Fewer than six values have no such interval of 95 %.
    """
    from scipy.stats import binom

    n = len(values)
    if not n:
        return NONE
    ordered = np.sort(values)
    k = int(binom.ppf((1 - CONFIDENCE) / 2, n, 0.5))  # the smallest with P(B <= k) at least this
    middle = float(np.median(ordered))
    if not k:
        return Interval(middle, math.nan, math.nan)
    return Interval(middle, float(ordered[k - 1]), float(ordered[n - k]))


def rank_correlation(x: Floats, y: Floats) -> Interval:
    """Spearman's rank correlation r of x (n,) and y (n,), ties with their mean rank.

    Interval: tanh(atanh r -+ z sqrt((1 + r^2 / 2) / (n - 3))) [Bonett & Wright 2000], with z the
    normal quantile. Where x has few values, as in a designed study, it covers 93 to 99.8 %
    (simulated: more than 95 % above |r| of 0.6). NaN where x or y is constant; no limits for
    |r| = 1 or fewer than four pairs.
    """
    from scipy.stats import norm, rankdata

    a, b = (rankdata(values) - (len(values) + 1) / 2 for values in (x, y))
    size = math.sqrt(float(a @ a) * float(b @ b))
    if not size:
        return NONE
    r = float(np.clip(a @ b / size, -1.0, 1.0))
    if len(a) < FEWEST_PAIRS or abs(r) > 1 - 1e-12:
        return Interval(r, math.nan, math.nan)
    half = norm.ppf((1 + CONFIDENCE) / 2) * math.sqrt((1 + r**2 / 2) / (len(a) - 3))
    return Interval(r, math.tanh(math.atanh(r) - half), math.tanh(math.atanh(r) + half))
