"""Covariance of fast noise between coordinates: Allan variance with two series at a time.

    C_ij(m) = 1/2 <(ybar_i(k+m) - ybar_i(k)) (ybar_j(k+m) - ybar_j(k))>

with window means ybar(k) = (y_k + ... + y_(k+m-1)) / m as in `noise.allan`; C_ii is the overlapping
Allan variance of series i (S Eq. 4). Drift and slow motion hardly touch it at small m.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TypedDict, cast

import numpy as np

from mocap_metrology.common.large import Sliced, in_parts
from mocap_metrology.noise.allan.confidence import equivalent_dof
from mocap_metrology.noise.allan.identification import noise_exponents
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


def block_sums(
    series: Sequence[Sliced], chosen: Sequence[int], n_blocks: int
) -> dict[int, tuple[np.ndarray, np.ndarray]]:
    """For each of these averaging factors (n_blocks, k, k) sums over the terms that begin in each
    equal part of the recording, halved as in the formula, and (n_blocks,) numbers of terms. series:
    k of (n,), NaN where missing, read once.

    A window counts with half of its frames in which all series are there; those are its mean.
    """
    k, n = len(series), len(series[0])
    by_scale = {m: (np.zeros((n_blocks, k, k)), np.zeros(n_blocks)) for m in chosen}
    edges = {m: np.linspace(0, max(n - 2 * m + 1, 0), n_blocks + 1).astype(int) for m in chosen}
    for block in range(n_blocks):
        first, last = (
            reach(edges[m][block + k] for m in chosen) for k, reach in enumerate((min, max))
        )
        for start in range(first, last, CHUNK):
            part = [one[start : start + CHUNK + 2 * max(chosen) - 1] for one in series]
            sums, counts = _running(np.array(part, dtype=np.float64))
            for m, (total, number) in by_scale.items():
                begin, stop = np.clip(edges[m][block : block + 2], start, start + CHUNK) - start
                terms = _differences(sums, counts, m, begin, stop)
                total[block] += terms @ terms.T / 2
                number[block] += terms.shape[1]
    return by_scale


def _running(series: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k, n + 1) sums of the frames before each, about their mean, and (n + 1,) their number, of
    those in which all (k, n) are there."""
    there = np.isfinite(series).all(axis=0)
    centre = series[:, there].mean(axis=1, keepdims=True) if there.any() else 0.0
    sums, counts = np.zeros((len(series), there.size + 1)), np.zeros(there.size + 1)
    np.cumsum(np.where(there, series - centre, 0.0), axis=1, out=sums[:, 1:])
    np.cumsum(there, out=counts[1:])
    return sums, counts


def _differences(sums: np.ndarray, counts: np.ndarray, m: int, begin: int, stop: int) -> np.ndarray:
    """(k, terms) differences of neighbouring window means that begin there, where both are."""
    step = max(m // PER_WINDOW, 1)
    edges = [
        (sums[:, begin + k : stop + k : step], counts[begin + k : stop + k : step])
        for k in (0, m, 2 * m)
    ]
    parts = [(after[0] - before[0], after[1] - before[1]) for before, after in pairwise(edges)]
    known = np.minimum(parts[0][1], parts[1][1]) >= max(MIN_COVERAGE * m, 1)
    before, after = (total / np.maximum(count, 1) for total, count in parts)
    terms = after - before
    return terms if known.all() else terms[:, known]


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
    pairs = list(_pairs([in_parts(series, name) for name in names], chosen)) if chosen else []
    rows: list[CovarianceRow] = []
    for place, m in enumerate(chosen):
        for i, j, of in pairs:
            covariance, count = of[m]
            if not count:
                continue
            dof = min(equivalent_dof(int(exponents[k][place]), m, n) for k in (i, j))
            share = min(count * max(m // PER_WINDOW, 1) / (n - 2 * m + 1), 1.0)
            values = names[i], names[j], m, m / frame_rate_hz, covariance, count, dof * share
            rows.append(cast(CovarianceRow, dict(zip(COLUMNS, values, strict=True))))
    return rows


def _pairs(
    values: Sequence[Sliced], chosen: Sequence[int]
) -> Iterator[tuple[int, int, dict[int, tuple[float, int]]]]:
    """Places of two series, upper triangle, and by factor their covariance and its number of terms;
    from the frames that their markers have, not all markers."""
    starts = range(0, len(values[0]) if len(values) else 0, CHUNK)
    whole = all(np.isfinite(one[at : at + CHUNK]).all() for one in values for at in starts)
    known: dict[tuple[int, int], dict[int, tuple[np.ndarray, np.ndarray]]] = {}
    for i in range(len(values)):
        for j in range(i, len(values)):
            markers = (0, 0) if whole else (i // 3, j // 3)
            if markers not in known:
                series = values if whole else [values[3 * k + c] for k in markers for c in range(3)]
                known[markers] = block_sums(series, chosen, 1)
            at = (0, i, j) if whole else (0, i % 3, 3 + j % 3)
            of = known[markers].items()
            yield i, j, {m: (float(sums[at] / max(n[0], 1)), int(n[0])) for m, (sums, n) in of}
