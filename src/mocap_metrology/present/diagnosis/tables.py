"""Files of a diagnosis: events.csv, periodic.csv, filters.csv, and diagnosis.json."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from mocap_metrology.common.files import write_csv, write_json, write_text
from mocap_metrology.noise.diagnosis.findings import Finding
from mocap_metrology.noise.diagnosis.recording import Diagnosis, Recording
from mocap_metrology.noise.diagnosis.rows import (
    EVENTS,
    FILTERS,
    PERIODIC,
    event_rows,
    filter_rows,
    periodic_rows,
)
from mocap_metrology.noise.diagnosis.sentence import Sentence


def write_diagnosis(
    folder: str | Path,
    name: str,
    source: str,
    recording: Recording,
    found: Diagnosis,
    findings: Sequence[Finding],
    sentences: Sequence[Sentence],
) -> None:
    """Write all four into `folder`; tables without a row keep their head. source: `twin` or
    `measured`."""
    folder = Path(folder)
    tables = {
        "events": (event_rows(found.events, recording.labels), EVENTS),
        "periodic": (periodic_rows(found.lines, recording.frame_rate_hz), PERIODIC),
        "filters": (filter_rows(found.filtered), FILTERS),
    }
    for stem, (rows, head) in tables.items():
        _write(folder / f"{stem}.csv", name, source, rows, head)
    document = {
        "recording": name,
        "source": source,
        "findings": [one.as_dict() for one in findings],
        "sentences": [{**asdict(one), "series": list(one.series)} for one in sentences],
    }
    write_json(folder / "diagnosis.json", document)


def _write(
    path: Path, name: str, source: str, rows: Sequence[dict[str, Any]], head: Sequence[str]
) -> None:
    if rows:
        write_csv(path, [{"recording": name, "source": source, **row} for row in rows])
    else:
        write_text(path, ",".join(("recording", "source", *head)) + "\n")
