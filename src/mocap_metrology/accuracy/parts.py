"""What the error of a bar is made of: of the class, of the pass, of the place, and a rest.

e = bias + class + pass + place + rest. Place: a quadratic surface of the middle [Huber's estimate],
common to the passes of a class, about each pass's own mean; a surface of p terms takes p / n_eff of
the rest's variance by chance, which is subtracted. Frame to frame, part of the rest: the mean of
(e_k+1 - e_k)^2 / 2.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mocap_metrology.accuracy.statistics import (
    Repeated,
    effective_number,
    huber_fit,
    random_effects,
    repeated,
    robust_sd,
)

FLAT = 0.05  # of the largest extent: along an axis of less the surface does not bend
FITTED = 10_000  # frames at most
BLOCKS = 5  # of one pass
SHIFTS, CLIPPED = 500, 4.0  # in time; robust standard deviations, of gross errors


@dataclass(frozen=True)
class Parts:
    """The parts of the error of one class. sizes: of bias, pass, place, rest, frame in mm;
    place_share: share of the variance about the pass's mean that the surface of other dates, or of
    other passes, explains in what it was not fitted to (NaN of one pass); predicts: whether it
    explains some in each, or in each of BLOCKS parts of one pass; pass_chance: of means that
    scatter as much where passes do not differ; alike: share of the shifts in
    time of which a surface explains as much (`shifted`); rest: (n,) of each pass; n_eff: of the
    rest."""

    sizes: Mapping[str, Repeated]
    place_share: float
    predicts: bool
    pass_chance: float
    alike: float
    rest: tuple[np.ndarray, ...]
    n_eff: float

    def __getitem__(self, name: str) -> Repeated:
        return self.sizes[name]

    @property
    def of_mean_square(self) -> dict[str, float]:
        """Sizes in mm whose squares add up to the mean square; the rest without frame to frame."""
        names = ("bias", "pass", "place", "rest", "frame")
        sizes = {name: abs(float(np.nan_to_num(self[name].value))) for name in names}
        sizes["frame"] = min(sizes["frame"], sizes["rest"])
        sizes["rest"] = float(np.sqrt(sizes["rest"] ** 2 - sizes["frame"] ** 2))
        return sizes


def parts_of(
    errors: Sequence[np.ndarray], middles: Sequence[np.ndarray], dates: Sequence[str]
) -> Parts:
    """The parts of the error of a class, from its passes: errors (n,) mm, NaN in gaps, middles of
    the bar (3, n) mm."""
    centred = [e - np.nanmean(e) for e in errors]
    terms = surface_terms(middles)
    surfaces = [term @ _fitted(terms, centred) for term in terms]
    rest = tuple(c - s for c, s in zip(centred, surfaces, strict=True))
    worth = [effective_number(one) for one in rest]
    sd = np.array([float(np.nanstd(one)) for one in rest])
    chance = terms[0].shape[1] / sum(worth) * float(np.mean(sd**2))
    bent = np.array([np.nanvar(np.where(np.isnan(e), np.nan, s)) for e, s in
                     zip(errors, surfaces, strict=True)])  # fmt: skip
    means = [float(np.nanmean(e)) for e in errors]
    variance = [max(float(np.nanvar(e)), 1e-30) / max(effective_number(e), 1.0) for e in errors]
    between = random_effects(means, variance)
    limits = between.between_lower, between.between_upper
    sizes = {
        "bias": repeated(means),
        "pass": Repeated(len(means), between.between, *limits),
        "place": repeated(np.sqrt(np.maximum(bent - chance, 0.0)), positive=True),
        "rest": repeated(sd, positive=True),
        "frame": repeated([math.sqrt(frame_variance(e)) for e in errors], positive=True),
    }
    left = _left_out(terms, centred, dates)
    share = 1 - float(left[:, 1].sum() / left[:, 0].sum()) if len(errors) > 1 else math.nan
    predicts = bool((left[:, 1] < left[:, 0]).all())
    chances = between.chance, shifted(terms, centred)
    return Parts(sizes, share, predicts, *chances, rest, sum(worth))


def frame_variance(errors: np.ndarray) -> float:
    """Mean of (e_k+1 - e_k)^2 / 2 of errors (n,), NaN in gaps."""
    return float(np.nanmean(np.diff(errors) ** 2)) / 2


def surface_terms(middles: Sequence[np.ndarray]) -> list[np.ndarray]:
    """(n, p) linear and quadratic terms of the middles (3, n) of each pass in their common main
    axes, scaled, each term about its mean in the pass; none of axes along which they hardly differ.
    NaN in gaps."""
    every = np.concatenate(middles, axis=1)
    every = every[:, np.isfinite(every).all(axis=0)]
    mean = every.mean(axis=1, keepdims=True)
    axes, variances, _ = np.linalg.svd((every - mean) @ (every - mean).T / every.shape[1])
    size = np.sqrt(variances)
    wide = size > max(FLAT * size[0], 1e-9)
    scaled = axes[:, wide].T / size[wide, None]
    first, second = np.triu_indices(int(wide.sum()))
    by_degree = []
    for middle in middles:
        linear = scaled @ (middle - mean)
        terms = np.concatenate([linear, linear[first] * linear[second]]).T
        by_degree.append(terms - np.nanmean(terms, axis=0))
    return by_degree


def _fitted(terms: Sequence[np.ndarray], centred: Sequence[np.ndarray]) -> np.ndarray:
    """Coefficients (p,) of the surface of some passes; of long ones some frames only."""
    design, target = np.concatenate(terms), np.concatenate(centred)
    known = np.flatnonzero(np.isfinite(target))
    some = known[:: max(known.size // FITTED, 1)]
    return huber_fit(design[some], target[some])


def _left_out(
    terms: Sequence[np.ndarray], centred: Sequence[np.ndarray], dates: Sequence[str]
) -> np.ndarray:
    """(folds, 2) robust variances about the mean of what was left out, as it is and less the
    surface of all others: dates where there are two or more, passes, or BLOCKS parts of one pass,
    as a slow error of one pass looks like one of the place."""
    marks = list(dates) if len(set(dates)) > 1 and all(dates) else list(range(len(centred)))
    if len(centred) == 1:
        known = np.array_split(np.flatnonzero(np.isfinite(centred[0])), BLOCKS)
        terms, centred = [terms[0][rows] for rows in known], [centred[0][rows] for rows in known]
        marks = list(range(BLOCKS))
    errors = []
    for out in dict.fromkeys(marks):
        others = [k for k, mark in enumerate(marks) if mark != out]
        surface = _fitted([terms[k] for k in others], [centred[k] for k in others])
        pieces = [(centred[k], centred[k] - terms[k] @ surface)
                  for k, mark in enumerate(marks) if mark == out]  # fmt: skip
        squares = [[robust_sd(one - np.nanmean(one)) ** 2 for one in both] for both in pieces]
        errors.append(np.mean(squares, axis=0))
    return np.array(errors)


def shifted(terms: Sequence[np.ndarray], centred: Sequence[np.ndarray]) -> float:
    """Share of circular shifts of the errors (n,) in time, and of the reversed errors, of which
    the terms (n, p) explain as much as of the errors where they were: of what is slow by itself
    many [surrogates by shifts, Theiler et al. 1992]. What changes over a whole pass, BLOCKS half
    cosines, is in neither, as it has no shifts."""
    gram, products = np.zeros(()), np.zeros(())
    for term, error in zip(terms, centred, strict=True):
        known = np.flatnonzero(np.isfinite(error))
        known = known[:: max(known.size // FITTED, 1)]
        width = CLIPPED * robust_sd(error[known])
        both = np.column_stack([term[known], np.clip(error[known], -width, width)])
        n = known.size
        slow = np.cos(np.pi / n * np.outer(np.arange(n) + 0.5, np.arange(BLOCKS + 1)))
        both -= slow @ np.linalg.lstsq(slow, both, rcond=None)[0]
        gram = gram + both[:, :-1].T @ both[:, :-1]
        of_terms, of_error = np.split(np.fft.rfft(both, axis=0), [-1], axis=1)
        at = np.arange(SHIFTS) * n // SHIFTS
        ways = of_error * of_terms.conj(), (of_error * of_terms).conj()
        products = products + np.concatenate([np.fft.irfft(w, n, axis=0)[at] for w in ways])
    explained = ((products @ np.linalg.pinv(gram)) * products).sum(axis=1)
    return float(np.mean(explained[1:] >= explained[0]))
