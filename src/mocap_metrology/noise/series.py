"""The series that are analysed (coordinates of markers, distances of pairs), and the columns in
which their results are stored.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from mocap_metrology.common.large import LazyArrays
from mocap_metrology.common.types import Columns, Floats, Record

if TYPE_CHECKING:
    from mocap_metrology.noise.allan.confidence import AllanCurve
    from mocap_metrology.noise.fit.spectral.periodogram import Periodogram

AXES = ("x", "y", "z")
ALLAN = (
    *("series", "estimator", "m", "tau_s", "avar_mm2", "adev_mm", "n_terms", "alpha", "edf"),
    *("adev_lower_mm", "adev_upper_mm"),
)
# Mean of the logarithms of the Allan variances of stretches, its uncertainty, and of how many
STRETCHES = ("ln_avar", "ln_avar_u", "ln_avar_n")
ALLAN_MASKED = ALLAN + STRETCHES
PERIODOGRAM = ("series", "f_hz", "f_lower_hz", "f_upper_hz", "psd_mm2_hz", "dof", "stretch_s")


def coordinate_names(n_markers: int) -> list[str]:
    """`x1, y1, z1, x2, ...`, markers numbered from 1 as in S."""
    return [f"{axis}{k}" for k in range(1, n_markers + 1) for axis in AXES]


def pair_name(pair: tuple[int, int], pairs: Sequence[tuple[int, int]]) -> str:
    """`L` for the first pair (S 3.3), `L_1_3` for further ones; markers numbered from 1."""
    return "L" if pair == pairs[0] else f"L_{pair[0]}_{pair[1]}"


def position(series: Mapping[str, np.ndarray], marker: int) -> np.ndarray:
    """(3, n) float64 coordinates of one marker (numbered from 1) out of named series."""
    return np.array([series[f"{axis}{marker}"] for axis in AXES], dtype=np.float64)


def distance(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """(n,) Euclidean distance of two markers, each (3, n); NaN where either is missing.

    S Eq. 12 with differences inside the squares (printed there as sums).
    """
    return _length(
        np.asarray(a, float) - np.asarray(b, float) for a, b in zip(first, second, strict=True)
    )


def _length(differences: Iterable[np.ndarray]) -> np.ndarray:
    """(n,) length of vectors whose components come one by one, as arrays that may be overwritten:
    nine hours of three at once would be 190 MB."""
    first, *others = (np.square(d, out=d) for d in differences)
    for other in others:
        first += other
    return np.sqrt(first, out=first)


def all_series(
    coordinates: Mapping[str, np.ndarray], pairs: Sequence[tuple[int, int]]
) -> Iterator[tuple[str, np.ndarray]]:
    """Name and (n,) float64 values of every coordinate, then of every pair's distance.

    Distances come from these coordinates: give the raw ones, and clean L as a series of its own.
    """
    return iter(every_series(coordinates, pairs).items())


def every_series(
    coordinates: Mapping[str, np.ndarray], pairs: Sequence[tuple[int, int]]
) -> Mapping[str, np.ndarray]:
    """The series of `all_series` by name, each computed whenever it is asked for."""
    distances = {pair_name(pair, pairs): pair for pair in pairs}

    def made(name: str) -> np.ndarray:
        if name not in distances:
            return np.asarray(coordinates[name], dtype=np.float64)
        first, second = distances[name]
        return _length(
            coordinates[f"{axis}{first}"].astype(np.float64) - coordinates[f"{axis}{second}"]
            for axis in AXES
        )

    return LazyArrays([*coordinates, *distances], made)


def pair_numbers(
    labels: Sequence[str], pairs: Sequence[Sequence[str]] | None
) -> list[tuple[int, int]]:
    """Numbers (from 1) of the markers of each pair; without pairs, the first two markers."""
    if not pairs:
        return [(1, 2)] if len(labels) > 1 else []
    place = {label: number for number, label in enumerate(labels, start=1)}
    return [(place[first], place[second]) for first, second in pairs]


def allan_columns(series: str, curve: AllanCurve, estimator: str = "oadev") -> Columns:
    """Columns of allan.parquet of one series and estimator; of a curve with stretches those
    of allan_masked.parquet."""
    k = curve.m.size
    values = (
        *(np.full(k, series, dtype=object), np.full(k, estimator, dtype=object)),
        *(curve.m, curve.tau_s, curve.variance, curve.deviation, curve.n_terms, curve.alpha),
        *(curve.edf, curve.lower, curve.upper),
    )
    stretches = (
        {} if curve.stretches is None else dict(zip(STRETCHES, curve.stretches, strict=True))
    )
    return dict(zip(ALLAN, values, strict=True)) | stretches


def periodogram_columns(series: str, periodogram: Periodogram | None) -> Columns:
    """Columns of periodogram.parquet of one series: what the likelihood was fitted to, lines
    subtracted; stretch_s is the duration of the stretch without long gaps a bin comes from."""
    if periodogram is None:
        return {name: np.array([]) for name in PERIODOGRAM}
    bins = periodogram.bins
    values = (
        *(np.full(bins.n.size, series, dtype=object), bins.centre_hz, bins.f_lower_hz),
        *(bins.f_upper_hz, periodogram.psd, periodogram.weight, bins.duration_s),
    )
    return dict(zip(PERIODOGRAM, values, strict=True))


def block_means(series: np.ndarray, length: int, least: float = 0.5) -> Floats:
    """Means of successive blocks of `length` values, NaN where less than this share of a block is
    there, or nothing."""
    blocks = np.asarray(series[: series.size // length * length], float).reshape(-1, length)
    valid = np.isfinite(blocks)
    counts = valid.sum(axis=1)
    sums = np.where(valid, blocks, 0.0).sum(axis=1)
    return np.where(counts >= max(least * length, 1), sums / np.maximum(counts, 1), np.nan)


def joined(parts: Sequence[Mapping[str, np.ndarray]], names: Sequence[str]) -> Columns:
    """The parts one below the other; columns `names` even without a part."""
    return {
        name: np.concatenate([p[name] for p in parts]) if parts else np.array([]) for name in names
    }


def length_s(origin: Record) -> float:
    """Length of a recording in s, with its gaps, by the metadata of one of its tables."""
    frames = sum(s["n_frames"] + max(s["gap_before"], 0) for s in origin["segments"])
    return float(frames / origin["frame_rate_hz"])
