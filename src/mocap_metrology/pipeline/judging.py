"""What is wrong with a recording, and whether it is good enough: diagnosis.json, verdict.json."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypedDict

import numpy as np

from mocap_metrology import settings as of
from mocap_metrology.common.files import Metadata
from mocap_metrology.common.parallel import Over, in_turn
from mocap_metrology.common.types import Row
from mocap_metrology.noise.assess.checks import Thresholds
from mocap_metrology.noise.assess.recording import Inputs, OutlierRow, assess_recording
from mocap_metrology.noise.assess.uncertainty import Span
from mocap_metrology.noise.diagnosis.findings import Finding, FindingRow, findings_of
from mocap_metrology.noise.diagnosis.recording import (
    Diagnosis,
    DiagnosisSettings,
    Recording,
    diagnose,
)
from mocap_metrology.noise.fit.estimates import NoiseRow
from mocap_metrology.noise.motion.movement import Movement
from mocap_metrology.pipeline.tables import Series, Table
from mocap_metrology.present.diagnosis.tables import write_diagnosis
from mocap_metrology.present.text.diagnosis import sentences
from mocap_metrology.present.text.sentence import Sentence
from mocap_metrology.present.verdict.document import verdict_document


@dataclass(frozen=True)
class Diagnosed:
    """A recording, what was found in it, as codes and numbers, and in words."""

    recording: Recording
    found: Diagnosis
    findings: Sequence[Finding]
    sentences: Sequence[Sentence]

    def write(self, folder: Path, name: str, source: str) -> None:
        """diagnosis.json, events.csv, periodic.csv, filters.csv."""
        write_diagnosis(
            folder, name, source, self.recording, self.found, self.findings, self.sentences
        )


def diagnosed(
    raw: Table,
    psd: Table,
    noise: Sequence[NoiseRow],
    settings: DiagnosisSettings,
    over: Over = in_turn,
    movements: Mapping[str, Movement] | None = None,
) -> Diagnosed:
    """Events, lines, resolution and filters of a recording; noise: rows of noise.csv; movements: of
    coordinates, where they are known already."""
    origin = raw.origin
    recording = Recording(
        raw.coordinates,
        origin["labels"],
        raw.pairs,
        origin["frame_rate_hz"],
        origin["resolution_mm"],
        origin["resolution_kind"],
        origin["n_filled_frames"],
        movements or {},
    )
    found = diagnose(recording, noise, psd.columns, settings, psd.origin["psd"], over)
    findings = findings_of(recording, found, noise)
    return Diagnosed(recording, found, findings, sentences(recording, found, noise, settings))


def diagnosis_settings(
    diagnosis: of.Diagnosis, still: of.Still, horizon_s: float
) -> DiagnosisSettings:
    return DiagnosisSettings(
        **diagnosis.model_dump(), still_range_mm=still.range_mm, horizon_s=horizon_s
    )


class DiagnosisDocument(TypedDict):
    """The part of diagnosis.json that a verdict needs."""

    findings: list[FindingRow]
    sentences: list[Row]


@dataclass(frozen=True)
class Evidence:
    """Evidence of a verdict. series: cleaned; origin: of clean.parquet; allan: columns of
    allan_masked.parquet; noise, outliers: rows of the CSV files; diagnosis: contents of
    diagnosis.json; warnings: of check.json."""

    series: Iterable[Series]
    origin: Metadata
    allan: Mapping[str, np.ndarray]
    noise: Sequence[NoiseRow]
    outliers: Sequence[OutlierRow]
    diagnosis: DiagnosisDocument
    warnings: Sequence[str] = ()


def judged(
    evidence: Evidence,
    named: Row,
    settings: of.Verdict,
    confidence: float,
    over: Over = in_turn,
) -> Row:
    """Contents of verdict.json. named: what it begins with; confidence: of intervals."""
    origin = evidence.origin
    limits = settings.model_dump()
    span = Span(
        origin["frame_rate_hz"],
        limits.pop("horizon_s"),
        limits.pop("window_s"),
        confidence,
        origin["resolution_mm"],
    )
    inputs = Inputs(
        evidence.series,
        origin["labels"],
        evidence.noise,
        evidence.allan,
        evidence.outliers,
        [Finding.of(row) for row in evidence.diagnosis["findings"]],
    )
    found = assess_recording(inputs, span, Thresholds(**limits), over)
    document = named | verdict_document(found, origin["source"])
    document["warnings"] = list(evidence.warnings)
    document["findings"] = evidence.diagnosis["findings"]
    document["sentences"] = evidence.diagnosis["sentences"]
    return document
