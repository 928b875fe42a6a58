"""Figures of a recording, out of the tables of its steps, as SVG, and as PNG where results have
that."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mocap_metrology.common.files import Metadata, whole_folder
from mocap_metrology.common.large import LazyArrays
from mocap_metrology.noise.fit.estimates import NoiseRow
from mocap_metrology.noise.series import coordinate_names, every_series, pair_name
from mocap_metrology.present.diagnosis import diagnosis_figure
from mocap_metrology.present.fits import fit_figure
from mocap_metrology.present.plot.figure import Texts, save
from mocap_metrology.present.recording import (
    allan_figure,
    source_words,
    step_words,
    trajectory_figure,
)
from mocap_metrology.present.verdict.figure import verdict_figure
from mocap_metrology.recording.results import Results, Table
from mocap_metrology.recording.verdict import Diagnosed
from mocap_metrology.settings import Settings


def draw_allan(results: Results) -> None:
    """Allan deviations of every series as recorded, gross outliers masked."""
    allan, origin = results.allan_masked.columns, results.allan_masked.origin
    pairs = results.allan_masked.pairs
    distances = [pair_name(pair, pairs) for pair in pairs]
    masked = f"Masked: outliers beyond {origin['noise']['mask_sigma']:g} sigma."
    picture = allan_figure(
        allan,
        Texts(f"{origin['recording']}: Allan deviation", _source(origin), masked),
        expected=[*coordinate_names(len(origin["labels"])), *distances],
        confidence=origin["allan"]["confidence"],
    )
    save(picture, results.folder / "adev", results.png)


def draw_trajectory(results: Results) -> None:
    """Every series over time, and which samples the filter replaced."""
    raw, origin, cleaned = results.raw, results.clean.origin, results.clean.coordinates
    recorded = every_series(raw.coordinates, raw.pairs)

    def replaced(name: str) -> np.ndarray:
        before, after = recorded[name], cleaned[name]
        return np.isfinite(before) & (before.astype(after.dtype) != after)

    changed, rate = LazyArrays(recorded, replaced), origin["frame_rate_hz"]
    hampel, frames = origin["hampel"], origin["window_frames"]
    filtered = f"Hampel filter, {hampel['n_sigma']:g} sigma, {frames} frames: {hampel['action']}."
    texts = Texts(f"{origin['recording']}: trajectory", _source(origin), filtered)
    picture = trajectory_figure(recorded, cleaned, changed, rate, texts)
    save(picture, results.folder / "trajectory", results.png)


def draw_diagnosis(diagnosed: Diagnosed, results: Results, settings: Settings) -> None:
    """What shows that something is wrong with a recording."""
    origin = results.raw.origin
    remarks = (
        f"As recorded, isolated frames bridged. Events: at most "
        f"{100 * settings.diagnosis.false_alarm:g} % of sound "
        "recordings show one. Filters run both ways (fourth order, half the amplitude at the "
        "cutoff). Spectrum: medians of bins, grey up to the greatest value; behind filters by "
        "their gain."
    )
    source = f"Source: {source_words(origin)}."
    texts = Texts(f"{origin['recording']}: diagnosis", source, remarks)
    picture = diagnosis_figure(diagnosed.recording, diagnosed.diagnosis, texts)
    save(picture, results.folder / "diagnosis", results.png)


def draw_verdict(document: Mapping[str, Any], results: Results) -> None:
    """Uncertainties, limits, causes. document: contents of verdict.json."""
    save(verdict_figure(document), results.folder / "verdict", results.png)


def decisive(document: Mapping[str, Any]) -> set[str]:
    """The series that decided a verdict, else the most uncertain coordinate, and the distance.
    document: contents of verdict.json."""
    series, decided = document["series"], document["decided_by"]["series"]
    if decided not in series:
        single = {k: v["frame_mm"] or 0.0 for k, v in series.items() if not k.startswith("L")}
        decided = max(single, key=single.__getitem__, default="")
    return {decided, "L"}


def draw_fits(results: Results, folder: str | Path, chosen: Collection[str] | None) -> None:
    """A figure for each of these series (None: all) that has coefficients: data, models, components
    and residuals."""
    allan, origin = results.allan_masked.columns, results.allan_masked.origin
    periodogram = Table.read(results.folder / "periodogram.parquet").columns
    source = f"Source: {source_words(origin)}."
    remarks = (
        f"As recorded, beyond {origin['noise']['mask_sigma']:g} sigma masked; components are those "
        "of the likelihood estimator."
    )
    by_series: dict[str, dict[str, list[NoiseRow]]] = {}
    for row in results.noise:
        if row["status"] != "refused" and (chosen is None or row["series"] in chosen):
            by_series.setdefault(row["series"], {}).setdefault(row["estimator"], []).append(row)
    with whole_folder(folder) as part:
        for series, estimates in by_series.items():
            of_allan = (allan["estimator"] == "oadev") & (allan["series"] == series)
            of_spectrum = periodogram["series"] == series
            picture = fit_figure(
                Texts(f"{origin['recording']}, {series}: noise model", source, remarks),
                {k: v[of_allan] for k, v in allan.items()},
                {k: v[of_spectrum] for k, v in periodogram.items()},
                estimates,
                origin["frame_rate_hz"],
                origin["allan"]["confidence"],
            )
            save(picture, part / series, results.png)


def _source(origin: Metadata) -> str:
    markers = ", ".join(f"{k} = {label}" for k, label in enumerate(origin["labels"], start=1))
    step_size = step_words(origin["resolution_mm"], origin["resolution_kind"])
    return (
        f"Source: {source_words(origin)}. {origin['frame_rate_hz']:g} Hz, {step_size}. "
        f"Markers: {markers}."
    )
