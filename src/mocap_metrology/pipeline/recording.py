"""From coordinates to coefficients of noise: steps of a recording, tables in and out.

Spectra and moments are in `statistics`: numba, which these steps need, takes 0.3 s to import.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from zlib import crc32

import numpy as np

from mocap_metrology import settings as of
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import Metadata, versions, write_series
from mocap_metrology.common.hampel import SHORT_WINDOW, hampel, taken_at_most, white_level_kept
from mocap_metrology.common.parallel import Over, in_turn
from mocap_metrology.common.types import Columns, Row
from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.fit import estimates
from mocap_metrology.noise.fit.estimators import (
    NoiseSettings,
    SeriesNoise,
    estimate_series,
    masked_curve,
)
from mocap_metrology.noise.series import (
    ALLAN,
    PERIODOGRAM,
    allan_columns,
    joined,
    periodogram_columns,
)
from mocap_metrology.pipeline.tables import Series, Table

log = logging.getLogger(__name__)


class CleanSeries(NamedTuple):
    """name without unit; values (n,), outliers replaced; outlier: (n,); row of outliers.csv."""

    name: str
    values: np.ndarray
    outlier: np.ndarray
    row: Row


@dataclass(frozen=True)
class Cleaned:
    """table: of clean.parquet; report: rows of outliers.csv; outliers: of each series, (n,)."""

    table: Table
    report: list[Row]
    outliers: dict[str, np.ndarray]


def cleaned(raw: Table, settings: of.Hampel, over: Over = in_turn) -> Cleaned:
    """Every series, distances included, through the Hampel filter."""
    columns, report, outliers = {"frame": raw.frame}, [], {}
    for name, values, outliers[name], row in _filtered(raw, settings, over):
        columns[f"{name}_mm"] = values
        report.append(row)
    return Cleaned(Table(columns, _clean_origin(raw, settings)), report, outliers)


def write_cleaned(raw: Table, settings: of.Hampel, path: str | Path) -> list[Row]:
    """As `cleaned`, written one series at a time to `path`; returns the report."""
    report = []

    def columns() -> Iterator[Series]:
        yield "frame", raw.frame
        for one in _filtered(raw, settings, in_turn):
            report.append(one.row)
            yield f"{one.name}_mm", one.values

    write_series(path, columns(), _clean_origin(raw, settings))
    return report


def _clean_origin(raw: Table, settings: of.Hampel) -> Metadata:
    own = {"hampel": settings.model_dump(), "window_frames": 2 * _half_window(raw, settings) + 1}
    return raw.origin | own | {"versions": versions("numpy", "numba", "pyarrow")}


def _half_window(raw: Table, settings: of.Hampel) -> int:
    return max(round(settings.half_window_s * raw.origin["frame_rate_hz"]), 1)


def _filtered(raw: Table, settings: of.Hampel, over: Over) -> Iterable[CleanSeries]:
    """Every series; coordinates in their own type."""
    origin, half_window = raw.origin, _half_window(raw, settings)
    share_of_noise, kept = white_level_kept(settings.n_sigma, half_window, settings.action)
    if half_window < SHORT_WINDOW and settings.action != "off":
        log.warning(
            "the window holds %d frames, so the filter replaces many good samples too; "
            "raise hampel.half_window_s to %g or more",
            2 * half_window + 1,
            SHORT_WINDOW / origin["frame_rate_hz"],
        )
    given = raw.coordinates
    kind = next(iter(given.values())).dtype

    def filtered(one: Series) -> CleanSeries:
        name, values = one
        result = hampel(
            values, half_window, settings.n_sigma, settings.action, origin["resolution_mm"]
        )
        log.info("%s: %.3f %% outliers", name, 100 * result.share)
        row: Row = {
            "series": name,
            "action": settings.action,
            "n_sigma": settings.n_sigma,
            "window_frames": 2 * half_window + 1,
            "n_frames": values.size,
            "n_valid": result.n_valid,
            "n_outliers": int(result.outlier.sum()),
            "share": result.share,
            "share_of_clean_gaussian_noise": share_of_noise,
            "white_level_kept": kept,
            "resolution_mm": origin["resolution_mm"],
            "resolution_kind": origin["resolution_kind"],
        }
        found = result.values.astype(kind if name in given else float)
        return CleanSeries(name, found, result.outlier, row)

    return over(filtered, raw.with_distances())


def allan_deviations(
    series: Iterable[Series], origin: Metadata, settings: of.Allan, over: Over = in_turn
) -> Table:
    """Allan deviations, with intervals, of series cleaned as in S: allan.parquet."""
    rate, given = origin["frame_rate_hz"], origin["hampel"]
    taken = taken_at_most(given["n_sigma"], origin["window_frames"] // 2, given["action"])

    def curves(one: Series) -> list[Columns]:
        name, values = one
        m = averaging_factors(values.size, settings.n_taus, settings.min_m, settings.max_fraction)
        how = (settings.confidence, settings.min_coverage)
        log.info("%s: %d averaging factors", name, m.size)
        return [
            allan_columns(
                name, allan_curve(values, rate, m, kind, *how).with_upper_raised(taken), kind
            )
            for kind in settings.estimators
        ]

    parts = [part for found in over(curves, series) for part in found]
    origin = origin | {"allan": settings.model_dump()}
    origin["versions"] = versions("numpy", "scipy", "numba", "pyarrow")
    return Table(joined(parts, ALLAN), origin)


@dataclass(frozen=True)
class NoiseTables:
    """rows: of noise.csv; allan: Allan deviations of the masked series; periodogram: what the
    likelihood was fitted to."""

    rows: list[Row]
    allan: Table
    periodogram: Table


def noise_coefficients(
    raw: Table,
    allan: Mapping[str, np.ndarray],
    settings: of.Settings,
    subset: tuple[str, int] | None = None,
    over: Over = in_turn,
    outliers: Mapping[str, np.ndarray] | None = None,
) -> NoiseTables:
    """Coefficients of the noise of every series, by every estimator: noise.csv and what was fitted.

    raw: coordinates as recorded; allan: of the cleaned ones; subset: of the paper's tables, whose
    panels S's estimators then fit. outliers: of `cleaned` with the same raw coordinates, which
    saves looking for the grosser ones among all samples.
    """
    origin = raw.origin
    rate, step, recording = origin["frame_rate_hz"], origin["resolution_mm"], origin["recording"]
    how = NoiseSettings.of(settings, rate, origin.get("form", "sampled"), subset)

    known = outliers if outliers and _same_window(settings.hampel, how, rate) else {}

    def curve(name: str, values: np.ndarray, kind: str = "oadev") -> Columns:
        return allan_columns(
            name, masked_curve(values, rate, how, step, kind, known.get(name))[1], kind
        )

    def estimated(one: Series) -> tuple[str, list[Columns], SeriesNoise | str]:
        """Its curves besides the first, and the noise or why there is none."""
        name, values = one
        own = (allan["series"] == name) & (allan["estimator"] == "oadev") & (allan["avar_mm2"] > 0)
        given = allan["m"][own], allan["avar_mm2"][own]
        curves = [curve(name, values, kind) for kind in how.curves if kind != "oadev"]
        seed = crc32(f"{recording} {name}".encode()) + how.seed
        asked = how.components(name)
        try:
            found = estimate_series(values, given, rate, how, asked, seed, step, known.get(name))
        except Refusal as refusal:
            return name, [*curves, curve(name, values)], str(refusal)
        return name, [*curves, allan_columns(name, found.curve)], found

    rows, curves, periodograms = [], [], []
    refused: dict[str, list[str]] = {}
    for name, own, found in over(estimated, raw.with_distances()):
        curves += own
        if isinstance(found, str):
            refused.setdefault(found, []).append(name)
            rows += estimates.refused_rows(name, how.estimators, found)
            continue
        rows += _rows(name, found)
        periodograms.append(periodogram_columns(name, found.periodogram))
    for why, names in refused.items():
        log.warning("%s: no noise coefficients: %s", ", ".join(names), why)
    origin = origin | settings.model_dump(include={"noise", "allan", "seed"})
    origin["versions"] = versions("numpy", "scipy", "numba", "pyarrow")
    return NoiseTables(
        rows,
        Table(joined(curves, ALLAN), origin),
        Table(joined(periodograms, PERIODOGRAM), origin),
    )


def _same_window(hampel: of.Hampel, how: NoiseSettings, rate: float) -> bool:
    """Whether the samples of the mask are among the outliers of the filter before."""
    same = round(hampel.half_window_s * rate) == how.half_window
    return same and hampel.action != "off" and hampel.n_sigma <= how.mask_sigma


def _rows(name: str, found: SeriesNoise) -> list[Row]:
    """Rows of noise.csv of one series."""
    rows = []
    for estimate in found.estimates:
        rows += estimates.rows(name, estimate)
        log.info("%s %s: cost %.6g %s", name, estimate.estimator, estimate.cost, estimate.note)
    for estimator, why in found.refused.items():
        log.warning("%s: %s: %s", name, estimator, why)
        rows += estimates.refused_rows(name, (estimator,), why)
    return rows
