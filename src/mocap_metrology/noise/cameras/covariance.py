"""Covariance of fast noise between coordinates: Allan variance with two series at a time.

    C_ij(m) = 1/2 <(ybar_i(k+m) - ybar_i(k)) (ybar_j(k+m) - ybar_j(k))>

with window means ybar(k) = (y_k + ... + y_(k+m-1)) / m as in `noise.allan`; C_ii is the overlapping
Allan variance of series i (S Eq. 4). Drift and slow motion hardly touch it at small m.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TypedDict

import numpy as np

from mocap_metrology.common.large import Sliced, in_parts
from mocap_metrology.noise.allan.confidence import equivalent_dof, noise_exponents
from mocap_metrology.noise.series import coordinate_names

TAUS_S = (0.1, 1.0, 10.0)  # beside one frame
MIN_COVERAGE = 0.5
PER_WINDOW = 8  # windows begin so many times in the length of one: more add no information
CHUNK = 65_536  # frames worked on at a time, so that nine hours need little memory


class CovarianceRow(TypedDict):
    """A row of covariance.csv."""

    series_1: str
    series_2: str
    m: int
    tau_s: float
    covariance_mm2: float
    n_terms: int
    edf: float


COLUMNS = tuple(CovarianceRow.__annotations__)


def factors(frame_rate_hz: float, n_frames: int, n_blocks: int = 1) -> list[int]:
    """Averaging factors: one frame, and those nearest 0.1, 1 and 10 s of which each of `n_blocks`
    parts of the recording holds one and a half terms."""
    wanted = [1, *(max(round(tau * frame_rate_hz), 1) for tau in TAUS_S)]
    return sorted({m for m in wanted if n_frames // n_blocks >= 3 * m})


def block_sums(series: Sequence[Sliced], m: int, n_blocks: int) -> tuple[np.ndarray, np.ndarray]:
    """(n_blocks, k, k) sums over the terms that begin in each equal part of the recording, halved
    as in the formula, and (n_blocks,) numbers of terms. series: k of (n,), NaN where missing.

    A window counts with half of its frames in which all series are there; those are its mean.
    """
    k, n = len(series), len(series[0])
    n_terms = max(n - 2 * m + 1, 0)
    edges = np.linspace(0, n_terms, n_blocks + 1).astype(np.int64)
    sums, counts = np.zeros((n_blocks, k, k)), np.zeros(n_blocks)
    for block, (first, last) in enumerate(pairwise(edges)):
        for start in range(first, last, CHUNK):
            stop = min(start + CHUNK, last)
            part = [one[start : stop + 2 * m - 1] for one in series]
            terms = _differences(np.array(part, dtype=np.float64), m)
            sums[block] += terms @ terms.T / 2
            counts[block] += terms.shape[1]
    return sums, counts


def _differences(series: np.ndarray, m: int) -> np.ndarray:
    """(k, terms) differences of neighbouring window means, where there are."""
    there = np.isfinite(series).all(axis=0)
    if m == 1:
        return np.diff(series)[:, there[1:] & there[:-1]]
    if not there.any():
        return np.empty((len(series), 0))
    series = np.where(there, series - series[:, there].mean(axis=1, keepdims=True), 0.0)
    step = max(m // PER_WINDOW, 1)
    sums = np.concatenate([np.zeros((len(series), 1)), np.cumsum(series, axis=1)], axis=1)
    counts = np.concatenate([[0], np.cumsum(there)])
    total, count = sums[:, m:] - sums[:, :-m], counts[m:] - counts[:-m]
    with np.errstate(invalid="ignore", divide="ignore"):
        means = np.where(count >= MIN_COVERAGE * m, total / count, np.nan)
    terms = (means[:, m:] - means[:, :-m])[:, ::step]
    return terms[:, np.isfinite(terms[0])]


def covariance_rows(
    series: Mapping[str, np.ndarray], n_markers: int, frame_rate_hz: float
) -> list[CovarianceRow]:
    """Rows of covariance.csv: upper triangle over the markers' coordinates, for each factor.

    edf: equivalent degrees of freedom of the less certain of the two series' Allan variances; the
    relative standard error of C_ii is sqrt(2 / edf).
    """
    names = [name for name in coordinate_names(n_markers) if name in series]
    n = len(series[names[0]])
    chosen = factors(frame_rate_hz, n)
    exponents = [
        noise_exponents(series[name].astype(np.float64), np.array(chosen)) for name in names
    ]
    values = [in_parts(series, name) for name in names]
    rows: list[CovarianceRow] = []
    for place, m in enumerate(chosen):
        for i, j, covariance, count in _pairs(values, m):
            dof = min(equivalent_dof(int(exponents[k][place]), m, n) for k in (i, j))
            share = min(count * max(m // PER_WINDOW, 1) / (n - 2 * m + 1), 1.0)
            rows.append(
                {
                    "series_1": names[i],
                    "series_2": names[j],
                    "m": m,
                    "tau_s": m / frame_rate_hz,
                    "covariance_mm2": covariance,
                    "n_terms": count,
                    "edf": dof * share,
                }
            )
    return rows


def _pairs(values: Sequence[Sliced], m: int) -> Iterator[tuple[int, int, float, int]]:
    """Places of two series, their covariance and its number of terms, upper triangle; from the
    frames that their markers have, not all markers."""
    whole = all(_is_finite(one) for one in values)
    known: dict[tuple[int, int], tuple[np.ndarray, np.ndarray]] = {}
    for i in range(len(values)):
        for j in range(i, len(values)):
            markers = (0, 0) if whole else (i // 3, j // 3)
            if markers not in known:
                own = values if whole else [values[3 * k + c] for k in markers for c in range(3)]
                known[markers] = block_sums(own, m, 1)
            sums, counts = known[markers]
            at = (i, j) if whole else (i % 3, 3 + j % 3)
            if counts[0]:
                yield i, j, float(sums[0][at] / counts[0]), int(counts[0])


def _is_finite(series: Sliced) -> bool:
    starts = range(0, len(series), CHUNK)
    return all(np.isfinite(series[start : start + CHUNK]).all() for start in starts)


def matrix(rows: Sequence[CovarianceRow], marker: int, m: int) -> np.ndarray:
    """(3, 3) covariance of one marker (numbered from 1) out of rows of covariance.csv."""
    names = [f"{axis}{marker}" for axis in "xyz"]
    found = {
        (row["series_1"], row["series_2"]): row["covariance_mm2"] for row in rows if row["m"] == m
    }
    return np.array([[found[min(i, j), max(i, j)] for j in names] for i in names])
