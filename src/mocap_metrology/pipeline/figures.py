"""Figures of one recording and of one calibration, out of the tables of the steps before."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np

from mocap_metrology.common.files import Metadata
from mocap_metrology.common.large import Made
from mocap_metrology.noise.fit.estimates import NoiseRow
from mocap_metrology.noise.series import coordinate_names, every_series, pair_name
from mocap_metrology.pipeline.judging import Diagnosed
from mocap_metrology.pipeline.tables import Table
from mocap_metrology.present.diagnosis.diagnosis_figure import diagnosis_figure
from mocap_metrology.present.fits.fit_figure import fit_figure
from mocap_metrology.present.plot.figure import save
from mocap_metrology.present.recording.recording_figures import (
    allan_figure,
    psd_figure,
    source_words,
    step_words,
)
from mocap_metrology.present.recording.trajectory import trajectory_figure
from mocap_metrology.present.tables import Record
from mocap_metrology.present.verdict.figure import verdict_figure


def draw_allan(allan: Table, stem: Path) -> None:
    """Allan deviations of every series as recorded, gross outliers masked."""
    origin = allan.origin
    picture = allan_figure(
        allan.columns,
        f"{origin['recording']}: Allan deviation",
        _source(origin),
        f"Masked: outliers beyond {origin['noise']['mask_sigma']:g} sigma.",
        expected=_series(origin),
        confidence=origin["allan"]["confidence"],
    )
    save(picture, stem)


def draw_psd(psd: Table, stem: Path) -> None:
    """Power spectral densities of every series, cleaned."""
    origin = psd.origin
    title = f"{origin['recording']}: power spectral density"
    how = _source(origin), _filtered(origin)
    save(psd_figure(psd.columns, title, *how, expected=_series(origin)), stem)


def draw_trajectory(raw: Table, clean: Table, stem: Path) -> None:
    """Every series over time, and which samples the filter replaced."""
    origin, cleaned = clean.origin, clean.coordinates
    given = every_series(raw.coordinates, raw.pairs)

    def replaced(name: str) -> np.ndarray:
        values, after = given[name], cleaned[name]
        return np.isfinite(values) & (values.astype(after.dtype) != after)

    changed = Made(given, replaced)
    title = f"{origin['recording']}: trajectory"
    how = title, _source(origin), _filtered(origin)
    save(trajectory_figure(given, cleaned, changed, origin["frame_rate_hz"], *how), stem)


def draw_diagnosis(found: Diagnosed, origin: Metadata, false_alarm: float, stem: Path) -> None:
    """What shows that something is wrong with a recording. origin: of its trajectories."""
    remarks = (
        f"As recorded, isolated frames bridged. Events: at most {100 * false_alarm:g} % of sound "
        "recordings show one. Filters run both ways (fourth order, half the amplitude at the "
        "cutoff). Spectrum: medians of bins, grey up to the greatest value; behind filters by "
        "their gain."
    )
    how = f"{origin['recording']}: diagnosis", f"Source: {source_words(origin)}.", remarks
    save(diagnosis_figure(found.recording, found.found, *how), stem)


def draw_fits(
    noise: Sequence[NoiseRow],
    allan: Table,
    periodogram: Table,
    folder: Path,
    chosen: Collection[str] | None = None,
) -> list[str]:
    """A figure a series that has coefficients: data, models, components and residuals.

    noise: rows of noise.csv; chosen: series to draw, or None for all. Returns their names.
    """
    folder.mkdir(parents=True, exist_ok=True)
    origin, drawn = allan.origin, []
    remarks = (
        f"As recorded, beyond {origin['noise']['mask_sigma']:g} sigma masked; components are those "
        "of the likelihood estimator."
    )
    shown = allan.columns["estimator"] == "oadev"
    for series in dict.fromkeys(row["series"] for row in noise):
        own = [row for row in noise if row["series"] == series and row["status"] != "refused"]
        if not own or (chosen is not None and series not in chosen):
            continue
        of_allan = shown & (allan.columns["series"] == series)
        of_spectrum = periodogram.columns["series"] == series
        estimates: dict[str, list[NoiseRow]] = {}
        for row in own:
            estimates.setdefault(row["estimator"], []).append(row)
        picture = fit_figure(
            f"{origin['recording']}, {series}: noise model",
            {k: v[of_allan] for k, v in allan.columns.items()},
            {k: v[of_spectrum] for k, v in periodogram.columns.items()},
            estimates,
            origin["frame_rate_hz"],
            f"Source: {source_words(origin)}.",
            remarks,
        )
        save(picture, folder / series)
        drawn.append(series)
    return drawn


def draw_verdict(verdict: Record, stem: Path) -> None:
    """Uncertainties, limits, causes. verdict: contents of verdict.json."""
    save(verdict_figure(verdict), stem)


def _series(origin: Metadata) -> list[str]:
    """Names of all that are analysed."""
    pairs = [(first, second) for first, second in origin["pairs"]]
    distances = [pair_name(pair, pairs) for pair in pairs]
    return [*coordinate_names(len(origin["labels"])), *distances]


def _source(origin: Metadata) -> str:
    markers = ", ".join(f"{k} = {label}" for k, label in enumerate(origin["labels"], start=1))
    step_size = step_words(origin["resolution_mm"], origin["resolution_kind"])
    return (
        f"Source: {source_words(origin)}. {origin['frame_rate_hz']:g} Hz, {step_size}. "
        f"Markers: {markers}."
    )


def _filtered(origin: Metadata) -> str:
    hampel = origin["hampel"]
    return (
        f"Hampel filter, {hampel['n_sigma']:g} sigma, {origin['window_frames']} frames: "
        f"{hampel['action']}."
    )
