"""Last step of a recording: what is wrong with it, and whether it is good enough."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mocap_metrology.common.files import read_json, write_json, write_text
from mocap_metrology.common.types import Row
from mocap_metrology.noise import filters
from mocap_metrology.noise.assess.recording import Inputs, assess_recording
from mocap_metrology.noise.assess.uncertainty import Span
from mocap_metrology.noise.diagnosis.findings import Finding, findings_of
from mocap_metrology.noise.diagnosis.recording import diagnose as diagnose_series
from mocap_metrology.noise.diagnosis.records import Diagnosis, DiagnosisSettings, Recording
from mocap_metrology.present.diagnosis import write_diagnosis
from mocap_metrology.present.text.diagnosis import sentences
from mocap_metrology.present.text.sentence import Sentence
from mocap_metrology.present.verdict.words import verdict_document
from mocap_metrology.recording.progress import CALM, Progress
from mocap_metrology.recording.results import Results, masked
from mocap_metrology.settings import Settings


@dataclass(frozen=True)
class Diagnosed:
    """A recording, what was found in it, as codes and numbers, and in words."""

    recording: Recording
    diagnosis: Diagnosis
    findings: Sequence[Finding]
    sentences: Sequence[Sentence]


def diagnose(results: Results, settings: Settings, progress: Progress = CALM) -> Diagnosed:
    """Events, lines, resolution and filters of a recording: diagnosis.json, events.csv,
    periodic.csv, filters.csv."""
    progress.step("events, periodic disturbances, filters")
    raw, psd, noise, origin = results.raw, results.psd, results.noise, results.raw.origin
    recording = Recording(
        raw.coordinates,
        origin["labels"],
        raw.pairs,
        origin["frame_rate_hz"],
        origin["resolution_mm"],
        origin["resolution_kind"],
        origin["n_filled_frames"],
        results.movements,
        origin.get("exchanged", ()),
    )
    how = DiagnosisSettings(
        **settings.diagnosis.model_dump(),
        still_range_mm=settings.still.range_mm,
        horizon_s=settings.verdict.horizon_s,
    )
    over = progress.over
    diagnosis = diagnose_series(recording, noise, psd.columns, how, psd.origin["psd"], over)
    findings = findings_of(recording, diagnosis, noise)
    words = sentences(recording, diagnosis, noise, how)
    found = recording, diagnosis, findings, words
    write_diagnosis(results.folder, origin["recording"], origin["source"], *found)
    return Diagnosed(*found)


def verdict(
    results: Results, named: Row, settings: Settings, progress: Progress = CALM
) -> Mapping[str, Any]:
    """verdict.json of a diagnosed recording; returns its contents. named: what it begins with."""
    progress.step("verdict")
    raw, limits = results.raw, settings.verdict
    diagnosis = read_json(results.folder / "diagnosis.json")
    span = Span(
        raw.origin["frame_rate_hz"],
        limits.horizon_s,
        limits.window_s,
        settings.allan.confidence,
        raw.origin["resolution_mm"],
        limits.mean_mm,
    )
    inputs = Inputs(
        masked(raw, results.clean, settings),
        raw.origin["labels"],
        results.noise,
        results.allan_masked.columns,
        results.outlier_rows,
        [Finding.of(row) for row in diagnosis["findings"]],
    )
    assessed = assess_recording(inputs, span, limits, progress.over)
    told = {key: diagnosis[key] for key in ("findings", "sentences")}
    document = named | verdict_document(assessed, raw.origin["source"])
    document |= {"warnings": list(results.check["warnings"])} | told
    path = results.folder / "verdict.json"
    write_json(path, document)
    written: Mapping[str, Any] = read_json(path)
    means = [np.nanmean(v) if np.isfinite(v).any() else np.nan for _, v in results.clean.in_mm()]
    places = np.array(means[: 3 * len(written["labels"])]).reshape(-1, 3)
    covariances = filters.covariances(written, places)
    write_text(results.folder / "noise_ros.yaml", filters.ros_yaml(written, covariances))
    write_text(results.folder / "px4.params", filters.px4_params(written, covariances))
    return written
