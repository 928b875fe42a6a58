"""Second step of a recording: spectra, moments, Allan deviations and noise coefficients."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Mapping
from zlib import crc32

import numpy as np

from mocap_metrology import settings as of
from mocap_metrology.common.errors import Refusal
from mocap_metrology.common.files import Metadata, versions, write_csv
from mocap_metrology.common.hampel import taken_at_most
from mocap_metrology.common.parallel import MapFunction, in_turn
from mocap_metrology.common.types import Columns, Row
from mocap_metrology.noise import series as tables
from mocap_metrology.noise.allan.confidence import allan_curve
from mocap_metrology.noise.allan.variance import averaging_factors
from mocap_metrology.noise.cameras.covariance import COLUMNS as COVARIANCE
from mocap_metrology.noise.cameras.covariance import CovarianceRow, covariance_rows
from mocap_metrology.noise.fit import estimates
from mocap_metrology.noise.fit import estimators as fit
from mocap_metrology.noise.fit.spectral.welch import welch
from mocap_metrology.noise.gaussian.two_markers import gaussian_rows
from mocap_metrology.recording.progress import CALM, Progress
from mocap_metrology.recording.results import Results, Series, Table, known_outliers

log = logging.getLogger(__name__)
PSD = ("series", "f_hz", "psd_mm2_hz", "n_segments", "n_bridged")


def noise(
    results: Results,
    settings: of.Settings,
    subset: tuple[str, int] | None = None,
    progress: Progress = CALM,
) -> None:
    """Statistics and noise of a cleaned recording: psd.parquet, allan.parquet, gaussian.csv,
    covariance.csv, noise.csv, allan_masked.parquet, periodogram.parquet.

    subset: type and number of cameras of the paper's tables, whose panel S's estimators then fit.
    """
    folder, over, filtered = results.folder, progress.over, results.clean
    progress.step("power spectral densities, Gaussian model")
    results.psd = spectra(filtered.in_mm(), filtered.origin, settings.psd, over)
    results.psd.write(folder / "psd.parquet")
    rows, covariance = gaussian_model(filtered, settings.gaussian)
    write_csv(folder / "gaussian.csv", rows)
    write_csv(folder / "covariance.csv", covariance, COVARIANCE)
    progress.step("Allan deviations")
    allan = allan_deviations(filtered.in_mm(), filtered.origin, settings.allan, over)
    allan.write(folder / "allan.parquet")
    progress.step("noise model")
    outliers = known_outliers(filtered, settings)
    rows, results.allan_masked, periodogram = noise_coefficients(
        results.raw, allan.columns, settings, subset, over, outliers
    )
    write_csv(folder / "noise.csv", rows)
    periodogram.write(folder / "periodogram.parquet")
    results.allan_masked.write(folder / "allan_masked.parquet")


def spectra(
    series: Iterable[Series], origin: Metadata, settings: of.Spectrum, over: MapFunction = in_turn
) -> Table:
    """Welch's power spectral density of every series: psd.parquet."""

    def density(one: Series) -> Columns | None:
        name, values = one
        try:
            spectrum = welch(values, origin["frame_rate_hz"], **settings.model_dump())
        except Refusal as refusal:  # the other series are whole enough
            log.warning("%s: %s", name, refusal)
            return None
        log.info("%s: %d segments of %d frames", name, spectrum.n_segments, spectrum.segment)
        count = spectrum.f_hz.size
        return {
            "series": np.full(count, name, dtype=object),
            "f_hz": spectrum.f_hz,
            "psd_mm2_hz": spectrum.psd,
            "n_segments": np.full(count, spectrum.n_segments, dtype=np.int64),
            "n_bridged": np.full(count, spectrum.n_bridged, dtype=np.int64),
        }

    parts = [part for part in over(density, series) if part]
    origin = origin | {
        "psd": settings.model_dump(),
        "versions": versions("numpy", "scipy", "pyarrow"),
    }
    return Table(tables.joined(parts, PSD), origin)


def gaussian_model(clean: Table, settings: of.Gaussian) -> tuple[list[Row], list[CovarianceRow]]:
    """The simple Gaussian model of every pair (S Table 4): gaussian.csv; and the covariance of fast
    noise between coordinates: covariance.csv."""
    series, origin = clean.coordinates, clean.origin
    labels, rate = origin["labels"], origin["frame_rate_hz"]
    rows = gaussian_rows(series, labels, clean.pairs, rate, settings.n_bins)
    named = [{"recording": origin["recording"]} | row for row in rows]
    return named, covariance_rows(series, len(labels), rate)


def allan_deviations(
    series: Iterable[Series], origin: Metadata, settings: of.Allan, over: MapFunction
) -> Table:
    """Allan deviations, with intervals, of series cleaned as in S: allan.parquet."""
    rate, filtered = origin["frame_rate_hz"], origin["hampel"]
    taken = taken_at_most(filtered["n_sigma"], origin["window_frames"] // 2, filtered["action"])

    def curves(one: Series) -> list[Columns]:
        name, values = one
        m = averaging_factors(values.size, settings.n_taus, settings.min_m, settings.max_fraction)
        how = (settings.confidence, settings.min_coverage)
        log.info("%s: %d averaging factors", name, m.size)
        return [
            tables.allan_columns(
                name, allan_curve(values, rate, m, kind, *how).with_upper_raised(taken), kind
            )
            for kind in settings.estimators
        ]

    parts = [part for of_series in over(curves, series) for part in of_series]
    origin = origin | {"allan": settings.model_dump()}
    origin["versions"] = versions("numpy", "scipy", "numba", "pyarrow")
    return Table(tables.joined(parts, tables.ALLAN), origin)


def noise_coefficients(
    raw: Table,
    allan: Mapping[str, np.ndarray],
    settings: of.Settings,
    subset: tuple[str, int] | None,
    over: MapFunction,
    outliers: Callable[[str, np.ndarray], np.ndarray | None],
) -> tuple[list[Row], Table, Table]:
    """Coefficients of the noise of every series, by every estimator: rows of noise.csv, Allan
    deviations of the masked series, and the periodograms to which the likelihood was fitted.

    raw: coordinates as recorded; allan: of the cleaned ones; subset: of the paper's tables, whose
    panels S's estimators then fit. outliers: `known_outliers`, which saves looking for the grosser
    ones among all samples.
    """
    origin = raw.origin
    rate, step, recording = origin["frame_rate_hz"], origin["resolution_mm"], origin["recording"]
    how = fit.NoiseSettings.of(settings, rate, origin.get("form"), subset)

    def curve(name: str, values: np.ndarray, kind: str = "oadev") -> Columns:
        among = outliers(name, values)
        return tables.allan_columns(
            name, fit.masked_curve(values, rate, how, step, kind, among)[1], kind
        )

    def estimated(one: Series) -> tuple[str, list[Columns], fit.SeriesNoise | str]:
        """Its curves besides the first, and the noise or why there is none."""
        name, values = one
        rows = (allan["series"] == name) & (allan["estimator"] == "oadev") & (allan["avar_mm2"] > 0)
        variances = allan["m"][rows], allan["avar_mm2"][rows]
        curves = [curve(name, values, kind) for kind in how.allan.estimators if kind != "oadev"]
        seed = crc32(f"{recording} {name}".encode()) + how.seed
        components, among = how.components(name), outliers(name, values)
        try:
            fitted = fit.estimate_series(
                values, variances, rate, how, components, seed, step, among
            )
        except Refusal as refusal:
            return name, [*curves, curve(name, values)], str(refusal)
        return name, [*curves, tables.allan_columns(name, fitted.curve)], fitted

    rows, curves, periodograms = [], [], []
    refused: dict[str, list[str]] = {}
    for name, columns, result in over(estimated, raw.with_distances()):
        curves += columns
        if isinstance(result, str):
            refused.setdefault(result, []).append(name)
            rows += estimates.refused_rows(name, how.noise.estimators, result)
            continue
        rows += _rows(name, result)
        periodograms.append(tables.periodogram_columns(name, result.periodogram))
    for why, names in refused.items():
        log.warning("%s: no noise coefficients: %s", ", ".join(names), why)
    origin = origin | settings.model_dump(include={"noise", "allan", "seed"})
    origin["versions"] = versions("numpy", "scipy", "numba", "pyarrow")
    fitted = Table(tables.joined(periodograms, tables.PERIODOGRAM), origin)
    return rows, Table(tables.joined(curves, tables.ALLAN_MASKED), origin), fitted


def _rows(name: str, fitted: fit.SeriesNoise) -> list[Row]:
    rows = []
    for estimate in fitted.estimates:
        rows += estimates.rows(name, estimate)
        log.info("%s %s: cost %.6g %s", name, estimate.estimator, estimate.cost, estimate.note)
    for estimator, why in fitted.refused.items():
        log.warning("%s: %s: %s", name, estimator, why)
        rows += estimates.refused_rows(name, (estimator,), why)
    return rows
