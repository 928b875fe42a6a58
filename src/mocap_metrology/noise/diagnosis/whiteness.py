"""Whether frames are less white than the noise beside them, as what moves is."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from mocap_metrology.noise.diagnosis.outliers import mad_spread

LIKE_NOISE, WHITE = 0.75, 0.5  # of the whiteness beside it, of louder noise; if its size varies
LIKE, PIECES = 5, 12  # windows as long to each side, at most; pieces at least, of all
SURE, SURER = 3.0, 5.0  # standard errors of a whiteness, or by which it scatters more; a scatter


def likeness(
    values: np.ndarray, first: int, last: int, context: int, n_series: int
) -> tuple[float, bool, bool, bool]:
    """Whiteness of the frames first to last of (n,) values, of that beside them; whether it is
    less, and more so than louder noise may be that is correlated; whether they are louder.

    context: frames to each side, at least; n_series: of which one may be less white by chance.
    """
    from scipy.special import ndtr, ndtri

    far = max(context, LIKE * (last - first))
    start = max(first - far, 0)
    near = values[start : last + far].astype(float)
    before, within, after = np.split(near, [first - start, last - start])
    count = [max(side.size // max(within.size, 1), 1) for side in (before, after)]  # as long
    alone = [*np.array_split(before, count[0]), *np.array_split(after, count[1])]
    alone = [one for one in alone if one.size > max(map(len, alone)) / 2]  # short ones tell little
    usual = np.median([_power(one) for one in alone if one.size > 1] or [np.zeros(2)], axis=0)
    of_event, beside = _power(within), max(sum(map(len, alone)), 1)
    scatter = math.sqrt(3 / max(within.size, 1) + 3 / beside)
    white = float(of_event[1] * usual[0] / max(usual[1] * of_event[0], 1e-300))  # of that beside it
    alike = max(_alike(within), _alike(np.diff(within)), 1.0)  # fewer, where a part is louder
    sure = -float(ndtri(ndtr(-SURE) / n_series))
    off = white < min(LIKE_NOISE, max(1 - sure * math.sqrt(1 / alike + 1 / beside), WHITE))
    louder = of_event > (1 + SURE * scatter) * usual
    varies = math.exp(-SURER * _varies([before, after], within.size)) if off and louder[1] else 1.0
    return white, off, off and white < varies, bool(louder.any())


def _alike(values: np.ndarray) -> float:
    """Number of Gaussian values of one size whose mean square is as uncertain as that of (n,)."""
    squares = (values - np.nanmean(values)) ** 2 if np.isfinite(values).any() else np.ones(1)
    n = np.isfinite(squares).sum()
    return float(min(3 * np.nansum(squares) ** 2 / max(np.nansum(squares**2), 1e-300), n))


def _varies(sides: Sequence[np.ndarray], size: int) -> float:
    """Scatter of the logarithm of the whiteness of so many frames, as noise has it that is
    correlated for long: by that of shorter pieces, where there are few so long."""
    length = max(min(size, sum(map(len, sides)) // PIECES), 2)
    rows = [side[: side.size // length * length].reshape(-1, length) for side in sides]
    powers = np.array([_power(row) for row in np.concatenate(rows)])
    known = powers[powers.min(axis=1, initial=1.0) > 0] if powers.size else np.ones((1, 2))
    return mad_spread(np.log(known[:, 1] / known[:, 0])) * math.sqrt(length / max(size, 1))


def _power(values: np.ndarray) -> np.ndarray:
    """Variance of (n,) values, and half that of their steps, which of white noise is as much [von
    Neumann 1941]."""
    known = values[np.isfinite(values)]
    return np.array([np.var(known), np.var(np.diff(known)) / 2]) if known.size > 1 else np.zeros(2)
